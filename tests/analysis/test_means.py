"""Means of all points as a table, and two sweeps side by side."""

import csv
import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from pictures import text_of
from scipy import stats
from typer.testing import CliRunner

import dem
from dem.analysis.drag import summarise
from dem.analysis.means import compared, means, table_of, write_means
from dem.analysis.tables import TextTable
from dem.base.errors import InputError
from dem.base.source_hash import ROOT
from dem.base.statistics import mean_interval
from dem.cli.app import app
from dem.cli.show import print_or_write
from dem.report.info import summary
from dem.sweep.axis import POINT

FILES = [
    ROOT / path
    for path in (
        "docs/data/precise.nc",
        *(f"studies/{name}/{name}.nc" for name in ("pressure", "shear", "velocity")),
    )
    if (ROOT / path).is_file()
]


@pytest.fixture
def file(tmp_path):
    """Writes a combined file of a design of three points with four seeds; shift (N): of all drags."""

    def write(name="drag.nc", shift=0.0, points=(0, 1, 2)):
        rng = np.random.default_rng(2)
        drag = 100.0 + shift + rng.normal(0.0, 5.0, (3, 4, 6))
        dataset = xr.Dataset(
            {
                "drag": (("point", "seed", "displacement"), drag, {"units": "N"}),
                "run_id": (
                    ("point", "seed"),
                    [[f"{shift:g} {4 * k + n}" for n in range(4)] for k in range(3)],
                ),
            },
            {
                "point": ("point", [0, 1, 2], {"long_name": POINT, "units": "1"}),
                "friction_granule": ("point", [0.1, 0.2, 0.3], {"units": "1"}),
                "seed": [1, 2, 3, 4],
                "displacement": np.arange(6) * 1e-3,
            },
            {"window_start": 1e-3, "window_stop": 4e-3, "title": "three points"},
        )
        dataset.isel(point=list(points)).to_netcdf(tmp_path / name)
        return tmp_path / name

    return write


def test_the_mean_of_a_point_is_that_of_its_runs_within_the_window(file, tmp_path):
    write_means(means(file()), tmp_path / "means.csv")
    with dem.open_results(file()) as dataset:
        runs = dataset["drag"].values[:, :, 1:5].mean(2)  # from 1 to 4 mm
    rows = list(csv.DictReader((tmp_path / "means.csv").open()))
    assert [float(row["drag (N)"]) for row in rows] == pytest.approx(runs.mean(1))
    half = stats.t.ppf(0.975, 3) * runs.std(1, ddof=1) / 2.0
    assert [float(row["drag_half_interval (N)"]) for row in rows] == pytest.approx(half)
    assert [row["friction_granule"] for row in rows] == ["0.1", "0.2", "0.3"]
    assert "point" not in rows[0]  # its number
    assert {row["drag_runs"] for row in rows} == {"4"}
    write_means(means(file()), tmp_path / "means.nc")
    with dem.open_results(tmp_path / "means.nc") as result:
        assert result["drag"].dims == ("point",) and result["drag"].attrs["units"] == "N"


def test_two_sweeps_are_compared_where_both_have_a_point(file):
    result = compared(file(), file("other.nc", shift=50.0, points=(1, 2)), "drag")
    assert result["point"].values.tolist() == [1, 2]
    assert result["ratio"].values == pytest.approx(
        (result["first"].values + 50.0) / result["first"].values
    )
    assert (result["ratio_low"] < result["ratio"]).all() and (
        result["ratio"] < result["ratio_high"]
    ).all()


def test_the_terminal_shows_one_quantity_by_what_varies(file):
    text = CliRunner().invoke(app, ["means", str(file())]).output
    assert "friction_granule" in text and "drag (N)" in text and len(table_of(means(file()))) == 3
    info = CliRunner().invoke(app, ["means", str(file()), "--of", "lift"])
    assert info.exit_code == 2


def test_means_of_an_experiment_of_ones_own_are_of_its_first_quantity(file):
    """Where it has no drag, as the page of experiments says; also beside another file."""
    paths = [changed(file(name), lambda d: d.rename(drag="mine")) for name in ("a.nc", "b.nc")]
    for words in (paths[:1], paths):
        run = CliRunner().invoke(app, ["means", *map(str, words)])
        assert run.exit_code == 0 and ("mine" in run.output or "ratio" in run.output), run.output


@pytest.mark.parametrize(
    "call, words",
    [
        (
            lambda f, d: write_means(means(f()), d / "means.txt"),
            "of a file that ends in .csv or .nc",
        ),
        (lambda f, d: compared(f(), f("o.nc"), "lift"), "it has no lift; it has drag"),
        (
            lambda f, d: compared(f(points=[0]), f("o.nc", points=[2]), "drag"),
            "have no point in common",
        ),
    ],
)
def test_what_cannot_be_shown_is_refused(file, tmp_path, call, words):
    with pytest.raises(InputError, match=words):
        call(file, tmp_path)


def changed(path, edit):
    """Write a file again as `edit` has it."""
    with xr.open_dataset(path) as dataset:
        result = edit(dataset.load())
    result.to_netcdf(path)
    return path


def test_each_quantity_counts_its_own_runs(file):
    def edit(dataset):
        lift = (
            dataset["drag"].where(dataset["seed"] < 3).mean("displacement").assign_attrs(units="N")
        )
        return dataset.assign(lift=lift)

    result = means(changed(file(), edit))
    assert (result["drag_runs"] == 4).all() and (result["lift_runs"] == 2).all()


def test_an_infinite_result_counts_as_none_wherever_means_are_shown(file):
    def edit(dataset):
        dataset["drag"][0, 0] = np.inf
        return dataset

    path = changed(file(), edit)
    data = means(path)
    with dem.open_results(path) as dataset:
        of_drag = summarise(dataset)
    mean = mean_interval(of_drag["run_mean"][0])
    assert data["drag"][0] == pytest.approx(mean.value) == of_drag["mean"][0]
    assert data["drag_half_interval"][0] == pytest.approx(mean.half) == of_drag["half_interval"][0]
    assert data["drag_runs"][0] == 3


def test_points_of_different_designs_are_no_pairs(file):
    """They have numbers, and the same number means nothing."""
    other = changed(
        file("other.nc"), lambda d: d.assign_coords(friction_granule=d["friction_granule"] + 0.1)
    )
    third = changed(file("third.nc"), lambda d: d.rename(friction_granule="friction_boundary"))
    for path in (other, third):
        with pytest.raises(InputError, match="have no point in common"):
            compared(file(), path, "drag")


def test_runs_that_both_files_have_count_once(file):
    """Fieller's interval is of independent samples."""

    def apart(dataset):  # the seeds 1 and 2 have the same runs
        of_both = dataset["run_id"].str.replace("50 ", "0 ")
        return dataset.assign(run_id=of_both.where(dataset["seed"] < 3, dataset["run_id"]))

    other = changed(file("other.nc", shift=50.0), apart)
    result = compared(file(), other, "drag")
    with dem.open_results(file("other.nc", shift=50.0)) as dataset:
        runs = summarise(dataset)["run_mean"]
    np.testing.assert_allclose(result["second"], runs.sel(seed=[3, 4]).mean("seed"))
    assert compared(file(), file("same.nc"), "drag")["ratio"].isnull().all()


def test_points_of_a_name_are_compared_whatever_their_granules_are(file):
    """And the table leaves out what differs."""

    def named(granules):
        coordinates = {"case": ("point", ["a", "b", "c"]), "granules": ("point", granules)}
        return lambda d: (
            d.drop_vars(["point", "friction_granule"])
            .assign_coords(coordinates)
            .swap_dims(point="case")
        )

    one = changed(file("one.nc"), named([60, 60, 60]))
    two = changed(file("two.nc"), named([60, 90, 60]))
    table = table_of(compared(one, two, "drag"))
    assert len(table) == 3 and "granules" not in table


@pytest.mark.parametrize("width", [30, 80, 1000])
def test_no_number_of_a_table_is_cut(width):
    """On a narrow terminal the last columns are below, beside the first one again."""
    values = {f"value {n}": [f"{row}.{n:09d}" for row in range(3)] for n in range(11)}
    frame = pd.DataFrame({"row": ["row0", "row1", "row2"]} | values)
    lines = text_of(TextTable(frame), width).splitlines()
    assert max(map(len, lines)) <= width
    for row in frame.itertuples(index=False):
        assert {cell for line in lines if row[0] in line for cell in line.split()} == set(row)


def test_a_pipe_gets_tables_as_wide_as_they_are(file, capsys):
    names = {
        f"quantity_of_a_long_name_{number:02d}": ("point", [1.0 / 3.0] * 3) for number in range(20)
    }
    print_or_write(TextTable(table_of(xr.Dataset(names))), None)
    assert capsys.readouterr().out.splitlines()[0].split() == ["point", *names]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_released_file_of_runs_has_a_summary(path):
    """Also where it holds less than a sweep writes."""
    assert re.search("±|half_interval", text_of(summary(path)))
