"""Means of all points as a table, and two sweeps side by side."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from pictures import text_of
from project import ROOT
from sweeps import dataset_of
from typer.testing import CliRunner

import dem
from dem.analysis.drag import summarise
from dem.analysis.means import compared, means, table_of, write_means
from dem.analysis.tables import TextTable
from dem.base.errors import InputError
from dem.base.statistics import mean_interval, ratio_interval
from dem.cli.app import app
from dem.cli.show import print_or_write
from dem.report.info import summary
from dem.sweep.axis import POINT

pytestmark = pytest.mark.quick


@pytest.fixture
def file(tmp_path):
    """Writes a combined file of a design of three points with four seeds; shift (N): of all drags. One run
    of the first point failed, and one of the second is infinite. The lift is there for two seeds."""

    def write(name="drag.nc", shift=0.0, edit=lambda runs: runs):
        rng = np.random.default_rng([2, int(shift)])
        drag = 100.0 + shift + rng.normal(0.0, 5.0, (3, 4, 6))
        drag[0, 3], drag[1, 0] = np.nan, np.inf
        runs = dataset_of(drag[..., 0], {"point": [0, 1, 2]}).isel(displacement=0, drop=True)
        dims, newtons = runs["run_id"].dims, {"units": "N"}
        numbers = [[f"{shift:g} {point} {seed}" for seed in range(4)] for point in range(3)]
        lift = runs["drag"].where(runs["seed"] < 2).assign_attrs(newtons)
        runs = runs.assign(
            drag=((*dims, "displacement"), drag, newtons), run_id=(dims, numbers), lift=lift
        )
        runs["point"].attrs = {"long_name": POINT, "units": "1"}
        friction = "point", [0.1, 0.2, 0.3], {"units": "1"}
        runs = runs.assign_coords(friction_granule=friction, displacement=1e-3 * np.arange(6))
        runs.attrs |= {"window_start": 1e-3, "window_stop": 4e-3, "title": "three points"}
        edit(runs).to_netcdf(tmp_path / name)
        return tmp_path / name

    return write


def runs_of(path):
    """Mean drag (point, seed) of the runs within the window, from 1 to 4 mm; NaN where a run failed."""
    with xr.open_dataset(path) as dataset:
        drag = dataset["drag"].values[:, :, 1:5].mean(2)
    return np.where(np.isfinite(drag), drag, np.nan)


def test_means_are_of_the_runs_that_did_not_fail_wherever_they_are_shown(file, tmp_path):
    """In the file, in the table, on the terminal and for figures; each quantity counts its own runs."""
    path, runs = file(), runs_of(file())
    half = [mean_interval(row).half for row in runs]
    for name in ("means.csv", "means.nc"):
        write_means(means(path), tmp_path / name)
    table = pd.read_csv(tmp_path / "means.csv")
    np.testing.assert_allclose(table["drag (N)"], np.nanmean(runs, 1))
    np.testing.assert_allclose(table["drag_half_interval (N)"], half)
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
    paths = file(), file("other.nc", 50.0, lambda runs: runs.isel(point=[1, 2]))
    result = compared(*paths, "drag")
    assert result["point"].values.tolist() == [1, 2]
    samples = zip(runs_of(paths[0])[1:], runs_of(paths[1]), strict=True)
    rows = [
        [np.nanmean(first), np.nanmean(second), *ratio_interval(second, first)]
        for first, second in samples
    ]
    names = ["first", "second", "ratio", "ratio_low", "ratio_high"]
    np.testing.assert_allclose(result[names].to_dataframe()[names], rows)
    printed = CliRunner().invoke(app, ["means", *map(str, paths)]).output
    assert all(f"{ratio:.5g}" in printed for ratio in result["ratio"].values)


def test_runs_that_both_files_have_count_for_the_first_alone(file):
    """Fieller's interval is of independent samples."""

    def apart(dataset):  # the first two seeds have the same runs
        of_both = dataset["run_id"].str.replace("50 ", "0 ")
        return dataset.assign(run_id=of_both.where(dataset["seed"] < 2, dataset["run_id"]))

    first, other = file(), file("other.nc", 50.0, apart)
    result = compared(first, other, "drag")
    np.testing.assert_allclose(result["first"], np.nanmean(runs_of(first), 1))
    np.testing.assert_allclose(result["second"], np.nanmean(runs_of(other)[:, 2:], 1))
    assert compared(first, file("same.nc"), "drag")["ratio"].isnull().all()


def test_means_of_an_experiment_of_ones_own_are_of_its_first_quantity(file):
    """Where it has no drag, as the page of experiments says; also beside another file."""
    paths = [
        str(file(name, edit=lambda runs: runs.rename(drag="mine"))) for name in ("a.nc", "b.nc")
    ]
    for words, shown in ((paths[:1], "mine (N)"), (paths, "ratio")):
        run = CliRunner().invoke(app, ["means", *words])
        assert run.exit_code == 0 and shown in run.output, run.output


@pytest.mark.parametrize(
    "edit",
    [
        lambda runs: runs.assign_coords(friction_granule=runs["friction_granule"] + 0.1),
        lambda runs: runs.rename(friction_granule="friction_boundary"),
        lambda runs: runs.isel(point=[2]).assign_coords(point=[7]),
    ],
)
def test_points_of_different_designs_are_no_pairs(file, edit):
    """They have numbers, and the same number means nothing."""
    with pytest.raises(InputError, match="have no point in common"):
        compared(file(), file("other.nc", edit=edit), "drag")


def test_points_of_a_name_are_compared_whatever_their_granules_are(file):
    """And the table leaves out what differs."""

    def named(granules):
        more = {"case": ("point", ["a", "b", "c"]), "granules": ("point", granules)}
        names = ["point", "friction_granule"]
        return lambda runs: runs.drop_vars(names).assign_coords(more).swap_dims(point="case")

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
    names = [f"quantity_of_a_long_name_{n:02d}" for n in range(20)]
    print_or_write(TextTable(pd.DataFrame(1.0 / 3.0, range(3), names)), None)
    assert capsys.readouterr().out.splitlines()[0].split() == names


@pytest.mark.parametrize("name", ["pressure", "shear", "velocity"])
def test_every_released_file_of_runs_has_a_summary(name):
    """Also where it holds less than a sweep writes."""
    path = ROOT / f"studies/{name}/{name}.nc"
    assert not path.is_file() or re.search("±|half_interval", text_of(summary(path)))
