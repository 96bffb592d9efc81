"""The model finds what made the runs, and spends a budget as they ask for."""

import numpy as np
import pytest
import xarray as xr
from sweeps import SMOKE

from dem.sweep.config import parse
from dem.sweep.state import SweepState
from dem.sweep.workers import Workers
from studies.accuracy.budget.model import LEFT_OUT, PAPER, Model, Runs, Settings
from studies.accuracy.budget.results import VARIABLES, make
from studies.accuracy.budget.spend import WAYS, WINDOW, Shape, levels
from studies.accuracy.budget.trial import interval, ratio, tried

STOPS = np.linspace(1.0e-3, WINDOW, 11)[1:]
TRUE = Model(
    mean=1000.0,
    bounds=(3.0e-7, 5.0e-8),
    bed=(0.1, 1.1),
    run=(4.0e-6, 0.9),
    step=-4.0e5,
    box=(0.3, 0.05),
    scatter=(0.12, 0.5),
    stops=STOPS,
    window=np.linspace(-0.1, 0.0, 10),
    wider=np.linspace(1.4, 1.0, 10),
)


def runs_of(model: Model, beds: int, seed: int = 0) -> dict:
    """Runs that follow a model; those of one bed at several steps differ by a third of their
    scatter."""
    rng, rows = np.random.default_rng(seed), []

    def add(part, fraction, granules, first, stroke=WINDOW, count=beds):
        for number in range(count):
            at = Settings(fraction, granules, STOPS, stroke)
            deviation = np.random.default_rng([seed, first + number, granules]).normal()
            draw = (deviation + rng.normal() / 3.0) / np.hypot(1.0, 1.0 / 3.0)
            mean, time = (
                model.mean * (1.0 + model.biases(at).sum(axis=0)),
                model.time(at) * rng.normal(1.0, 0.02),
            )
            bed = model.bed[0] * (granules / PAPER) ** model.bed[1]
            rows.append(
                {
                    "part": part,
                    "shape": "c1",
                    "seed": first + number,
                    "fraction": fraction,
                    "granules": granules,
                    "stroke": stroke,
                    "drag": mean + model.mean * model.spread(at) * draw,
                    "time": time - bed,
                    "time_step": float(model.time_step(fraction)),
                    "spent": time - bed * (part == "steps"),
                }
            )

    add("reference", 0.1, PAPER, 0, count=4 * beds)
    for fraction in (0.2, 0.3, 0.5, LEFT_OUT, 0.95):
        add("steps", fraction, PAPER, 0)
    for granules in (100, 200, 800):
        add("boxes", 0.5, granules, 0)
    add("held", LEFT_OUT, 283, 5000)
    add("recommended_1", 0.5, PAPER, 9000, count=400)
    for way, at in WAYS.items():
        add(f"{way}_1", at.fraction, at.granules, 9000, at.stroke, 400)
    return {f"run_{key}": np.array([row[key] for row in rows]) for key in rows[0]} | {
        "window_stop": STOPS
    }


@pytest.fixture(scope="module")
def dataset():
    return xr.Dataset(
        {name: (VARIABLES[name][0], values) for name, values in runs_of(TRUE, 300).items()}
    )


def test_the_model_finds_what_made_the_runs(dataset):
    model = Runs(dataset, "c1").fit()
    off = {"mean": 0.03, "bounds": 1e-6, "bed": 0.05, "run": 0.05, "scatter": 0.15}
    for name, share in off.items():
        assert getattr(model, name) == pytest.approx(getattr(TRUE, name), rel=share), name
    assert model.step == pytest.approx(TRUE.step, abs=3e5)
    assert model.box == pytest.approx(TRUE.box, abs=0.03)
    assert model.window == pytest.approx(TRUE.window, abs=0.02)
    assert model.wider == pytest.approx(TRUE.wider, rel=0.1)


def test_an_error_is_that_of_means_drawn_with_these_settings(dataset):
    """Root mean square over many draws from what made the runs, where biases do not cancel by
    chance."""
    shape, rng = Shape(dataset, "c1"), np.random.default_rng(5)
    for at in (
        Settings(0.3, PAPER, WINDOW, WINDOW),
        Settings(0.1, 200, WINDOW, WINDOW),
        Settings(0.1, PAPER, 3.0e-3, 3.0e-3),
    ):
        spent = shape.spent(at, 30.0)
        off = TRUE.biases(at).sum() + TRUE.spread(at) * rng.normal(size=(4000, spent.runs)).mean(
            axis=1
        )
        assert spent.error == pytest.approx(np.sqrt((off**2).mean()), rel=0.15)


def test_two_levels_gain_nothing_where_coarse_runs_are_dear(dataset):
    """A bed's runs correlate by 0.9: 1 / (1 + 1/9)."""
    level = levels(Shape(dataset, "c1"), 0.3, 0.1)
    assert level.correlation[0] == pytest.approx(0.9, abs=0.03)
    assert level.correlation[1] < level.correlation[0] < level.correlation[2]
    assert level.gain[2] < 1.0  # three times the step is not thrice as fast, because of damping


def test_two_levels_take_what_the_best_numbers_of_runs_take(dataset):
    """Among all numbers of runs, by the times that the runs of the file took: a bed is packed
    once for both steps."""
    table = Runs(dataset, "c1").table
    beds = range(300)
    coarse, fine = (
        table[table.fraction == f].set_index("seed").query("granules == @PAPER").loc[beds]
        for f in (0.3, 0.1)
    )
    fine, coarse = fine[fine.part == "reference"], coarse[coarse.part == "steps"]
    single, both = fine.spent.mean(), fine.spent.mean() + coarse.spent.mean()
    packed = coarse.spent.mean() + fine.spent.mean() - fine.time.mean()
    runs = np.arange(1, 400)
    one, two = runs[:, None], runs[None]
    variance = coarse.drag.var() / one + (fine.drag - coarse.drag).var() / two
    least = (variance * (one * packed + two * both)).min()
    assert levels(Shape(dataset, "c1"), 0.3, 0.1).gain[0] == pytest.approx(
        fine.drag.var() * single / least, rel=0.03
    )


def test_repetitions_show_a_bias_and_a_scatter(dataset):
    """Means that are a tenth too large are off by a tenth."""
    off = dataset.copy(deep=True)
    rows = off["run_part"].values == "paper_1"
    off["run_drag"][rows] = off["run_drag"][rows] * 1.1
    ways = tried(Shape(off, "c1"))
    for error in map(interval, (ways["paper"].repeated, ways["paper"].whole)):
        assert error[0] == pytest.approx(0.1, abs=0.02)
        assert error[1] < error[0] < error[2]
    assert ways["default"].whole[0] < 0.05
    assert ways["paper"].time == pytest.approx(ways["default"].time, rel=0.1)


def test_a_way_that_scatters_less_has_the_smaller_error_by_as_much(dataset):
    """By all runs and by the repetitions, within the intervals of the ratio."""
    wide = dataset.copy(deep=True)
    rows = wide["run_part"].values == "paper_1"
    wide["run_drag"][rows] = 3.0 * wide["run_drag"][rows] - 2.0 * wide["run_drag"][rows].mean("run")
    ways = [tried(Shape(wide, "c1"))]
    reference = [tried(Shape(dataset, "c1"))]
    for by in ("repeated", "whole"):
        value, low, high = ratio(ways, "recommended", "paper", by)
        assert low < 1.0 / 3.0 < high
        assert value == pytest.approx(
            ratio(reference, "recommended", "paper", by)[0] / 3.0, rel=0.25
        )


def test_every_run_is_a_row_with_what_it_gave(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = {
        "reference": {"shape": "c1", "seed": [1, 2]},
        "steps": {"shape": ["c1", "d1"], "numerics.step_fraction": [0.5, 0.9], "seed": 1},
        "boxes": {
            "values": {"shapes.c1.granules": 30, "box_width": 6.0e-3},
            "shape": "c1",
            "seed": 3,
        },
    }
    record = {"observables": ["drag"], "bins": 12}
    values = {"extends": str(SMOKE), "results": "results", "record": record}
    work = SweepState(parse(values | {"sweep": {"blocks": blocks}}))
    work.make(Workers())
    values, _ = make(work, 1, lambda share: None)
    rows = xr.Dataset({name: (VARIABLES[name][0], array) for name, array in values.items()})
    assert rows.sizes["run"] == 2 + 4 + 1
    for number in range(rows.sizes["run"]):
        row = rows.isel(run=number)
        at = {
            "seed": int(row["run_seed"]),
            "shape": str(row["run_shape"].values),
            "numerics_step_fraction": float(row["run_fraction"]),
        }
        drags = xr.load_dataset(work.combined(str(row["run_part"].values))[0])
        run = drags.sel({key: value for key, value in at.items() if key in drags.dims})
        inside = (run["displacement"] > drags.attrs["window_start"]) & (
            run["displacement"] < drags.attrs["window_stop"]
        )
        assert float(row["run_drag"][-1]) == pytest.approx(float(run["drag"].where(inside).mean()))
        assert float(row["run_time"]) == float(run["run_time"])
        assert float(row["run_time_step"]) * int(run["steps"]) * 2.0 == pytest.approx(
            float(row["run_stroke"])
        )  # at 2 m/s
        assert int(row["run_granules"]) == int(run["granules"])
