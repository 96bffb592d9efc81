"""All ways to find a contact, tried in one way: the same pairs, the same loop, in turns."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import put, unconverged
from dem.jit.block_memory import BLOCK, ROW
from dem.jit.compilation import compiled, inlined
from dem.shapes.common_normal import CommonNormal
from dem.shapes.geometric_potential import GeometricPotential
from dem.shapes.protocol import ellipse_contact, ellipse_normal
from studies.accuracy import definitions
from studies.accuracy.pairs import Contact, Pairs

SHORTEST = 1e-3  # s, of one timing: clock, call and cold caches are then a per cent or two


class Method(NamedTuple):
    """kind and name; what the kernels take; its definition, from Pairs to Contact.

    doubts: True for one that starts from a guess and may ask for a better one, else None.
    """

    kind: str
    name: str
    solver: tuple
    definition: Callable[[Pairs], Contact]
    doubts: bool | None = None


def common_normal(tolerance: float) -> Method:
    """The kernels' own, to a tolerance in rad."""
    name = f"common normal, {tolerance:.0e} rad".replace("e-0", "e-")
    solver = CommonNormal(tolerance)
    return Method("common normal", name, solver, definitions.common_normal, True)


POTENTIAL = Method(
    "geometric potential", "geometric potential", GeometricPotential(), definitions.chord
)

# Pairs side by side, BLOCK at a time, as the kernels lay them out (dem.jit.block_memory).
(DX, DY, GX, GY, OWN, _, _, _, OTHER, _, _, _, OVERLAP, NX, NY, N1, T1, N2, T2, UNCONVERGED) = (
    np.uint64(r * int(ROW)) for r in range(20)
)


@inlined
def four(values, at):
    return values[at], values[at + ROW], values[at + ROW + ROW], values[at + ROW + ROW + ROW]


@inlined
def pair(values, k):
    guess = values[GX + k], values[GY + k]
    return values[DX + k], values[DY + k], four(values, OWN + k), four(values, OTHER + k), guess


@inlined
def keep(geometry, values, k):
    overlap, nx, ny, n1, t1, n2, t2 = geometry
    values[OVERLAP + k], values[NX + k], values[NY + k] = overlap, nx, ny
    values[N1 + k], values[T1 + k], values[N2 + k], values[T2 + k] = n1, t1, n2, t2


@inlined
def look_again(doubts, method, values):
    if doubts is None:
        return
    for q in range(BLOCK):
        k = np.uint64(q)
        if values[UNCONVERGED + k] != 0.0:
            dx, dy, own, other, guess = pair(values, k)
            guess = ellipse_normal(method, dx, dy, own, other, guess)
            keep(ellipse_contact(method, dx, dy, own, other, guess)[0], values, k)


@compiled
def find_contacts(method, blocks, doubts, rounds):
    """Find all contacts, `rounds` times over. doubts: True for a method that asks for better
    guesses, else None; those pairs are computed a second time, as in dem.contacts.blocks."""
    for _ in range(rounds):
        for i in range(len(blocks)):
            for q in range(BLOCK):
                k = np.uint64(q)
                geometry, _, converged = ellipse_contact(method, *pair(blocks[i], k))
                keep(geometry, blocks[i], k)
                put(unconverged(converged), blocks[i], UNCONVERGED + k)
            look_again(doubts, method, blocks[i])


def lay_out(pairs: Pairs, guesses):
    """Blocks for find_contacts, from pairs and normals to start from (n, 2)."""
    count = len(pairs.d) // BLOCK
    blocks = np.zeros((count, 20 * int(ROW)))
    lanes = blocks.reshape(count, 20, int(ROW))
    for row, values in enumerate((*pairs.d.T, *guesses.T, *pairs.own.T, *pairs.other.T)):
        lanes[:, row, :BLOCK] = values.reshape(count, BLOCK)
    return blocks


def find(method: Method, pairs: Pairs, guesses) -> Contact:
    """Contacts of pairs (a multiple of 64) by one method, from normals to start from (n, 2); NaN
    where it finds none."""
    blocks = lay_out(pairs, guesses)
    find_contacts(method.solver, blocks, method.doubts, 1)
    lanes = blocks.reshape(len(blocks), 20, int(ROW))[:, 12:17, :BLOCK]
    overlap, nx, ny, n1, t1 = lanes.transpose(1, 0, 2).reshape(5, -1)
    normal, point = np.stack([nx, ny], -1), np.stack([n1 * nx - t1 * ny, n1 * ny + t1 * nx], -1)
    return definitions.where(overlap > 0.0, Contact(overlap, normal, point))


def time_all(trials, pairs: Pairs, repeats: int):
    """Seconds per pair (trials, repeats) of (method, guesses), in turns."""
    laid = [(method.solver, lay_out(pairs, guesses), method.doubts) for method, guesses in trials]
    rounds, spent = np.ones(len(laid), int), np.empty((len(laid), repeats))
    for repeat in range(-2, repeats):  # the first compiles, the second sets the number of rounds
        for k, arguments in enumerate(laid):
            started = time.perf_counter()
            find_contacts(*arguments, int(rounds[k]))
            taken = time.perf_counter() - started
            if repeat == -1:
                rounds[k] = max(1, int(np.ceil(SHORTEST / taken)))
            elif repeat >= 0:
                spent[k, repeat] = taken / (rounds[k] * len(pairs.d))
    return spent
