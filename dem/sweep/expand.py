"""A block of a sweep: its axes, and the runs at the points of their grid."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import compress, product
from math import prod

import numpy as np

from dem.base.errors import InputError
from dem.experiment.entries import Entry
from dem.experiment.replicate import Replicate
from dem.sweep.axis import RUN_KEYS, Axis, axis_of, changes, name_of, text_of
from dem.sweep.derive import Derive, derived
from dem.sweep.precision import MOST_RUNS, GridPoint, Until

WORDS = ("needs", "values")  # keys of a block that do not vary
SAME = "cylinder.stroke", "shear.strain", "experiment"  # constant in a block, like sizes


@dataclass(eq=False)
class Block:
    """All runs of a block.

    name:  of the block
    axes:  what varies
    runs:  by grid point, in the order of the grid
    fixed: paths of values that all runs share, and that may differ from the file
    """

    name: str
    axes: list[Axis]
    runs: dict[GridPoint, Replicate]
    fixed: Iterable[str] = ()

    @property
    def until(self) -> Until | None:
        """The precision that replicates are added for, None where seeds are listed."""
        return next((axis.until for axis in self.axes if axis.until), None)

    @property
    def first(self) -> Replicate:
        """Its first run."""
        return next(iter(self.runs.values()))

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(axis.name for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""
        return tuple(len(axis.points) for axis in self.axes)

    @property
    def beside_seed(self) -> list[Axis]:
        """All axes except the seeds."""
        return [axis for axis in self.axes if axis.name != "seed"]

    @property
    def paths(self) -> list[str]:
        """What varies along the axes, or is set for all runs."""
        return list(dict.fromkeys([*(p for axis in self.axes for p in axis.paths), *self.fixed]))

    def first_seeds(self) -> "Block":
        """The same block with the first seed alone."""
        at = self.dims.index("seed")
        axes = list(self.axes)
        seed = axes[at]
        axes[at] = Axis("seed", seed.entry, seed.coordinate[:1], seed.points[:1])
        runs = {point: run for point, run in self.runs.items() if point[at] == 0}
        return Block(self.name, axes, runs, self.fixed)

    @cached_property
    def replicates(self) -> dict[GridPoint, list[Replicate]]:
        """The runs at each point but for the seed, in the order of the seeds."""
        groups, kept = {}, [axis.name != "seed" for axis in self.axes]
        for point, run in self.runs.items():
            groups.setdefault(tuple(compress(point, kept)), []).append(run)
        return groups

    @property
    def counts(self) -> dict[GridPoint, int]:
        """How many replicates there are at each point."""
        return {point: len(runs) for point, runs in self.replicates.items()}

    def words(self, point: GridPoint) -> str:
        """Where replicates are on the axes, in words."""
        at = zip(self.beside_seed, point, strict=True)
        return ", ".join(f"{axis.name} {axis.coordinate[i]}" for axis, i in at)

    @cached_property
    def partners(self) -> dict[GridPoint, GridPoint | None]:
        """The point whose mean each point's is divided by, if ratios are wanted."""
        if self.until is None or not self.until.reference:
            return dict.fromkeys(self.replicates)
        at = next(i for i, axis in enumerate(self.beside_seed) if axis.name in ("case", "shape"))
        reference = self.beside_seed[at].coordinate.index(self.until.reference)
        return {point: (*point[:at], reference, *point[at + 1 :]) for point in self.replicates}

    @cached_property
    def points(self) -> dict[str, list[GridPoint]]:
        """Points of each run by its identity; values that it does not read make no other run."""
        points = {}
        for point, run in self.runs.items():
            points.setdefault(run.id, []).append(point)
        return points

    def unique(self) -> Iterator[Replicate]:
        """Every run once."""
        return (self.runs[points[0]] for points in self.points.values())

    def labels(self) -> dict[str, tuple[Entry, tuple[str, ...], np.ndarray]]:
        """Labels of the runs beside the axes: units and words, dimensions, values."""
        axes, runs = self.axes, list(self.runs.values())
        if self.until:  # some points have fewer replicates, which have the same labels
            axes, runs = self.beside_seed, [group[0] for group in self.replicates.values()]
        cases = [axis.name for axis in axes if axis.name in ("case", "shape")]
        of_runs, labels = [run.labels() for run in runs], {}
        for name in of_runs[0]:
            if name not in self.dims:
                values, kept = [of_run[name] for of_run in of_runs], cases * (name != "seed")
                labels[name] = None, *_varying(values, axes, kept)
        known = self.first.configuration.entries
        for path in self.paths:
            name = name_of(path)
            if path in known and name not in self.dims and not path.startswith("shapes."):
                values = [run.configuration.at(path) for run in runs]
                entry = known[path]
                if any(isinstance(value, tuple) for value in values):
                    entry, values = entry._replace(units=None), list(map(text_of, values))
                values = [np.nan if value is None else value for value in values]
                labels[name] = entry, *_varying(values, axes, [])
        return labels


def _varying(values: list, axes: list[Axis], kept: list[str]) -> tuple[tuple[str, ...], np.ndarray]:
    """Values of the runs of a grid, along the kept axes and those along which they vary."""
    array = np.reshape(values, [len(axis.points) for axis in axes])
    dims = [axis.name for axis in axes]
    for axis in range(len(dims) - 1, -1, -1):
        first = np.broadcast_to(array.take([0], axis), array.shape)
        same = np.array_equal(array, first, equal_nan=array.dtype.kind == "f")
        if same and dims[axis] not in kept:
            array = array.take(0, axis)
            del dims[axis]
    return tuple(dims), array


def expand(
    sweep,
    name: str,
    results: dict[str, list] | None = None,
    counts: dict[GridPoint, int] | None = None,
) -> Block:
    """All runs of a block of a sweep; raises InputError that names key and value.

    results: files of each block that it needs, open; if absent, values that follow from them
             are taken from the sweep file.
    counts: replicates at each point after some rounds; of the first round if absent.
    """
    block = sweep.named(name)
    where = "sweep" if name == "drag" else f"sweep.blocks.{name}"
    fixed = changes(block.get("values", {}), sweep, f"{where}.values")
    replicates = max(counts.values()) if counts else None
    axes = [
        axis_of(key, spec, sweep, where, replicates)
        for key, spec in block.items()
        if key not in WORDS
    ]
    if "shape" in fixed:
        axes.insert(0, axis_of("shape", [fixed.pop("shape")], sweep, where))
    if not any("seed" in axis.paths for axis in axes):
        axes.append(axis_of("seed", [fixed.pop("seed", 1)], sweep, where))
    ways = Counter([*fixed, *(path for axis in axes for path in axis.paths)])
    shaped = any(all("shape" in point for point in axis.points) for axis in axes)
    if len(sweep.shapes) > 1 and not shaped:
        raise InputError(
            f"{where} must give all runs a shape or a case; there are {', '.join(sweep.shapes)}."
        )
    recorded = [f"phases.{name}.time" for name in [*sweep.phases][-1:]]
    same = (*SAME, *recorded, *sweep.module.table("SIZES").values())
    if same := [path for path in same if path in ways.keys() - fixed.keys()]:
        raise InputError(f"{where} varies {same[0]}, which runs of one block share; use blocks.")
    if twice := [path for path, count in ways.items() if count > 1]:
        raise InputError(f"{where} varies {min(twice)} in two ways; name it once.")
    most = prod(axis.until.most if axis.until else len(axis.points) for axis in axes)
    if most > MOST_RUNS:
        raise InputError(f"{where} has {most:,} runs; it must have at most {MOST_RUNS:,}.")
    find = partial(derived, sweep, name, results)
    grid = Block(name, axes, _runs(sweep, where, fixed, axes, find, counts), fixed)
    first = grid.first.configuration
    experiment = first.module
    names = [*grid.dims, *map(name_of, ways.keys() - {axis.entry.path for axis in axes})]
    recorded = {*experiment.layout, *experiment.along, *experiment.sizes(grid.first)}
    if twice := [name for name in names if names.count(name) > 1 or name in recorded]:
        raise InputError(f"{where} uses the name {twice[0]} twice in files of results; rename one.")
    seeds = max((len(axis.points) for axis in axes if axis.name == "seed"), default=1)
    if seeds > 1 and grid.first.bed_description.given_diameters is not None:
        raise InputError(
            f"{where}.seed has {seeds} seeds, and packing.file the diameters too; all of these runs "
            "would be the same, list one seed."
        )
    if grid.until:
        if "needs" in block:
            raise InputError(
                f"{where}.seed has until, and needs {block['needs']}; list the seeds of a block "
                "whose values follow from another."
            )
        labels = (axis.coordinate for axis in axes if axis.name in ("case", "shape"))
        grid.until.check(f"{where}.seed", first, next(labels, ()))
    return grid


def _runs(sweep, where, fixed, axes, find, counts) -> dict[GridPoint, Replicate]:
    """The run at each point of the grid; runs that differ in seed alone share a configuration."""
    configurations, runs = {}, {}
    seeded = next((at for at, axis in enumerate(axes) if axis.until), None)
    for point in product(*(range(len(axis.points)) for axis in axes)):
        if counts and point[seeded] >= counts[*point[:seeded], *point[seeded + 1 :]]:
            continue
        values = {"seed": 1} | fixed
        for axis, at in zip(axes, point, strict=True):
            values |= axis.points[at]
        shape, density, seed = (values.pop(key, None) for key in RUN_KEYS)
        shape = shape or next(iter(sweep.shapes))
        density = density or sweep.density_of(shape)
        key = shape, density, repr(values)
        if key not in configurations:
            wanted = {path: value for path, value in values.items() if isinstance(value, Derive)}
            plain = {path: value for path, value in values.items() if path not in wanted}
            configurations[key] = sweep.changed(plain, shape)
            if wanted:  # what is derived from another result comes last
                run = Replicate(configurations[key], shape, density, 0)
                found = {path: find(value, path, run) for path, value in wanted.items()}
                configurations[key] = sweep.changed(plain | found, shape)
        try:
            runs[point] = configurations[key].replicate(shape, density, seed)
        except InputError as error:
            raise InputError(f"{where} asks for an impossible run: {error}") from None
    return runs
