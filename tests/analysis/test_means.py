"""Means of all points as a table, and two sweeps side by side."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from command_line import called
from numpy.testing import assert_allclose
from pictures import text_of
from project import ROOT

import dem
from dem.analysis.means import PAIR, RATIO, compared, means, table_of, write_means
from dem.analysis.tables import TextTable
from dem.base.statistics import mean_interval, ratio_interval
from dem.cli.show import print_or_write
from dem.report.info import summary
from dem.sweep.axis import POINT

pytestmark = pytest.mark.quick


def runs(shift=0.0):
    """A combined file of a design of three points with four seeds; shift (N): of all drags. One run
    of the first point failed, and one of the second is infinite. The lift is there for two seeds."""
    drag = np.random.default_rng([2, int(shift)]).normal(100.0 + shift, 5.0, (3, 4, 6))
    drag[0, 3], drag[1, 0] = np.nan, np.inf
    dims = "point", "seed"
    numbers = [[f"{shift:g} {point} {seed}" for seed in range(4)] for point in range(3)]
    made = xr.Dataset(
        {"drag": ((*dims, "displacement"), drag, {"units": "N"}), "run_id": (dims, numbers)},
        {
            "point": ("point", range(3), {"long_name": POINT, "units": "1"}),
            "seed": range(4),
            "displacement": 1e-3 * np.arange(6),
            "friction_granule": ("point", [0.1, 0.2, 0.3], {"units": "1"}),
        },
        {"window_start": 1e-3, "window_stop": 4e-3},
    )
    return made.assign(lift=made["drag"].isel(displacement=0, drop=True).where(made["seed"] < 2))


def drag_of(made):
    """Mean drag (point, seed) of the runs within the window, from 1 to 4 mm; NaN where a run failed."""
    drag = made["drag"].values[:, :, 1:5].mean(2)
    return np.where(np.isfinite(drag), drag, np.nan)


@pytest.fixture
def saved(folder):
    """Writes files and returns their paths: 0.nc, 1.nc, ..."""

    def write(*datasets):
        for number, made in enumerate(datasets):
            made.to_netcdf(folder / f"{number}.nc")
        return sorted(folder.glob("*.nc"))

    return write


def printed(words):
    result = called(f"means {words}")
    assert result.exit_code == 0, result.output
    return result.output


def test_means_are_of_the_runs_that_did_not_fail_wherever_they_are_shown(saved, tmp_path):
    """In the file, in the table and on the terminal; each quantity counts its own runs."""
    (path,), drag = saved(runs()), drag_of(runs())
    for name in ("means.csv", "means.nc"):
        write_means(means(path), tmp_path / name)
    table = pd.read_csv(tmp_path / "means.csv")
    assert_allclose(table["drag (N)"], np.nanmean(drag, 1))
    half = [mean_interval(row).half for row in drag]
    assert_allclose(table["drag_half_interval (N)"], half)
    assert table["drag_runs"].tolist() == [3, 3, 4] and table["lift_runs"].tolist() == [2, 1, 2]
    assert table["friction_granule"].tolist() == [0.1, 0.2, 0.3] and "point" not in table
    with dem.open_results(tmp_path / "means.nc") as result:
        for name in ("drag", "drag_half_interval"):
            assert result[name].dims == ("point",) and result[name].attrs["units"] == "N"
            assert_allclose(result[name], table[f"{name} (N)"])
    text = printed("0.nc --of drag")
    shown = *table["drag (N)"], *table["drag_half_interval (N)"]
    assert all(f"{value:.5g}" in text for value in shown)
    assert "drag (N)" in text and "lift" not in text


def test_two_sweeps_are_compared_where_both_have_a_point(saved):
    """The second over the first, within Fieller's interval; the command prints the same."""
    one, two = runs(), runs(50.0).isel(point=[1, 2])
    paths = saved(one, two)
    result = compared(*paths, "drag")
    assert result["point"].values.tolist() == [1, 2]
    first, second = drag_of(one)[1:], drag_of(two)
    ratios = [ratio_interval(*pair) for pair in zip(second, first, strict=True)]
    expected = [np.nanmean(first, 1), np.nanmean(second, 1), *np.transpose(ratios)]
    for name, values in zip((*PAIR, *RATIO), expected, strict=True):
        assert_allclose(result[name], values)
    text = printed("0.nc 1.nc")
    assert all(f"{ratio:.5g}" in text for ratio in result["ratio"].values)


def test_runs_that_both_files_have_count_for_the_first_alone(saved):
    """Fieller's interval is of independent samples."""
    one, two = runs(), runs(50.0)
    two["run_id"] = two["run_id"].where(two["seed"] > 1, one["run_id"])  # two seeds are of both
    paths = saved(one, two, one)
    result = compared(*paths[:2], "drag")
    assert_allclose(result["first"], np.nanmean(drag_of(one), 1))
    assert_allclose(result["second"], np.nanmean(drag_of(two)[:, 2:], 1))
    assert compared(*paths[::2], "drag")["ratio"].isnull().all()


def test_means_of_an_experiment_of_ones_own_are_of_its_first_quantity(saved):
    """Where it has no drag, as the page of experiments says; also beside another file."""
    saved(*[runs().rename(drag="mine")] * 2)
    assert "mine (N)" in printed("0.nc") and "ratio" in printed("0.nc 1.nc")


@pytest.mark.parametrize(
    "other",
    [
        runs().assign_coords(friction_granule=runs()["friction_granule"] + 0.1),
        runs().rename(friction_granule="friction_boundary"),
        runs().isel(point=[2]).assign_coords(point=[7]),
    ],
)
def test_points_of_different_designs_are_no_pairs(saved, other):
    """They have numbers, and the same number means nothing."""
    with pytest.raises(dem.InputError, match="have no point in common"):
        compared(*saved(runs(), other), "drag")


def test_points_of_a_name_are_compared_whatever_their_granules_are(saved):
    """And the table leaves out what differs."""
    named = runs().drop_vars(["point", "friction_granule"]).rename(point="case")
    named["case"] = ["a", "b", "c"]
    both = [named.assign_coords(granules=("case", [60, more, 60])) for more in (60, 90)]
    table = table_of(compared(*saved(*both), "drag"))
    assert table["case"].tolist() == ["a", "b", "c"] and "granules" not in table


@pytest.mark.parametrize("width", [30, 1000])
def test_no_number_of_a_table_is_cut(width):
    """On a narrow terminal the last columns are below, beside the first one again."""
    values = {f"value {n}": [f"{row}.{n:09d}" for row in range(3)] for n in range(11)}
    frame = pd.DataFrame({"row": ["row0", "row1", "row2"]} | values)
    lines = text_of(TextTable(frame), width).splitlines()
    assert max(map(len, lines)) <= width
    for row in frame.itertuples(index=False):
        assert {cell for line in lines if row[0] in line for cell in line.split()} == set(row)


def test_a_pipe_gets_tables_as_wide_as_they_are(capsys):
    names = [f"quantity_of_a_long_name_{n:02d}" for n in range(20)]
    print_or_write(TextTable(pd.DataFrame(1.0 / 3.0, range(3), names)), None)
    assert capsys.readouterr().out.splitlines()[0].split() == names


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pressure", "±"),
        ("shear", "half_interval"),
        ("velocity", "cylinder at 0.125 to 32 m/s"),  # of the runs, and not of the file
    ],
)
def test_every_released_file_of_runs_has_a_summary(name, words):
    """Also where it holds less than a sweep writes."""
    path = ROOT / f"studies/{name}/{name}.nc"
    assert not path.is_file() or words in text_of(summary(path))
