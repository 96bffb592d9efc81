"""One run: its values, and what it is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dem.base.errors import InputError
from dem.experiment.granule_sizes import diameters_of, sample_parts
from dem.experiment.identity import Identity
from dem.experiment.sections import RollingSection, ShapeSection
from dem.laws import law_of
from dem.material import Material
from dem.shapes import Kind

if TYPE_CHECKING:
    from dem.experiment.config import Configuration  # which imports this file


@dataclass(eq=False)
class Replicate(Identity):
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
        return law_of(c.law_name, c.beside)(**c.contact.constants)

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
