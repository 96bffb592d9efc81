"""A whole configuration file: the values of a run, and what is varied."""

import os
import sys
from dataclasses import replace
from functools import cached_property
from itertools import takewhile
from pathlib import Path
from textwrap import indent
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from dem.base.errors import InputError
from dem.base.messages import check_known
from dem.base.plugins import refresh, with_folder
from dem.base.refusals import parsed
from dem.base.source_hash import ROOT
from dem.base.types import Coefficient, Count, Density, Label, Section, must
from dem.base.yaml_file import DEEPEST, read
from dem.experiment.config import Configuration, model_of
from dem.experiment.replicate import Replicate
from dem.sweep.expand import Block, expand
from dem.sweep.granule_file import with_granules

FOLDERS = ("store", "figures", "logs", "rounds")  # of results
CONFIG = "config.yaml"  # of results, as resolved
TABLES = "cases", "phases", "shapes", "solids"  # of groups by labels of a user

# systems take 255 characters for a name, some 260 for a whole path
Folder = Annotated[
    str,
    Field(pattern=r"^results(/[A-Za-z0-9][A-Za-z0-9._-]*)*$", max_length=200),
    must(
        "be results or a folder below it, such as results/mine, but not that of the store, "
        "named by letters from A to Z, digits, ., _ and -, at most 200 in all",
        lambda name: "store" not in name.split("/"),
    ),
]
Blocks = Annotated[dict[Label, dict[Any, Any]], Field(min_length=1)]


class CaseSection(Section):
    shape: Label
    """label of a shape"""
    density: Density
    """density of the granules"""


class Sweep(Configuration):
    """A configuration file: values, tables of shapes and cases, what varies, and where it goes."""

    title: str = "Slow drag of a cylinder through a bed of granules"
    """title of files and figures"""
    results: Folder
    """folder of all results: results, or one below it, such as results/mine"""
    batch: Annotated[Count, Field(ge=1, le=10_000)] = 10
    """runs that one process makes, and writes into one file of the store"""
    failures: Annotated[Coefficient, Field(lt=1)] = 0.0
    """share of runs that may fail without an error"""
    cases: dict[Label, CaseSection] = Field({})
    """shapes with a density, by label"""
    sweep: Annotated[dict[str, Any], Field(min_length=1)]
    """what varies, by key"""
    figures: list[str] | None = None
    """names of the figures that are drawn; none: all that the runs suffice for"""
    studies: str = "sweep.yaml"
    """name of the sweep file that is read in the folder of each study"""

    @model_validator(mode="after")
    def _check_cases(self):
        for label, case in self.cases.items():
            check_known(f"cases.{label}.shape is", case.shape, self.shapes, "shapes")
        return self

    @cached_property
    def blocks(self) -> dict[str, dict]:
        """What varies in each block, by its name; a sweep without blocks is one, named drag."""
        if "blocks" not in self.sweep:
            return {"drag": self.sweep}
        if others := set(self.sweep) - {"blocks"}:
            raise InputError(f"sweep has blocks and {min(others)}; move that into a block.")
        blocks = parsed(Blocks, self.sweep["blocks"], "sweep.blocks")
        if taken := blocks.keys() & set(FOLDERS):
            raise InputError(f"sweep.blocks.{min(taken)} is a folder of results; rename the block.")
        return blocks

    def named(self, name: str) -> dict:
        """What varies in a block; raises InputError where there is no such block."""
        check_known("block is", name, self.blocks, "the blocks")
        return self.blocks[name]

    @cached_property
    def _expanded(self) -> dict[str, Block]:
        return {}

    def block(self, name: str) -> Block:
        """All runs of a block, in the first round of replicates, and with the values of the file
        where these follow from another block; raises InputError for impossible runs."""
        if name not in self._expanded:
            self._expanded[name] = expand(self, name)
        return self._expanded[name]

    def needed(self, name: str) -> tuple[str, ...]:
        """The blocks, among those before it, whose results a block needs first.

        Raises InputError where there is no such block.
        """
        wanted = self.named(name).get("needs", ())
        names = tuple(wanted) if isinstance(wanted, list | tuple) else (wanted,)
        before = [*takewhile(lambda other: other != name, self.blocks)]
        for other in names:
            if other not in before:
                raise InputError(
                    f"sweep.blocks.{name}.needs is {other!r}; it must be a block before it: "
                    f"{', '.join(before) or 'there is none'}."
                )
        return names

    def density_of(self, shape: str) -> float:
        """Density (kg/m3) of the first case of a shape, or of the first case of all."""
        cases = list(self.cases.values())
        if not cases:
            raise InputError("density is missing: let sweep.density say it, or name cases.")
        return next((case.density for case in cases if case.shape == shape), cases[0].density)

    def dump(self) -> dict:
        """The whole file as plain groups."""
        return self.model_dump(mode="json")


def parse(data, source: str = "configuration") -> Sweep:
    """Sweep from the content of a file; raises InputError with one sentence per fault."""
    data = extended(data, source)
    sweep = parsed(model_of(Sweep, data), data, source=source)
    try:
        for name in sweep.blocks:
            sweep.needed(name)
            sweep.block(name)
    except InputError as error:
        raise InputError(indent(str(error), f"{source}: ")) from None
    return sweep


def extended(data, source: str, left: int = DEEPEST):
    """A file's content merged over the file that it extends, which may extend another, and so on for
    so many files; raises InputError."""
    folder = Path(source.partition(", ")[0]).parent  # of the first, where Snakemake names several
    if not isinstance(data, dict):
        return data
    data = with_files(data, source, folder)
    # without keys for anchors of YAML, as Docker Compose has them
    data = {key: value for key, value in data.items() if not str(key).startswith("x-")}
    if "extends" not in data:
        return data
    name = parsed(str, data.pop("extends"), "extends", source)
    if not left:
        raise InputError(
            f"{source}: extends is {name!r}; more than {DEEPEST} files extend each other, perhaps in "
            "a circle."
        )
    base = find_file(name, folder)
    if "results" not in data:
        raise InputError(
            f"{source}: results is missing; a file that extends another needs a folder of its own."
        )
    return merged(extended(read(base), str(base), left - 1), data)


def with_files(data: dict, source: str, folder: Path) -> dict:
    """Values of a file, with the discs of clumps and the granules of a table in place of files in its
    folder that hold them; raises InputError."""
    data = with_granules(with_folder(data, folder), source, folder)
    if not isinstance(shapes := data.get("shapes"), dict):
        return data
    shapes = dict(shapes)
    for label, shape in shapes.items():
        if isinstance(shape, dict) and isinstance(name := shape.get("discs"), str):
            try:
                discs = np.loadtxt(folder / name, delimiter=",", ndmin=2).tolist()
            except (OSError, ValueError) as error:
                raise InputError(
                    f"{source}: shapes.{label}.discs is {name!r}; it must be a file with a line "
                    f"x, y, radius of each disc ({error})."
                ) from None
            shapes[label] = shape | {"discs": discs}
    return data | {"shapes": shapes}


def merged(base: dict, changes: dict, top: bool = True) -> dict:
    """Groups of values with some changed, key by key; null takes a label out of a table."""
    values = dict(base)
    for key, new in changes.items():
        old = values.get(key)
        deep = isinstance(old, dict) and isinstance(new, dict) and not (top and key == "sweep")
        values[key] = merged(old, new, False) if deep else new
        if deep and top and key in TABLES:
            values[key] = {name: row for name, row in values[key].items() if row is not None}
    return values


def find_file(name: str | Path, beside: Path = Path()) -> Path:
    """The file of that name: in the working folder, beside another, in the checkout, or of the package."""
    folders = Path(), beside, ROOT, Path(sys.prefix, "share/granular-drag")
    paths = [folder / name for folder in folders]  # Path would raise for a name that is too long
    return next((path for path in paths if os.path.isfile(path)), Path(name))  # noqa: PTH113


def load(path: Path) -> Sweep:
    """Sweep from a YAML file; raises InputError with one sentence per fault."""
    refresh()
    path = find_file(path)
    return parse(read(path), str(path))


def described(run: Replicate) -> dict:
    """A sweep file of one run alone, as plain groups: a cylinder as solids and phases of a scene."""
    c = run.configuration
    values = replace(run, configuration=c.scene if c.experiment == "drag" else c).values()
    values.pop("beside", None)  # the folder of the file, wherever it is put
    varied = {name: [values.pop(name)] for name in run.coordinates}
    return {"title": run.words(), "results": "results/described"} | values | {"sweep": varied}
