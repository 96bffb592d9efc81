"""A block of a sweep: its axes, and all runs on their grid."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from itertools import product
from math import prod
from typing import Any, NamedTuple

import numpy as np

from dem.base.errors import InputError
from dem.base.schema import MOST
from dem.experiment.box import check_rooms
from dem.experiment.config import Configuration, Entry, Replicate, entries
from dem.io.dataset import LABELS, OF_STORE
from dem.sweep.axis import OWN, Axis, Derive, axis_of, changes, name_of, place_in
from dem.sweep.precision import Lead, counts

WORDS = ("needs", "values")  # of a block, beside what varies
MOST_AXES = 24  # dimensions of a sweep; a variable of netCDF-4 has at most 32 with its own
SAME = "cylinder.stroke", "shear.strain", "experiment"  # beside the sizes of runs

# gives a value: what is asked for (a group with `derive`), values of the run so far
Derived = Callable[[dict, Replicate], Any]


class Run(NamedTuple):
    """A run of a block: its place on the axes, and what it is."""

    place: tuple[int, ...]
    replicate: Replicate


class Block:
    """All runs of a block: axes, and runs in their order; fixed: paths of values that all its runs
    share, and that may be others than those of the file."""

    def __init__(self, name: str, axes: list[Axis], runs: list[Run], fixed: Iterable[str] = ()):
        self.name, self.axes, self.runs, self.fixed = name, axes, runs, tuple(fixed)
        self.until = next((axis.until for axis in axes if axis.until), None)  # that rounds go on until

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the axes."""
        return tuple(axis.name for axis in self.axes)

    @property
    def is_by_case(self) -> bool:
        """Whether its runs differ in case, or shape, and seed alone."""
        return set(self.dims) in ({"case", "seed"}, {"shape", "seed"})

    def first_seeds(self) -> "Block":
        """The same with the first seed alone."""
        axes = [
            axis._replace(coordinate=axis.coordinate[:1], points=axis.points[:1], until=None)
            if axis.name == "seed"
            else axis
            for axis in self.axes
        ]
        at = self.dims.index("seed")
        runs = [run for run in self.runs if run.place[at] == 0]
        return Block(self.name, axes, runs, self.fixed)

    @property
    def beside_seed(self) -> list[Axis]:
        """The axes but that of the seeds."""
        return [axis for axis in self.axes if axis.name != "seed"]

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""
        return tuple(len(axis.points) for axis in self.axes)

    @property
    def paths(self) -> list[str]:
        """What varies along the axes, or is set for all runs."""
        return list(dict.fromkeys([*(path for axis in self.axes for path in axis.paths), *self.fixed]))

    def lead(self, place: tuple[int, ...]) -> Lead:
        """A place without its seed."""
        return tuple(at for at, axis in zip(place, self.axes, strict=True) if axis.name != "seed")

    @cached_property
    def replicates(self) -> dict[Lead, list[Replicate]]:
        """The runs of each place but for the seed, in the order of the seeds."""
        found = {}
        for run in self.runs:
            found.setdefault(self.lead(run.place), []).append(run.replicate)
        return found

    def words(self, place: Lead) -> str:
        """What the runs of a place share, in words: where it is on the axes."""
        at = zip(self.beside_seed, place, strict=True)
        return ", ".join(f"{axis.name} {axis.coordinate[k]}" for axis, k in at)

    def grown(self, values: dict[Lead, np.ndarray], rounds: int) -> dict[Lead, int] | None:
        """Replicates of each place after one round more, or as many as values suffice for; None where all is known."""
        found = counts(self.until, values, self.partners, rounds)
        return None if found == self.counts else found

    @property
    def counts(self) -> dict[Lead, int]:
        """How many replicates each place has."""
        return {place: len(runs) for place, runs in self.replicates.items()}

    @cached_property
    def partners(self) -> dict[Lead, Lead | None]:
        """The place whose mean each place's is divided by, if ratios are wanted."""
        if self.until is None or not self.until.reference:
            return dict.fromkeys(self.replicates)
        at = next(k for k, axis in enumerate(self.beside_seed) if axis.name in ("case", "shape"))
        own = self.beside_seed[at].coordinate.index(self.until.reference)
        return {place: (*place[:at], own, *place[at + 1 :]) for place in self.replicates}

    @cached_property
    def places(self) -> dict[str, list[tuple[int, ...]]]:
        """Places of each run by its identity; values that it does not read make no other run."""
        found = {}
        for run in self.runs:
            found.setdefault(run.replicate.id, []).append(run.place)
        return found

    def unique(self) -> Iterator[Replicate]:
        """Every run once."""
        found = {}
        for run in self.runs:
            found.setdefault(run.replicate.id, run.replicate)
        yield from found.values()

    def labels(self) -> dict[str, tuple[Entry, tuple[str, ...], np.ndarray]]:
        """Labels of the runs beside the axes: units and words, dimensions, values."""
        base = [axis.name for axis in self.axes if axis.name in ("case", "shape")]
        replicates, found = [run.replicate for run in self.runs], {}
        labels = [replicate.labels() for replicate in replicates]
        for name in labels[0]:
            if name not in self.dims:
                forced = base if name != "seed" else []
                found[name] = (None, *self._along([each[name] for each in labels], forced))
        known = entries({run.label: None for run in replicates}, replicates[0].configuration.read)
        for path in self.paths:
            name = name_of(path)
            if path in known and name not in self.dims and not path.startswith("shapes."):
                of_runs = [r.configuration.at(path) for r in replicates]
                values = self._along([np.nan if v is None else v for v in of_runs], [])
                found[name] = (known[path], *values)
        return found

    def _along(self, values: list, forced) -> tuple[tuple[str, ...], np.ndarray]:
        """Values of all runs, along those axes only along which they vary."""
        own = np.array(values)
        array = np.empty(self.shape, own.dtype)
        if len(own) < array.size:  # where a place has fewer replicates, as its first one
            for run, each in zip(reversed(self.runs), own[::-1], strict=True):
                array[tuple(slice(None) if a.until else k for a, k in zip(self.axes, run.place, strict=True))] = each
        for run, each in zip(self.runs, own, strict=True):
            array[run.place] = each
        dims = list(self.dims)
        for at, name in reversed(list(enumerate(self.dims))):
            first = array.take([0], at)
            same = (array == first) | ((array != array) & (first != first))
            if name not in forced and same.all():
                array = array.take(0, at)
                dims.remove(name)
        return tuple(dims), array


def expand(
    sweep, name: str, block: dict, derived: Derived | None, counts: dict[Lead, int] | None = None
) -> Block:
    """All runs of a block of a sweep; raises InputError that names key and value.

    counts: replicates of each place after some rounds; those of the first round if absent.
    """
    where = "sweep" if name == "drag" else f"sweep.blocks.{name}"
    place = place_in(sweep, where)
    fixed = changes(block.get("values", {}), place.at("values"))
    specs = {key: spec for key, spec in block.items() if key not in WORDS}
    replicates = max(counts.values()) if counts else None
    axes = [axis_of(key, spec, place, replicates) for key, spec in specs.items()]
    if "shape" in fixed:
        axes.insert(0, axis_of("shape", [fixed.pop("shape")], place))
    given = {path for axis in axes for path in axis.paths}
    if "seed" not in given:
        axes.append(axis_of("seed", [fixed.pop("seed", 1)], place))
    if len(axes) > MOST_AXES:
        place.refuse(
            f"has {len(axes)} dimensions; it must have at most {MOST_AXES}: what has one value belongs under "
            "values, and values that go together under one name"
        )
    given |= set(fixed)
    shaped = (axis for axis in axes if axis.points and all("shape" in point for point in axis.points))
    if len(sweep.shapes) > 1 and not any(shaped):
        place.refuse(f"must give all runs a shape or a case; there are {', '.join(sweep.shapes)}")
    same = (*SAME, *sweep.module.said(sweep, "SIZES").values())
    if same := [path for path in same if path in given - set(fixed)]:
        place.refuse(f"varies {same[0]}, which runs of one block share; use blocks")
    points = [fixed, *(point for axis in axes for point in axis.points)]
    if "needs" not in block and any(isinstance(v, Derive) for point in points for v in point.values()):
        place.refuse("derives values; needs must name the blocks that it takes them from")
    ways = Counter([*fixed, *(path for axis in axes for path in axis.paths)])
    if twice := [path for path, count in ways.items() if count > 1]:
        place.refuse(f"varies {min(twice)} in two ways; name it once")
    found = Block(name, axes, [], fixed)
    most = prod(max(len(axis.points), axis.until.most if axis.until else 0) for axis in axes)
    if most > MOST:
        place.refuse(f"has {most:,} runs; it must have at most {MOST:,}")
    found.runs = _runs(sweep, where, fixed, axes, derived, counts)
    first = found.runs[0].replicate.configuration
    names = [*found.dims, *map(name_of, given - {axis.entry.path for axis in axes})]
    recorded = first.module.names(first)
    lengths = {f"{name}_length" for name in (*names, *recorded, *LABELS, *OF_STORE)}  # of texts
    if twice := [name for name in names if names.count(name) > 1 or name in recorded | lengths]:
        place.refuse(f"gives files of results two things named {twice[0]}; rename one")
    if found.until:
        if "needs" in block:
            place.at("seed").refuse(
                f"has until, and needs {block['needs']}; list the seeds of a block whose values follow from another"
            )
        labels = (axis.coordinate for axis in axes if axis.name in ("case", "shape"))
        found.until.check(f"{where}.seed", found.runs[0].replicate.configuration, next(labels, ()))
    return found


def _runs(sweep, where, fixed, axes, derived, counts) -> list[Run]:
    made, runs = {}, []
    seeded = next((at for at, axis in enumerate(axes) if axis.until), None)
    for place in product(*(range(len(axis.points)) for axis in axes)):
        if counts and place[seeded] >= counts[*place[:seeded], *place[seeded + 1 :]]:
            continue
        own = {"seed": 1} | fixed
        for axis, at in zip(axes, place, strict=True):
            own |= axis.points[at]
        shape, density, seed = (own.pop(key, None) for key in OWN)
        shape = shape or next(iter(sweep.shapes))
        density = density or sweep.density_of(shape)
        key = shape, density, repr(own)
        if key not in made:
            made[key] = _resolved(sweep, shape, density, own, derived), []
        configuration, seeds = made[key]
        seeds.append(seed)
        runs.append(Run(place, Replicate(configuration, shape, density, seed)))
    for (shape, *_), (configuration, seeds) in made.items():
        try:
            check_rooms(configuration, shape, seeds)
        except ValueError as error:
            raise InputError(f"{where} asks for an impossible run: {error}.") from None
    return runs


def _resolved(sweep, shape: str, density: float, own: dict, derived) -> Configuration:
    """The configuration of a run; what is derived from another result comes last."""
    asked = {path: new for path, new in own.items() if isinstance(new, Derive)}
    plain = {path: new for path, new in own.items() if path not in asked}
    found = sweep.changed(plain, shape)
    if derived is None or not asked:
        return found
    replicate = Replicate(found, shape, density, 0)
    more = {path: derived(new, replicate) for path, new in asked.items()}
    return sweep.changed(plain | more, shape)
