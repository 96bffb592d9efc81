"""Kinds of experiment, one file each; the folder is the list. Files of a user's own are beside a sweep file.

Constants at the top are read without running the file:

SECTIONS   sections of the configuration that it reads beside those of all, and whether it needs them
VARIABLES  what a run gives, name: (dimensions, units, words); of an OBSERVED one, its observables say it
VALUES     values of its own, name: (default, units, words) or (default, units, words, limits), in a section of the
           configuration that has the name of the file
SIZES      length of each of its dimensions, or the path of the value that says it; shorter rows end in NaN
AXIS       variables along these dimensions, as VARIABLES
ASKS       values that it asks for, by path, and why
OBSERVED   True where it records record.observables, and takes bed and checkpoint
BED_ALONE  True where it reads nothing but what makes the bed

run(replicate, bed=None, progress=..., ...)   variables of a run by name; bed: at rest, packed here if None
axes(configuration)                           values of the variables of AXIS, by name
duration(replicate)                           time (s) that a run simulates, to estimate what it takes
warm_up(replicate)                            compiles what a run needs
All but run may be left out.
"""

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, create_model

from dem.base.constants import constants, definitions, described
from dem.base.errors import InputError, RunError
from dem.base.plugins import find_module, load
from dem.base.types import BOUNDS, Count, Number, Section, Unit, shown
from dem.experiment.observables import OBSERVABLES, file_of, variables_of
from dem.io.dataset import AXES, LABELS, OF_RUN, OF_STORE, OF_SWEEP

EXPERIMENTS = described(Path(__file__).parent, "SECTIONS")
TYPES = {bool: bool, int: Count, float: Number, str: str}  # of values, by those of their defaults


def filled(name: str, values, sizes: dict[str, int]) -> np.ndarray:
    """A variable with NaN up to the lengths of its dimensions; raises RunError where it is longer, or no
    numbers."""
    shape = tuple(sizes.values())
    try:
        values = np.asarray(values, float)
    except (TypeError, ValueError):
        raise RunError(f"the variable {name} is {shown(values)}; it must be numbers.") from None
    if values.ndim != len(shape) or np.any(values.shape > np.array(shape)):
        words = " and ".join(f"{size} along {dim}" for dim, size in sizes.items()) or "one value"
        raise RunError(f"the variable {name} has the shape {values.shape}; it may have {words}.")
    gaps = [(0, size - length) for size, length in zip(shape, values.shape, strict=True)]
    return np.pad(values, gaps, constant_values=np.nan) if gaps else values


class Experiment:
    """A kind of experiment by its name or file, and the configuration that asks for it; only `code`,
    and what needs it, runs a file of a user's own."""

    def __init__(self, name: str, beside: str | None = None, configuration=None):
        self.name, self.beside, self.configuration = name, beside, configuration

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
    def code(self):
        """Its module, imported."""
        return load(self.file)

    @property
    def constants(self) -> dict:
        """Those at the top of its file; none where there is no such file, as for readers of results."""
        with suppress(InputError):
            return constants(self.file)
        return {}

    @property
    def observed(self) -> bool:
        """Whether it records record.observables."""
        return self.constants.get("OBSERVED", False)

    def values(self, given) -> dict:
        """Its VALUES; without its file, what can be known of those that are given."""
        if self.constants or not isinstance(given, dict):
            return self.constants.get("VALUES", {})
        return {name: (type(value)(), None, "") for name, value in given.items()}

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
        they are not those of its layout."""
        values, sizes = self.code.run(replicate, *args, **options), self.sizes(replicate)
        layout = self.layout
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
        """Its file and those of its observables; raises InputError where one cannot be used."""
        names = self.configuration.observables if self.observed else ()
        return self.file, *(file_of(name, self.beside) for name in names)

    def table(self, name: str) -> dict:
        """A constant of all these files."""
        tables = (constants(file).get(name, {}) for file in self.files)
        return {key: value for table in tables for key, value in table.items()}

    @property
    def along(self) -> dict:
        """Variables along its dimensions, as VARIABLES."""
        return (AXES if self.observed else {}) | self.table("AXIS")

    @property
    def layout(self) -> dict:
        """The variables of a run, as in dem.io.dataset; raises InputError where two have one name."""
        if not self.observed:
            return self.constants["VARIABLES"]
        layout = dict(OF_RUN)
        for name in self.configuration.observables:
            variables = variables_of(name, self.beside)
            if twice := variables.keys() & layout.keys():
                raise InputError(
                    f"record.observables has {name!r}; runs have a variable {min(twice)} without it, "
                    "rename that in your file."
                )
            layout |= variables
        for name, path in (
            ("top_y", "packing.pressure"),
            ("cylinder_orientation", "cylinder.spin"),
            ("second_orientation", "second.spin"),
        ):
            if self.configuration.at(path) is None:  # it does not move, or turn
                layout.pop(name, None)
        return layout

    def variables(self, observable: str) -> dict:
        """Those of a combined file, by its name without .nc."""
        if not self.observed:
            return self.constants["VARIABLES"]
        file = f"{observable}.py"
        name = file if file in self.configuration.observables else observable
        return variables_of(name, self.beside) | OF_RUN

    @property
    def names(self) -> set[str]:
        """Names of the variables and dimensions of a run."""
        layout = self.layout | self.along
        return {*layout, *(dim for dims, *_ in layout.values() for dim in dims)}

    def sizes(self, replicate) -> dict[str, int]:
        """Length of every dimension of a run."""
        return self.lengths | {"granule": replicate.shape.granules}

    @property
    def lengths(self) -> dict[str, int]:
        """Length of the dimensions that all runs of a configuration share."""
        at = self.configuration.at
        return {
            dim: at(size) if isinstance(size, str) else size
            for dim, size in self.table("SIZES").items()
        }

    @property
    def axes(self) -> dict:
        """Values along these dimensions, by the names of `along`."""
        files = [file for file in self.files if "axes" in definitions(file)]
        return {k: v for file in files for k, v in load(file).axes(self.configuration).items()}

    def duration(self, replicate) -> float | None:
        """Time (s) that a run simulates; None where it prepares beds, or is a file that would run here."""
        if self.name not in EXPERIMENTS or not hasattr(self.code, "duration"):
            return None
        return self.code.duration(replicate)

    def check(self) -> None:
        """Raise InputError where its file or one of an observable cannot be used."""
        for name in self.configuration.observables:
            file_of(name, self.beside)
        lengths = self.lengths
        for dim, length in lengths.items():
            if type(length) is not int or length < 1:
                raise InputError(
                    f"the dimension {dim} of SIZES has the length {length}; it must be a whole number from 1 on, or "
                    "the path of one."
                )
        layout, known = self.layout, {*lengths, "granule"}
        taken = self.names & {*LABELS, *OF_STORE, *OF_SWEEP}
        if taken := taken | layout.keys() & {*known, *self.along}:
            raise InputError(f"{min(taken)} has two meanings in files of its runs; rename yours.")
        for name, (dims, *_) in layout.items():
            if unknown := [dim for dim in dims if dim not in known]:
                raise InputError(
                    f"the variable {name} is over {unknown[0]}; its dimensions may be {', '.join(sorted(known))}."
                )
