"""The shapes, one file each. A new shape is a new file and one line of kinds.toml.

In: sizes of granules (m). Out: what dem.shapes.protocol lists, for the kernels and for Python. A
smooth convex shape is its support function (see superellipse.py); `dem.check_shape` says what is
wrong with a shape. Here you may add a shape, or a way to find a contact.
"""

import tomllib
from importlib import import_module
from pathlib import Path
from typing import NamedTuple


class Kind(NamedTuple):
    """Where the class of a shape is, and its length over width; None where configurations give it.

    The class is loaded when first used, so that what a run depends on does not hold other shapes.
    """

    where: str
    aspect_ratio: float | None = None

    @property
    def module(self) -> str:
        """The module of the class."""
        return self.where.rpartition(".")[0]

    @property
    def shape(self) -> type:
        """The class."""
        return getattr(import_module(self.module), self.where.rpartition(".")[2])


_TABLE = (Path(__file__).parent / "kinds.toml").read_text(encoding="utf-8")
KINDS = {name: Kind(**line) for name, line in tomllib.loads(_TABLE).items()}
