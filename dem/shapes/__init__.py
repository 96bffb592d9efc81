"""The shapes, one file each. A new shape is a new file and one line of KINDS.

In: sizes of granules (m). Out: what dem.shapes.protocol lists, for the kernels and for Python. A
smooth convex shape is its support function (see superellipse.py); `dem.check_shape` says what is
wrong with a shape. Here you may add a shape, or a way to find a contact.
"""

from importlib import import_module
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


# by the name that configurations and data use
KINDS = {
    "disc": Kind("dem.shapes.disc.Disc", 1.0),
    "dumbbell": Kind("dem.shapes.dumbbell.Dumbbell", 2.0),
    "ellipse": Kind("dem.shapes.ellipse.Ellipse"),
    "superellipse": Kind("dem.shapes.superellipse.Superellipse"),
}
