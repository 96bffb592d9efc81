"""Granules that break a law of shapes, and what are none."""

from contextlib import suppress
from functools import partial
from itertools import count
from typing import NamedTuple

import numpy as np
from egg import support

import dem
from dem.shapes import protocol, smooth

SIZES = 1e-3 * np.array([0.5, 0.7, 1.0])
NUMBERS = count()
USUAL = smooth.support, smooth.refine_normal, smooth.find_contact


def oval(slope=1.0, curvature=1.0, shift=0.0):
    """Support function of an ellipse of 3:2, a = r, with faults: factors, and a centre off by shift."""

    def support(nx, ny, sizes):
        (r,) = sizes
        h = r * np.sqrt(nx * nx + 4.0 / 9.0 * ny * ny)
        q, rho = -5.0 / 9.0 * r * r * nx * ny / h, 4.0 / 9.0 * r**4 / h**3
        return h + shift * r * nx, slope * q - shift * r * ny, curvature * rho

    return support


def stadium(nx, ny, sizes):
    (r,) = sizes
    return r * (1.0 + np.abs(nx)), -r * np.sign(nx) * ny, r + 0.0 * nx


def granules(function=None, answers=None, **members):
    """Three granules of a class of their own, with some members and some answers to the kernels changed."""
    name = f"Wrong{next(NUMBERS)}"
    fields = NamedTuple(name, [("radius", np.ndarray)])  # noqa: UP014
    kind = smooth.smooth(function or oval())(type(name, (fields,), members))
    if answers:
        protocol.answer(kind, **{f.__name__: f for f in USUAL} | answers)
    return kind(SIZES)


def half(name):
    """With half of one of its properties."""
    whole = getattr(smooth.Smooth, name).fget
    return {name: property(lambda shape: 0.5 * whole(shape))}


def contact(change):
    """With a contact that is changed."""

    def find_contact(shape, *values):
        geometry, converged = smooth.find_contact(shape, *values)
        return geometry._replace(**change(geometry)), converged

    return {"answers": {"find_contact": find_contact}}


def mirrored(shape, points):
    return smooth.Smooth.polygons(shape, points)[..., ::-1] * [1, -1]


HALVED = "area", "gyration_squared", "bounding_radius", "normal_lever", "normal_bend"
WRONG = {f"{name} is": half(name) for name in HALVED} | {
    "of_size gives a granule of 3.490659e-07 m2": {"of_size": classmethod(lambda cls, size, ratio: cls(0.5 * size))},
    "area is 1.0; it must be 3 finite": {"area": property(lambda shape: 1.0)},
    "grow by the power 2": {"scaled": lambda shape, factor: shape},
    "centre of mass": {"function": oval(shift=0.1)},
    "its outline has": {"function": oval(curvature=0.9)},
    "differ": {"polygons": mirrored},
    "q of support": {"function": oval(slope=1.05)},
    "area is 1.2854e-06 m2": {"function": stadium},
    "levers of a contact": contact(lambda c: {"t1": 0.0, "t2": 0.0}),
    "swapping them changes it": contact(lambda c: {"t2": 0.0}),
    "nearly coincide must touch": contact(lambda c: {"overlap": -1.0}),
    "normal of a contact": contact(lambda c: {"nx": c.nx - 0.05 * c.ny, "ny": c.ny + 0.05 * c.nx}),
    "circle": {"circle_outline": lambda shape, radius: (0.0, 1.1 * radius, 1.0)},
}  # fmt: skip


def lumpy(nx, ny, sizes):
    r, e, c = sizes
    return support(nx, ny, (r, e / r, c / r))


# Each granule has its own bulges and its own place of the centre (m).
FIELDS = [(name, np.ndarray) for name in ("radius", "lump", "shift")]
Lumps = smooth.smooth(lumpy)(NamedTuple("Lumps", FIELDS))
MANY = np.full(9, 1e-3)
SIXTH = 1e-3 * np.eye(9)[5]
OFF, BENT = Lumps(MANY, 0.05 * MANY, 0.1 * SIXTH), Lumps(MANY, 0.2 * SIXTH, 0.0 * MANY)


class Stranger(NamedTuple):
    """A class that no kernel knows."""

    radius: np.ndarray


def refused():
    """A class that was refused stays unknown."""
    with suppress(dem.InputError):
        protocol.answer(Stranger, *USUAL[1:])
    dem.check_shape(Stranger(SIZES))


CALLS = {words: lambda wrong=wrong: dem.check_shape(granules(**wrong)) for words, wrong in WRONG.items()} | {
    f"discs is {value}; it must be one list of discs": partial(dem.Clump, value)
    for value in ([], [(0.0, 0.0, 0.001)], [[(0.0, 0.0, 0.0)]], [[(0.0, 1.0)]])
} | {
    "bounces would make or lose energy": lambda: dem.check_shape(dem.Ellipse.of_size(SIZES, 1.5, "geometric_potential")),
    "semi_minor must not exceed": lambda: dem.check_shape(dem.Ellipse(SIZES, 2.0 * SIZES)),
    "it must be granules of a shape, such": partial(dem.check_shape, dem.Disc),
    "Lumps: granule 5 is not convex: its radius": lambda: dem.check_shape(BENT),
    "granule 5 is not convex: its radius": lambda: dem.Scene(BENT),
    "granules 0 and 5: the centre of mass is at c = (0.0001, ": lambda: dem.check_shape(OFF),
    "must answer the questions find_contact, support of": lambda: protocol.answer(Stranger, *USUAL[1:]),
    "Stranger has no area": lambda: protocol.answer(Stranger, *USUAL),
    "shape is Stranger(radius=": refused,
    "Lumps answers colour; it must answer": lambda: protocol.answer(Lumps, colour=support),
}  # fmt: skip
ROD = {"kind": "clump", "discs": [[0, 0]], "diameter": 9e-4, "granules": 60}
FILES = {
    "it must be a list of discs": {"shapes.t": ROD},
    "shapes.t: kind is missing; a shape needs one": {"shapes.t": {"granules": 9}},
    "shapes.m.mixture": {"shapes.m": {"mixture": {"c1": 1.0}, "granules": 9}},
}  # fmt: skip
