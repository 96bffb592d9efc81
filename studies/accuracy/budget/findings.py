"""What a budget of processor time buys."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.tables import numbers
from studies.accuracy.budget import trial
from studies.accuracy.budget.model import LEFT_OUT, PAPER, Settings
from studies.accuracy.budget.spend import FRACTIONS, WAYS, WINDOW, Levels, Shape, Spent, levels
from studies.accuracy.budget.trial import NAMES, RUNS, Way, ratio, tried
from studies.common.findings import Findings, clock, estimate, interval

__all__ = ["budget"]

BUDGETS = 10.0, 60.0, 600.0, 3600.0  # s of one core
LEVELS = (0.95, 0.1), (0.3, 0.1)
LONGEST = Settings(0.95, PAPER, WINDOW, WINDOW)
HELD = Settings(LEFT_OUT, 283, WINDOW, WINDOW), Settings(LEFT_OUT, PAPER, WINDOW, WINDOW)


def percent(share: float, digits: int = 1) -> str:
    """A share in per cent."""
    return f"{100.0 * share:.{digits}f} %" if np.isfinite(share) else "-"


def scatter_of(drags) -> float:
    """Standard error of a mean, over it."""
    return drags.std() / drags.mean() / drags.count() ** 0.5


def ends(spent: Spent) -> str:
    """An error with its interval."""
    return (
        estimate(100.0 * np.array([spent.error, spent.low, spent.high]), "%", 1)
        if np.isfinite(spent.error)
        else "-"
    )


class Budget(Findings):
    """Error of the mean drag against processor time, budget.nc."""

    name, command, needs = "budget", "snakemake -j2 budget", ("run_drag", "run_spent")

    @cached_property
    def shapes(self) -> dict[str, Shape]:
        """The shapes by their labels."""
        return {
            name: Shape(self.dataset, name)
            for name in dict.fromkeys(self.dataset["run_shape"].values.tolist())
        }

    @cached_property
    def ways(self) -> dict[str, list[Way]]:
        """By shape, what the same time gave in several ways."""
        return {name: tried(shape) for name, shape in self.shapes.items()}

    def frontier(self) -> Table:
        """Settings with the least error by budget of one core, and the errors of the default and of the paper's sweep there."""
        made = numbers(
            "shape",
            "budget",
            "step fraction",
            "granules",
            "mean to mm",
            "runs",
            "error",
            "default",
            "paper's sweep",
            words=2,
        )
        for name, shape in self.shapes.items():
            for seconds in BUDGETS:
                found = shape.best(seconds)
                others = (percent(shape.spent(at, seconds).error) for at in WAYS.values())
                made.add_row(
                    name, clock(seconds), f"{found.at.fraction:g}", f"{found.at.granules:.0f}", f"{1e3 * found.at.stop:.1f}",
                    f"{found.runs}", ends(found), *others,
                )  # fmt: skip
        return made

    def paper_box(self) -> bool:
        """Whether the least error takes the paper's box and the whole window at every budget."""
        best = [shape.best(seconds).at for shape in self.shapes.values() for seconds in BUDGETS]
        return all(at.granules == PAPER and at.stop == WINDOW for at in best)

    def dearest(self) -> float:
        """Time of a run at the default step over that at the longest stable one, at most."""
        return max(
            shape.model.time(LONGEST._replace(fraction=0.3)) / shape.model.time(LONGEST)
            for shape in self.shapes.values()
        )

    def boxed(self, shape: str, granules: int) -> str:
        """Change of the mean drag in another box, by its runs."""
        table = self.shapes[shape].runs.table
        one, two = (table.drag[table.part == part].dropna() for part in ("boxes", "reference"))
        one = one[table.granules == granules]
        ratio = one.mean() / two.mean()
        half = (
            1.96
            * ratio
            * np.hypot(*(each.std() / each.mean() / np.sqrt(len(each)) for each in (one, two)))
        )
        return interval(100.0 * (ratio - 1.0), 100.0 * half, "%", 0)

    def costs_nothing(self) -> bool:
        """Whether the interval of the bias of the longest stable step holds zero, for every shape."""
        found = [
            (s.model.biases(LONGEST)[0], np.std([m.biases(LONGEST)[0] for m in s.draws]))
            for s in self.shapes.values()
        ]
        return all(abs(value) < 1.96 * error for value, error in found)

    def shortest(self) -> bool:
        """Whether the least error of long budgets takes the shortest step, and that of the shortest the longest one."""
        fractions = [
            [shape.best(seconds).at.fraction for seconds in BUDGETS]
            for shape in self.shapes.values()
        ]
        return all(
            each[0] == FRACTIONS[-1] and each[-1] == each[-2] == FRACTIONS[0] for each in fractions
        )

    def hours(self) -> str:
        """Processor time of all runs."""
        return clock(float(self.dataset["run_spent"].sum()))

    def windowed(self, shape: str, stop: float) -> str:
        """By how much a mean that ends early is lower."""
        return percent(-self.shapes[shape].model.biases(LONGEST._replace(stop=stop))[2])

    def biased(self, shape: str) -> str:
        """Bias of the longest stable step, with its interval."""
        return self._interval(self.shapes[shape], LONGEST, 0)

    def _interval(self, shape: Shape, at: Settings, part: int) -> str:
        """A bias with its interval."""
        drawn = [model.biases(at)[part] for model in shape.draws]
        return interval(
            100.0 * float(shape.model.biases(at)[part]), 196.0 * float(np.std(drawn)), "%", 1
        )

    def beds(self) -> str:
        """Beds of a shape in the reference."""
        return (
            f"{np.unique(self.dataset['run_seed'][self.dataset['run_part'] == 'reference']).size}"
        )

    def failed(self) -> str:
        """Runs that failed, of those in other boxes."""
        other = self.dataset["run_granules"] != PAPER
        return f"{int(self.dataset['run_drag'][:, -1].isnull()[other].sum())} of {int(other.sum())}"

    def checks(self) -> Table:
        """The model at places that it was not fitted to, against runs there: time of a run, its scatter over the mean, change of the mean."""
        made = numbers(
            "shape",
            "granules",
            "step fraction",
            "time, model s",
            "found s",
            "scatter, model",
            "found",
            "change, model",
            "found",
            words=1,
        )
        for name, at, (time, own_time), *parts in self._checked():
            cells = (
                cell
                for told, *found in parts
                for cell in (percent(told), interval(*(100.0 * each for each in found), "%", 1))
            )
            made.add_row(
                name, f"{at.granules}", f"{at.fraction:g}", f"{time:.2f}", f"{own_time:.2f}", *cells
            )
        return made

    def _checked(self):
        """By shape and place, times by the model and of runs; scatter and change by the model, of runs, and half their intervals."""
        for name, shape in self.shapes.items():
            for at in HELD:
                some, model, root = (
                    self._held(name, at),
                    shape.model,
                    LONGEST._replace(fraction=0.1),
                )
                time = (
                    some.spent.median()
                    if at.granules != PAPER
                    else some.time.median() + model.bed[0]
                )
                scatter = some.drag.std() / model.mean
                reference = (
                    shape.runs.table[shape.runs.table.part == "reference"].set_index("seed").drag
                )
                same = at.granules == PAPER  # the beds of the reference, each its own control
                change = (
                    some.drag - (some.seed.map(reference) if same else reference.mean())
                ) / model.mean
                error = np.hypot(
                    change.std() / len(change) ** 0.5, 0.0 if same else scatter_of(reference)
                )
                told = (model.biases(at) - model.biases(root)).sum()
                yield (
                    name, at, (model.time(at), time),
                    (model.spread(at), scatter, 1.96 * scatter / np.sqrt(2.0 * len(some))), (told, change.mean(), 1.96 * error),
                )  # fmt: skip

    def outside(self) -> str:
        """Scatters and changes of the model that are outside the intervals of the runs that it was not fitted to."""
        parts = [part for _, _, _, *some in self._checked() for part in some]
        return f"{sum(abs(told - found) > half for told, found, half in parts)} of {len(parts)}"

    def slow(self) -> float:
        """By how much times of the model are off there, at most."""
        return max(abs(told / found - 1.0) for _, _, (told, found), *_ in self._checked())

    def _held(self, shape: str, at: Settings):
        """Runs at a place that was not fitted to."""
        table = self.shapes[shape].runs.table
        mine = (
            (table.granules == at.granules)
            & (table.fraction == at.fraction)
            & table.part.isin(("held", "steps"))
        )
        return table[mine & table.drag.notna()]

    def model(self) -> Table:
        """The model: bias at the longest stable step, of half and of twice the granules, scatter and its power, times."""
        made = numbers(
            "shape",
            "mean N",
            "step 0.95",
            "200 granules",
            "800 granules",
            "mean to 3 mm",
            "scatter",
            "power",
            "bed s",
            "run s",
        )
        for name, shape in self.shapes.items():
            own = shape.model
            boxes = (
                f"{self.boxed(name, granules)}, {percent(own.biases(LONGEST._replace(granules=granules))[1], 0)}"
                for granules in (200, 800)
            )
            cells = (
                self.biased(name),
                *boxes,
                self._interval(shape, LONGEST._replace(stop=3.0e-3), 2),
            )
            made.add_row(
                name, f"{own.mean:.0f}", *cells, percent(own.scatter[0]), f"{own.scatter[1]:.2f}", f"{own.bed[0]:.2f}",
                f"{own.time(LONGEST) - own.bed[0]:.2f}",
            )  # fmt: skip
        return made

    def trial(self) -> Table:
        """The same processor time spent in three ways, ten times each: error by these means, by all their runs, and by the model."""
        made = numbers(
            "shape", "way", "runs", "time s", "error", "by all runs", "by the model", words=2
        )
        for name, ways in self.ways.items():
            for way in ways:
                told = self._told(name, way)
                errors = (
                    estimate(100.0 * trial.interval(each), "%", 1)
                    for each in (way.repeated, way.whole)
                )
                made.add_row(
                    name, way.name, f"{way.runs}", f"{way.time:.1f}", *errors, percent(told.error)
                )
        return made

    def _told(self, shape: str, way: Way) -> Spent:
        """What the model says of a way."""
        time = {each.name: each for each in self.ways[shape]}["paper"].time
        own = self.shapes[shape]
        return own.spent(WAYS[way.name], time) if way.name in WAYS else own.best(time)

    def as_tried(self) -> bool:
        """Whether the runs of the recommended way have the settings that the model recommends."""
        table = self.dataset.isel(run=self.dataset["run_part"].str.startswith(NAMES[-1]).values)
        for name, ways in self.ways.items():
            at = self._told(name, ways[-1]).at
            own = table.isel(run=(table["run_shape"] == name).values)
            if not all(
                (own[f"run_{key}"] == getattr(at, key)).all()
                for key in ("fraction", "granules", "stroke")
            ):
                return False
        return True

    def tried(self) -> str:
        """Runs of the paper's sweep whose time is spent."""
        return f"{RUNS}"

    def ratio(self, other: str, by: str) -> str:
        """Error of the recommended settings over that of another way, over all shapes."""
        return estimate(ratio(list(self.ways.values()), NAMES[-1], other, by))

    def expected(self, other: str) -> str:
        """The same by the model."""
        logs = []
        for name, ways in self.ways.items():
            own = {way.name: self._told(name, way).error for way in ways}
            logs.append(np.log(own[NAMES[-1]] / own[other]))
        return f"{np.exp(np.mean(logs)):.2f}"

    def decided(self, other: str, by: str) -> bool:
        """Whether the interval of that ratio is on one side of one."""
        _, low, high = ratio(list(self.ways.values()), NAMES[-1], other, by)
        return not low <= 1.0 <= high

    @cached_property
    def every_level(self) -> dict[str, list[Levels]]:
        """By shape, what two levels of steps would gain."""
        return {
            name: [levels(shape, *each) for each in LEVELS] for name, shape in self.shapes.items()
        }

    def levels(self) -> Table:
        """Two steps of the same beds: correlation of their drags, and time of one level over that of two for the same error."""
        made = numbers("shape", "steps", "correlation", "time of one over two levels", words=2)
        for name, some in self.every_level.items():
            for each in some:
                made.add_row(
                    name,
                    f"{each.coarse:g} and {each.fine:g}",
                    estimate(each.correlation),
                    estimate(each.gain),
                )
        return made

    def gain(self) -> float:
        """The most that two levels would gain."""
        return max(each.gain[2] for some in self.every_level.values() for each in some)


budget = Budget()
