"""Means of all points as a table, and two sweeps side by side."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from pictures import text_of
from project import ROOT
from scipy import stats
from typer.testing import CliRunner

import dem
from dem.analysis.drag import summarise
from dem.analysis.means import compared, means, table_of, write_means
from dem.analysis.tables import TextTable
from dem.base.errors import InputError
from dem.base.statistics import ratio_interval
from dem.cli.app import app
from dem.cli.show import print_or_write
from dem.report.info import summary
from dem.sweep.axis import POINT

pytestmark = pytest.mark.quick
NAMES = (
    "docs/data/precise",
    *(f"studies/{name}/{name}" for name in ("pressure", "shear", "velocity")),
)
FILES = [path for name in NAMES if (path := ROOT / f"{name}.nc").is_file()]


@pytest.fixture
def file(tmp_path):
    """Writes a combined file of a design of three points with four seeds; shift (N): of all drags. One run
    of the first point failed, and one of the second is infinite. The lift is there for two seeds."""

    def write(name="drag.nc", shift=0.0, points=(0, 1, 2), edit=lambda runs: runs):
        rng = np.random.default_rng([2, int(shift)])
        drag = 100.0 + shift + rng.normal(0.0, 5.0, (3, 4, 6))
        drag[0, 3], drag[1, 0] = np.nan, np.inf
        runs = [[f"{shift:g} {4 * k + n}" for n in range(4)] for k in range(3)]
        dims = "point", "seed"
        dataset = xr.Dataset(
            {
                "drag": ((*dims, "displacement"), drag, {"units": "N"}),
                "run_id": (dims, runs),
                "lift": (dims, drag[..., 0] / 2.0, {"units": "N"}),
            },
            {
                "point": ("point", [0, 1, 2], {"long_name": POINT, "units": "1"}),
                "friction_granule": ("point", [0.1, 0.2, 0.3], {"units": "1"}),
                "seed": [1, 2, 3, 4],
                "displacement": np.arange(6) * 1e-3,
            },
            {"window_start": 1e-3, "window_stop": 4e-3, "title": "three points"},
        )
        dataset["lift"] = dataset["lift"].where(dataset["seed"] < 3)
        edit(dataset.isel(point=list(points))).to_netcdf(tmp_path / name)
        return tmp_path / name

    return write


def runs_of(path):
    """Mean drag (point, seed) of the runs within the window, from 1 to 4 mm; NaN where a run failed."""
    with xr.open_dataset(path) as dataset:
        drag = dataset["drag"].values[:, :, 1:5].mean(2)
    return np.where(np.isfinite(drag), drag, np.nan)


def test_means_are_of_the_runs_that_did_not_fail_wherever_they_are_shown(file, tmp_path):
    """In the file, in the table, on the terminal and for figures; each quantity counts its own runs."""
    path, runs = file(), [row[np.isfinite(row)] for row in runs_of(file())]
    half = [stats.t.interval(0.95, len(row) - 1, 0.0, stats.sem(row))[1] for row in runs]
    for name in ("means.csv", "means.nc"):
        write_means(means(path), tmp_path / name)
    table = pd.read_csv(tmp_path / "means.csv")
    assert table["drag (N)"].values == pytest.approx([row.mean() for row in runs])
    assert table["drag_half_interval (N)"].values == pytest.approx(half)
    assert table["drag_runs"].tolist() == [3, 3, 4] and table["lift_runs"].tolist() == [2, 1, 2]
    assert table["friction_granule"].tolist() == [0.1, 0.2, 0.3] and "point" not in table
    with dem.open_results(tmp_path / "means.nc") as result, dem.open_results(path) as dataset:
        of_figures = summarise(dataset)
        for name, other in (("drag", "mean"), ("drag_half_interval", "half_interval")):
            assert result[name].dims == ("point",) and result[name].attrs["units"] == "N"
            np.testing.assert_allclose(result[name], table[f"{name} (N)"])
            np.testing.assert_allclose(of_figures[other], table[f"{name} (N)"])
    printed = CliRunner().invoke(app, ["means", str(path), "--of", "drag"]).output
    rows = [line.split() for line in printed.splitlines() if re.match(r"\s*0\.\d", line)]
    expected = table[["friction_granule", "drag (N)", "drag_half_interval (N)", "drag_runs"]]
    np.testing.assert_allclose(np.array(rows, float), expected, rtol=1e-4)
    assert "drag (N)" in printed and "lift" not in printed


def test_two_sweeps_are_compared_where_both_have_a_point(file):
    """The second over the first, within Fieller's interval; the command prints the same."""
    paths = file(), file("other.nc", shift=50.0, points=(1, 2))
    result = compared(*paths, "drag")
    assert result["point"].values.tolist() == [1, 2]
    for row, first, second in zip(range(2), runs_of(paths[0])[1:], runs_of(paths[1]), strict=True):
        at = {name: float(values[row]) for name, values in result.data_vars.items()}
        assert (at["first"], at["second"]) == pytest.approx((np.nanmean(first), np.nanmean(second)))
        ratio = at["ratio"], at["ratio_low"], at["ratio_high"]
        assert ratio == pytest.approx(ratio_interval(second, first))
    printed = CliRunner().invoke(app, ["means", *map(str, paths)]).output
    assert all(f"{ratio:.5g}" in printed for ratio in result["ratio"].values)


def test_runs_that_both_files_have_count_for_the_first_alone(file):
    """Fieller's interval is of independent samples."""

    def apart(dataset):  # the seeds 1 and 2 have the same runs
        of_both = dataset["run_id"].str.replace("50 ", "0 ")
        return dataset.assign(run_id=of_both.where(dataset["seed"] < 3, dataset["run_id"]))

    first, other = file(), file("other.nc", shift=50.0, edit=apart)
    result = compared(first, other, "drag")
    np.testing.assert_allclose(result["first"], np.nanmean(runs_of(first), 1))
    np.testing.assert_allclose(result["second"], np.nanmean(runs_of(other)[:, 2:], 1))
    assert compared(first, file("same.nc"), "drag")["ratio"].isnull().all()


def test_means_of_an_experiment_of_ones_own_are_of_its_first_quantity(file):
    """Where it has no drag, as the page of experiments says; also beside another file."""

    def mine(dataset):
        return dataset.rename(drag="mine")

    paths = [str(file(name, edit=mine)) for name in ("a.nc", "b.nc")]
    for words, shown in ((paths[:1], "mine (N)"), (paths, "ratio")):
        run = CliRunner().invoke(app, ["means", *words])
        assert run.exit_code == 0 and shown in run.output, run.output


def test_points_of_different_designs_are_no_pairs(file):
    """They have numbers, and the same number means nothing."""
    for edit in (
        lambda d: d.assign_coords(friction_granule=d["friction_granule"] + 0.1),
        lambda d: d.rename(friction_granule="friction_boundary"),
        lambda d: d.isel(point=[2]).assign_coords(point=[7]),
    ):
        with pytest.raises(InputError, match="have no point in common"):
            compared(file(), file("other.nc", edit=edit), "drag")


def test_points_of_a_name_are_compared_whatever_their_granules_are(file):
    """And the table leaves out what differs."""

    def named(granules):
        coordinates = {"case": ("point", ["a", "b", "c"]), "granules": ("point", granules)}
        return lambda d: (
            d.drop_vars(["point", "friction_granule"])
            .assign_coords(coordinates)
            .swap_dims(point="case")
        )

    one = file("one.nc", edit=named([60, 60, 60]))
    table = table_of(compared(one, file("two.nc", edit=named([60, 90, 60])), "drag"))
    assert table["case"].tolist() == ["a", "b", "c"] and "granules" not in table


@pytest.mark.parametrize("width", [30, 80, 1000])
def test_no_number_of_a_table_is_cut(width):
    """On a narrow terminal the last columns are below, beside the first one again."""
    values = {f"value {n}": [f"{row}.{n:09d}" for row in range(3)] for n in range(11)}
    frame = pd.DataFrame({"row": ["row0", "row1", "row2"]} | values)
    lines = text_of(TextTable(frame), width).splitlines()
    assert max(map(len, lines)) <= width
    for row in frame.itertuples(index=False):
        assert {cell for line in lines if row[0] in line for cell in line.split()} == set(row)


def test_a_pipe_gets_tables_as_wide_as_they_are(capsys):
    names = {f"quantity_of_a_long_name_{n:02d}": ("point", [1.0 / 3.0] * 3) for n in range(20)}
    print_or_write(TextTable(table_of(xr.Dataset(names))), None)
    assert capsys.readouterr().out.splitlines()[0].split() == ["point", *names]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_released_file_of_runs_has_a_summary(path):
    """Also where it holds less than a sweep writes."""
    assert re.search("±|half_interval", text_of(summary(path)))
