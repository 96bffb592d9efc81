"""One run: its values, and what it is made of."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dem.base.errors import InputError
from dem.base.provenance import compilers
from dem.base.source_hash import digest, run_hash
from dem.base.types import SEEDS
from dem.contacts.effective import effective_modulus
from dem.experiment.bed_description import BedDescription, Part
from dem.experiment.intruders import intruder_of
from dem.experiment.sections import RollingSection, ShapeSection
from dem.material import Material

if TYPE_CHECKING:
    from dem.experiment.config import Configuration  # which imports this file


LAYOUT = 6  # of the files of runs: raise it where a variable comes, goes or has another meaning


@dataclass(eq=False)
class Replicate:
    """One run: values of a configuration, a shape of it, a density (kg/m3) and a seed; raises
    InputError where its granules cannot have them."""

    configuration: Configuration
    label: str
    density: float
    seed: int
    point: tuple[str, ...] = ()  # words by which it was chosen among the runs of a file

    def __post_init__(self):
        if self.rolling is not None and self.shape.kind != "disc":
            raise InputError(
                f"rolling is for discs, and shapes.{self.label}.kind is {self.shape.kind}; make the "
                "coefficients of rolling zero, or leave this shape out of the sweep."
            )

    # What it is known by

    def run_key(self) -> str:
        """All that the run depends on, as text."""
        c = self.configuration
        if c.module.constants.get("BED_ALONE"):
            own = json.dumps(c.values().get(c.module.label), sort_keys=True)
            return f"{c.experiment} {self.bed_description.text} {own}"
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
        """Identity of its bed."""
        return self.bed_description.id

    # What it is made of

    @property
    def shape(self) -> ShapeSection:
        return self.configuration.shape_of(self.label)

    def material_of(self, section) -> Material:
        """Material of granules, a wall or a solid: values that a section leaves out are the
        run's."""
        plain = self.configuration.material
        elastic = section or plain
        return Material(
            getattr(elastic, "density", None) or self.density,
            elastic.young_modulus,
            elastic.poisson_ratio,
            elastic.restitution or plain.restitution,
        )

    @property
    def materials(self) -> tuple[Material, ...]:
        """Material of the granules; of a mixture one of each shape, if a shape has its own."""
        sections = [part.material for part in self.configuration.parts_of(self.label)]
        return tuple(map(self.material_of, sections if any(sections) else [None]))

    @property
    def beds(self) -> list[BedDescription]:
        """Its bed; then the granules that sources have at the start, as if they were one, by a seed of
        its own."""
        bed, sources = self.bed_description, self.configuration.sources.values()
        if not (count := sum(source.count or 0 for source in sources)):
            return [bed]
        return [bed, replace(bed, count=count, table=None, seed=self.seed + SEEDS)]

    @property
    def granules(self) -> int:
        """Number of granules, with the granules of sources."""
        return sum(bed.count for bed in self.beds)

    @property
    def species(self) -> np.ndarray | None:
        """Which of the materials (n,) each granule is of; None if there is one."""
        species = [bed.species for bed in self.beds]
        return None if species[0] is None else np.concatenate(species)

    @property
    def mean_density(self) -> float:
        """Density of the granules (kg/m3): their mass over their volume."""
        density = np.array([material.density for material in self.materials])
        if self.species is None:
            return float(density[0])
        denser = density[self.species] - density[0]  # zero where all are alike, to the last bit
        return float(density[0] + np.average(denser, weights=np.square(self.diameters)))

    @property
    def diameters(self) -> np.ndarray:
        """Volume diameters (n,) in m of its granules."""
        return np.concatenate([bed.diameters for bed in self.beds])

    @property
    def bed_description(self) -> BedDescription:
        """All that its bed depends on."""
        known, key = self.configuration.bed_descriptions, (self.label, self.density)
        if key not in known:
            known[key] = self._described_bed()
        return replace(known[key], seed=self.seed)

    def _described_bed(self) -> BedDescription:
        c, shape, packing = self.configuration, self.shape, self.configuration.packing
        pressed, settled = packing.pressure is not None, packing.preparation == "settled"
        shares = (shape.mixture or {self.label: 1.0}).values()
        return BedDescription(
            kind=shape.kind,
            parts=tuple(
                Part(part.diameter, part.form, share)
                for part, share in zip(c.parts_of(self.label), shares, strict=True)
            ),
            count=shape.granules,
            size_spread=packing.size_spread,
            width=c.box_width,
            periodic=c.periodic,
            solids=tuple(map(intruder_of, c.scene.solids.values())),
            law=c.contact.name,
            constants=c.contact.constants,
            preparation=packing.preparation,
            friction=packing.friction,
            moduli=tuple(modulus / max(self.moduli) for modulus in self.moduli),
            fraction=packing.fraction,
            box_height=packing.height,
            region=packing.region,
            table=packing.file,
            pressure=packing.pressure,
            modulus=max(self.moduli) if pressed else None,
            thickness=self.thickness if pressed or settled else None,
            materials=self.materials if settled else None,
            gravity=c.gravity if settled else None,
            label=self.label,
            beside=c.beside,
        )

    @property
    def moduli(self) -> list[float]:
        """E* (Pa) of two granules of each material."""
        return [effective_modulus(material, material) for material in self.materials]

    @property
    def modulus(self) -> float:
        """Modulus of the law of contacts (Pa or N/m) for two granules, the stiffest if they differ; over
        the thickness (m), the pressure (Pa) in a run whose Bed has a pressure of one."""
        return float(self.law.modulus(max(self.moduli), self.thickness))

    @property
    def rolling(self) -> RollingSection | None:
        """Rolling resistance; coefficients of zero are none for granules that are no discs."""
        if (rolling := self.configuration.rolling) and self.shape.kind != "disc":
            return rolling if rolling.granule or rolling.wall or rolling.cylinder else None
        return rolling

    @property
    def law(self):
        """The law of contacts, under which the bed is packed too."""
        return self.bed_description.contact_law

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

    @property
    def thickness(self) -> float:
        """Thickness (m) of the granules out of the plane."""
        return self.configuration.material.thickness or self.shape.diameter
