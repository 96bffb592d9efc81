"""Kinds of experiment, one file each; the folder is the list. Files of a user's own are beside a sweep file.

Constants at the top are read without running the file:

SECTIONS   sections of the configuration that it reads besides common ones, and if it needs them
RECORD     keys of the section record that it reads besides common ones: window, cells and region
VARIABLES  what a run gives, name: (dimensions, units, words); of an OBSERVED one, its observables say it
VALUES     values of its own, name: (default, units, words) or (default, units, words, limits), in a section of the
           configuration that has the name of the file
SIZES      length of each of its dimensions, or the path of the value that says it; shorter rows end in NaN
AXIS       variables along these dimensions, as VARIABLES
ASKS       values that it asks for, by path, and why
OBSERVED   observables that it usually records, where it records observables, and takes bed and checkpoint
BED_ALONE  True where it reads nothing but what makes the bed
DERIVES    what follows from its results for runs of other blocks, name: (options, as VALUES; what it asks for, as ASKS)

run(replicate, bed=None, progress=..., ...)   variables of a run by name; bed: at rest, packed here if None
axes(configuration)                           values of the variables of AXIS, by name
duration(replicate)                           time (s) that a run simulates, to estimate what it takes
check(configuration)                          raises ValueError where its values do not go together; of kinds of this folder
derive(name, results, replicate, other, ...)  a value of DERIVES for a run of another block; results: files of its
                                              own runs, open; other: a run of the file to compare with; options
All but run may be left out. Kinds of this folder may leave run out too, for run of
dem.experiment.phases.
"""

from contextlib import suppress
from dataclasses import dataclass
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, create_model

from dem.base.declarations import constants, definitions, described
from dem.base.errors import InputError, RunError
from dem.base.plugins import find_module, load
from dem.base.refusals import BOUNDS, shown
from dem.base.types import Count, Number, Section, Unit
from dem.experiment.observables import OBSERVABLES, file_of
from dem.io.dataset import LABELS, OF_RUN, OF_STORE, OF_SWEEP

EXPERIMENTS = described(Path(__file__).parent, "SECTIONS")
PHASES = Path(__file__).parents[1] / "phases.py"
TYPES = {bool: bool, int: Count, float: Number, str: str}  # of values, by type of default


def filled(name: str, values, sizes: dict[str, int]) -> np.ndarray:
    """A variable with NaN up to the lengths of its dimensions, also of rows that differ in length; raises
    RunError where it is longer, or no numbers."""
    if isinstance(values, list):
        values = [filled(name, row, dict([*sizes.items()][1:])) for row in values]
    array = np.full([*sizes.values()], np.nan)
    try:
        values = np.asarray(values, float)
        array[tuple(slice(size) for size, _ in zip(values.shape, sizes, strict=True))] = values
    except (TypeError, ValueError):
        most = " and ".join(f"{size} along {dim}" for dim, size in sizes.items())
        words = f"numbers, at most {most}" if sizes else "a number"
        raise RunError(f"the variable {name} is {shown(values)}; it must be {words}.") from None
    return array


@dataclass
class Experiment:
    """A kind of experiment by its name or file, and the configuration that asks for it; only `run`, `axes`
    and `duration` run code of a file of a user's own."""

    name: str
    beside: str | None = None
    configuration: Any = None

    @property
    def label(self) -> str:
        """Its name in files."""
        return self.name.removesuffix(".py")

    @property
    def file(self) -> Path:
        """Its file; raises InputError where it cannot be used."""
        if self.name in EXPERIMENTS:
            return Path(__file__).with_name(f"{self.name}.py")
        known = *EXPERIMENTS, *OBSERVABLES  # whose files of results have these names
        return find_module("experiment", self.name, self.beside, known, "run")

    @property
    def constants(self) -> dict:
        """Those at the top of its file; none where there is no such file, as for readers of results."""
        with suppress(InputError):
            return constants(self.file)
        return {}

    @property
    def observed(self) -> bool:
        """Whether it records record.observables."""
        return "OBSERVED" in self.constants

    def values(self, given) -> dict:
        """Its VALUES; without its file, what can be known of those that are given."""
        if self.constants or not isinstance(given, dict):
            return self.constants.get("VALUES", {})
        return {name: (type(value)(), None, "") for name, value in given.items()}

    @property
    def derives(self) -> dict:
        """Its DERIVES, where it has a function that gives them; raises InputError where they are none."""
        table = self.constants.get("DERIVES", {}) if "derive" in definitions(self.file) else {}
        try:
            return {
                name: (options, {at: (right, why) for at, (right, why) in asks.items()})
                for name, (options, asks) in table.items()
            }
        except (AttributeError, TypeError, ValueError):
            raise InputError(
                f"experiment is {self.name!r}; its DERIVES must be plain values, name: (options, what it asks for)."
            ) from None

    def section(self, table: dict) -> type[Section]:
        """The section of such VALUES; raises InputError where they are none."""
        fields = {}
        try:
            for name, (default, units, about, *limits) in table.items():
                bounds = dict(*limits)
                if hasattr(Section, name) or not bounds.keys() <= BOUNDS.keys():
                    raise KeyError(name)
                kind = Annotated[TYPES[type(default)], Field(**bounds), Unit(units or "")]
                fields[name] = kind, Field(default, description=about)
            return create_model(self.label, __base__=Section, **fields)
        except (AttributeError, KeyError, TypeError, ValueError):
            raise InputError(
                f"experiment is {self.name!r}; its VALUES must be plain values, name: (default, units, words) or "
                "(default, units, words, limits), such as 'gap': (1e-3, 'm', 'gap between plates', {'gt': 0})."
            ) from None

    def run(self, replicate, *args, **options) -> dict:
        """Make one run; its variables by name, each as long as `sizes` says. Raises RunError where
        they differ from its layout."""
        file = self.file if "run" in definitions(self.file) else PHASES
        try:
            values = load(file).run(replicate, *args, **options)
        except RunError as error:
            if file != PHASES:  # has a scene of its own
                raise
            raise type(error)(self.configuration.names_in(str(error))) from None
        sizes, layout = self.sizes(replicate), self.layout
        if wrong := set(values if isinstance(values, dict) else ()) ^ layout.keys():
            raise RunError(
                f"the variable {min(wrong)} must be both in VARIABLES and in what {self.name} gives."
            )
        return {
            name: filled(name, value, {dim: sizes[dim] for dim in layout[name][0]})
            for name, value in values.items()
        }

    @property
    def files(self) -> tuple[Path, ...]:
        """Its file and the files of its observables; raises InputError where one cannot be used."""
        names = self.configuration.observables if self.observed else ()
        return self.file, *(file_of(name, self.beside) for name in names)

    def table(self, name: str) -> dict:
        """A constant of all these files."""
        return reduce(or_, (constants(file).get(name, {}) for file in self.files))

    @property
    def along(self) -> dict:
        """Variables along its dimensions, as VARIABLES."""
        axes = self.table("AXIS").items()
        return {name: entry for name, entry in axes if not self.absent & set(entry[0])}

    @property
    def absent(self) -> set[str]:
        """Dimensions of variables that are not there, by NEEDED, and of no others."""
        every, there = (
            {dim for dims, *_ in table.values() for dim in dims}
            for table in (self.table("VARIABLES"), self.layout)
        )
        return every - there

    @property
    def layout(self) -> dict:
        """The variables of a run, as in dem.io.dataset."""
        at = self.configuration.at
        layout = (OF_RUN if self.observed else {}) | self.table("VARIABLES")
        absent = {name for name, path in self.table("NEEDED").items() if at(path) is None}
        return {name: entry for name, entry in layout.items() if name not in absent}

    def variables(self, observable: str) -> dict:
        """Variables of a combined file, by its name without .nc."""
        file = {file.stem: file for file in self.files}[observable]
        return constants(file)["VARIABLES"] | (OF_RUN if self.observed else {})

    def sizes(self, replicate) -> dict[str, int]:
        """Length of every dimension of a run."""
        return self.lengths | {"granule": replicate.granules}

    @property
    def lengths(self) -> dict[str, int]:
        """Length of the dimensions that all runs of a configuration share."""
        at = self.configuration.at
        return {
            dim: at(size) if isinstance(size, str) else size
            for dim, size in self.table("SIZES").items()
            if dim not in self.absent
        }

    @property
    def axes(self) -> dict:
        """Values along these dimensions, by the names of `along`."""
        files = (file for file in self.files if "axes" in definitions(file))
        values = reduce(or_, (load(file).axes(self.configuration) for file in files), {})
        return {name: row for name, row in values.items() if name in self.along}

    def answer(self, function: str, of: Any) -> Any:
        """What duration(replicate) or check(configuration) says; None without it, or of a user's file."""
        if self.name in EXPERIMENTS and function in definitions(self.file):
            return getattr(load(self.file), function)(of)
        return None

    def check(self) -> None:
        """Raise InputError where its file or one of an observable cannot be used."""
        for file in self.files[1:]:
            for name in constants(file).get("SECTIONS", ()):
                if self.configuration.at(name) is None:
                    raise InputError(f"record.observables has {file.stem}, which needs a {name}.")
        lengths, layout = self.lengths, self.layout
        if "granule" in lengths:
            raise InputError("SIZES has granule, the number of granules of a run; leave it out.")
        for dim, length in lengths.items():
            if type(length) is not int or length < 1:
                raise InputError(
                    f"the dimension {dim} of SIZES has the length {length}; it must be a whole number from 1 on, or "
                    "the path of one."
                )
        known = {*lengths, "granule"}
        names = [*LABELS, *OF_STORE, *OF_SWEEP, *{*known, *self.along}]
        names += [*OF_RUN] * self.observed
        names += [name for file in self.files for name in constants(file).get("VARIABLES", ())]
        if twice := [name for name in names if names.count(name) > 1]:
            raise InputError(f"{min(twice)} has two meanings in files of its runs; rename yours.")
        for name, (dims, *_) in layout.items():
            if unknown := [dim for dim in dims if dim not in known]:
                raise InputError(
                    f"the variable {name} is over {unknown[0]}; its dimensions may be {', '.join(sorted(known))}."
                )
