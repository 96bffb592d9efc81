"""The sections of a configuration: what each value is, its type with its unit, its default."""

import math
from collections.abc import Iterable
from itertools import pairwise
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
    Mass,
    NotNegative,
    Number,
    PoissonRatio,
    Positive,
    Pressure,
    Ratio,
    Restitution,
    Section,
    Seed,
    Speed,
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
from dem.experiment.intruders import towards
from dem.experiment.observables import OBSERVABLES
from dem.laws import LAWS
from dem.material import BasePlate, Friction, Rolling, Tilt
from dem.shapes import KINDS

# in any order they are one bed, or one scene
SORTED = AfterValidator(lambda table: dict(sorted(table.items())))
Share = Annotated[Ratio, Field(lt=1)]
# the shortest length of an outline, however slender or rounded, is one that the library takes
Diameter = Annotated[Number, Field(ge=1e-12), Unit("m")]
LOOSEST = 0.75  # packing fraction of a box with room above a bed that settles


def or_file(known: Iterable[str]) -> AfterValidator:
    """A name of the package, or of a file of a user's own, which is looked up later."""

    def check(name: str) -> str:
        if name in tuple(known) or is_plugin(name):
            return name
        *others, last = map(repr, known)
        raise ValueError(f"it must be {', '.join(others)} or {last}")

    return AfterValidator(check)


Place = Annotated[Number, Unit("m")]
Region = Annotated[
    tuple[Place, Place, Place, Place],
    must(
        "be left, bottom, right, top, in this order and apart",
        lambda region: region[0] < region[2] and region[1] < region[3],
    ),
]
Side = Place | None
Opening = Annotated[
    tuple[Side, Side, Side, Side],
    must(
        "be left, bottom, right, top, in this order and apart, null for a side that is open",
        lambda region: all(
            None in sides or sides[0] < sides[1] for sides in (region[::2], region[1::2])
        ),
    ),
]
Angle = Annotated[Number, Unit("rad")]


def _rise(rows) -> bool:
    """Whether the times of rows rise; a number has none."""
    return not isinstance(rows, tuple) or all(one[0] < two[0] for one, two in pairwise(rows))


Path = Annotated[
    Annotated[tuple[tuple[NotNegative, Number, Number, Number], ...], Field(min_length=2)],
    must("be rows [time, velocity along x, along y, spin] whose times rise", _rise),
]
Loads = Annotated[tuple[tuple[NotNegative, Number], ...], Field(min_length=2)]
Push = Annotated[
    Annotated[Number, Unit("N")] | Loads,
    must("be a force, or rows [time, force] whose times rise", _rise),
    Unit("N"),
]
Torque = Annotated[
    Annotated[Number, Unit("N m")] | Loads,
    must("be a torque, or rows [time, torque] whose times rise", _rise),
    Unit("N m"),
]
Spin = Annotated[
    Literal["free"] | Annotated[Number, Unit("rad s-1")],
    must("be an angular velocity or free"),
    Unit("rad s-1"),
]


class SolidMaterialSection(Section):
    young_modulus: Pressure
    """Young's modulus"""
    poisson_ratio: PoissonRatio = 0.3
    """Poisson's ratio"""
    restitution: Restitution | None = None
    """coefficient of restitution of two bodies of it; none: that of the granules"""


class GranuleMaterialSection(SolidMaterialSection):
    density: Density | None = None
    """density; none: that of the run"""


CELLS = 60


class MovingSection(Section):
    """How a solid moves: along a direction, and about a point."""

    velocity: Annotated[Number, Unit("m s-1")] | None = None
    """velocity along its direction; none: that of before, 0 at the start"""
    direction: Angle | None = None
    """direction of the motion, anticlockwise from the right; none: that of before, upwards at the start"""
    spin: Spin | None = None
    """angular velocity, or free: granules turn it, as a body of their mean density; none: that of before, 0 at the start"""

    @property
    def ahead(self) -> tuple[float, float]:
        """Unit vector along the motion."""
        return towards(self.direction)


class CylinderSection(MovingSection):
    diameter: Diameter
    """diameter of the cylinder; length of a plate or an ellipse"""
    velocity: Speed
    """velocity of the cylinder, upwards if there is no direction"""
    direction: Angle | None = None
    """direction of the motion, anticlockwise from the right; none: upwards"""
    start: Share
    """height of the cylinder's axis as a fraction of that of the box"""
    stroke: Length
    """distance over which the cylinder is drawn"""
    outline: Literal["circle", "ellipse", "plate", "square", "wedge"] | None = None
    """outline, as wide as the diameter; none: circle"""
    aspect_ratio: Annotated[AspectRatio, Field(gt=1)] | None = None
    """length over width of an ellipse or a plate; none: 2 or 6"""
    angle: Angle | None = None
    """angle at the start, anticlockwise; none: 0, its length from left to right, its tip upwards"""
    material: SolidMaterialSection | None = None
    """material; none: rigid"""

    @model_validator(mode="after")
    def _check(self):
        long = self.outline in ("ellipse", "plate")
        if self.aspect_ratio is not None and not long:
            raise ValueError(
                f"aspect_ratio is {self.aspect_ratio:g} and outline {self.outline or 'circle'}; "
                "leave it out, or let outline be ellipse or plate"
            )
        return self


class SecondSection(Section):
    diameter: Diameter
    """diameter of a second cylinder, which moves with the first"""
    gap: Annotated[NotNegative, Unit("m")]
    """distance between the surfaces of both"""
    bearing: Angle = 0.0
    """where it is, seen from the first: 0 beside it, to the right; pi/2 ahead of it"""
    friction: Coefficient | None = None
    """friction at it; none: friction.cylinder"""
    spin: Spin | None = None
    """angular velocity, or free; none: 0"""


class MotionSection(MovingSection):
    """The same of a solid of a scene, which forces may move too."""

    force_x: Push | None = None
    """force that moves it along x, with those of the granules, or rows [time, force] since its start; none: its velocity does"""
    force_y: Push | None = None
    """the same along y"""
    spring_x: Stiffness | None = None
    """stiffness along x of a spring that pulls it to a point, which moves by velocity and direction, or by path; none: no spring"""
    spring_y: Stiffness | None = None
    """the same along y"""
    torque: Torque | None = None
    """torque that turns it, with those of the granules, or rows [time, torque] since its start; none: its spin does"""
    path: Path | None = None
    """rows [time, velocity along x, along y, spin] in s, m/s and rad/s since its start, linear in between; none: velocity"""

    @property
    def springs(self) -> tuple[float, float]:
        """Stiffness along x and y."""
        return self.spring_x or 0.0, self.spring_y or 0.0

    @property
    def forces(self) -> tuple:
        """Forces along x and y, none where its velocity moves it."""
        pairs = zip((self.force_x, self.force_y), self.springs, strict=True)
        return tuple(0.0 if force is None and spring else force for force, spring in pairs)

    @property
    def driven(self) -> bool:
        """Whether forces move or turn it."""
        return self.forces != (None, None) or self.torque is not None or self.spin == "free"

    @model_validator(mode="after")
    def _check_motion(self):
        if self.path is not None:
            others = ["velocity", "direction"]
            if not any(self.springs):
                others += ["spin", "force_x", "force_y", "torque"]
            elif any(row[3] for row in self.path):
                raise ValueError(
                    "path has a spin, and it is that of the point to which a spring pulls; make it 0, "
                    "and give spin or torque"
                )
            for name in others:
                if getattr(self, name) is not None:
                    raise ValueError(
                        f"path and {name} are given; a path has all of the motion, leave one out"
                    )
        if self.direction is not None and self.velocity is None and self.forces != (None, None):
            raise ValueError(
                f"direction is {self.direction:g} and velocity missing; forces move it from the velocity "
                "that it has, give both or none"
            )
        if self.torque is not None and self.spin is not None:
            raise ValueError(f"torque is given and spin {self.spin}; leave one out")
        return self


class PhaseMotionSection(MotionSection):
    removed: bool = False
    """true: it is there no more, from the start of the phase on"""

    @model_validator(mode="after")
    def _check_removed(self):
        for name, value in self if self.removed else ():
            if name != "removed" and value is not None:
                raise ValueError(
                    f"removed is true and {name} given; what is not there cannot move, leave one out"
                )
        return self


def _check_thickness(section) -> None:
    if section.thickness is not None and section.outline not in ("ellipse", "plate", "ring"):
        raise ValueError(
            f"thickness is {section.thickness:g} and outline {section.outline}; leave it out, or let "
            "outline be plate, ellipse or ring"
        )
    long = section.outline in ("ellipse", "plate")
    if long and (section.thickness or 0.0) >= section.diameter:
        raise ValueError(
            f"thickness is {section.thickness:g} m; it must be less than diameter, {section.diameter:g} m"
        )


class PartSection(Section):
    """A part of a solid that has several."""

    outline: Literal["circle", "plate", "square", "wedge", "ring"]
    """outline, as of a solid"""
    diameter: Diameter
    """diameter, as of a solid"""
    thickness: Length | None = None
    """thickness of a ring or a plate; none: a sixth of the diameter"""
    x: Place = 0.0
    """place of its middle along x from that of the solid, where that has an angle of 0"""
    y: Place = 0.0
    """the same along y"""
    angle: Angle = 0.0
    """angle from that of the solid, anticlockwise"""

    @model_validator(mode="after")
    def _check(self):
        _check_thickness(self)
        return self


class SolidSection(MotionSection):
    outline: Literal["circle", "ellipse", "plate", "square", "wedge", "ring"] | None = None
    """outline, with its length from left to right and its tip upwards at an angle of 0; none: it has parts"""
    diameter: Diameter | None = None
    """diameter; length of a plate or an ellipse; of a ring, which has 36 plates, that of the room inside; none: it has parts"""
    parts: Annotated[
        dict[Label, PartSection],
        AfterValidator(lambda parts: dict(sorted(parts.items()))),  # in any order they are one run
    ] = Field({})
    """outlines that together are one body, by name"""
    thickness: Length | None = None
    """thickness of a ring or a plate, width of an ellipse; none: a sixth of the diameter, half of it"""
    x: Place
    """place of the middle along x at the start"""
    y: Place = 0.0
    """place of the middle along y at the start, above that of start"""
    start: Annotated[Coefficient, Field(lt=1)] = 0.0
    """height from which y counts, as a fraction of that of the box"""
    angle: Angle = 0.0
    """angle at the start, anticlockwise"""
    pivot_x: Place | None = None
    """place along x of the point that it turns about; none: x"""
    pivot_y: Place | None = None
    """place along y of the point that it turns about; none: y"""
    mass: Mass | None = None
    """its mass where forces move or turn it; none: that of granules in its place"""
    weight: bool = False
    """true: its weight moves it where forces do along y, and else turns it, at the centre of its area"""
    friction: Coefficient | None = None
    """friction at it; none: friction.cylinder"""
    material: SolidMaterialSection | None = None
    """material; none: rigid"""

    @model_validator(mode="after")
    def _check(self):
        if not {"y", "start"} & self.model_fields_set:
            raise ValueError("y is missing; give it, or start")
        for name in ("outline", "diameter"):
            if not self.parts and getattr(self, name) is None:
                raise ValueError(f"{name} is missing; give it, or parts")
        for name in ("outline", "diameter", "thickness"):
            if self.parts and getattr(self, name) is not None:
                raise ValueError(f"{name} and parts are given; parts have theirs, leave one out")
        _check_thickness(self)
        turned = self.pivot_x is not None or self.pivot_y is not None
        if turned and self.outline in ("circle", "ellipse"):
            raise ValueError(
                f"outline is {self.outline}, which turns about its middle; leave pivot_x and pivot_y out"
            )
        return self


class PhaseSection(Section):
    time: Time | None = None
    """how long it lasts; none: until says it"""
    until: Literal["rest"] | None = None
    """rest: until the granules are at rest under gravity; none: time says it"""
    motion: dict[Label, PhaseMotionSection] = Field({})
    """how solids move from its start on"""

    @model_validator(mode="after")
    def _check(self):
        if (self.time is None) == (self.until is None):
            words = "both are given" if self.time else "neither is given"
            raise ValueError(f"it must have a time or until, and {words}")
        return self


class SinkSection(Section):
    """Where granules leave a scene."""

    region: Opening
    """where a granule with its centre in it goes: left, bottom, right, top; null: open on that side"""
    to: Label | None = None
    """name of the source where it comes again; none: nowhere"""


class SourceSection(Section):
    """Where granules come into a scene."""

    region: Region
    """where they come, whole: left, bottom, right, top"""
    count: Annotated[Count, Field(ge=1, le=10_000_000)] | None = None
    """number of granules that it has at the start; none: those of sinks alone"""
    rate: Annotated[Positive, Unit("s-1")] | None = None
    """granules in a second, at most; none: as many as have room"""
    velocity_x: Annotated[Number, Unit("m s-1")] = 0.0
    """velocity along x with which they come"""
    velocity_y: Annotated[Number, Unit("m s-1")] = 0.0
    """the same along y"""


class WallSection(Section):
    friction: Coefficient | None = None
    """friction at this wall; none: friction.wall"""
    material: SolidMaterialSection | None = None
    """material of this wall; none: rigid"""


class WallsSection(Section):
    left: WallSection | None = None
    right: WallSection | None = None
    bottom: WallSection | None = None
    top: WallSection | None = None


class PackingSection(Section):
    fraction: Share | None = None
    """packing fraction; none: packing.pressure or packing.height is given"""
    height: Length | None = None
    """height of the box; none: it follows from the fraction or the pressure"""
    size_spread: Annotated[Coefficient, Field(lt=1)]
    """diameters are uniform within +- this share"""
    friction: Coefficient = 0.0
    """friction of all contacts while the bed is packed"""
    pressure: Pressure | None = None
    """pressure on the top wall, which holds it; none: packing.fraction or packing.height is given"""
    preparation: Literal["relaxed", "grown", "settled", "lattice", "file"] = "relaxed"
    """how granules grow: energy minimised, or in motion; settled: then they fall under gravity; lattice: they are put in
    rows, apart from each other; file: they are where packing.file says"""
    region: Region | None = None
    """where the rows are: left, bottom, right, top; none: the whole box"""
    file: Granules | None = None
    """where granules are: a CSV file with columns x, y, angle, diameter, a text dump of LAMMPS, or a file of results
    with words that choose one run, whose last snapshot it is; without diameters the seed draws them"""

    @model_validator(mode="after")
    def _check(self):
        if self.preparation == "lattice":
            if self.height is None:
                raise ValueError("height is missing; granules in a lattice fill no box, give it")
            if self.friction:
                raise ValueError(
                    f"friction is {self.friction:g} and preparation lattice; granules there do not meet, "
                    "leave it out"
                )
        if (self.file is None) == (self.preparation == "file"):
            words = "missing" if self.file is None else "given"
            other = "give one" if self.file is None else "leave it out, or let that be file"
            raise ValueError(f"file is {words} and preparation {self.preparation}; {other}")
        if self.file is not None and self.height is None:
            raise ValueError("height is missing; granules of a file fill no box, give it")
        if self.file is not None and self.friction:
            raise ValueError(
                f"friction is {self.friction:g} and preparation file; nothing is packed, leave it out"
            )
        given = {"fraction": self.fraction, "pressure": self.pressure, "height": self.height}
        if all(value is None for value in given.values()):
            raise ValueError("fraction is missing; give it, or a pressure in its place")
        if self.height is not None and (other := self.fraction or self.pressure) is not None:
            key = "fraction" if self.fraction else "pressure"
            raise ValueError(
                f"height is {self.height:g} m and {key} {other:g}; one follows from the other, make one "
                "of them null"
            )
        if self.region is not None and self.preparation != "lattice":
            raise ValueError("region is given; only a lattice has one, leave it out")
        if self.fraction is not None and self.pressure is not None:
            raise ValueError(
                f"fraction is {self.fraction:g} and pressure {self.pressure:g} Pa; one follows "
                "from the other, make one of them null"
            )
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


class MaterialSection(Section):
    young_modulus: Pressure
    """Young's modulus"""
    poisson_ratio: PoissonRatio
    """Poisson's ratio"""
    restitution: Restitution
    """coefficient of restitution"""
    thickness: Length | None = None
    """thickness out of the plane; none: mean diameter"""


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


class BasePlateSection(Section):
    friction: Coefficient
    """friction between granules and the plate"""
    solid: Coefficient = BasePlate.solid
    """friction between the plate and solids that forces move"""
    gravity: Annotated[Positive, Unit("m s-2")] = BasePlate.gravity
    """gravity, which presses on the plate"""
    slope: Tilt = BasePlate.slope
    """angle by which the plate is tilted, downwards along -y"""
    slip: Ratio = BasePlate.slip
    """mean distance by which a granule moves before it slides, relative to the mean radius"""


class ContactSection(Section):
    law: Annotated[str, or_file(LAWS)] | None = None
    """law of contacts, or a class in a file of your own; none: hertz"""
    stiffness: Stiffness | None = None
    """normal stiffness of linear contacts; none: pi/4 E* times thickness"""
    pull_off: Force | None = None
    """force that parts cohesive contacts"""
    range: Length | None = None
    """gap across which cohesive contacts attract"""

    @property
    def constants(self) -> dict[str, float]:
        """What the law is given."""
        return {key: value for key, value in self if key != "law" and value is not None}

    @model_validator(mode="after")
    def _check(self):
        law, cohesive = self.law or "hertz", {"pull_off", "range"}
        for key, value in self.constants.items():
            owner = "cohesive" if key in cohesive else "linear"
            if law != owner:
                raise ValueError(
                    f"{key} is {value:g} and law {law}; leave it out, or let law be {owner}"
                )
        if law == "cohesive" and (missing := cohesive - self.constants.keys()):
            raise ValueError(f"law is cohesive; give {' and '.join(sorted(missing))} too")
        return self


class ShearSection(Section):
    inertial_number: Ratio
    """inertial number: rate of shear times sqrt(mass / (pressure thickness))"""
    pressure: Pressure
    """pressure on the lid"""
    settle: Coefficient
    """least strain before anything is measured"""
    strain: Ratio
    """strain while it is measured"""
    samples: Annotated[Count, Field(ge=2, le=100_000)]
    """samples over this strain"""


class EllipseSection(Section):
    contact: Literal["common_normal", "geometric_potential"] = "common_normal"
    """how a contact of ellipses is found"""
    curvature: Literal["volume", "local"] = "volume"
    """radius of ellipses in Hertz's law"""


class RecordSection(Section):
    bins: Annotated[Count, Field(ge=1, le=100_000)]
    """bins over the stroke"""
    window: tuple[Coefficient, Length] | None = None
    """displacements of the mean drag's window; of no other experiment"""
    snapshots: Annotated[Count, Field(ge=2, le=10_000)]
    """snapshots of all granules"""
    cells: Annotated[Count, Field(ge=1, le=10_000)] = CELLS
    """cells along x of the profile of the surface of a scene"""
    region: Region | None = None
    """where granules are counted, of a scene: left, bottom, right, top; none: nowhere"""
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
    """what is recorded; none: what the experiment usually does"""

    @model_validator(mode="after")
    def _check(self):
        if self.window and not self.window[0] < self.window[1]:
            raise ValueError(f"window {list(self.window)} must run from less to more")
        return self


class NumericsSection(Section):
    step_fraction: StepFraction = STEP_FRACTION
    """fraction of the critical time step of stiffness alone; damping may shorten it more"""
    allow_unstable: bool = False
    """whether steps beyond the critical one are taken"""
    time_step: Time | None = None
    """time step; none: from the bed's stiffness"""
    max_overlap: MaxOverlap = MAX_OVERLAP
    """overlap relative to the smaller radius at which a run ends"""

    @model_validator(mode="after")
    def _check(self):
        check_stable(self.step_fraction, self.allow_unstable)
        return self


Discs = Annotated[
    Annotated[tuple[tuple[Number, Number, Positive], ...], Field(min_length=1)],
    must("be a list of discs [x, y, radius], or a file with a line x, y, radius of each"),
    WithJsonSchema({"anyOf": [{"type": "array"}, {"type": "string"}]}),
]
Mixture = Annotated[dict[Label, Share], Field(min_length=2), SORTED]


class ShapeSection(Section):
    kind: Annotated[str, or_file(KINDS)] | None = None
    """kind of granule, or file and class of your own, such as stones.Stone; none: a mixture"""
    diameter: Diameter | None = None
    """mean volume diameter of the granules; none: a mixture"""
    granules: Annotated[Count, Field(ge=1, le=10_000_000)] | None = None
    """number of granules; none: a part of mixtures alone"""
    aspect_ratio: AspectRatio | None = None
    """length over width of a granule"""
    discs: Discs | None = None
    """discs of a clump, [x, y, radius] of each in any unit, or a file with these"""
    mixture: Mixture | None = None
    """shares by number of other shapes of one kind"""
    material: GranuleMaterialSection | None = None
    """material of these granules; none: material"""

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


class RunSection(Section):
    """What a run has beside the values of its configuration."""

    shape: str
    """label of the shape of its granules"""
    density: Density
    """density of its granules"""
    seed: Seed
    """seed of its random bed"""
