"""The shapes, one file each, which says its class at its top: SHAPE = "Disc", and ASPECT_RATIO, its
length over width, where that is given by nature. A new shape is a new file.

In: sizes of granules (m). Out: what dem.shapes.protocol lists, for the kernels and for Python. A
smooth convex shape is its support function (see superellipse.py); `dem.check_shape` says what is
wrong with a shape. Here you may add a shape, or a way to find a contact. Shapes in files of a user's
own: dem.base.plugins.
"""

import math
from pathlib import Path
from typing import NamedTuple

from dem.base.declarations import definitions, described
from dem.base.errors import InputError
from dem.base.plugins import find, load

HOW = "docs/howto/shape.md"
SAME = 1e-6  # relative error of the areas of granules that are asked for by their diameters


class Kind(NamedTuple):
    """File and name of the class of a shape, and its length over width; None where configurations give it."""

    file: Path
    name: str
    aspect_ratio: float | None = None

    @property
    def shape(self) -> type:
        """The class; the file of a user's own runs here, and nowhere else. Raises InputError."""
        granules = getattr(load(self.file), self.name)
        if not hasattr(granules, "oriented"):  # which dem.shapes.protocol gives to each shape
            raise InputError(
                f"{self.file}: {self.name} is no shape; decorate it with smooth, see {HOW}."
            )
        return granules


KINDS = {
    name: Kind(Path(__file__).with_name(f"{name}.py"), table["SHAPE"], table.get("ASPECT_RATIO"))
    for name, table in described(Path(__file__).parent, "SHAPE").items()
}


def kind_of(name: str, beside: str | None = None) -> Kind:
    """The kind of this name, of the package or of a file in the folder `beside`; raises
    InputError."""
    if name in KINDS:
        return KINDS[name]
    file, last = find("kind", name, beside, tuple(KINDS)), name.rpartition(".")[2]
    classes, said = definitions(file), f"kind is {name!r}; "
    if last not in classes:
        raise InputError(
            f"{said}{file} has no class {last}; it defines {', '.join(classes) or 'none'}."
        )
    if "of_size" not in classes[last]:
        raise InputError(
            f"{said}its class has no of_size; give it a class method of_size(diameter, "
            f"aspect_ratio), "
            f"see {HOW}."
        )
    return Kind(file, last)


def of_size(cls: type, diameters, *form):
    """Granules of a class with the areas of discs of these diameters (n,) in m; raises InputError
    where they have others. form: what else of_size of the class takes."""
    granules, areas = cls.of_size(diameters, *form), 0.25 * math.pi * diameters**2
    off = abs(granules.area / areas - 1.0)
    if not off.max() <= SAME:
        g = off.argmax()
        raise InputError(
            f"{cls.__name__}.of_size gives a granule of {granules.area[g]:.7g} m2 for a diameter of "
            f"{diameters[g]:g} m; "
            f"it must have the area of that disc, {areas[g]:.7g} m2."
        )
    return granules


def is_drawn(kind: str) -> bool:
    """Whether a kind and an aspect ratio tell an outline: not for clumps, mixtures or a user's own
    shapes, because readers of results run no code that the results name."""
    return kind in KINDS and kind != "clump"


def outlines(kind: str, diameters, ratio: float):
    """Outlines (n, rings, points, 2) in m about the centre at angle zero, to draw; discs of equal
    area where the kind does not tell them."""
    return KINDS[kind if is_drawn(kind) else "disc"].shape.of_size(diameters, ratio).polygons(33)
