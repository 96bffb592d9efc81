"""The identity of a run and of its bed: a hash of the values that they depend on, and of the code."""

import json
from functools import cached_property
from pathlib import Path

from dem.base.provenance import compilers
from dem.base.source_hash import digest, run_hash

LAYOUT = 4  # of the files of runs: raise it where a variable comes, goes or has another meaning


class Identity:
    """What a Replicate is known by."""

    @property
    def bed_family(self) -> str:
        """Hash of all that the bed depends on, except packing fraction or pressure, friction and
        seed."""
        return self.bed_description.family

    def bed_key(self) -> str:
        """All that the bed depends on, as text."""
        return self.bed_description.text

    def run_key(self) -> str:
        """All that the run depends on, as text."""
        c = self.configuration
        if c.module.constants.get("BED_ALONE"):
            own = json.dumps(c.values().get(c.module.label), sort_keys=True)
            return f"{c.experiment} {self.bed_key()} {own}"
        return f"{json.dumps(c.known[self.label], sort_keys=True)} {self.density} {self.seed}"

    @property
    def files(self) -> tuple[Path, ...]:
        """The files of its experiment, observables, shape and law."""
        return self.configuration.files[self.label]

    @property
    def source_hash(self) -> str:
        """Hash of the code that decides the numbers of this run, and of what compiles it."""
        return digest(run_hash(*self.files), compilers())

    @cached_property
    def id(self) -> str:
        """Identity of the run: hash of the values that it reads and the code that it runs."""
        return digest(self.run_key(), self.source_hash, str(LAYOUT))

    @property
    def bed_id(self) -> str:
        """Identity of the bed of the run."""
        return self.bed_description.id
