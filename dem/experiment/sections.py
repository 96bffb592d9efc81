"""The sections of a configuration: what each value is, its type with its unit, its default.

Those of what stands and moves in a bed, and of what happens there, are in `scene_sections.py`.
"""

import math
from collections.abc import Iterable
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from dem.base.plugins import is_plugin
from dem.base.types import (
    AspectRatio,
    Coefficient,
    Count,
    Density,
    Force,
    Label,
    Length,
    Number,
    PoissonRatio,
    Positive,
    Pressure,
    Ratio,
    Restitution,
    Section,
    Seed,
    Stiffness,
    Time,
    Unit,
    must,
)
from dem.dynamics.numerics import (
    MAX_OVERLAP,
    STEP_FRACTION,
    MaxOverlap,
    StepFraction,
    check_stable,
)
from dem.experiment.granule_table import Granules
from dem.experiment.observables import OBSERVABLES
from dem.laws import LAWS
from dem.material import Friction, Rolling
from dem.shapes import KINDS

# in any order they are one bed, or one scene
SORTED = AfterValidator(lambda table: dict(sorted(table.items())))
Share = Annotated[Ratio, Field(lt=1)]
# the shortest length of an outline, however slender or rounded, is one that the library takes
Diameter = Annotated[Number, Field(ge=1e-12), Unit("m")]
Place = Annotated[Number, Unit("m")]
Region = Annotated[
    tuple[Place, Place, Place, Place],
    must(
        "be left, bottom, right, top, in this order and apart",
        lambda region: region[0] < region[2] and region[1] < region[3],
    ),
]
LOOSEST = 0.75  # packing fraction of a box with room above a bed that settles
CELLS = 60


def or_file(known: Iterable[str]) -> AfterValidator:
    """A name of the package, or of a file of a user's own, which is looked up later."""

    def check(name: str) -> str:
        if name in tuple(known) or is_plugin(name):
            return name
        *others, last = map(repr, known)
        raise ValueError(f"it must be {', '.join(others)} or {last}")

    return AfterValidator(check)


class SolidMaterialSection(Section):
    young_modulus: Pressure
    """Young's modulus"""
    poisson_ratio: PoissonRatio = 0.3
    """Poisson's ratio"""
    restitution: Restitution | None = None
    """coefficient of restitution of two bodies of this material; none: that of the granules"""


class GranuleMaterialSection(SolidMaterialSection):
    density: Density | None = None
    """density of these granules; none: that of the run"""


class MaterialSection(Section):
    young_modulus: Pressure
    """Young's modulus"""
    poisson_ratio: PoissonRatio
    """Poisson's ratio"""
    restitution: Restitution
    """coefficient of restitution"""
    thickness: Length | None = None
    """length of granules out of the plane; none: mean diameter"""


class FrictionSection(Section):
    granule: Coefficient
    """friction between granules"""
    wall: Coefficient
    """friction at the walls"""
    cylinder: Coefficient
    """friction at the cylinder"""
    stiffness: Ratio = Friction.stiffness
    """stiffness of tangential springs relative to Mindlin's"""


class RollingSection(Section):
    granule: Coefficient
    """rolling resistance between granules"""
    wall: Coefficient
    """rolling resistance at the walls"""
    cylinder: Coefficient
    """rolling resistance at the cylinder"""
    damping: Coefficient = Rolling.damping
    """damping ratio of granules that rock without rolling"""


class ContactSection(Section):
    law: Annotated[str, or_file(LAWS), Field(examples=[*LAWS])] | None = None
    """law of contacts, or file and class of your own, such as mine.Law; none: hertz"""
    stiffness: Stiffness | None = None
    """normal stiffness of linear contacts; none: pi/4 E* times thickness"""
    pull_off: Force | None = None
    """force that parts cohesive contacts, which they need"""
    range: Length | None = None
    """gap across which cohesive contacts attract, which they need"""

    @property
    def name(self) -> str:
        """Name of the law."""
        return self.law or "hertz"

    @property
    def constants(self) -> dict[str, float]:
        """What the law is given."""
        return {key: value for key, value in self if key != "law" and value is not None}

    @model_validator(mode="after")
    def _check(self):
        law, cohesive = self.name, {"pull_off", "range"}
        for key, value in self.constants.items():
            owner = "cohesive" if key in cohesive else "linear"
            if law != owner:
                raise ValueError(
                    f"{key} is {value:g} and law {law}; leave it out, or let law be {owner}"
                )
        if law == "cohesive" and (missing := cohesive - self.constants.keys()):
            raise ValueError(f"law is cohesive; give {' and '.join(sorted(missing))} too")
        return self


class EllipseSection(Section):
    contact: Literal["common_normal", "geometric_potential"] = "common_normal"
    """how the point and the normal of a contact of ellipses are found"""
    curvature: Literal["volume", "local"] = "volume"
    """radius of ellipses in Hertz's law: volume, sqrt(a b); local, the radius of curvature at the contact"""


Discs = Annotated[
    Annotated[tuple[tuple[Number, Number, Positive], ...], Field(min_length=1)],
    must("be a list of discs [x, y, radius], or a file with a line x, y, radius of each"),
    WithJsonSchema({"anyOf": [{"type": "array"}, {"type": "string"}]}),
]
Mixture = Annotated[dict[Label, Share], Field(min_length=2), SORTED]


class ShapeSection(Section):
    kind: Annotated[str, or_file(KINDS), Field(examples=[*KINDS])] | None = None
    """kind of granule, or file and class of your own, such as stones.Stone; none: required unless mixture is given"""
    diameter: Diameter | None = None
    """mean volume diameter of the granules; none: required unless mixture is given"""
    granules: Annotated[Count, Field(ge=1, le=10_000_000)] | None = None
    """number of granules; none: required unless the shape is only a part of mixtures"""
    aspect_ratio: AspectRatio | None = None
    """length over width of a granule; none: that of the kind, such as 1 of a disc"""
    discs: Discs | None = None
    """discs of a clump, [x, y, radius] of each in any unit, or a file with these lines; none: required where kind is clump"""
    mixture: Mixture | None = None
    """shares by number of other shapes, by label, all of one kind; none: required unless kind is given"""
    material: GranuleMaterialSection | None = None
    """material of these granules; none: that of the key material"""

    @model_validator(mode="after")
    def _check(self):
        mixed, clump = self.mixture is not None, self.kind == "clump"
        natural = KINDS[self.kind].aspect_ratio if self.kind in KINDS else None
        whose = "a mixture" if mixed else f"kind {self.kind}" if self.kind else "a shape"
        if mixed and self.material is not None:
            raise ValueError("material is given; a mixture takes none, its shapes have theirs")
        needed = {"kind": not mixed, "diameter": not mixed, "discs": clump}
        if not natural:
            needed["aspect_ratio"] = not (mixed or clump)
        for name, needs in needed.items():
            if needs and getattr(self, name) is None:
                raise ValueError(f"{name} is missing; {whose} needs one")
            if not needs and getattr(self, name) is not None:
                raise ValueError(f"{name} is given; {whose} takes none")
        if mixed and not math.isclose(total := sum(self.mixture.values()), 1.0, abs_tol=1e-9):
            raise ValueError(f"mixture has shares that sum to {total:g}; they must sum to 1")
        if natural and self.aspect_ratio not in (None, natural):
            raise ValueError(
                f"aspect_ratio is {self.aspect_ratio:g}; a {self.kind} always has {natural:g}, "
                "leave it out"
            )
        return self

    @property
    def ratio(self) -> float:
        """Length over width."""
        if self.discs is None:
            return self.aspect_ratio or KINDS[self.kind].aspect_ratio
        x, y, radius = np.transpose(self.discs)
        angle = np.linspace(0.0, np.pi, 721)[:, None]
        along = x * np.cos(angle) + y * np.sin(angle)
        width = np.ptp(np.hstack([along + radius, along - radius]), axis=1)
        return float(width.max() / width.min())

    @property
    def form(self):
        """What granules are made of beside their diameter."""
        return self.discs or self.ratio


class PackingSection(Section):
    fraction: Share | None = None
    """area of the granules over the area of the box without solids; none: required unless pressure or height is given"""
    height: Length | None = None
    """height of the box; none: it follows from fraction or pressure"""
    size_spread: Annotated[Coefficient, Field(lt=1)]
    """half-width of the uniform distribution of diameters, relative to the mean diameter"""
    friction: Coefficient = 0.0
    """friction of all contacts while the bed is packed"""
    pressure: Pressure | None = None
    """pressure that the top wall exerts and keeps; none: required unless fraction or height is given"""
    preparation: Literal["relaxed", "grown", "settled", "lattice", "file"] = "relaxed"
    """relaxed: granules grow and their energy is minimised; grown: they grow in motion; settled: then they fall under
    gravity; lattice: they are put in rows, apart from each other; file: they are where packing.file says"""
    region: Region | None = None
    """rectangle [left, bottom, right, top] of the rows of a lattice; none: the whole box"""
    file: Granules | None = None
    """file with the places of granules: CSV with columns x, y, angle, diameter, a text dump of LAMMPS, or a file of
    results with words that choose one run, whose last snapshot is taken; without diameters the seed draws them"""

    @model_validator(mode="after")
    def _check(self):
        sizes = "fraction", "height", "pressure"
        given = {key: value for key, value in self if key in sizes and value is not None}
        placed = {"lattice": "in a lattice", "file": "of a file"}.get(self.preparation)
        if placed and self.height is None:
            raise ValueError(f"height is missing; granules {placed} fill no box, give it")
        if placed and self.friction:
            raise ValueError(
                f"friction is {self.friction:g} and preparation {self.preparation}; nothing is packed, "
                "leave it out"
            )
        if (self.file is None) == (self.preparation == "file"):
            words = "missing" if self.file is None else "given"
            other = "give one" if self.file is None else "leave it out, or let that be file"
            raise ValueError(f"file is {words} and preparation {self.preparation}; {other}")
        if not given:
            raise ValueError("fraction is missing; give it, or a pressure in its place")
        if len(given) > 1:
            (name, value), (other, size), *_ = given.items()
            raise ValueError(
                f"{name} is {value:g} and {other} {size:g}; one follows from the other, make one of them "
                "null"
            )
        if self.region is not None and self.preparation != "lattice":
            raise ValueError("region is given; only a lattice has one, leave it out")
        if self.preparation == "settled" and (self.fraction or 0.0) > LOOSEST:
            raise ValueError(
                f"fraction is {self.fraction:g} and preparation settled; it is that of the box with "
                f"the room above the bed, let it be at most {LOOSEST:g}"
            )
        if self.pressure is not None and (self.friction or self.preparation != "relaxed"):
            raise ValueError(
                f"friction is {self.friction:g} and preparation {self.preparation}; a bed that is "
                "packed under a pressure is relaxed without friction, leave both out"
            )
        return self


class ShearSection(Section):
    inertial_number: Ratio
    """inertial number: rate of shear times sqrt(mass / (pressure * thickness))"""
    pressure: Pressure
    """pressure on the lid"""
    settle: Coefficient
    """least strain before anything is measured"""
    strain: Ratio
    """strain while it is measured"""
    samples: Annotated[Count, Field(ge=2, le=100_000)]
    """samples over this strain"""


class RecordSection(Section):
    bins: Annotated[Count, Field(ge=1, le=100_000)]
    """bins over the stroke, or over the last phase of a scene; a multiple of snapshots - 1"""
    window: tuple[Coefficient, Length] | None = None
    """[start, stop]: displacements between which the mean drag is taken; the experiment drag needs it"""
    snapshots: Annotated[Count, Field(ge=2, le=10_000)]
    """number of snapshots of all granules, from the start to the end"""
    cells: Annotated[Count, Field(ge=1, le=10_000)] = CELLS
    """cells along x of the profile of the surface; of the experiment scene"""
    region: Region | None = None
    """rectangle [left, bottom, right, top] in which granules are counted; of the experiment scene; none: nowhere"""
    observables: (
        Annotated[
            tuple[Annotated[str, or_file(OBSERVABLES)], ...],
            Field(min_length=1),
            AfterValidator(
                lambda names: tuple(sorted(set(names)))
            ),  # in any order they are one run
        ]
        | None
    ) = None
    """names of observables, or files of your own, such as mine.py; none: the usual ones of the experiment"""

    @model_validator(mode="after")
    def _check(self):
        if self.window and not self.window[0] < self.window[1]:
            raise ValueError(f"window {list(self.window)} must run from less to more")
        return self


class NumericsSection(Section):
    step_fraction: StepFraction = STEP_FRACTION
    """time step over the critical one of stiffness alone; damping may shorten it more"""
    allow_unstable: bool = False
    """whether steps beyond the critical one are taken"""
    time_step: Time | None = None
    """fixed time step; none: it follows from the stiffness of the bed and step_fraction"""
    max_overlap: MaxOverlap = MAX_OVERLAP
    """overlap at which a run ends with an error, relative to the smaller radius"""

    @model_validator(mode="after")
    def _check(self):
        check_stable(self.step_fraction, self.allow_unstable)
        return self


class RunSection(Section):
    """What a run has beside the values of its configuration."""

    shape: str
    """label of the shape of its granules"""
    density: Density
    """density of its granules"""
    seed: Seed
    """seed of its random bed"""
