"""The study measures how far off a curve is, and would show that points are placed well or badly."""

import numpy as np
import pytest
from typer.testing import CliRunner

from conftest import assert_not_blank
from dem.figures.catalogue import draw
from dem.io.dataset import global_attributes, write
from dem.io.lazily import open_lazily
from studies.__main__ import app
from studies.catalogue import figures
from studies.refinement.curves import GRID, INTERPOLATED, REFINED, SURROGATE, Curves
from studies.refinement.findings import refinement
from studies.refinement.layout import VARIABLES

LOW, HIGH, SCATTER = 0.125, 32.0, 0.02


def step(velocity):
    """A curve that rises about 8 m/s only."""
    return 1000.0 * (1.0 + 1.0 / (1.0 + np.exp(-12.0 * np.log(velocity / 8.0))))


def write_runs(path, law, scatter=SCATTER):
    """Grids, a hypercube and refined points, of which those of the second round are about the step."""
    rng, rows = np.random.default_rng(1), []

    def add(part, velocities, seeds, rounds):
        for velocity, number in zip(velocities, rounds, strict=True):
            rows.extend({
                "part": part, "velocity": velocity, "seed": seed, "round": number, "spent": 1.0,
                "drag": law(velocity) * rng.normal(1.0, scatter),
            } for seed in range(seeds))  # fmt: skip

    grid, around = np.geomspace(LOW, HIGH, 17), np.geomspace(5.6, 11.5, 4)
    add("held", np.geomspace(0.15, 29.0, 23), 60, [0] * 23)
    add(GRID, grid, 12, [0] * 17)
    add("hypercube_9", grid[::2] * 1.07, 12, [0] * 9)
    for number in range(6):
        add(f"{REFINED}_{number}", np.append(grid[::4], around), 2, [0] * 5 + [1] * 4)
    values = {f"run_{key}": np.array([row[key] for row in rows]) for key in rows[0]}
    origin = {"versions": "", "git_revision": "", "source_hash": ""}
    write(path, values, global_attributes("refinement", "test", **origin), VARIABLES)


def curves_of(path):
    with open_lazily(path) as dataset:
        return Curves(dataset.load())


def test_points_where_the_curve_is_steep_are_worth_more_than_a_grid(tmp_path):
    write_runs(path := tmp_path / "refinement.nc", step)
    found = curves_of(path)
    assert found.of(REFINED)[-1].error[2] < found.of(GRID)[1].error[1]  # of as many points
    assert found.runs_for(0.01, GRID) > 18


def test_an_error_is_that_of_the_runs_where_the_curve_is_a_line(tmp_path):
    """Drag that does not vary: between two points half the variance is left in the middle, and 2/3 on average."""
    write_runs(path := tmp_path / "refinement.nc", lambda velocity: 1000.0)
    found = curves_of(path)
    expected = SCATTER / np.sqrt(2) * np.sqrt(2.0 / 3.0)
    assert found.of(GRID, INTERPOLATED)[-1].error[0] == pytest.approx(expected, rel=0.25)
    for points, each in zip((5, 9, 17), found.of(GRID, SURROGATE), strict=True):
        assert each.points == points
        assert each.error[0] < 0.8 * expected  # neighbours help


def test_the_file_can_be_shown_and_drawn(tmp_path):
    write_runs(path := tmp_path / "refinement.nc", step)
    run = CliRunner().invoke(app, ["refinement", "info", str(path)])
    assert run.exit_code == 0, run.output
    assert_not_blank(draw("refinement", path, tmp_path, figures())[1])


@pytest.mark.skipif(not refinement.path.is_file(), reason="refinement.nc is not there yet")
def test_the_released_curves_are_of_three_designs():
    assert {each.design for each in refinement.curves.errors} == {GRID, "hypercube", REFINED}
