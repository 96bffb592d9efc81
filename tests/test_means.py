"""Means of all places as a table, and two sweeps side by side."""

import csv

import numpy as np
import pytest
import xarray as xr
from scipy import stats
from typer.testing import CliRunner

import dem
from dem.analysis.means import compared, means, table_of, write_means
from dem.base.errors import InputError
from dem.cli.app import app
from dem.io.checksums import seal
from dem.sweep.axis import POINT


@pytest.fixture
def file(tmp_path):
    """Writes a combined file of a design of three points with four seeds; shift (N): of all drags."""

    def write(name="drag.nc", shift=0.0, points=(0, 1, 2)):
        rng = np.random.default_rng(2)
        drag = 100.0 + shift + rng.normal(0.0, 5.0, (3, 4, 6))
        dataset = xr.Dataset(
            {"drag": (("point", "seed", "displacement"), drag, {"units": "N"}),
             "run_id": (("point", "seed"), np.arange(12).reshape(3, 4).astype(str))},
            {"point": ("point", [0, 1, 2], {"long_name": POINT, "units": "1"}),
             "friction_granule": ("point", [0.1, 0.2, 0.3], {"units": "1"}),
             "seed": [1, 2, 3, 4], "displacement": np.arange(6) * 1e-3},
            {"window_start": 1e-3, "window_stop": 4e-3, "title": "three points"},
        )  # fmt: skip
        dataset.isel(point=list(points)).to_netcdf(tmp_path / name)
        seal(tmp_path / name)
        return tmp_path / name

    return write


def test_the_mean_of_a_place_is_that_of_its_runs_within_the_window(file, tmp_path):
    write_means(means(file()), tmp_path / "means.csv")
    with dem.open_results(file()) as dataset:
        runs = dataset["drag"].values[:, :, 1:5].mean(2)  # from 1 to 4 mm
    rows = list(csv.DictReader((tmp_path / "means.csv").open()))
    assert [float(row["drag (N)"]) for row in rows] == pytest.approx(runs.mean(1))
    half = stats.t.ppf(0.975, 3) * runs.std(1, ddof=1) / 2.0
    assert [float(row["drag_half_interval (N)"]) for row in rows] == pytest.approx(half)
    # the values that vary, and not the number of the point
    assert [row["friction_granule"] for row in rows] == ["0.1", "0.2", "0.3"] and "point" not in rows[0]
    assert {row["runs"] for row in rows} == {"4"}


def test_means_can_be_opened_as_results(file, tmp_path):
    write_means(means(file()), tmp_path / "means.nc")
    with dem.open_results(tmp_path / "means.nc") as found:
        assert found["drag"].dims == ("point",) and found["drag"].attrs["units"] == "N"


def test_two_sweeps_are_compared_where_both_have_a_place(file):
    found = compared(file(), file("other.nc", shift=50.0, points=(1, 2)), "drag")
    assert found["point"].values.tolist() == [1, 2]
    assert found["ratio"].values == pytest.approx((found["first"].values + 50.0) / found["first"].values)
    assert (found["ratio_low"] < found["ratio"]).all() and (found["ratio"] < found["ratio_high"]).all()
    same = compared(file(), file(), "drag")
    assert (same["ratio"] == 1.0).all()


def test_the_terminal_shows_one_quantity_by_what_varies(file):
    shown = CliRunner().invoke(app, ["means", str(file())]).output
    assert "friction_granule" in shown and "drag (N)" in shown and len(table_of(means(file()))) == 3
    info = CliRunner().invoke(app, ["means", str(file()), "--of", "lift"])
    assert info.exit_code == 2


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda f, d: write_means(means(f()), d / "means.txt"), "it must end in .csv or .nc"),
        (lambda f, d: compared(f(), f("o.nc"), "lift"), "it has no lift; it has drag"),
        (lambda f, d: compared(f(points=[0]), f("o.nc", points=[2]), "drag"), "have no place in common"),
    ],
)
def test_what_cannot_be_shown_is_refused(file, tmp_path, call, words):
    with pytest.raises(InputError, match=words):
        call(file, tmp_path)
