"""The sections of a configuration for what is in a bed: solids and how they move, walls, the plate
below, sinks and sources, phases."""

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from dem.base.types import (
    Coefficient,
    Count,
    Label,
    Length,
    Mass,
    NotNegative,
    Number,
    Positive,
    Ratio,
    Section,
    Speed,
    Stiffness,
    Time,
    Unit,
    must,
)
from dem.experiment.intruders import towards
from dem.experiment.sections import SORTED, Diameter, Place, Region, Share, SolidMaterialSection
from dem.material import BasePlate, Tilt

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
Drift = Annotated[Number, Unit("m s-1")]


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


class MovingSection(Section):
    """How a solid moves: along a direction, and about a point."""

    velocity: Drift | None = None
    """velocity along direction; none: as before, 0 at the start"""
    direction: Angle | None = None
    """direction of the motion, anticlockwise from the right; none: as before, upwards at the start"""
    spin: Spin | None = None
    """angular velocity, or free: granules turn it, as a body of their mean density; none: as before, 0 at the start"""

    @property
    def ahead(self) -> tuple[float, float]:
        """Unit vector along the motion."""
        return towards(self.direction)


class CylinderSection(MovingSection):
    diameter: Diameter
    """diameter of the cylinder, or length of a plate or an ellipse"""
    velocity: Speed
    """velocity of the cylinder, upwards if there is no direction"""
    direction: Angle | None = None
    """direction of the motion, anticlockwise from the right; none: upwards"""
    start: Share
    """height of the cylinder's axis at the start, as a fraction of the height of the box"""
    stroke: Length
    """distance over which the cylinder is drawn"""
    outline: Literal["circle", "ellipse", "plate", "square", "wedge"] | None = None
    """outline of the cylinder, as wide as diameter; none: circle"""
    aspect_ratio: Annotated[Number, Field(gt=1, le=1e6), Unit("1")] | None = None
    """length over width of an ellipse or a plate; none: 2 of an ellipse, 6 of a plate"""
    angle: Angle | None = None
    """angle at the start, anticlockwise from where its length is along x, or its tip upwards; none: 0"""
    material: SolidMaterialSection | None = None
    """material of the cylinder; none: rigid"""

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
    """distance between the surfaces of both cylinders"""
    bearing: Angle = 0.0
    """direction from the first to the second: 0 to the right of the motion, pi/2 ahead"""
    friction: Coefficient | None = None
    """friction at the second cylinder; none: friction.cylinder"""
    spin: Spin | None = None
    """angular velocity of the second cylinder, or free; none: 0"""


class MotionSection(MovingSection):
    """The same of a solid of a scene, which forces may move too."""

    force_x: Push | None = None
    """force that moves it along x, beside the forces of granules; or rows [time in s, force] from its start; none: velocity moves it"""
    force_y: Push | None = None
    """force that moves it along y, as force_x; none: velocity moves it"""
    spring_x: Stiffness | None = None
    """stiffness along x of a spring that pulls it to a point, which moves by velocity and direction, or by path; none: no spring"""
    spring_y: Stiffness | None = None
    """stiffness along y, as spring_x; none: no spring"""
    torque: Torque | None = None
    """torque that turns it, beside the torques of granules; or rows [time in s, torque] from its start; none: spin turns it"""
    path: Path | None = None
    """rows [time, velocity along x, along y, spin] in s, m/s and rad/s from its start, linear in between; none: velocity and spin"""

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
    """whether it is taken out at the start of the phase"""

    @model_validator(mode="after")
    def _check_removed(self):
        for name, value in self if self.removed else ():
            if name != "removed" and value is not None:
                raise ValueError(
                    f"removed is true and {name} given; what is not there cannot move, leave one out"
                )
        return self


def _check_thickness(section) -> None:
    long = section.outline in ("ellipse", "plate")
    if section.thickness is not None and not (long or section.outline == "ring"):
        raise ValueError(
            f"thickness is {section.thickness:g} and outline {section.outline}; leave it out, or let "
            "outline be plate, ellipse or ring"
        )
    if long and (section.thickness or 0.0) >= section.diameter:
        raise ValueError(
            f"thickness is {section.thickness:g} m; it must be less than diameter, {section.diameter:g} m"
        )


class PartSection(Section):
    """A part of a solid that has several."""

    outline: Literal["circle", "plate", "square", "wedge", "ring"]
    """outline of the part"""
    diameter: Diameter
    """diameter of the part, or length of a plate"""
    thickness: Length | None = None
    """thickness of a ring or a plate; none: a sixth of the diameter"""
    x: Place = 0.0
    """place of its middle along x from the middle of the solid, at an angle of 0 of the solid"""
    y: Place = 0.0
    """place of its middle along y, as x"""
    angle: Angle = 0.0
    """angle from the angle of the solid, anticlockwise"""

    @model_validator(mode="after")
    def _check(self):
        _check_thickness(self)
        return self


class SolidSection(MotionSection):
    outline: Literal["circle", "ellipse", "plate", "square", "wedge", "ring"] | None = None
    """outline; at an angle of 0 its length is along x, or its tip upwards; none: required unless there are parts"""
    diameter: Diameter | None = None
    """diameter, or length of a plate or an ellipse; of a ring, which is made of 36 plates, the diameter inside; none: required unless there are parts"""
    parts: Annotated[dict[Label, PartSection], SORTED] = Field({})
    """outlines that together are one body, by label"""
    thickness: Length | None = None
    """thickness of a ring or a plate, or width of an ellipse; none: a sixth of the diameter, or half of it for an ellipse"""
    x: Place
    """place of the middle along x at the start"""
    y: Place = 0.0
    """place of the middle along y at the start, above the height of start"""
    start: Annotated[Coefficient, Field(lt=1)] = 0.0
    """height from which y counts, as a fraction of the height of the box; y or start is required"""
    angle: Angle = 0.0
    """angle at the start, anticlockwise"""
    pivot_x: Place | None = None
    """place along x of the point that it turns about; none: the middle"""
    pivot_y: Place | None = None
    """place along y of the point that it turns about; none: the middle"""
    mass: Mass | None = None
    """mass, where forces move or turn the solid; none: the mass of granules in its place"""
    weight: bool = False
    """whether its weight acts, at the centre of its area: it moves a solid that forces move along y, and turns others"""
    friction: Coefficient | None = None
    """friction at the solid; none: friction.cylinder"""
    material: SolidMaterialSection | None = None
    """material of the solid; none: rigid"""

    @model_validator(mode="after")
    def _check(self):
        if not {"y", "start"} & self.model_fields_set:
            raise ValueError("y is missing; give it, or start")
        for name in ("outline", "diameter", "thickness"):
            given = getattr(self, name) is not None
            if self.parts and given:
                raise ValueError(f"{name} and parts are given; parts have theirs, leave one out")
            if not (self.parts or given or name == "thickness"):
                raise ValueError(f"{name} is missing; give it, or parts")
        _check_thickness(self)
        turned = self.pivot_x is not None or self.pivot_y is not None
        if turned and self.outline in ("circle", "ellipse"):
            raise ValueError(
                f"outline is {self.outline}, which turns about its middle; leave pivot_x and pivot_y out"
            )
        return self


class WallSection(Section):
    friction: Coefficient | None = None
    """friction at this wall; none: friction.wall"""
    material: SolidMaterialSection | None = None
    """material of this wall; none: rigid"""


class WallsSection(Section):
    left: WallSection | None = None
    """left wall; none: friction.wall, rigid"""
    right: WallSection | None = None
    """right wall; none: friction.wall, rigid"""
    bottom: WallSection | None = None
    """floor; none: friction.wall, rigid"""
    top: WallSection | None = None
    """top wall; none: friction.wall, rigid"""


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


class SinkSection(Section):
    """Where granules leave a scene."""

    region: Opening
    """rectangle [left, bottom, right, top] in which a granule leaves once its centre is there; null: open on that side"""
    to: Label | None = None
    """name of the source where these granules come again; none: nowhere"""


class SourceSection(Section):
    """Where granules come into a scene."""

    region: Region
    """rectangle [left, bottom, right, top] in which granules come, each wholly inside"""
    count: Annotated[Count, Field(ge=1, le=10_000_000)] | None = None
    """number of granules that wait in it at the start; none: only granules of sinks come"""
    rate: Annotated[Positive, Unit("s-1")] | None = None
    """granules in a second; those without room are owed, and come as soon as they have it; none: as many as have room"""
    velocity_x: Drift = 0.0
    """velocity along x of granules that come"""
    velocity_y: Drift = 0.0
    """velocity along y of granules that come"""


class PhaseSection(Section):
    time: Time | None = None
    """duration of the phase; none: required unless until is given"""
    until: Literal["rest"] | None = None
    """rest: the phase lasts until the granules are at rest under gravity; none: required unless time is given"""
    motion: dict[Label, PhaseMotionSection] = Field({})
    """motion of solids from the start of the phase on, by name; others move as before"""

    @model_validator(mode="after")
    def _check(self):
        if (self.time is None) == (self.until is None):
            words = "both are given" if self.time else "neither is given"
            raise ValueError(f"it must have a time or until, and {words}")
        return self
