"""All ways to find a contact, tried in one way: the same pairs, the same loop, in turns."""

import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from dem.jit.block_memory import BLOCK, ROW
from dem.shapes.common_normal import CommonNormal
from dem.shapes.geometric_potential import GeometricPotential
from studies.accuracy import definitions, solvers
from studies.accuracy.pairs import Contact, Pairs, direction

SHORTEST = 1e-3  # s, of one timing: clock, call and cold caches are then a per cent or two


class Method(NamedTuple):
    """kind and name; what the kernels take; its definition, from Pairs to Contact.

    doubts: whether it asks for better guesses (True or None). remembers: whether a guess matters.
    """

    kind: str
    name: str
    solver: tuple
    definition: Callable[[Pairs], Contact]
    doubts: bool | None = None
    remembers: bool = False


def common_normal(tolerance: float) -> Method:
    """The kernels' own, to a tolerance in rad."""
    name = f"common normal, {tolerance:.0e} rad".replace("e-0", "e-")
    solver = CommonNormal(tolerance)
    return Method("common normal", name, solver, definitions.common_normal, True, True)


def polygon(sides: int) -> Method:
    """Polygons in place of the ellipses."""
    solver = solvers.Polygon(direction(2.0 * np.pi / sides * np.arange(sides)))
    definition = partial(definitions.polygon, sides=sides)
    return Method("polygon", f"polygon, {sides} sides", solver, definition, remembers=True)


POTENTIAL = Method(
    "geometric potential", "geometric potential", GeometricPotential(), definitions.chord
)
INTERSECTION = Method(
    "intersection", "intersection", solvers.Intersection(), definitions.crossing
)  # fmt: skip


def lay_out(pairs: Pairs, guesses):
    """Blocks for solvers.find_contacts, from pairs and normals to start from (n, 2)."""
    count = len(pairs.d) // BLOCK
    blocks = np.zeros((count, 20 * int(ROW)))
    lanes = blocks.reshape(count, 20, int(ROW))
    for row, values in enumerate((*pairs.d.T, *guesses.T, *pairs.own.T, *pairs.other.T)):
        lanes[:, row, :BLOCK] = values.reshape(count, BLOCK)
    return blocks


def found(blocks) -> Contact:
    """What solvers.find_contacts has written; NaN where it has found no contact."""
    lanes = blocks.reshape(len(blocks), 20, int(ROW))[:, 12:17, :BLOCK]
    overlap, nx, ny, n1, t1 = lanes.transpose(1, 0, 2).reshape(5, -1)
    normal, point = np.stack([nx, ny], -1), np.stack([n1 * nx - t1 * ny, n1 * ny + t1 * nx], -1)
    return definitions.where(overlap > 0.0, Contact(overlap, normal, point))


def find(method: Method, pairs: Pairs, guesses) -> Contact:
    """Contacts of pairs (a multiple of 64) by one method, from normals to start from (n, 2)."""
    blocks = lay_out(pairs, guesses)
    solvers.find_contacts(method.solver, blocks, method.doubts, 1)
    return found(blocks)


def time_all(trials, pairs: Pairs, repeats: int):
    """Seconds per pair (trials, repeats) of (method, guesses), in turns."""
    laid = [(method.solver, lay_out(pairs, guesses), method.doubts) for method, guesses in trials]
    rounds, spent = np.ones(len(laid), int), np.empty((len(laid), repeats))
    for repeat in range(-2, repeats):  # the first compiles, the second sets the number of rounds
        for k, arguments in enumerate(laid):
            started = time.perf_counter()
            solvers.find_contacts(*arguments, int(rounds[k]))
            taken = time.perf_counter() - started
            if repeat == -1:
                rounds[k] = max(1, int(np.ceil(SHORTEST / taken)))
            elif repeat >= 0:
                spent[k, repeat] = taken / (rounds[k] * len(pairs.d))
    return spent
