"""The sections of a configuration: what each value is, its units, limits and default."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator

from dem.base.hints import meant
from dem.base.schema import NotNegative, Number, Positive, Section, Whole, value
from dem.experiment.observables import OBSERVABLES
from dem.shapes import KINDS
from dem.shapes.outside import is_outside

NO_BITS = "describes values, which are part of what a run is known by"


class CylinderSection(Section):
    diameter: Annotated[Positive, value("m", "diameter of the cylinder")]
    velocity: Annotated[Positive, value("m s-1", "velocity of the cylinder, upwards")]
    start: Annotated[
        Positive, value("1", "height of the cylinder's axis over the height of the box", lt=1)
    ]
    stroke: Annotated[Positive, value("m", "distance over which the cylinder is drawn")]


class PackingSection(Section):
    fraction: Annotated[
        Positive | None, value("1", "packing fraction; none: packing.pressure is given", lt=1)
    ] = None
    size_spread: Annotated[
        Number, value("1", "diameters are uniform within +- this share", ge=0, lt=1)
    ]
    friction: Annotated[
        NotNegative, value("1", "friction of all contacts while the bed is packed")
    ] = 0.0
    pressure: Annotated[
        Positive | None,
        value(
            "Pa", "pressure on the top wall, which holds it; none: packing.fraction is given", None
        ),
    ] = None
    preparation: Annotated[
        Literal["relaxed", "grown"],
        value(None, "how granules grow: energy minimised, or in motion", "relaxed"),
    ] = "relaxed"

    @model_validator(mode="after")
    def _check(self):
        if self.fraction is None and self.pressure is None:
            raise ValueError("fraction is missing; give it, or a pressure in its place")
        if self.fraction is not None and self.pressure is not None:
            raise ValueError(
                f"fraction is {self.fraction:g} and pressure {self.pressure:g} Pa; one follows from "
                "the other, make one of them null"
            )
        if self.pressure is not None and self.friction > 0.0:
            raise ValueError(
                f"friction is {self.friction:g}; a bed that is packed under a pressure is packed "
                "without friction, make it 0"
            )
        if self.pressure is not None and self.preparation != "relaxed":
            raise ValueError(
                f"preparation is {self.preparation}; a bed that is packed under a pressure is relaxed, "
                "leave it out"
            )
        return self


class MaterialSection(Section):
    young_modulus: Annotated[Positive, value("Pa", "Young's modulus")]
    poisson_ratio: Annotated[Number, value("1", "Poisson's ratio", gt=-1, le=0.5)]
    restitution: Annotated[Number, value("1", "coefficient of restitution", ge=1e-3, le=1)]
    thickness: Annotated[
        Positive | None, value("m", "thickness out of the plane; none: mean diameter")
    ] = None


class FrictionSection(Section):
    granule: Annotated[NotNegative, value("1", "friction between granules")]
    wall: Annotated[NotNegative, value("1", "friction at the walls")]
    cylinder: Annotated[NotNegative, value("1", "friction at the cylinder")]
    stiffness: Annotated[Positive, value("1", "stiffness of tangential springs over Mindlin's")] = (
        1.0
    )


class ShearSection(Section):
    inertial_number: Annotated[
        Positive,
        value("1", "inertial number: rate of shear times sqrt(mass / (pressure thickness))"),
    ]
    pressure: Annotated[Positive, value("Pa", "pressure on the lid")]
    settle: Annotated[NotNegative, value("1", "least strain before anything is measured")]
    strain: Annotated[Positive, value("1", "strain while it is measured")]
    samples: Annotated[Whole, value("1", "samples over this strain", ge=2, le=100_000)]


class EllipseSection(Section):
    contact: Annotated[
        Literal["common_normal", "geometric_potential"],
        value(None, "how a contact of ellipses is found"),
    ] = "common_normal"
    curvature: Annotated[
        Literal["volume", "local"], value(None, "radius of ellipses in Hertz's law")
    ] = "volume"


def _observables(names):
    """Each name once, in the order of the registry, so that the order makes no other run."""
    if isinstance(names, list | tuple) and all(name in OBSERVABLES for name in names):
        return tuple(name for name in OBSERVABLES if name in names)
    return names


class RecordSection(Section):
    bins: Annotated[Whole, value("1", "bins over the stroke", ge=1, le=100_000)]
    window: Annotated[
        tuple[NotNegative, Positive], value("m", "displacements of the mean drag's window")
    ]
    snapshots: Annotated[Whole, value("1", "snapshots of all granules", ge=2, le=10_000)]
    observables: Annotated[
        tuple[Literal[tuple(OBSERVABLES)], ...],
        BeforeValidator(_observables),
        value(None, "what is recorded", min_length=1),
    ] = ("drag", "snapshots")

    @model_validator(mode="after")
    def _check(self):
        if not self.window[0] < self.window[1]:
            raise ValueError(f"window {list(self.window)} must run from less to more")
        if self.bins % (self.snapshots - 1):
            raise ValueError(
                f"bins ({self.bins}) must be a multiple of snapshots - 1 ({self.snapshots - 1}), "
                "so that every snapshot falls on the end of a bin"
            )
        return self


class NumericsSection(Section):
    step_fraction: Annotated[Positive, value("1", "time step over the critical one", le=10)] = 0.5
    allow_unstable: Annotated[
        bool, value("1", "whether steps beyond the critical one are taken")
    ] = False
    time_step: Annotated[
        Positive | None, value("s", "time step; none: from the bed's stiffness")
    ] = None
    max_overlap: Annotated[
        Positive, value("1", "overlap over the smaller radius that stops", le=1.5)
    ] = 1.2

    @model_validator(mode="after")
    def _check(self):
        if self.step_fraction >= 1.0 and not self.allow_unstable:
            raise ValueError(
                f"step_fraction is {self.step_fraction:g}; it must be less than 1, or "
                "allow_unstable be true"
            )
        return self


def _kind(name):
    """A kind of the package, or the class of a file, which is looked up where a file is read."""
    if name not in tuple(KINDS) and not is_outside(name):
        *others, last = map(repr, KINDS)
        raise ValueError(f"it must be {', '.join(others)} or {last}{meant(name, KINDS)}")
    return name


class ShapeSection(Section):
    kind: Annotated[
        str,
        BeforeValidator(_kind),
        value(None, "kind of granule, or file and class of your own, such as stones.Stone"),
    ]
    diameter: Annotated[Positive, value("m", "mean volume diameter of the granules")]
    granules: Annotated[Whole, value("1", "number of granules", ge=1, le=10_000_000)]
    aspect_ratio: Annotated[Number | None, value("1", "length over width of a granule", ge=1)] = (
        None
    )

    @model_validator(mode="after")
    def _check(self):
        natural = KINDS[self.kind].aspect_ratio if self.kind in KINDS else None
        if natural is None and self.aspect_ratio is None:
            raise ValueError(f"aspect_ratio is missing; kind {self.kind} needs one")
        if natural and self.aspect_ratio not in (None, natural):
            raise ValueError(
                f"aspect_ratio is {self.aspect_ratio:g}; a {self.kind} always has {natural:g}, "
                "leave it out"
            )
        return self

    @property
    def ratio(self) -> float:
        """Length over width."""
        return self.aspect_ratio or KINDS[self.kind].aspect_ratio
