"""The model finds what made the runs, and spends a budget as they ask for."""

import numpy as np
import pytest
import xarray as xr
from sweeps import SMOKE

from dem.analysis.drag import within
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


@pytest.fixture(scope="module")
def dataset():
    """Runs that follow the model; those of one bed at several steps differ by a third of their
    scatter."""
    rng, parts = np.random.default_rng(0), []

    def add(part, fraction, granules, first, stroke=WINDOW, count=300):
        at = Settings(fraction, granules, STOPS, stroke)
        of_bed = np.random.default_rng([first, granules]).normal(size=count)
        draw = (of_bed + rng.normal(size=count) / 3.0) / np.hypot(1.0, 1.0 / 3.0)
        drag = 1.0 + TRUE.biases(at).sum(axis=0) + TRUE.spread(at) * draw[:, None]
        time = TRUE.time(at) * rng.normal(1.0, 0.02, count)
        bed = TRUE.bed[0] * (granules / PAPER) ** TRUE.bed[1]
        values = {
            "part": part,
            "shape": "c1",
            "seed": first + np.arange(count),
            "fraction": fraction,
            "granules": granules,
            "stroke": stroke,
            "time": time - bed,
            "time_step": TRUE.time_step(fraction),
            "spent": time - bed * (part == "steps"),
        }
        runs = {f"run_{name}": ("run", np.resize(value, count)) for name, value in values.items()}
        parts.append(xr.Dataset(runs | {"run_drag": (("run", "window_stop"), TRUE.mean * drag)}))

    add("reference", 0.1, PAPER, 0, count=1200)
    for fraction in (0.2, 0.3, 0.5, LEFT_OUT, 0.95):
        add("steps", fraction, PAPER, 0)
    for granules in (100, 200, 800):
        add("boxes", 0.5, granules, 0)
    add("recommended_1", 0.5, PAPER, 9000, count=400)
    for way, at in WAYS.items():
        add(f"{way}_1", at.fraction, at.granules, 9000, at.stroke, 400)
    return xr.concat(parts, "run").assign(window_stop=STOPS)


def test_the_model_finds_what_made_the_runs(dataset):
    model = Runs(dataset, "c1").fit()
    off = {"mean": 0.03, "bounds": 1e-6, "bed": 0.05, "run": 0.05, "scatter": 0.15, "wider": 0.1}
    for name, share in off.items():
        assert getattr(model, name) == pytest.approx(getattr(TRUE, name), rel=share), name
    for name, share in {"step": 3e5, "box": 0.03, "window": 0.02}.items():
        assert getattr(model, name) == pytest.approx(getattr(TRUE, name), abs=share), name


def test_an_error_is_that_of_means_drawn_with_these_settings(dataset):
    """Root of the square of the bias and of the scatter of the mean, where biases do not cancel by
    chance."""
    shape = Shape(dataset, "c1")
    for fraction, granules, stop in (
        (0.3, PAPER, WINDOW),
        (0.1, 200, WINDOW),
        (0.1, PAPER, 3.0e-3),
    ):
        at = Settings(fraction, granules, stop, stop)
        spent = shape.spent(at, 30.0)
        error = np.hypot(TRUE.biases(at).sum(), TRUE.spread(at) / np.sqrt(spent.runs))
        assert spent.error == pytest.approx(error, rel=0.25)


def test_two_levels_take_what_the_best_numbers_of_runs_take(dataset):
    """Among all numbers of runs, by the times that the runs of the file took: a bed is packed
    once for both steps. Its runs correlate by 0.9: 1 / (1 + 1/9)."""
    table = Runs(dataset, "c1").table.set_index("seed")
    fine = table[table.part == "reference"].loc[:299]
    coarse = table[(table.part == "steps") & (table.fraction == 0.3)]
    single, both = fine.spent.mean(), fine.spent.mean() + coarse.spent.mean()
    packed = both - fine.time.mean()
    one, two = np.ogrid[1:400, 1:400]
    variance = coarse.drag.var() / one + (fine.drag - coarse.drag).var() / two
    least = (variance * (one * packed + two * both)).min()
    level = levels(Shape(dataset, "c1"), 0.3, 0.1)
    assert level.gain[0] == pytest.approx(fine.drag.var() * single / least, rel=0.03)
    assert level.correlation[0] == pytest.approx(0.9, abs=0.03)
    assert level.correlation[1] < level.correlation[0] < level.correlation[2]


def tried_with(dataset, change):
    """The ways where the drags of the paper's way are changed."""
    drag, mine = dataset["run_drag"], dataset["run_part"] == "paper_1"
    return tried(Shape(dataset.assign(run_drag=drag.where(~mine, change(drag.where(mine)))), "c1"))


def test_repetitions_show_a_bias_and_a_scatter(dataset):
    """Means that are a tenth too large are off by a tenth."""
    ways = tried_with(dataset, lambda drag: 1.1 * drag)
    for error in map(interval, (ways["paper"].repeated, ways["paper"].whole)):
        assert error[0] == pytest.approx(0.1, abs=0.02)
        assert error[1] < error[0] < error[2]
    assert ways["default"].whole[0] < 0.05
    assert ways["paper"].time == pytest.approx(ways["default"].time, rel=0.1)


def test_a_way_that_scatters_less_has_the_smaller_error_by_as_much(dataset):
    """By all runs and by the repetitions, within the intervals of the ratio."""
    ways = [tried_with(dataset, lambda drag: 3.0 * drag - 2.0 * drag.mean("run"))]
    reference = [tried(Shape(dataset, "c1"))]
    for by in ("repeated", "whole"):
        value, low, high = ratio(ways, "recommended", "paper", by)
        same, *_ = ratio(reference, "recommended", "paper", by)
        assert low < 1.0 / 3.0 < high
        assert value == pytest.approx(same / 3.0, rel=0.25)


def test_every_run_is_a_row_with_what_it_gave(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    box = {"shapes.c1.granules": 30, "box_width": 6.0e-3}
    blocks = {
        "reference": {"shape": "c1", "seed": [1, 2]},
        "steps": {"shape": ["c1", "d1"], "numerics.step_fraction": [0.5, 0.9], "seed": 1},
        "boxes": {"values": box, "shape": "c1", "seed": 3},
    }
    record = {"observables": ["drag"], "bins": 12}
    values = {"extends": str(SMOKE), "results": "results", "record": record}
    work = SweepState(parse(values | {"sweep": {"blocks": blocks}}))
    work.make(Workers())
    values, _ = make(work, 1, lambda share: None)
    rows = xr.Dataset({name: (VARIABLES[name][0], array) for name, array in values.items()})
    assert rows.sizes["run"] == 2 + 4 + 1
    for _, row in rows.groupby("run_time"):
        row = row.squeeze("run")
        file = xr.load_dataset(work.combined(row["run_part"].item())[0])
        names = {"seed": "seed", "shape": "shape", "numerics_step_fraction": "fraction"}
        run = file.sel({dim: row[f"run_{names[dim]}"] for dim in {*names} & {*file.dims}})
        drag = within(run["drag"], file.attrs["window_start"], file.attrs["window_stop"])
        assert row["run_drag"].values[-1] == pytest.approx(drag.mean().item())
        assert row["run_time"] == run["run_time"] and row["run_granules"] == run["granules"]
        moved = row["run_time_step"] * run["steps"] * 2.0  # at 2 m/s
        assert moved.item() == pytest.approx(row["run_stroke"].item())
