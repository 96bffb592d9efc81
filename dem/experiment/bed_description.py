"""What a bed is made of, as plain values: granules, a box, solids, and how all is packed.

What packs a bed is given nothing else, so it depends on nothing else: its identity is the hash of
these values and of the code of its shape and law.
"""

import json
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dem.base.provenance import compilers
from dem.base.source_hash import digest, run_hash
from dem.experiment.granule_table import GranuleTable
from dem.experiment.intruders import Intruder
from dem.laws import file_of, law_of
from dem.material import Material
from dem.shapes import KINDS, kind_of

NOMINAL = 0.84  # packing fraction that tells where a bed under a pressure has its cylinder
NO_VALUES = {"label", "beside"}  # fields that no number depends on
MEMBER = {
    "fraction",
    "box_height",
    "region",
    "pressure",
    "modulus",
    "thickness",
    "friction",
    "seed",
}  # that beds of a family differ in


@dataclass(frozen=True)
class Part:
    """Granules of one shape of a mixture, or all.

    Attributes
    ----------
    diameter : float
        Mean volume diameter (m).
    form : float or tuple
        Length over width, without unit; of a clump rows (x, y, radius) of its discs.
    share : float
        By number.
    """

    diameter: float
    form: float | tuple
    share: float = 1.0


@dataclass(frozen=True)
class BedDescription:
    """All that a bed depends on.

    Attributes
    ----------
    kind : str
        Kind of its granules, or file and class of a user's own.
    parts : tuple of Part
        Their shapes.
    count : int
        Number of granules.
    size_spread : float
        Diameters are uniform within +- this share, without unit.
    width : float
        Width (m) of the box.
    periodic : str
        Sides along which it repeats itself.
    solids : tuple of Intruder
        What granules leave room for.
    law, constants : str, dict
        Contact law by its name or file, and the constants that it is given.
    preparation : str
        How granules grow, or that they settle.
    friction : float
        Of all contacts while the bed is packed.
    moduli : tuple of float
        E* of two granules of each material over the greatest.
    fraction : float, optional
        Packing fraction; None under a pressure.
    box_height : float, optional
        Height (m) of the box; None where it follows from the fraction or the pressure.
    region : tuple of float, optional
        Left, bottom, right and top (m) of the rows of a lattice.
    table : GranuleTable, optional
        The granules of a file.
    pressure, modulus, thickness : float, optional
        Pressure (Pa) on the top wall, greatest E* (Pa), thickness (m); where it is pressed.
    materials, gravity : tuple of Material, float, optional
        Of granules that settle, with the thickness; gravity in m/s2.
    seed : int
        Seed of sizes, places and angles.
    label, beside : str
        What sentences call the shape, and the folder of a user's files.
    """

    kind: str
    parts: tuple[Part, ...]
    count: int
    size_spread: float
    width: float
    periodic: str
    solids: tuple[Intruder, ...]
    law: str
    constants: dict[str, float]
    preparation: str
    friction: float
    moduli: tuple[float, ...]
    fraction: float | None = None
    box_height: float | None = None
    region: tuple[float, ...] | None = None
    table: GranuleTable | None = None
    pressure: float | None = None
    modulus: float | None = None
    thickness: float | None = None
    materials: tuple[Material, ...] | None = None
    gravity: float | None = None
    seed: int = 0
    label: str = ""
    beside: str | None = None

    def _text(self, without: set[str]) -> str:
        known = {name: v for name, v in values_of(self).items() if name not in without}
        return json.dumps(known, default=values_of)

    @property
    def text(self) -> str:
        """Its values as text."""
        return self._text(NO_VALUES)

    @property
    def family(self) -> str:
        """Hash of all values but how densely the bed is packed, with which friction and seed."""
        return digest(self._text(NO_VALUES | MEMBER))

    @property
    def id(self) -> str:
        """Identity of the bed; raises InputError where the file of its shape or law cannot be used."""
        files = kind_of(self.kind, self.beside).file, file_of(self.law, self.beside)
        return digest(self.text, compilers(), run_hash(*files))

    @property
    def contact_law(self):
        """The law of contacts; raises InputError where its file cannot be used."""
        return law_of(self.law, self.beside)(**self.constants)

    # Granules

    @property
    def part_numbers(self) -> np.ndarray:
        """Which of the parts (n,) each granule is of, in the numbers nearest to their shares."""
        ends = np.cumsum([0.0, *(part.share for part in self.parts)])
        counts = np.diff(np.rint(ends * self.count).astype(int))
        numbers = np.repeat(np.arange(len(counts)), counts)
        return np.random.default_rng([self.seed, 2]).permutation(numbers)

    @property
    def species(self) -> np.ndarray | None:
        """Which of the materials (n,) each granule is of; None if there is one."""
        return self.part_numbers if len(self.moduli) > 1 else None

    @property
    def given_diameters(self) -> np.ndarray | None:
        """Volume diameters (n,) in m of a file, None where the seed draws them."""
        return self.table and self.table.diameters

    @property
    def diameters(self) -> np.ndarray:
        """Volume diameters (n,) in m, from a file, or each about the mean of its part."""
        if self.given_diameters is not None:
            return self.given_diameters
        means = np.array([part.diameter for part in self.parts])[self.part_numbers]
        return sample_diameters(means, self.count, self.size_spread, self.seed)

    @property
    def extremes(self) -> tuple[float, float]:
        """Least and greatest volume diameter (m) that a granule of any seed may have."""
        if (given := self.given_diameters) is not None:
            return given.min(), given.max()
        sizes = [part.diameter for part in self.parts]
        return min(sizes) * (1.0 - self.size_spread), max(sizes) * (1.0 + self.size_spread)

    # The box

    @cached_property
    def area_of_solids(self) -> float:
        """Area (m2) that the solids take."""
        return sum(solid.area for solid in self.solids)

    def height(self, diameters: np.ndarray | float, count: int = 1) -> float:
        """Height (m) for granules of some diameters (m), V_f = V_g / (W H - V_c) (equation 18).

        count: how many granules there are of every diameter. Under a pressure V_f is NOMINAL: the
        height by which the start of the cylinder is measured, near the height of the bed.
        """
        if self.box_height is not None:
            return self.box_height
        granules = 0.25 * math.pi * count * np.sum(np.square(diameters))
        return (granules / (self.fraction or NOMINAL) + self.area_of_solids) / self.width

    def start_height(self, height: float) -> float:
        """Height (m) of the box by which solids are placed in a bed of a height (m): the same, or under
        a pressure that at NOMINAL, in which the bed was packed around them."""
        return height if self.pressure is None else self.height(self.diameters)


def values_of(part) -> dict:
    """Fields of a dataclass by name, but for those that are None, or follow from others."""
    fields = part.__dataclass_fields__.items()
    values = ((name, getattr(part, name)) for name, field in fields if field.compare)
    return {name: value for name, value in values if value is not None}


def sample_diameters(mean, count: int, spread: float, seed: int) -> np.ndarray:
    """Volume diameters (count,) in m, uniform within +- spread of the mean (m), or of one each."""
    return mean * np.random.default_rng([seed, 0]).uniform(1.0 - spread, 1.0 + spread, count)


def length_of(form, diameter: float) -> float:
    """Diameter (m) of the circle about the centre of a granule that holds it; diameter: of its
    volume (m)."""
    if isinstance(form, tuple):
        return 2.0 * float(KINDS["clump"].shape.of_size([diameter], form).bounding_radius[0])
    return diameter * math.sqrt(form)
