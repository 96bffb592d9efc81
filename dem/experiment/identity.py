"""The identity of a run and of its bed: a hash of the values that they depend on, and of the code."""

import json
from functools import cached_property
from pathlib import Path

from dem.base.provenance import compilers
from dem.base.source_hash import digest, run_hash

LAYOUT = 2  # of the files of runs: raise it where a variable comes, goes or has another meaning
# what a bed depends on, beside its shape and how densely it is packed
BED_KEYS = (
    "box_width",
    "periodic",
    "cylinder.diameter",
    "cylinder.start",
    "cylinder.outline",
    "cylinder.aspect_ratio",
    "cylinder.angle",
    "cylinder.direction",
    "second.diameter",
    "second.gap",
    "second.bearing",
    "packing.size_spread",
    "packing.preparation",
    "contact.law",
    "contact.stiffness",
)
PACKED = "packing.fraction", "packing.friction", "packing.pressure"
ELASTICITY = "material.young_modulus", "material.poisson_ratio", "material.thickness"
SETTLED_BY = "gravity", "material", "contact"


class Identity:
    """What a Replicate is known by."""

    def _known(self, *paths: str) -> str:
        """The values at some paths and below them that this run is known by, as text."""
        known = self.configuration.known[self.label].items()
        groups = *(f"{path}." for path in paths), "shape."
        values = {path: v for path, v in known if path in paths or path.startswith(groups)}
        return json.dumps(values, sort_keys=True)

    @property
    def _elasticity(self) -> tuple[str, ...]:
        """Keys of elasticity, on which a bed depends that is pressed, or of several materials."""
        pressed = self.configuration.packing.pressure is not None
        return ELASTICITY if pressed or len(self.materials) > 1 else ()

    @property
    def bed_family(self) -> str:
        """Hash of all that the bed depends on, except packing fraction or pressure, friction and
        seed."""
        return digest(self._known(*BED_KEYS, *self._elasticity))

    def bed_key(self, *more: str) -> str:
        """All that the bed depends on, as text; more: paths of other values."""
        if self.configuration.packing.preparation == "settled":
            return (
                f"{self._known(*BED_KEYS, *PACKED, *SETTLED_BY, *more)} {self.density} {self.seed}"
            )
        return f"{self._known(*BED_KEYS, *PACKED, *self._elasticity, *more)} {self.seed}"

    def run_key(self) -> str:
        """All that the run depends on, as text."""
        c = self.configuration
        if c.module.constants.get("BED_ALONE"):
            return f"{c.experiment} {self.bed_key(c.module.label)}"
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
        return digest(self.bed_key(), compilers(), run_hash(*self.files[-2:]))
