"""One run: its values, what it is made of, and its identity."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dem.base.errors import InputError
from dem.base.provenance import compilers
from dem.base.sources import digest, run_hash
from dem.experiment.box import diameters_of, sample_parts
from dem.experiment.sections import RollingSection, ShapeSection
from dem.laws import file_of as law_file
from dem.laws import law_of
from dem.material import Material
from dem.shapes import Kind

if TYPE_CHECKING:
    from dem.experiment.config import Configuration  # which imports this file

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


@dataclass(eq=False)
class Replicate:
    """One run: values of a configuration, a shape of it, a density (kg/m3) and a seed; raises
    InputError where its granules cannot have them."""

    configuration: Configuration
    label: str
    density: float
    seed: int

    def __post_init__(self):
        if self.rolling is not None and self.shape.kind != "disc":
            raise InputError(
                f"rolling is for discs, and shapes.{self.label}.kind is {self.shape.kind}; make the "
                "coefficients of rolling zero, or leave this shape out of the sweep."
            )

    @property
    def shape(self) -> ShapeSection:
        return self.configuration.shape_of(self.label)

    def material_of(self, section) -> Material:
        """Material of granules, a wall or a solid: what a section leaves out is that of the run."""
        plain = self.configuration.material
        elastic = section or plain
        return Material(
            getattr(elastic, "density", None) or self.density,
            elastic.young_modulus,
            elastic.poisson_ratio,
            elastic.restitution or plain.restitution,
        )

    @property
    def parts(self) -> list[ShapeSection]:
        """The shapes of a mixture; of another shape, itself."""
        return self.configuration.parts_of(self.label)

    @property
    def materials(self) -> tuple[Material, ...]:
        """Material of the granules; of a mixture one of each shape, if a shape has its own."""
        sections = [part.material for part in self.parts]
        return tuple(map(self.material_of, sections if any(sections) else [None]))

    @property
    def species(self) -> np.ndarray | None:
        """Which of the materials (n,) each granule is of; None if there is one."""
        return sample_parts(self) if len(self.materials) > 1 else None

    @property
    def mean_density(self) -> float:
        """Density of the granules (kg/m3): their mass over their volume."""
        density = np.array([material.density for material in self.materials])
        if self.species is None:
            return float(density[0])
        denser = density[self.species] - density[0]  # zero where all are alike, to the last bit
        return float(density[0] + np.average(denser, weights=np.square(diameters_of(self))))

    @property
    def rolling(self) -> RollingSection | None:
        """Rolling resistance; coefficients of zero are none for granules that are no discs."""
        if (rolling := self.configuration.rolling) and self.shape.kind != "disc":
            return rolling if rolling.granule or rolling.wall or rolling.cylinder else None
        return rolling

    @property
    def kind(self) -> Kind:
        """The kind of its granules; raises InputError where its file cannot be used."""
        return self.configuration.kind_of(self.label)

    @property
    def law(self):
        """The law of contacts, under which the bed is packed too."""
        c = self.configuration
        law, stiffness = law_of(c.law_name, c.beside), c.contact.stiffness
        return law() if stiffness is None else law(stiffness)

    @property
    def coordinates(self) -> dict:
        """Shape, density and seed."""
        return {"shape": self.label, "density": self.density, "seed": self.seed}

    def values(self) -> dict:
        """All values as plain groups, in the form that `of_values` takes."""
        values = self.configuration.values()
        values["shapes"] = self.configuration.with_parts(self.label, values["shapes"])
        return values | self.coordinates

    def labels(self) -> dict:
        """What tells this run from others."""
        shape = self.shape
        return self.coordinates | {
            "kind": "mixture" if shape.mixture else shape.kind,
            "aspect_ratio": shape.ratio,
            "diameter": shape.diameter,
            "granules": shape.granules,
        }

    def at(self, path: str):
        """The value at a path, or the shape, density or seed."""
        return self.coordinates.get(path, self.configuration.at(path))

    def words(self) -> str:
        """The run in words, for sentences."""
        return f"{self.label} at {self.density:.10g} kg/m3, seed {self.seed}"

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
        c = self.configuration
        return *c.module.files, self.kind.file, law_file(c.law_name, c.beside)

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
