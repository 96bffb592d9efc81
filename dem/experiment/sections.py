"""The sections of a configuration: what each value is, its units, limits and default."""

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import BeforeValidator, model_validator

from dem.base.plugins import is_plugin
from dem.base.schema import NotNegative, Number, Positive, Section, Seed, Whole, value
from dem.experiment.observables import OBSERVABLES
from dem.shapes import KINDS


def or_file(known: Iterable[str]) -> BeforeValidator:
    """A name of the package, or of a file of a user's own, which is looked up where a file is read."""

    def check(name):
        if name in tuple(known) or is_plugin(name):
            return name
        *others, last = map(repr, known)
        raise ValueError(f"it must be {', '.join(others)} or {last}")

    return BeforeValidator(check)


class CylinderSection(Section):
    diameter: Positive = value("m", "diameter of the cylinder")
    velocity: Positive = value("m s-1", "velocity of the cylinder, upwards")
    start: Positive = value("1", "height of the cylinder's axis over the height of the box", lt=1)
    stroke: Positive = value("m", "distance over which the cylinder is drawn")


class PackingSection(Section):
    fraction: Positive | None = value(
        "1", "packing fraction; none: packing.pressure is given", None, lt=1
    )
    size_spread: NotNegative = value("1", "diameters are uniform within +- this share", lt=1)
    friction: NotNegative = value("1", "friction of all contacts while the bed is packed", 0.0)
    pressure: Positive | None = value(
        "Pa",
        "pressure on the top wall, which holds it; none: packing.fraction is given",
        None,
        None,
    )
    preparation: Literal["relaxed", "grown"] = value(
        None, "how granules grow: energy minimised, or in motion", "relaxed", "relaxed"
    )

    @model_validator(mode="after")
    def _check(self):
        if self.fraction is None and self.pressure is None:
            raise ValueError("fraction is missing; give it, or a pressure in its place")
        if self.fraction is not None and self.pressure is not None:
            raise ValueError(
                f"fraction is {self.fraction:g} and pressure {self.pressure:g} Pa; one follows from "
                "the other, make one of them null"
            )
        if self.pressure is not None and (self.friction or self.preparation != "relaxed"):
            raise ValueError(
                f"friction is {self.friction:g} and preparation {self.preparation}; a bed that is packed "
                "under a pressure is relaxed without friction, leave both out"
            )
        return self


class MaterialSection(Section):
    young_modulus: Positive = value("Pa", "Young's modulus")
    poisson_ratio: Number = value("1", "Poisson's ratio", gt=-1, le=0.5)
    restitution: Number = value("1", "coefficient of restitution", ge=1e-3, le=1)
    thickness: Positive | None = value("m", "thickness out of the plane; none: mean diameter", None)


class FrictionSection(Section):
    granule: NotNegative = value("1", "friction between granules")
    wall: NotNegative = value("1", "friction at the walls")
    cylinder: NotNegative = value("1", "friction at the cylinder")
    stiffness: Positive = value("1", "stiffness of tangential springs over Mindlin's", 1.0)


class ShearSection(Section):
    inertial_number: Positive = value(
        "1", "inertial number: rate of shear times sqrt(mass / (pressure thickness))"
    )
    pressure: Positive = value("Pa", "pressure on the lid")
    settle: NotNegative = value("1", "least strain before anything is measured")
    strain: Positive = value("1", "strain while it is measured")
    samples: Whole = value("1", "samples over this strain", ge=2, le=100_000)


class EllipseSection(Section):
    contact: Literal["common_normal", "geometric_potential"] = value(
        None, "how a contact of ellipses is found", "common_normal"
    )
    curvature: Literal["volume", "local"] = value(
        None, "radius of ellipses in Hertz's law", "volume"
    )


def _observables(names):
    """Each name once, in order, so that the order makes no other run."""
    named = isinstance(names, list | tuple) and all(isinstance(name, str) for name in names)
    return tuple(sorted(set(names))) if named else names


class RecordSection(Section):
    bins: Whole = value("1", "bins over the stroke", ge=1, le=100_000)
    window: tuple[NotNegative, Positive] = value("m", "displacements of the mean drag's window")
    snapshots: Whole = value("1", "snapshots of all granules", ge=2, le=10_000)
    observables: Annotated[
        tuple[Annotated[str, or_file(OBSERVABLES)], ...], BeforeValidator(_observables)
    ] = value(None, "what is recorded", ("drag", "snapshots"), min_length=1)

    @model_validator(mode="after")
    def _check(self):
        if not self.window[0] < self.window[1]:
            raise ValueError(f"window {list(self.window)} must run from less to more")
        return self


class NumericsSection(Section):
    step_fraction: Positive = value("1", "time step over the critical one", 0.3, le=10)
    allow_unstable: bool = value("1", "whether steps beyond the critical one are taken", False)
    time_step: Positive | None = value("s", "time step; none: from the bed's stiffness", None)
    max_overlap: Positive = value("1", "overlap over the smaller radius that stops", 1.2, le=1.5)

    @model_validator(mode="after")
    def _check(self):
        if self.step_fraction >= 1.0 and not self.allow_unstable:
            raise ValueError(
                f"step_fraction is {self.step_fraction:g}; it must be less than 1, or "
                "allow_unstable be true"
            )
        return self


class ShapeSection(Section):
    kind: Annotated[str, or_file(KINDS)] = value(
        None, "kind of granule, or file and class of your own, such as stones.Stone"
    )
    diameter: Positive = value("m", "mean volume diameter of the granules")
    granules: Whole = value("1", "number of granules", ge=1, le=10_000_000)
    aspect_ratio: Number | None = value("1", "length over width of a granule", None, ge=1)

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


class OwnSection(Section):
    """What a run has beside the values of its configuration."""

    shape: str = value(None, "label of the shape of its granules")
    density: Positive = value("kg m-3", "density of its granules")
    seed: Seed = value("1", "seed of its random bed")
