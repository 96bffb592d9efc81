"""The study measures how far off a curve is, and would show that points are placed well or badly."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made import SMOKE, assert_shown_and_drawn, run_all

from dem.io.dataset import global_attributes, write
from dem.io.lazily import open_lazily
from dem.sweep.campaign import Campaign
from dem.sweep.config import parse
from studies.refinement import curves
from studies.refinement.curves import GRID, HYPERCUBE, REFINED, Curves
from studies.refinement.findings import refinement
from studies.refinement.layout import VARIABLES
from studies.refinement.table import make

LOW, HIGH, SCATTER, BEDS = 0.125, 32.0, 0.02, 12


def step(velocity):
    """A curve that rises about 8 m/s only."""
    return 1000.0 * (1.0 + 1.0 / (1.0 + np.exp(-12.0 * np.log(velocity / 8.0))))


def write_runs(path, law, scatter=SCATTER, seed=1):
    """Grids, a hypercube and refined points, of which those of the second round are about the step. Beds scatter
    more than that, alike at all velocities."""
    rng, rows = np.random.default_rng(seed), []
    beds = rng.normal(1.0, 5.0 * scatter, BEDS)

    def add(part, velocities, rounds=0):
        rounds = np.broadcast_to(rounds, len(velocities))
        for velocity, number in zip(velocities, rounds, strict=True):
            rows.extend({
                "part": part, "velocity": velocity, "seed": bed, "round": number,
                "drag": law(velocity) * beds[bed] * rng.normal(1.0, scatter),
            } for bed in range(BEDS))  # fmt: skip

    grid, around = np.geomspace(LOW, HIGH, 17), np.geomspace(5.6, 11.5, 4)
    add("held", np.geomspace(0.15, 29.0, 23))
    add(GRID, grid)
    add("hypercube_9", grid[:-1:2] * 1.07)
    add(REFINED, np.append(grid[::4], around), [0] * 5 + [1] * 4)
    values = {f"run_{key}": np.array([row[key] for row in rows]) for key in rows[0]}
    origin = {"versions": "", "git_revision": "", "source_hash": ""}
    write(path, values, global_attributes("refinement", "test", **origin), VARIABLES)


@pytest.fixture(autouse=True)
def few(monkeypatch):
    monkeypatch.setattr(curves, "DRAWS", 25)


def curves_of(path):
    with open_lazily(path) as dataset:
        return Curves(dataset.load())


def test_points_where_the_curve_is_steep_are_worth_more_than_a_grid(tmp_path):
    write_runs(path := tmp_path / "refinement.nc", step)
    found = curves_of(path)
    refined = found.of(REFINED)[-1]
    assert refined.error[0] < 0.8 * found.of(GRID)[1].error[0]  # of as many points


def test_an_error_is_that_of_means_where_the_curve_is_flat(tmp_path):
    """Straight lines leave 2/3 of the variance of a mean, on average; what beds do alike is none."""
    squares = []
    for seed in range(12):
        write_runs(path := tmp_path / f"{seed}.nc", lambda velocity: 1000.0, seed=seed)
        found = curves_of(path)
        grid = found.designs[GRID][-1]
        squares.append([found.off(found.between(grid)) ** 2, found.off(found.read(grid)) ** 2, found.own() ** 2])
    straight, surrogate, own = np.mean(squares, axis=0)
    assert own == pytest.approx(SCATTER**2 / BEDS, rel=0.2)
    assert straight - own == pytest.approx(SCATTER**2 * 2.0 / 3.0 / BEDS, rel=0.5)
    assert surrogate - own < 0.6 * (straight - own)  # neighbours help


def test_the_file_can_be_shown_and_drawn(tmp_path):
    write_runs(path := tmp_path / "refinement.nc", step)
    assert_shown_and_drawn("refinement", path)


def test_every_run_is_a_row_with_the_round_of_its_point(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = {
        "held": {"shape": "c1", "cylinder.velocity": [3.0, 6.0], "seed": [1, 2]},
        "refined": {"shape": "c1", "cylinder.velocity": {"refine": "log", "low": 2.0, "high": 8.0, "until": "1 N", "least": 3, "most": 6}, "seed": [1, 2]},
    }
    record = {"observables": ["drag"], "bins": 12}
    work = Campaign(parse({"extends": str(SMOKE), "results": "results", "record": record, "sweep": {"blocks": blocks}}))
    monkeypatch.setattr("dem.sweep.refine.SURE", np.array([1.0, 1.0]))  # that beds suffice
    run_all(work)
    make(work, Path("refinement.nc"))
    found = xr.load_dataset("refinement.nc")
    rows = zip(*(found[f"run_{name}"].values.tolist() for name in ("part", "velocity", "seed", "round", "drag")), strict=True)
    rounds = {}
    for part, velocity, seed, number, drag in rows:
        run = xr.load_dataset(work.first(part)).sel(cylinder_velocity=velocity, seed=seed)
        inside = (run["displacement"] > run.attrs["window_start"]) & (run["displacement"] < run.attrs["window_stop"])
        assert drag == pytest.approx(float(run["drag"].where(inside).mean()))
        rounds.setdefault((part, number), set()).add(velocity)
    assert rounds[REFINED, 0] == {2.0, 4.0, 8.0}
    assert [len(rounds[REFINED, number]) for number in range(3)] == [3, 2, 1]


@pytest.mark.skipif(not refinement.path.is_file(), reason="refinement.nc is not there yet")
def test_the_released_curves_are_of_three_designs():
    assert {each.design for each in refinement.curves.errors} == {GRID, HYPERCUBE, REFINED}
