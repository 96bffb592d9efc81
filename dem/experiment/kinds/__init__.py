"""Kinds of experiment, one file each; the folder is the list. Files of a user's own are beside a sweep file.

Constants at the top are read without running the file:

SECTIONS   sections of the configuration that it reads beside those of all, and whether it needs them
VARIABLES  what a run gives, name: (dimensions, units, words); of an OBSERVED one, its observables say it
SIZES      length of each of its dimensions, or the path of the value that says it
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

from dem.base.constants import described
from dem.base.errors import InputError
from dem.base.outside import file_found, loaded, said_in
from dem.experiment.observables import OBSERVABLES, place_of, variables_of
from dem.io.dataset import AXES, LABELS, OF_RUN, OF_STORE, OF_SWEEP

NO_BITS = "describes kinds of experiment"
EXPERIMENTS = described(Path(__file__).parent, "SECTIONS")


class Experiment:
    """A kind of experiment by its name or file; only `code`, and what needs it, runs a file of a user's own."""

    def __init__(self, name: str, beside: str | None = None):
        self.name, self.beside = name, beside

    @property
    def place(self) -> str:
        """Its module, as dem.base.sources names it; raises InputError where its file cannot be used."""
        if self.name in EXPERIMENTS:
            return f"{__name__}.{self.name}"
        known = *EXPERIMENTS, *OBSERVABLES  # whose files of results have these names
        return file_found("experiment", self.name, self.beside, known, "run")

    @property
    def says(self) -> dict:
        """Constants at the top of its file; none where there is no such file, as for readers of results."""
        with suppress(InputError):
            return said_in(self.place)
        return {}

    @property
    def code(self):
        """Its module, loaded."""
        return loaded(self.place)

    @property
    def run(self):
        """What makes a run."""
        return self.code.run

    @property
    def observed(self) -> bool:
        """Whether it records record.observables."""
        return self.says.get("OBSERVED", False)

    @property
    def AXIS(self) -> dict:
        """Variables along its dimensions."""
        return AXES if self.observed else self.says.get("AXIS", {})

    def layout(self, configuration) -> dict:
        """The variables of a run, as in dem.io.dataset; raises InputError where two have one name."""
        if not self.observed:
            return self.says["VARIABLES"]
        found = dict(OF_RUN)
        for name in configuration.observables:
            more = variables_of(name, configuration.beside)
            if twice := more.keys() & found.keys():
                raise InputError(
                    f"record.observables has {name!r}; runs have a variable {min(twice)} without it, "
                    "rename that in your file."
                )
            found |= more
        if configuration.packing.pressure is None:  # all walls are at rest
            found.pop("top_y", None)
        return found

    def variables(self, configuration, observable: str) -> dict:
        """Those of a combined file, by its name without .nc."""
        if not self.observed:
            return self.says["VARIABLES"]
        own = f"{observable}.py"
        name = own if own in configuration.observables else observable
        return variables_of(name, configuration.beside) | OF_RUN

    def names(self, configuration) -> set[str]:
        """Names of the variables and dimensions of a run."""
        every = self.layout(configuration) | self.AXIS
        return {*every, *(dim for dims, *_ in every.values() for dim in dims)}

    def sizes(self, replicate) -> dict[str, int]:
        """Length of every dimension of a run."""
        at, sizes = replicate.configuration.at, self.says.get("SIZES", {})
        found = {dim: at(size) if isinstance(size, str) else size for dim, size in sizes.items()}
        return found | {"granule": replicate.shape.granules}

    def axes(self, configuration) -> dict:
        """Values along the dimensions that all runs of a configuration share, by the names of AXIS."""
        return self.code.axes(configuration) if self.AXIS else {}

    def duration(self, replicate) -> float | None:
        """Time (s) that a run simulates; None where it prepares beds, or is a file that would run here."""
        if self.name not in EXPERIMENTS or not hasattr(self.code, "duration"):
            return None
        return self.code.duration(replicate)

    def check(self, configuration) -> None:
        """Raise InputError where its file or one of an observable cannot be used."""
        for name in configuration.observables:
            place_of(name, configuration.beside)
        known = {"run", *self.says.get("SIZES", {}), "granule"}
        layout = self.layout(configuration) if self.place else {}
        taken = self.names(configuration) & {*LABELS, *OF_STORE, *OF_SWEEP} | layout.keys() & self.AXIS.keys()
        if taken:
            raise InputError(f"{min(taken)} has two meanings in files of its runs; rename yours.")
        for name, (dims, *_) in layout.items():
            if strange := [dim for dim in dims if dim not in known]:
                raise InputError(
                    f"the variable {name} is over {strange[0]}; its dimensions may be {', '.join(sorted(known))}."
                )

    def motions(self, replicate) -> set:
        """What selects the machine code of what it moves: has that friction, damping, gravity, a ledger;
        does a wall hold a pressure; how are contacts of ellipses found?"""
        if self.says.get("BED_ALONE"):
            return set()
        c = replicate.configuration
        rough = any((c.friction.granule, c.friction.wall, c.friction.cylinder))
        ellipse = c.ellipse if replicate.shape.kind == "ellipse" else type(c.ellipse)()
        has = c.gravity > 0, "ledger" in c.observables, c.packing.pressure is not None
        own = () if self.observed else (self.name,)
        return {(rough, c.material.restitution < 1, *has, str(ellipse), *own)}
