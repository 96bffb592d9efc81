"""A whole configuration file: the values of a run, and what is varied."""

import json
import os
from functools import cached_property
from importlib.metadata import files as installed_files
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import Field, model_validator

from dem.base.errors import InputError
from dem.base.files import atomic
from dem.base.outside import placed
from dem.base.schema import Folder, Label, Number, Positive, Section, Whole
from dem.base.sources import ROOT
from dem.base.validate import shown
from dem.base.yaml_file import read
from dem.experiment.config import Configuration
from dem.experiment.config import parse as parse_values
from dem.sweep.axis import check_label
from dem.sweep.expand import Block, Derived, expand
from dem.sweep.hints import meant, remedies

DISTRIBUTION = "granular-drag"
FOLDERS = ("store", "chunks", "flow", "figures", "logs", "benchmarks")  # of results
CONFIG = "config.yaml"  # of results, as resolved
LONGEST_CHAIN = 20  # files that extend one another
REPLACED = ("sweep",)  # whole, by a file that extends another


class CaseSection(Section):
    shape: Label
    density: Positive  # kg/m3


class Sweep(Configuration):
    """A configuration file: values, tables of shapes and cases, what varies, and where it goes."""

    title: str = "Slow drag of a cylinder through a bed of granules"
    results: Annotated[Folder, Field(description="folder of all results, such as results/mine")]
    chunk: Annotated[Whole, Field(ge=1, le=10_000)] = 10  # runs per file of the store
    failures: Annotated[Number, Field(ge=0, lt=1)] = 0.0  # share of runs that may fail
    cases: dict[Label, CaseSection] = Field(default_factory=dict)
    sweep: Annotated[dict[str, Any], Field(min_length=1)]
    figures: list[str] | None = None  # all that the runs suffice for
    studies: str = "sweep.yaml"  # name of the sweep in the folder of each study

    @model_validator(mode="after")
    def _check_sweep(self):
        if set(self.results.split("/")[1:]) & {"store", "chunks"}:
            raise ValueError(
                f"results is {self.results!r}; the store is there, name another folder"
            )
        seen = {}
        for label, case in self.cases.items():
            if case.shape not in self.shapes:
                raise ValueError(
                    f"cases.{label}.shape is {case.shape!r}, which is not one of shapes: "
                    + ", ".join(self.shapes)
                    + meant(case.shape, self.shapes)
                )
            twin = seen.setdefault((case.shape, case.density), label)
            if twin != label:
                raise ValueError(f"cases.{label} repeats cases.{twin}")
        try:
            for name in self.blocks:
                self.needed(name)
                self.block(name)
        except InputError as error:
            raise ValueError(str(error).rstrip(".")) from None
        return self

    @cached_property
    def _expanded(self) -> dict[str, Block]:
        return {}

    @cached_property
    def blocks(self) -> dict[str, dict]:
        """What varies in each block, by its name; a sweep without blocks is one, named drag."""
        if "blocks" not in self.sweep:
            return {"drag": self.sweep}
        blocks, others = self.sweep["blocks"], set(self.sweep) - {"blocks"}
        if others:
            raise InputError(f"sweep has blocks and {min(others)}; move that into a block.")
        if not isinstance(blocks, dict) or not blocks:
            raise InputError("sweep.blocks must be groups of what varies, by name.")
        for name, block in blocks.items():
            check_label(name, "sweep.blocks")
            if name in FOLDERS:
                raise InputError(f"sweep.blocks has {name!r}, a folder of results; rename it.")
            if not isinstance(block, dict):
                raise InputError(
                    f"sweep.blocks.{name} is {block!r}; it must be a group of what varies."
                )
        return blocks

    def block(self, name: str, derived: Derived | None = None) -> Block:
        """All runs of a block; raises InputError for impossible runs.

        derived: gives the values that follow from another block's result; without it, a run has
        the values in the file.
        """
        if derived is None and name not in self._expanded:
            self._expanded[name] = expand(self, name, self._spec(name), None)
        return expand(self, name, self._spec(name), derived) if derived else self._expanded[name]

    def _spec(self, name: str) -> dict:
        """What a file says of a block; raises InputError where there is no such block."""
        if name not in self.blocks:
            raise InputError(
                f"block is {name!r}; the sweep has {', '.join(self.blocks)}"
                f"{meant(name, self.blocks)}."
            )
        return self.blocks[name]

    def needed(self, name: str) -> tuple[str, ...]:
        """The blocks, among those before it, whose results a block needs first."""
        wanted = self._spec(name).get("needs", ())
        names = tuple(wanted) if isinstance(wanted, list | tuple) else (wanted,)
        before = list(self.blocks)[: list(self.blocks).index(name)]
        for each in names:
            if each not in before:
                raise InputError(
                    f"sweep.blocks.{name}.needs is {each!r}; it must be a block before it: "
                    f"{', '.join(before) or 'there is none'}."
                )
        return names

    @cached_property
    def first_seed(self) -> int:
        """The least seed of the first block, for what needs one bed."""
        return min(run.replicate.seed for run in self.block(next(iter(self.blocks))).runs)

    def density_of(self, shape: str) -> float:
        """Density (kg/m3) of the first case of a shape, or of the first case of all."""
        cases = list(self.cases.values())
        if not cases:
            raise InputError("density is missing: let sweep.density say it, or name cases.")
        return next((case.density for case in cases if case.shape == shape), cases[0].density)

    def dump(self) -> dict:
        """The whole file as plain groups."""
        return json.loads(self.model_dump_json())


def parse(data, source: str = "configuration") -> Sweep:
    """Sweep from the content of a file; raises InputError with one sentence per fault."""
    with remedies(source, Sweep):
        return parse_values(extended(data, source), source, Sweep)


def extended(data, source: str, above: tuple = ()):
    """A file's content merged over the file that it extends; raises InputError."""
    data = placed(data, _folder_of(source))
    if not isinstance(data, dict) or "extends" not in data:
        return data
    name, own = data["extends"], {key: data[key] for key in data if key != "extends"}
    if not isinstance(name, str) or not name.isprintable():
        raise InputError(f"{source}: extends is {shown(name)}; it must be the name of a file.")
    if len(above) >= LONGEST_CHAIN:
        raise InputError(
            f"{source}: extends is {shown(name)}; {LONGEST_CHAIN} files extend each other already, write "
            "fewer."
        )
    try:
        path = found(name, Path(source).parent)
        real = path.resolve()
    except (
        OSError,
        ValueError,
        RuntimeError,
    ) as error:  # too long, links in a ring
        why = (getattr(error, "strerror", None) or str(error)).lower()
        raise InputError(
            f"{source}: extends is {shown(name)}; it must be the name of a file ({why})."
        ) from None
    if real in above:
        raise InputError(f"{source}: extends is {name!r}, which extends this file.")
    if "results" not in own:
        raise InputError(
            f"{source}: results is missing{meant('results', own)}; a file that extends another needs a "
            "folder of its own."
        )
    base = extended(read(path), str(path), (*above, real))
    return merged(base, own)


def _folder_of(source: str) -> Path:
    """Folder of the file of this name, or of the first of several, as Snakemake names them."""
    path = Path(source)
    return path.parent if path.is_file() else Path(source.partition(", ")[0]).parent


def merged(base: dict, own: dict, top: bool = True) -> dict:
    """Groups of values over others, key by key."""
    found = dict(base)
    for key, new in own.items():
        old = found.get(key)
        deep = isinstance(old, dict) and isinstance(new, dict) and not (top and key in REPLACED)
        found[key] = merged(old, new, False) if deep else new
    return found


def found(name: str | Path, beside: Path = Path()) -> Path:
    """The file of that name: here, beside another, in the checkout, or as it came with the package."""
    choices = [Path(name), beside / name, ROOT / name]
    if not any(each.is_file() for each in choices):
        for each in installed_files(DISTRIBUTION) or ():
            if each.as_posix().endswith(f"share/{DISTRIBUTION}/{name}"):
                choices.append(Path(each.locate()))
    return next((each for each in choices if each.is_file()), choices[0])


def load(path: Path) -> Sweep:
    """Sweep from a YAML file; raises InputError with one sentence per fault."""
    path = found(path)
    return parse(read(path), str(path))


FROM = "# resolved from "


def file_of(sweep: Sweep, path: Path) -> str:
    """The file that a sweep is known by, as it is seen from the working folder, which may be moved.

    Of the resolved configuration in the sweep's own folder it is the one that this was made from.
    """
    path, own = (Path(os.path.realpath(each)) for each in (path, Path(sweep.results) / CONFIG))
    if path == own:
        with path.open(encoding="utf-8") as file:
            first = file.readline().rstrip("\n")
        return first.removeprefix(FROM) if first.startswith(FROM) else ""
    try:
        return Path(os.path.relpath(path, os.path.realpath(Path.cwd()))).as_posix()
    except ValueError:  # another drive of Windows
        return path.as_posix()


def save(sweep: Sweep, path: Path, file: str = "") -> None:
    """Write the resolved configuration; `load` then gives the same sweep. file: that of the sweep."""
    head = f"{FROM}{file}\n" if file.isprintable() and file else ""
    text = (head + yaml.safe_dump(sweep.dump(), sort_keys=False)).encode()
    path = Path(path)
    if not path.is_file() or path.read_bytes() != text:  # a pipe has no end
        with atomic(path) as part:
            part.write_bytes(text)
