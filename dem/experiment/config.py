"""The values of one run, as a configuration file gives them, checked in one place.

SI units throughout. Workflow, command line and library read values only through this module. It
refuses values that cannot be simulated with one sentence per fault, which names key and value.
"""

import re
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, create_model, model_validator
from pydantic.fields import FieldInfo

from dem.base.errors import InputError
from dem.base.messages import check_known
from dem.base.plugins import is_plugin
from dem.base.refusals import parsed
from dem.base.types import (
    Count,
    Density,
    Label,
    Length,
    NotNegative,
    Section,
    Seed,
    Time,
    Unit,
    checked,
)
from dem.experiment.box import check_room
from dem.experiment.cylinder import as_scene
from dem.experiment.entries import UNHASHED_KEYS, Entry, entries
from dem.experiment.kinds import EXPERIMENTS, Experiment
from dem.experiment.replicate import Replicate
from dem.experiment.scene_sections import (
    BasePlateSection,
    CylinderSection,
    PhaseSection,
    SecondSection,
    SinkSection,
    SolidSection,
    SourceSection,
    WallsSection,
)
from dem.experiment.sections import (
    CELLS,
    SORTED,
    ContactSection,
    EllipseSection,
    FrictionSection,
    MaterialSection,
    NumericsSection,
    PackingSection,
    RecordSection,
    RollingSection,
    RunSection,
    ShapeSection,
    ShearSection,
    or_file,
)
from dem.io.dataset import WALLS
from dem.laws import file_of as law_file
from dem.periodic import Sides, periods_of, walled
from dem.shapes import Kind, kind_of

# sections that only some experiments read
SECTIONS = dict.fromkeys(name for header in EXPERIMENTS.values() for name in header["SECTIONS"])
# of the section record, which only some experiments read, and what they have without it
RECORD_KEYS = {"window": None, "cells": CELLS, "region": None}
# what runs have without these keys: said or not, they are one run
USUAL = {
    "contact.law": ContactSection().name,
    "cylinder.outline": "circle",
    "cylinder.angle": 0.0,
    "record.cells": CELLS,
}


class Configuration(Section):
    """All values that a run can read, by `read`; a sweep file has more."""

    read: ClassVar[dict[str, FieldInfo]]
    experiment: Annotated[str, or_file(EXPERIMENTS), Field(examples=[*EXPERIMENTS])] = "drag"
    """kind of experiment, or a file of your own, such as mine.py"""
    box_width: Length
    """width of the box; its height follows from packing.fraction or packing.pressure"""
    periodic: Sides = "none"
    """sides along which the box repeats itself"""
    cylinder: CylinderSection | None = None
    """cylinder that is drawn through the bed"""
    second: SecondSection | None = None
    """a second cylinder beside the first; both are centred in the box"""
    solids: Annotated[dict[Label, SolidSection], SORTED] = Field({})
    """solids of a scene, by name"""
    packing: PackingSection
    """packing of the bed"""
    material: MaterialSection
    """material of granules"""
    friction: FrictionSection
    """friction at contacts"""
    rolling: RollingSection | None = None
    """rolling resistance of discs, once they are packed"""
    base_plate: BasePlateSection | None = None
    """plate on which the bed lies flat"""
    contact: ContactSection = ContactSection()
    """law of contacts"""
    walls: WallsSection | None = None
    """friction and material of single walls; none: friction.wall, rigid"""
    gravity: Annotated[NotNegative, Unit("m s-2")] = 0.0
    """gravity, downwards"""
    ellipse: EllipseSection = EllipseSection()
    """contacts of ellipses"""
    shapes: dict[Label, ShapeSection] = Field(min_length=1)
    """shapes of granules, by label"""
    threads: Annotated[Count, Field(ge=1, le=64)] = 1
    """threads of a run, for beds of tens of thousands of granules"""
    beside: str | None = None
    """folder of files of your own; none: the folder of this file"""
    record: RecordSection | None = None
    """what is recorded"""
    phases: dict[Label, PhaseSection] = Field({})
    """what happens in a scene, one after the other; the last is recorded"""
    sinks: Annotated[dict[Label, SinkSection], SORTED] = Field({})
    """where granules leave a scene, by name"""
    sources: Annotated[dict[Label, SourceSection], SORTED] = Field({})
    """where granules come into a scene, by name"""
    exchange_interval: Time | None = None
    """time between two moments at which sinks and sources act; none: sqrt(diameter / gravity) / 4"""
    shear: ShearSection | None = None
    """how the bed is sheared"""
    numerics: NumericsSection = NumericsSection()
    """time step, and the overlap that ends a run"""

    @model_validator(mode="after")
    def _check_sections(self):
        header = self.module.constants
        for name in SECTIONS if "SECTIONS" in header else ():
            given, needed = getattr(self, name) not in (None, {}), header["SECTIONS"].get(name)
            if needed and not given:
                raise ValueError(f"{name} is missing; the experiment {self.experiment} needs it")
            if given and needed is None:
                raise ValueError(
                    f"{name} is no section of the experiment {self.experiment}; leave it out"
                )
        for name in RECORD_KEYS.keys() - header.get("RECORD", RECORD_KEYS) if self.record else ():
            if getattr(self.record, name) != RECORD_KEYS[name]:
                raise ValueError(
                    f"record.{name} is given; the experiment {self.experiment} has none, leave it out"
                )
        for pattern, (wanted, why) in header.get("ASKS", {}).items():
            plain = (label for label, shape in self.shapes.items() if not shape.mixture)
            for path in {pattern.replace("*", label) for label in plain}:
                if (value := self.at(path)) != wanted:
                    must = "takes none" if wanted is None else f"needs {wanted}"
                    words = value if isinstance(value, str) else f"{value:g}"
                    raise ValueError(
                        f"{path} is {words}; the experiment {self.experiment} {must}, because {why}"
                    )
        return self

    @model_validator(mode="after")
    def _check_mixtures(self):
        for label in self.shapes:
            path = f"shapes.{label}.mixture"
            for name in self.shapes[label].mixture or ():
                check_known(f"{path} has", name, self.shapes, "shapes")
                if self.shapes[name].mixture:
                    raise ValueError(
                        f"{path} has {name}, a mixture itself; name its shapes instead"
                    )
            kinds = {part.kind for part in self.parts_of(label)}
            if len(kinds) > 1:
                words = " and ".join(sorted(kinds))
                raise ValueError(f"{path} has the kinds {words}; its shapes must be of one kind")
        return self

    @model_validator(mode="after")
    def _check_together(self):
        record, pressure, preparation = self.record, self.packing.pressure, self.packing.preparation
        settled, plate = preparation == "settled", self.base_plate is not None
        bed_alone = self.module.constants.get("BED_ALONE")
        if self.second is not None and self.cylinder is None:
            other = "name it among solids" if self.phases else "give cylinder too"
            raise ValueError(f"second is a cylinder beside another; {other}")
        if pressure is not None and "y" in self.periodic:
            raise ValueError(
                f"packing.pressure is {pressure:g} Pa and periodic {self.periodic}; a pressure "
                "needs a top wall, let periodic be none or x"
            )
        if plate and self.gravity:
            raise ValueError(
                f"gravity is {self.gravity:g}, in the plane of the bed, and base_plate is given; a bed "
                "lies on a plate by base_plate.gravity: make gravity 0, and tilt the plate by "
                "base_plate.slope"
            )
        motions = [*self.scene.solids.values()]
        motions += [m for phase in self.phases.values() for m in phase.motion.values()]
        rubs = self.base_plate and self.base_plate.solid and self.experiment in EXPERIMENTS
        if rubs and not any(motion.driven for motion in motions):
            raise ValueError(
                f"base_plate.solid is {self.base_plate.solid:g} and no force moves a solid, so that it "
                "has no effect; leave it out, or give a force, a spring, a torque or spin: free"
            )
        if settled and plate:
            raise ValueError(
                "packing.preparation is settled and base_plate is given; granules that lie on a plate "
                "settle on no floor, let it be relaxed or grown"
            )
        if settled and (not self.gravity or "y" in self.periodic):
            raise ValueError(
                f"packing.preparation is settled, gravity {self.gravity:g} and periodic "
                f"{self.periodic}; granules settle on a floor, give gravity, and let periodic be none "
                "or x"
            )
        if settled and bed_alone:
            raise ValueError(
                f"packing.preparation is settled; the experiment {self.experiment} compresses its bed, "
                "let it be relaxed or grown"
            )
        if bed_alone and self.contact.law == "cohesive":
            raise ValueError(
                f"contact.law is cohesive; the experiment {self.experiment} compresses its bed, and "
                "beds are packed without attraction: let law be hertz"
            )
        if record is not None and self.module.observed and record.bins % (record.snapshots - 1):
            raise ValueError(
                f"record.bins is {record.bins}; it must be a multiple of record.snapshots - 1, "
                f"which is {record.snapshots - 1}, so that every snapshot falls on the end of a bin"
            )
        if preparation in ("lattice", "file") and not self.phases:
            raise ValueError(
                f"packing.preparation is {preparation}; such granules have still to fall, in a phase of "
                "a scene, let it be relaxed, grown or settled"
            )
        self.module.answer("check", self)
        return self

    @property
    def duration(self) -> float | None:
        """How long the last phase lasts (s)."""
        return next((phase.time for phase in reversed(self.phases.values())), None)

    @cached_property
    def scene(self) -> "Configuration":
        """The same with solids and phases in place of a cylinder."""
        if self.cylinder is None:
            return self
        return self.model_construct(**dict(self) | as_scene(self))

    @property
    def solid_names(self) -> list[str]:
        """Names of the solids that are in the bed."""
        return [*self.scene.solids]

    def names_in(self, sentence: str) -> str:
        """A sentence with the names of walls and solids in place of their numbers."""
        section, named = "solids." if self.solids else "", {}
        for k, name in enumerate(self.solid_names):
            named |= dict.fromkeys((f"solid {k}", f"solids[{k}]"), section + name)
        walls = np.array(WALLS)[walled(periods_of(1.0, 1.0, self.periodic))]
        named |= {f"wall {k}": f"the {name} wall" for k, name in enumerate(walls)}
        return re.sub(
            r"\b((wall|solid) \d+|solids\[\d+\])", lambda of: named.get(of[0], of[0]), sentence
        )

    @property
    def solid_count(self) -> int:
        """Number of these."""
        return len(self.solid_names)

    @property
    def sink_count(self) -> int | None:
        """Number of sinks; None where there is none."""
        return len(self.sinks) or None

    @property
    def source_count(self) -> int | None:
        """Number of sources; None where there is none."""
        return len(self.sources) or None

    @property
    def observables(self) -> tuple[str, ...]:
        """What is recorded, as record.observables names it."""
        if self.record is None:
            return ()
        return self.record.observables or self.module.constants.get("OBSERVED", ())

    @property
    def recorded(self) -> tuple[str, ...]:
        """What runs record: observables, or what an experiment of its own gives."""
        module = self.module
        return tuple(file.stem for file in module.files[module.observed :])

    def values(self) -> dict:
        """The values of a run as plain groups, but for those that are null."""
        return self.model_dump(mode="json", include=set(self.read), exclude_none=True)

    def parts_of(self, label: str) -> list[ShapeSection]:
        """The shapes of a mixture; of another shape, itself."""
        return [self.shapes[name] for name in self.shapes[label].mixture or (label,)]

    def with_parts(self, label: str, shapes: dict) -> dict:
        """What shapes have of one of them, and of the shapes of a mixture."""
        return {name: shapes[name] for name in (label, *(self.shapes[label].mixture or ()))}

    def shape_of(self, label: str) -> ShapeSection:
        """A shape; a mixture with the kind of its shapes, and the means of their sizes."""
        shape = self.shapes[label]
        if not shape.mixture:
            return shape
        parts, shares = self.parts_of(label), [*shape.mixture.values()]
        diameter, ratio = np.dot(shares, [[part.diameter, part.ratio] for part in parts]).tolist()
        means = {"kind": parts[0].kind, "diameter": diameter, "aspect_ratio": ratio}
        return shape.model_copy(update=means)

    def kind_of(self, shape: str) -> Kind:
        """The kind of granules of a shape; raises InputError where its file cannot be used."""
        try:
            return kind_of(self.shape_of(shape).kind, self.beside)
        except InputError as error:
            raise InputError(f"shapes.{shape}.{error}") from None

    @cached_property
    def known(self) -> dict[str, dict[str, Any]]:
        """The values that a run of each shape is known by, by path, but for density and seed."""
        values = self.values()
        shapes, ellipse, known = values.pop("shapes"), values.pop("ellipse"), {}
        paths = {
            path: value
            for path, value in by_path(values).items()
            if path not in UNHASHED_KEYS and value != USUAL.get(path)
        } | {"record.observables": self.observables}
        if self.packing.file is not None:
            paths["packing.file"] = self.packing.file.id
        if self.phases:
            paths["phases"] = [*self.phases]  # their order
        for label, shape in self.shapes.items():
            if shape.mixture:
                parts = {name: shapes[name] | {"granules": s} for name, s in shape.mixture.items()}
                section = {"granules": shape.granules, "mixture": parts}
            else:
                section = shapes[label] | {"aspect_ratio": shape.ratio}
            groups = {"shape": section}
            if self.shape_of(label).kind == "ellipse":
                groups["ellipse"] = ellipse
            known[label] = paths | by_path(groups)
        return known

    @cached_property
    def files(self) -> dict[str, tuple[Path, ...]]:
        """The files of the experiment, of observables, of each shape and of the law, by shape."""
        files, law = self.module.files, law_file(self.contact.name, self.beside)
        return {label: (*files, self.kind_of(label).file, law) for label in self.shapes}

    @cached_property
    def bed_descriptions(self) -> dict:
        """Of the beds that were asked for, by shape and density (kg/m3): all seeds share one."""
        return {}

    @cached_property
    def fitting_shapes(self) -> set[str]:
        """The shapes that are known to fit into the box for every seed."""
        return set()

    @checked
    def replicate(self, shape: str, density: Density, seed: Seed) -> Replicate:
        """One run; raises InputError if it is impossible."""
        check_known("shape is", shape, self.shapes, "shapes")
        if self.shapes[shape].granules is None:
            raise InputError(
                f"shapes.{shape}.granules is missing; only a part of mixtures needs none."
            )
        replicate = Replicate(self, shape, density, seed)
        check_room(replicate)
        return replicate

    def at(self, path: str):
        """The value at a path; None where there is none."""
        value = self
        for name in path.split("."):
            value = value.get(name) if isinstance(value, dict) else getattr(value, name, None)
        return value

    @cached_property
    def entries(self) -> dict[str, Entry]:
        """The values that may vary, by path."""
        return entries(self.read, self)

    @property
    def module(self) -> Experiment:
        """The experiment. Its code is loaded on use, so that reading results does not depend on the
        code that made them."""
        return Experiment(self.experiment, self.beside, self)

    def check_files(self) -> None:
        """Raise InputError where the values name a file that cannot be used."""
        _ = self.files  # looked up
        self.module.check()

    def changed(self, changes: dict[str, Any], shape: str) -> "Configuration":
        """These values with some changed by path, and one shape only; raises InputError.

        A change to another shape has no effect.
        """
        # sections that no change is in stay as they are: they were judged before
        data = {name: getattr(self, name) for name in self.read}
        data["shapes"] = self.with_parts(shape, data["shapes"])
        if (own := self.module.label) in data and own not in Configuration.read:
            data[own] = dict(data[own])
        for path, value in changes.items():
            *groups, last = path.split(".")
            section = data
            for name in groups:
                if (inner := section.get(name, {})) is None:
                    words = f"there is no {name}, give that first"
                    if section is data and name in SECTIONS:
                        words = f"the experiment {self.experiment} has no {name}"
                    raise InputError(f"{path} cannot vary; {words}.")
                if name in section:
                    section[name] = dict(inner)
                section = section.get(name, {})
            section[last] = value
        words = ", ".join(f"{path} {value}" for path, value in changes.items())
        configuration = parse(data, f"{shape} with {words}" if changes else shape)
        configuration.check_files()
        return configuration


Configuration.read = dict(Configuration.model_fields)


def by_path(values: dict, head: str = "") -> dict[str, Any]:
    """Values of groups by path, such as friction.granule."""
    paths = {}
    for name, value in values.items():
        path = head + name
        paths |= by_path(value, f"{path}.") if isinstance(value, dict) else {path: value}
    return paths


def of_values(data: dict, source: str = "values") -> Replicate:
    """One run from plain groups of values with `shape`, `density` and `seed`; raises InputError."""
    rest = dict(data)
    coordinates = {key: rest.pop(key) for key in RunSection.model_fields if key in rest}
    run = parsed(RunSection, coordinates, source=source)
    return parse(rest, source).replicate(**dict(run))


def of_results(values: dict, source: str = "values", folder: Path | str | None = None) -> Replicate:
    """The same from a file of results: of the files of users that it names, those in a folder that
    the reader names may run, and no other."""
    return of_values(values | {"beside": folder and str(Path(folder).resolve())}, source)


def parse(data, source: str = "configuration") -> Configuration:
    """Values from the content of a file; raises InputError with one sentence per fault."""
    return parsed(model_of(Configuration, data), data, source=source)


_models = {}  # by what they are made of, because that takes longer than to use them


def model_of(base: type[Configuration], data) -> type[Configuration]:
    """The model that takes data: with a section for the VALUES of their experiment, named after it.

    Raises InputError where the file of the experiment cannot be used for that.
    """
    group = data if isinstance(data, dict) else {}
    name, beside = group.get("experiment"), group.get("beside")
    if not is_plugin(name) or not isinstance(beside, str | None):
        return base
    experiment = Experiment(name, beside)
    values, label = experiment.values(group.get(experiment.label)), experiment.label
    key = base, name, repr(values)
    if not values or key in _models:
        return _models.get(key, base)
    if label in {*base.model_fields, *RunSection.model_fields, "extends"}:
        raise InputError(
            f"experiment is {name!r}; its VALUES need a section {label}, which is another key: "
            "give the file another name."
        )
    section = experiment.section(values)
    default = parsed(section, {}, label)
    model = create_model(base.__name__, __base__=base, **{label: (section, default)})
    model.read = base.read | {label: model.model_fields[label]}
    return _models.setdefault(key, model)
