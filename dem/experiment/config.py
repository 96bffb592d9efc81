"""The one schema: a configuration file is a sweep, a sweep expands to replicates.

SI units throughout. Workflow, command line and library read configurations only through here;
whatever cannot be simulated is refused with one sentence a fault, naming key and value.
"""

import json
import math
from collections.abc import Iterable
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import yaml
from pydantic import Field, ValidationError, model_validator

from dem.base.errors import InputError
from dem.base.files import atomic
from dem.base.schema import (
    Folder,
    Label,
    NotNegative,
    Number,
    Positive,
    Section,
    Seeds,
    Whole,
    sentences,
)
from dem.base.sources import code_hash
from dem.base.yaml_file import read
from dem.experiment.fit import check_room, check_rooms
from dem.shapes import KINDS


class CylinderSection(Section):
    diameter: Positive  # m
    velocity: Positive  # m/s, upwards
    start: Annotated[Positive, Field(lt=1)]  # height of the axis over that of the box
    stroke: Positive  # m


class PackingSection(Section):
    fraction: Annotated[Positive, Field(lt=1)]  # V_f
    size_spread: Annotated[Number, Field(ge=0, lt=1)]  # diameters uniform within +- this share
    friction: NotNegative = 0.0  # of all contacts while the bed is packed


class MaterialSection(Section):
    young_modulus: Positive  # Pa
    poisson_ratio: Annotated[Number, Field(gt=-1, le=0.5)]
    restitution: Annotated[Number, Field(ge=1e-3, le=1)]
    thickness: Positive | None = None  # m out of the plane, for the mass; None: mean diameter


class FrictionSection(Section):
    granule: NotNegative
    wall: NotNegative
    cylinder: NotNegative
    stiffness: Positive = 1.0  # of the tangential springs, over Mindlin's


class EllipseSection(Section):
    contact: Literal["common_normal", "geometric_potential"] = "common_normal"
    curvature: Literal["volume", "local"] = "volume"


class RecordSection(Section):
    bins: Annotated[Whole, Field(ge=1, le=100_000)]
    window: tuple[NotNegative, Positive]  # m, displacements between which the drag is averaged
    snapshots: Annotated[Whole, Field(ge=2, le=10_000)]  # of all granules, first and last included

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
    step_fraction: Annotated[Positive, Field(lt=1)] = 0.5  # of the critical time step
    time_step: Positive | None = None  # s, fixed; None: from the bed's stiffness
    max_overlap: Annotated[Positive, Field(le=1.5)] = 1.2  # over the smaller radius


class ShapeSection(Section):
    kind: Literal[tuple(KINDS)]
    diameter: Positive  # m, mean volume diameter
    granules: Annotated[Whole, Field(ge=1, le=10_000_000)]
    aspect_ratio: Annotated[Number, Field(ge=1)] | None = None

    @model_validator(mode="after")
    def _check(self):
        natural = KINDS[self.kind].aspect_ratio
        if natural is None and self.aspect_ratio is None:
            raise ValueError(f"aspect_ratio is missing; kind {self.kind} needs one")
        if natural and self.aspect_ratio not in (None, natural):
            raise ValueError(
                f"aspect_ratio is {self.aspect_ratio:g}; that of a {self.kind} is {natural:g}, "
                "leave it out"
            )
        return self

    @property
    def ratio(self) -> float:
        """Length over width."""
        return self.aspect_ratio or KINDS[self.kind].aspect_ratio


class CaseSection(Section):
    shape: Label
    density: Positive  # kg/m3


class Sweep(Section):
    """A whole configuration file."""

    title: str = "Slow drag of a cylinder through a bed of granules"
    results: Folder
    seeds: Seeds  # a list, or words such as 1 to 10000
    batch: Annotated[Whole, Field(ge=1, le=10_000)] = 1  # seeds that one job of the workflow makes
    failures: Annotated[Number, Field(ge=0, lt=1)] = 0.0  # share of replicates that may fail
    box_width: Positive  # m
    cylinder: CylinderSection
    packing: PackingSection
    material: MaterialSection
    friction: FrictionSection
    gravity: NotNegative = 0.0  # m/s2, downwards
    ellipse: EllipseSection = EllipseSection()
    shapes: Annotated[dict[Label, ShapeSection], Field(min_length=1)]
    cases: Annotated[dict[Label, CaseSection], Field(min_length=1)]
    record: RecordSection
    numerics: NumericsSection = NumericsSection()

    @model_validator(mode="after")
    def _check(self):
        if len(set(self.seeds)) < len(self.seeds):
            twice = next(a for a, b in pairwise(sorted(self.seeds)) if a == b)
            raise ValueError(f"seeds has {twice} twice; list each seed once")
        if self.failures and self.batch == 1:
            raise ValueError(
                f"failures is {self.failures:g}; with batch 1 it must be 0, because a failed run would "
                "block every rule that depends on it"
            )
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
        seen = {}
        for label, case in self.cases.items():
            if case.shape not in self.shapes:
                raise ValueError(
                    f"cases.{label}.shape is {case.shape!r}, which is not one of shapes: "
                    + ", ".join(self.shapes)
                )
            twin = seen.setdefault((case.shape, density_label(case.density)), label)
            if twin != label:
                raise ValueError(f"cases.{label} repeats cases.{twin}")
        for label in self.shapes:
            check_rooms(self, label)
        return self

    def own_dump(self, exclude=None) -> dict:
        """The values as a dictionary, without sections of studies."""
        return self.model_dump(include=set(Sweep.model_fields), exclude=exclude)

    def code_of(self, *modules: str, shapes: Iterable[str]) -> str:
        """SHA-256 of the code that modules and some shapes of this sweep depend on."""
        kinds = {KINDS[self.shapes[shape].kind].module for shape in shapes}
        return code_hash(*modules, *sorted(kinds))

    def batches(self) -> int:
        """Number of jobs that make the replicates of a shape."""
        return -(-len(self.seeds) // self.batch)

    def seeds_of_batch(self, number: int) -> list[int]:
        """Seeds of one job, ascending; raises InputError where there is no such job."""
        if not 0 <= number < self.batches():
            raise InputError(f"batch is {number}; there are {self.batches()}, from 0.")
        return self.ascending[number * self.batch : (number + 1) * self.batch]

    @cached_property
    def ascending(self) -> list[int]:
        """Seeds in order."""
        return sorted(self.seeds)

    def densities(self, shape: str) -> list[float]:
        """Densities (kg/m3) of the cases of a shape; raises InputError where it has none."""
        found = [case.density for case in self.cases.values() if case.shape == shape]
        if not found:
            raise InputError(
                f"shape is {shape!r}; the cases have "
                + ", ".join(dict.fromkeys(case.shape for case in self.cases.values()))
                + "."
            )
        return found

    def density_of(self, shape: str) -> float:
        """Density (kg/m3) of the first case of a shape, or of the first case of all."""
        cases = list(self.cases.values())
        return next((case.density for case in cases if case.shape == shape), cases[0].density)

    @property
    def in_window(self) -> np.ndarray:
        """Which bins (bins,) of a run have their middle in the averaging window."""
        middle = (np.arange(self.record.bins) + 0.5) / self.record.bins * self.cylinder.stroke
        return (middle >= self.record.window[0]) & (middle <= self.record.window[1])

    def replicates(self) -> list["Replicate"]:
        """All runs, case by case, seeds in the order of the file."""
        return [
            Replicate.of(self, case.shape, case.density, seed)
            for case in self.cases.values()
            for seed in self.seeds
        ]

    def replicate(self, shape: str, density: float, seed: int) -> "Replicate":
        """One run; raises InputError for a shape that the configuration does not have."""
        if shape not in self.shapes:
            raise InputError(
                f"shape is {shape!r}; the configuration has " + ", ".join(self.shapes) + "."
            )
        if not (math.isfinite(density) and density > 0):
            raise InputError(f"density is {density!r}; it must be a positive number (kg/m3).")
        if seed < 0:
            raise InputError(f"seed is {seed}; it must not be negative.")
        try:
            check_room(self, shape, seed)
        except ValueError as error:
            raise InputError(f"{error}.") from None
        return Replicate.of(self, shape, density, seed)


class Replicate(Section):
    """One run of the sweep: a shape at a density with a seed."""

    sweep: Sweep
    label: str
    density: float
    seed: int

    @classmethod
    def of(cls, sweep: Sweep, label: str, density: float, seed: int) -> "Replicate":
        """A run of a sweep that is known to be sound: it is not checked all over again."""
        return cls.model_construct(sweep=sweep, label=label, density=density, seed=seed)

    @property
    def shape(self) -> ShapeSection:
        return self.sweep.shapes[self.label]

    @property
    def key(self) -> tuple[str, str, int]:
        """Shape, density as paths have it, and seed."""
        return self.label, density_label(self.density), self.seed

    @property
    def path(self) -> str:
        """Where its file lies below the folder of results."""
        density = density_label(self.density)
        return f"replicates/{self.label}/density{density}/seed{self.seed}.nc"

    @property
    def source_hash(self) -> str:
        """SHA-256 of the code that this run depends on."""
        return self.sweep.code_of("dem.experiment.drag", shapes=[self.label])

    def _granules(self) -> dict:
        """The section of the shape, with the aspect ratio that its kind may give it."""
        return self.shape.model_dump() | {"aspect_ratio": self.shape.ratio}

    def bed_key(self) -> str:
        """All that the bed depends on, as text: the packing is made again when it changes."""
        s = self.sweep
        cylinder = (s.cylinder.diameter, s.cylinder.start)
        return json.dumps(
            [self._granules(), s.packing.model_dump(), s.box_width, cylinder, self.seed]
        )

    def run_key(self) -> str:
        """All that the run depends on, as text."""
        names = (
            "title",
            "results",
            "seeds",
            "batch",
            "failures",
            "shapes",
            "cases",
        )
        unread = dict.fromkeys(names, True)
        unread["record"] = {"window"}
        if self.shape.kind != "ellipse":
            unread["ellipse"] = True
        common = self.sweep.own_dump(exclude=unread)
        return json.dumps([self._granules(), common, self.density, self.seed])


def density_label(density: float) -> str:
    """A density (kg/m3) as paths have it."""
    return f"{density:.10g}"


def parse(data, source: str = "configuration", model: type[Sweep] = Sweep) -> Sweep:
    """Sweep from the content of a file; raises InputError with one sentence a fault.

    model: Sweep, or one with sections of its own beside (dem.studies.config).
    """
    if not isinstance(data, dict):
        raise InputError(f"{source}: it must hold keys with values, see config/paper.yaml.")
    try:
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return model.model_validate(data)
    except ValidationError as error:
        raise InputError(sentences(source, error)) from None


def load(path: Path) -> Sweep:
    """Sweep from a YAML file; raises InputError with one sentence a fault."""
    return parse(read(path), str(path))


def save(sweep: Sweep, path: Path) -> None:
    """Write the configuration as resolved, so that `load` gives the same sweep again."""
    text = yaml.safe_dump(json.loads(sweep.model_dump_json()), sort_keys=False).encode()
    path = Path(path)
    if not path.exists() or path.read_bytes() != text:
        with atomic(path) as part:
            part.write_bytes(text)
