"""The values of one run, as a configuration file gives them, checked in one place.

SI units throughout. Workflow, command line and library read values only through this module. It
refuses values that cannot be simulated with one sentence per fault, which names key and value.
"""

import hashlib
import json
import math
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, ValidationError, model_validator
from pydantic_core import PydanticKnownError

from dem.base.errors import InputError
from dem.base.outside import is_outside
from dem.base.provenance import compilers
from dem.base.schema import (
    SEEDS,
    Label,
    NotNegative,
    Number,
    Positive,
    Section,
    Whole,
    number,
    sentences,
)
from dem.base.sources import code_hash
from dem.experiment.fit import check_room
from dem.experiment.kinds import EXPERIMENTS, Experiment
from dem.experiment.observables import OBSERVABLES, place_of
from dem.shapes import KINDS, Kind, kind_of

NO_BITS = "reads values, which are part of what a run is known by"

LAYOUT = 1  # of the files of runs: raise it where a variable comes, goes or has another meaning
# sections that only some experiments read, by these
SECTIONS = {
    name: tuple(kind for kind, own in EXPERIMENTS.items() if name in own["SECTIONS"])
    for name in ("cylinder", "record", "shear")
}


def or_file(known: Iterable[str]) -> BeforeValidator:
    """A name of the package, or of a file of a user's own, which is looked up where a file is read."""

    def check(name):
        if name in tuple(known) or is_outside(name):
            return name
        *others, last = map(repr, known)
        raise PydanticKnownError("literal_error", {"expected": f"{', '.join(others)} or {last}"})

    return BeforeValidator(check)


NEEDED = object()


def value(units: str | None, about: str, before=NEEDED, **limits):
    """Description of a value: its units (None: text) and what it is.

    before: of a key that is younger than the first runs, the value at which all is as it was. Runs with
    it are known by the same name as runs from before. It stays what it is when a default changes.
    """
    extra = {"units": units} | ({} if before is NEEDED else {"before": before})
    return Field(description=about, json_schema_extra=extra, **limits)


def known_by(section: BaseModel, without: Iterable[str] = ()) -> dict:
    """Values of a section that a run is known by: all but those that are as before there was the key."""
    found = {}
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        if name not in without and value != (field.json_schema_extra or {}).get("before", NEEDED):
            found[name] = known_by(value) if isinstance(value, BaseModel) else value
    return found


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
    """Each name once, in order, so that the order makes no other run."""
    named = isinstance(names, list | tuple) and all(isinstance(name, str) for name in names)
    return tuple(sorted(set(names))) if named else names


class RecordSection(Section):
    bins: Annotated[Whole, value("1", "bins over the stroke", ge=1, le=100_000)]
    window: Annotated[
        tuple[NotNegative, Positive], value("m", "displacements of the mean drag's window")
    ]
    snapshots: Annotated[Whole, value("1", "snapshots of all granules", ge=2, le=10_000)]
    observables: Annotated[
        tuple[Annotated[str, or_file(OBSERVABLES)], ...],
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


class ShapeSection(Section):
    kind: Annotated[
        str,
        or_file(KINDS),
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


class Configuration(Section):
    """All values that a run can read."""

    experiment: Annotated[
        str, or_file(EXPERIMENTS), value(None, "what is done with the bed, or a file of your own")
    ] = "drag"
    box_width: Annotated[
        Positive,
        value(
            "m", "width of the box; its height follows from packing.fraction or packing.pressure"
        ),
    ]
    periodic: Annotated[
        Literal["none", "x", "y", "xy"],
        value(None, "sides along which the box repeats itself", "none"),
    ] = "none"
    cylinder: Annotated[
        CylinderSection | None, value(None, "the cylinder; null: there is none", None)
    ] = None
    packing: PackingSection
    material: MaterialSection
    friction: FrictionSection
    gravity: Annotated[NotNegative, value("m s-2", "gravity, downwards")] = 0.0
    ellipse: EllipseSection = EllipseSection()
    shapes: Annotated[dict[Label, ShapeSection], Field(min_length=1)]
    beside: Annotated[str | None, value(None, "folder of files of your own; that of this file")] = (
        None
    )
    record: Annotated[RecordSection | None, value(None, "what is recorded", None)] = None
    shear: Annotated[ShearSection | None, value(None, "how the bed is sheared", None)] = None
    numerics: NumericsSection = NumericsSection()

    @model_validator(mode="after")
    def _check_sections(self):
        kind = self.module.says
        for name in SECTIONS if "SECTIONS" in kind else ():
            given, needed = getattr(self, name) is not None, kind["SECTIONS"].get(name)
            if needed and not given:
                raise ValueError(f"{name} is missing; the experiment {self.experiment} needs it")
            if given and needed is None:
                raise ValueError(
                    f"{name} is no section of the experiment {self.experiment}; leave it out"
                )
        for pattern, (wanted, why) in kind.get("ASKS", {}).items():
            for label in self.shapes if "*" in pattern else ("",):
                path = pattern.replace("*", label)
                if (value := self.at(path)) != wanted:
                    shown = value if isinstance(value, str) else f"{value:g}"
                    must = "takes none" if wanted is None else f"needs {wanted}"
                    raise ValueError(
                        f"{path} is {shown}; the experiment {self.experiment} {must}, because {why}"
                    )
        return self

    @model_validator(mode="after")
    def _check_pressure(self):
        if self.packing.pressure is not None:
            asked = f"packing.pressure is {self.packing.pressure:g} Pa"
            if "y" in self.periodic:
                raise ValueError(
                    f"{asked} and periodic {self.periodic}; a pressure needs a top wall, let periodic "
                    "be none or x"
                )
        return self

    @model_validator(mode="after")
    def _check_window(self):
        if self.record is None or self.cylinder is None:
            return self
        if self.record.window[1] > self.cylinder.stroke:
            raise ValueError(
                f"record.window ends at {self.record.window[1]:g} m, beyond cylinder.stroke, "
                f"{self.cylinder.stroke:g} m"
            )
        if not self.in_window.any():
            raise ValueError(
                f"record.window {list(self.record.window)} holds no bin; each is "
                f"{self.cylinder.stroke / self.record.bins:.3g} m wide"
            )
        return self

    @property
    def in_window(self) -> np.ndarray:
        """Which bins (bins,) of a run have their middle in the averaging window."""
        middle = (np.arange(self.record.bins) + 0.5) / self.record.bins * self.cylinder.stroke
        return (middle >= self.record.window[0]) & (middle <= self.record.window[1])

    @property
    def observables(self) -> tuple[str, ...]:
        """What is recorded, as record.observables names it."""
        return self.record.observables if self.record else ()

    @property
    def recorded(self) -> tuple[str, ...]:
        """What runs record: observables, or what an experiment of its own gives."""
        names = self.observables if self.module.observed else (self.experiment,)
        return tuple(name.removesuffix(".py") for name in names)

    def values(self) -> dict:
        """The values of a run as plain groups, without the other keys of a file."""
        found = json.loads(self.model_dump_json(include=set(Configuration.model_fields)))
        return found if self.beside else {key: found[key] for key in found if key != "beside"}

    def kind_of(self, shape: str) -> Kind:
        """The kind of granules of a shape; raises InputError where its file cannot be used."""
        try:
            return kind_of(self.shapes[shape].kind, self.beside)
        except InputError as error:
            raise InputError(f"shapes.{shape}.{error}") from None

    @cached_property
    def _read_by_all(self) -> str:
        """Values that every run reads, for any shape, as text."""
        own = set(type(self).model_fields) - set(Configuration.model_fields)
        found = known_by(self, {"shapes", "beside", "ellipse", "experiment", *own})
        found.get("record", {}).pop("window", None)
        return json.dumps(found, sort_keys=True)

    @cached_property
    def _granules(self) -> dict[str, str]:
        """Sections of the shapes as text, by label, with the aspect ratio that the kind fixes."""
        return {
            label: json.dumps(shape.model_dump() | {"aspect_ratio": shape.ratio})
            for label, shape in self.shapes.items()
        }

    def replicate(self, shape: str, density: float, seed: int) -> "Replicate":
        """One run; raises InputError if it is impossible."""
        if shape not in self.shapes:
            raise InputError(
                f"shape is {shape!r}; the configuration has "
                + ", ".join(self.shapes)
                + f"{nearest(shape.lower(), self.shapes)}."
            )
        if not (math.isfinite(density) and density > 0):
            raise InputError(f"density is {density!r}; it must be a positive number (kg/m3).")
        if seed < 0:
            raise InputError(f"seed is {seed}; it must not be negative.")
        try:
            check_room(self, shape, seed)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        return Replicate(self, shape, density, seed)

    def at(self, path: str):
        """The value at a path; None where there is none."""
        found = self
        for name in path.split("."):
            found = found.get(name) if isinstance(found, dict) else getattr(found, name, None)
        return found

    @property
    def module(self) -> Experiment:
        """The experiment. Its code is loaded on use, so that reading results does not depend on the code
        that made them."""
        return Experiment(self.experiment, self.beside)

    def checked(self):
        """These values; raises InputError where a file of a user's own that they name cannot be used."""
        for label in self.shapes:
            self.kind_of(label)
        self.module.check(self)
        return self

    def code_of(self, *modules: str, shapes: Iterable[str]) -> str:
        """SHA-256 of the code that modules and some shapes depend on."""
        return code_hash(*modules, *sorted({self.kind_of(shape).module for shape in shapes}))

    def changed(self, changes: dict[str, Any], shape: str) -> "Configuration":
        """These values with some changed by path, and one shape only; raises InputError.

        A change to another shape has no effect.
        """
        if not changes and set(self.shapes) == {shape} and type(self) is Configuration:
            return self
        data = self.values()
        data["shapes"] = {shape: data["shapes"][shape]}
        for path, new in changes.items():
            *groups, last = path.split(".")
            at = data
            for name in groups:
                if (at := at.get(name, {})) is None:
                    raise InputError(
                        f"{path} cannot vary; the experiment {self.experiment} has no {name}."
                    )
            if last in at:
                at[last] = new
        source = f"{shape} with {words_of(changes)}" if changes else shape
        return parse(data, source).checked()


def words_of(changes: dict) -> str:
    """Changed values in words: friction.granule 0.3, box_width 0.02."""
    return ", ".join(f"{path} {new}" for path, new in changes.items())


class Replicate:
    """One run: values of a configuration, a shape of it, a density (kg/m3) and a seed."""

    def __init__(self, configuration: Configuration, label: str, density: float, seed: int):
        self.configuration, self.label = configuration, label
        self.density, self.seed = float(density), int(seed)

    @property
    def shape(self) -> ShapeSection:
        return self.configuration.shapes[self.label]

    @property
    def kind(self) -> Kind:
        """The kind of its granules; raises InputError where its file cannot be used."""
        return self.configuration.kind_of(self.label)

    def values(self, beside: bool = True) -> dict:
        """All values as plain groups, in the form that `of_values` takes; beside: with the folder of
        shapes of a user's own, which is no part of what the run is."""
        own = self.configuration.values()
        if not beside:
            own.pop("beside", None)
        own["shapes"] = {self.label: own["shapes"][self.label]}
        return own | {"shape": self.label, "density": self.density, "seed": self.seed}

    def with_shapes(self, folder: Path | str | None) -> "Replicate":
        """The same run, where the files of shapes of a user's own are in a folder."""
        if folder is None:
            return self
        own = self.configuration.model_copy(update={"beside": str(Path(folder).resolve())})
        return Replicate(own, self.label, self.density, self.seed)

    def labels(self) -> dict:
        """What tells this run from others."""
        return {
            "shape": np.array(self.label),
            "kind": np.array(self.shape.kind),
            "aspect_ratio": float(self.shape.ratio),
            "density": self.density,
            "diameter": self.shape.diameter,
            "granules": np.int64(self.shape.granules),
            "seed": np.int64(self.seed),
        }

    def at(self, path: str):
        """The value at a path, or the shape, density or seed."""
        own = {"shape": self.label, "density": self.density, "seed": self.seed}
        return own[path] if path in own else self.configuration.at(path)

    def words(self) -> str:
        """The run in words, for sentences."""
        return f"{self.label} at {density_label(self.density)} kg/m3, seed {self.seed}"

    def _bed(self) -> str:
        c = self.configuration
        around = (c.cylinder.diameter, c.cylinder.start) if c.cylinder else ()
        others = c.packing.size_spread, c.box_width, *around
        sides = "" if c.periodic == "none" else f" {c.periodic}"
        made = "" if c.packing.preparation == "relaxed" else f" {c.packing.preparation}"
        return f"{c._granules[self.label]} {others}{sides}{made}"

    @property
    def variant(self) -> str:
        """The values that select the machine code of the run, as text: of each motion that it computes,
        its own and those of its bed."""
        c = self.configuration
        motions = c.module.motions(self)
        if c.packing.friction > 0:
            motions.add(PRESSED)
        if c.packing.preparation == "grown":
            motions.add((False, *PRESSED[1:]))
        return f"{self.shape.kind} {c.periodic} {sorted(motions)}"

    @property
    def bed_family(self) -> str:
        """Hash of all that the bed depends on, except packing fraction or pressure, friction and
        seed."""
        return _digest(self._bed())

    def bed_key(self) -> str:
        """All that the bed depends on, as text."""
        packing, material = self.configuration.packing, self.configuration.material
        if packing.pressure is None:
            return f"{self._bed()} {packing.fraction} {packing.friction} {self.seed}"
        load = packing.pressure, material.young_modulus, material.poisson_ratio, material.thickness
        return f"{self._bed()} {load} {self.seed}"

    def run_key(self) -> str:
        """All that the run depends on, as text."""
        c = self.configuration
        if c.module.says.get("BED_ALONE"):
            return f"{c.experiment} {self.bed_key()}"
        ellipse = c.ellipse if self.shape.kind == "ellipse" else ""
        own = c._granules[self.label], c._read_by_all, ellipse, self.density, self.seed
        return " ".join(map(str, own))

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules that make the run: experiment, observables and shape."""
        c = self.configuration
        observables = c.observables if c.module.observed else ()
        return c.module.place, *(place_of(name, c.beside) for name in observables), self.kind.module

    @property
    def source_hash(self) -> str:
        """SHA-256 of the code that decides the bits of this run, and of what compiles it."""
        return _digest(code_hash(*self.modules, bits=True), compilers())

    @cached_property
    def id(self) -> str:
        """Identity of the run: hash of the values that it reads and the code that it runs."""
        return _digest(self.run_key(), self.source_hash, str(LAYOUT))

    @property
    def bed_id(self) -> str:
        """Identity of the bed of the run."""
        return _digest(
            self.bed_key(), compilers(),
            code_hash("dem.experiment.bed", self.kind.module, bits=True),
        )  # fmt: skip


# machine code of a bed that is pressed with friction, as kinds of experiment describe theirs
PRESSED = (True, True, False, False, False, str(EllipseSection()))


def _digest(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:32]


def of_values(data: dict, source: str = "values") -> Replicate:
    """One run from plain groups of values with `shape`, `density` and `seed`; raises InputError."""
    own = dict(data)
    try:
        shape, density, seed = (own.pop(name) for name in ("shape", "density", "seed"))
    except KeyError as error:
        raise InputError(f"{source}: {error.args[0]} is missing.") from None
    if not isinstance(shape, str):
        raise InputError(f"{source}: shape is {shape!r}; it must be the label of a shape.")
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < SEEDS:
        raise InputError(f"{source}: seed is {seed!r}; it must be a whole number below {SEEDS}.")
    try:
        density = float(number(density))
    except ValueError as error:
        raise InputError(f"{source}: density is {density!r}; {error}.") from None
    return parse(own, source).replicate(shape, density, seed)


def density_label(density: float) -> str:
    """A density (kg/m3) as text for sentences."""
    return f"{density:.10g}"


def parse(data, source: str = "configuration", model: type[Configuration] = Configuration):
    """Values from the content of a file; raises InputError with one sentence per fault."""
    if not isinstance(data, dict):
        raise InputError(f"{source}: it must hold keys with values, see config/paper.yaml.")
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return model.model_validate(data)
    except ValidationError as error:
        raise InputError(sentences(source, error)) from None


class Entry(NamedTuple):
    """A value that may vary: its path, units (None: a text) and what it is."""

    path: str
    units: str | None
    about: str


def entries(shapes: Iterable[str]) -> dict[str, Entry]:
    """All values of a configuration that may vary, by path; shapes: labels of the configuration."""
    found = {}

    def visit(model, head):
        for name, field in model.model_fields.items():
            path = head + name
            if path == "shapes":
                for label in shapes:
                    visit(ShapeSection, f"shapes.{label}.")
            elif section := section_of(field.annotation):
                visit(section, path + ".")
            elif path not in ("record.window", "record.observables", "beside"):
                units = (field.json_schema_extra or {}).get("units")
                found[path] = Entry(path, units, field.description)

    visit(Configuration, "")
    return found


def section_of(annotation) -> type[BaseModel] | None:
    """The section that a field holds, or may hold."""
    if get_origin(annotation) is dict:  # of sections by name
        return None
    choices = get_args(annotation) or (annotation,)
    return next((c for c in choices if isinstance(c, type) and issubclass(c, BaseModel)), None)


def nearest(word: str, words: Iterable[str]) -> str:
    """A hint at the word that was probably meant: "; the nearest is ...", or ""."""
    close = get_close_matches(str(word), list(words), 1, 0.6)
    return f"; the nearest is {close[0]}" if close else ""
