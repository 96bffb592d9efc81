"""What a budget of processor time buys."""

from functools import cached_property

import numpy as np
from rich.table import Table

from studies.accuracy.budget import trial
from studies.accuracy.budget.model import LEFT_OUT, PAPER, Settings
from studies.accuracy.budget.spend import (
    FRACTIONS,
    WAYS,
    WINDOW,
    Levels,
    Shape,
    Spent,
    levels,
)
from studies.accuracy.budget.trial import NAMES, RUNS, Way
from studies.common.findings import Findings, clock, estimate, numbers, percent

__all__ = ["budget"]

BUDGETS = 10.0, 60.0, 600.0, 3600.0  # s of one core
LEVELS = (0.95, 0.1), (0.3, 0.1)
LONGEST = Settings(0.95, PAPER, WINDOW, WINDOW)
HELD = Settings(LEFT_OUT, 283, WINDOW, WINDOW), Settings(LEFT_OUT, PAPER, WINDOW, WINDOW)


def share(value: float) -> str:
    """A share in per cent; a dash where there is none."""
    return percent(value, 1) if np.isfinite(value) else "-"


def shares(values) -> str:
    """A share and the ends of its interval, in per cent."""
    return estimate(100.0 * np.asarray(values), "%", 1) if np.isfinite(values[0]) else "-"


class Budget(Findings):
    """Error of the mean drag against processor time, budget.nc."""

    name, command, needs = "budget", "snakemake -j2 budget", ("run_drag", "run_spent")
    repeated = RUNS

    @cached_property
    def shapes(self) -> dict[str, Shape]:
        """The shapes by their labels."""
        labels = dict.fromkeys(self.dataset["run_shape"].values.tolist())
        return {name: Shape(self.dataset, name) for name in labels}

    @cached_property
    def ways(self) -> dict[str, dict[str, Way]]:
        """By shape and name, what the same time gave in several ways."""
        return {name: trial.tried(shape) for name, shape in self.shapes.items()}

    @cached_property
    def best(self) -> dict[str, list[Spent]]:
        """By shape, the settings with the least error for each of BUDGETS."""
        return {name: [shape.best(s) for s in BUDGETS] for name, shape in self.shapes.items()}

    @property
    def paper_box(self) -> bool:
        """Whether the least error takes the paper's box and the whole window at every budget."""
        every = [spent.at for some in self.best.values() for spent in some]
        return all(at.granules == PAPER and at.stop == WINDOW for at in every)

    @property
    def shortest(self) -> bool:
        """Whether the least error of long budgets takes the shortest step, and that of the
        shortest the longest one."""
        steps = [[spent.at.fraction for spent in some] for some in self.best.values()]
        first, last = FRACTIONS[-1], FRACTIONS[0]
        return all(
            fractions[0] == first and fractions[-1] == fractions[-2] == last for fractions in steps
        )

    @property
    def faster(self) -> float:
        """Time of a run at the default step over that at the longest stable one, at most."""
        default = LONGEST._replace(fraction=0.3)
        models = [shape.model for shape in self.shapes.values()]
        return max(model.time(default) / model.time(LONGEST) for model in models)

    @property
    def spent(self) -> float:
        """Processor time (s) of all runs."""
        return float(self.dataset["run_spent"].sum())

    @property
    def beds(self) -> int:
        """Beds of a shape in the reference."""
        return np.unique(self.dataset["run_seed"][self.dataset["run_part"] == "reference"]).size

    @property
    def failed(self) -> str:
        """Runs that failed, of those in other boxes."""
        other = self.dataset["run_granules"] != PAPER
        return f"{int(self.dataset['run_drag'][:, -1].isnull()[other].sum())} of {int(other.sum())}"

    def bias(self, shape: str, part: int = 0, **changes) -> tuple[float, float]:
        """A bias of the longest stable step, with some settings changed, and half its interval;
        part: 0 of the step, 1 of the box, 2 of the window."""
        at, fitted = LONGEST._replace(**changes), self.shapes[shape]
        drawn = [model.biases(at)[part] for model in fitted.draws]
        return float(fitted.model.biases(at)[part]), 1.96 * float(np.std(drawn))

    @property
    def unbiased(self) -> bool:
        """Whether the biases of the longest stable step have intervals that hold zero."""
        return all(abs(value) < half for value, half in map(self.bias, self.shapes))

    def boxed(self, shape: str, granules: int) -> tuple[float, float]:
        """Change of the mean drag in another box, by its runs, and half its interval."""
        table = self.shapes[shape].runs.table
        one, two = (table[table.part == part] for part in ("boxes", "reference"))
        one, two = one.drag[one.granules == granules].dropna(), two.drag.dropna()
        ratio = one.mean() / two.mean()
        half = (
            1.96 * ratio * np.hypot(*(sample.sem(ddof=1) / sample.mean() for sample in (one, two)))
        )
        return ratio - 1.0, half

    def error(self, shape: str, seconds: float) -> str:
        """Least error of the mean drag of a shape by a budget of one core, with its interval."""
        spent = self.best[shape][BUDGETS.index(seconds)]
        return shares((spent.error, spent.low, spent.high))

    def frontier(self) -> Table:
        """Settings with the least error by budget of one core, and the errors of the default and
        of the paper's sweep there."""
        table = numbers(
            "shape",
            "budget",
            "step fraction",
            "granules",
            "mean to, mm",
            "runs",
            "error",
            "default",
            "paper's sweep",
            words=2,
        )
        for name, shape in self.shapes.items():
            for seconds, spent in zip(BUDGETS, self.best[name], strict=True):
                at, others = (
                    spent.at,
                    (shape.spent(way, seconds).error for way in WAYS.values()),
                )
                settings = f"{at.fraction:g}", f"{at.granules:.0f}", f"{1e3 * at.stop:.1f}"
                error = shares((spent.error, spent.low, spent.high))
                table.add_row(
                    name, clock(seconds), *settings, f"{spent.runs}", error, *map(share, others)
                )
        return table

    def model(self) -> Table:
        """The model: bias at the longest stable step, of half and of twice the granules, scatter
        and its power, times."""
        table = numbers(
            "shape",
            "mean, N",
            "step 0.95",
            "200 granules",
            "800 granules",
            "mean to 3 mm",
            "scatter",
            "power",
            "bed, s",
            "run, s",
        )
        for name, shape in self.shapes.items():
            model = shape.model
            step, window = self.bias(name), self.bias(name, 2, stop=3.0e-3)
            boxes = (
                f"{percent(self.boxed(name, n))}, {percent(model.biases(LONGEST._replace(granules=n))[1])}"
                for n in (200, 800)
            )
            (scatter, power), bed = model.scatter, model.bed[0]
            times = f"{bed:.2f}", f"{model.time(LONGEST) - bed:.2f}"
            cells = f"{model.mean:.0f}", percent(step, 1), *boxes, percent(window, 1)
            cells += share(scatter), f"{power:.2f}"
            table.add_row(name, *cells, *times)
        return table

    @cached_property
    def _checked(self) -> list[tuple]:
        """By shape and place that the model was not fitted to: times by the model and of runs;
        scatter and change by the model, of runs, and half their intervals."""
        places = []
        for name, shape in self.shapes.items():
            table, model = shape.runs.table, shape.model
            reference = table[table.part == "reference"].set_index("seed").drag
            for at in HELD:
                mine = (table.granules == at.granules) & (table.fraction == at.fraction)
                some = table[mine & table.part.isin(("held", "steps")) & table.drag.notna()]
                same = at.granules == PAPER  # the beds of the reference, each its own control
                time = some.time.median() + model.bed[0] if same else some.spent.median()
                scatter = some.drag.std() / model.mean
                base = some.seed.map(reference) if same else reference.mean()
                change = (some.drag - base) / model.mean
                error = np.hypot(change.sem(), 0.0 if same else reference.sem() / reference.mean())
                root = LONGEST._replace(fraction=0.1)
                predicted = (model.biases(at) - model.biases(root)).sum()
                spread = model.spread(at), scatter, 1.96 * scatter / np.sqrt(2.0 * len(some))
                times = model.time(at), time
                places.append((name, at, times, spread, (predicted, change.mean(), 1.96 * error)))
        return places

    @property
    def outside(self) -> str:
        """Scatters and changes of the model that are outside the intervals of the runs that it
        was not fitted to."""
        parts = [part for *_, spread, change in self._checked for part in (spread, change)]
        return f"{sum(abs(predicted - measured) > half for predicted, measured, half in parts)} of {len(parts)}"

    @property
    def slow(self) -> float:
        """By how much times of the model are off there, at most."""
        return max(
            abs(predicted / measured - 1.0) for _, _, (predicted, measured), *_ in self._checked
        )

    def checks(self) -> Table:
        """The model at places that it was not fitted to, against runs there: time of a run, its
        scatter over the mean, change of the mean."""
        heads = (
            "time, model, s",
            "time, runs, s",
            "scatter, model",
            "scatter, runs",
            "change, model",
            "change, runs",
        )
        table = numbers("shape", "granules", "step fraction", *heads)
        for name, at, times, *parts in self._checked:
            cells = [f"{time:.2f}" for time in times]
            for predicted, *measured in parts:
                cells += share(predicted), percent(measured, 1)
            table.add_row(name, f"{at.granules}", f"{at.fraction:g}", *cells)
        return table

    def _expected(self, shape: str, way: str) -> Spent:
        """What the model says of a way."""
        fitted, time = self.shapes[shape], self.ways[shape]["paper"].time
        return fitted.spent(WAYS[way], time) if way in WAYS else fitted.best(time)

    def trial(self) -> Table:
        """The same processor time spent in three ways, ten times each: error by these means, by
        all their runs, and by the model."""
        heads = "runs", "time, s", "error", "by all runs", "by the model"
        table = numbers("shape", "way", *heads, words=2)
        for name, ways in self.ways.items():
            for way, result in ways.items():
                errors = (
                    shares(trial.interval(sample)) for sample in (result.repeated, result.whole)
                )
                expected = share(self._expected(name, way).error)
                table.add_row(name, way, f"{result.runs}", f"{result.time:.1f}", *errors, expected)
        return table

    @property
    def as_tried(self) -> bool:
        """Whether the runs of the recommended way have the settings that the model recommends."""
        table = self.dataset[
            ["run_shape", "run_part", "run_fraction", "run_granules", "run_stroke"]
        ]
        table = table.to_dataframe()
        table = table[table.run_part.str.startswith(NAMES[-1])]
        settings = table.groupby("run_shape")[["run_fraction", "run_granules", "run_stroke"]]
        at = {name: self._expected(name, NAMES[-1]).at for name in self.ways}
        return all(
            (some == [at[name].fraction, at[name].granules, at[name].stroke]).all(axis=None)
            for name, some in settings
        )

    def ratio(self, other: str, by: str) -> np.ndarray:
        """Error of the recommended settings over that of another way, over all shapes, and the
        ends of its interval."""
        return trial.ratio(self.ways.values(), NAMES[-1], other, by)

    def decided(self, other: str, by: str) -> bool:
        """Whether the interval of that ratio is on one side of one."""
        _, low, high = self.ratio(other, by)
        return not low <= 1.0 <= high

    def expected(self, other: str) -> float:
        """That ratio by the model."""
        errors = [
            [self._expected(name, way).error for way in (NAMES[-1], other)] for name in self.ways
        ]
        return np.exp(np.mean([np.log(one / two) for one, two in errors]))

    @cached_property
    def every_level(self) -> dict[str, list[Levels]]:
        """By shape, what two levels of steps would gain."""
        return {
            name: [levels(shape, *pair) for pair in LEVELS] for name, shape in self.shapes.items()
        }

    @property
    def gain(self) -> float:
        """The most that two levels would gain."""
        return max(level.gain[2] for some in self.every_level.values() for level in some)

    def levels(self) -> Table:
        """Two steps of the same beds: correlation of their drags, and time of one level over
        that of two for the same error."""
        table = numbers("shape", "steps", "correlation", "time, one level / two levels", words=2)
        for name, some in self.every_level.items():
            for level in some:
                steps = f"{level.coarse:g} and {level.fine:g}"
                table.add_row(name, steps, estimate(level.correlation), estimate(level.gain))
        return table


budget = Budget()
