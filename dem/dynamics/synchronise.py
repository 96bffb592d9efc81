"""How several threads run one compiled loop in step.

All threads run the same loop (dem.dynamics.integration.advance), each over its own granules, and
wait for each other several times per step. A barrier of the operating system would take longer than
a short step. The threads spin instead, and yield the processor when they wait for long.
"""

import os
from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic

from dem.jit.compilation import compiled
from dem.jit.optional import optional

PATIENCE = 2000  # checks of the gate before the thread yields the processor
LINE = 8  # numbers to a cache line: each thread writes into its own


class Thread(NamedTuple):
    """One thread's place: its number, how many there are, and what they share.

    gate (1,): arrivals so far; moved (8 size,): largest squared displacement that each has seen.
    """

    me: int
    size: int
    gate: np.ndarray
    moved: np.ndarray


def make_threads(size: int) -> list[Thread]:
    """Places of all threads."""
    gate, moved = np.zeros(1, np.int64), np.zeros(LINE * size)
    return [Thread(me, size, gate, moved) for me in range(size)]


def _first(context, builder, signature, arguments):
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return array.data


@intrinsic
def _arrive(typing, gate):
    """Add one to gate[0], as one indivisible operation; returns the new number."""

    def generate(context, builder, signature, arguments):
        one = context.get_constant(types.int64, 1)
        old = builder.atomic_rmw(
            "add", _first(context, builder, signature, arguments), one, "seq_cst"
        )
        return builder.add(old, one)

    return types.int64(gate), generate


@intrinsic
def _arrived(typing, gate):
    """gate[0], read each time."""

    def generate(context, builder, signature, arguments):
        return builder.load_atomic(
            _first(context, builder, signature, arguments), "seq_cst", align=8
        )

    return types.int64(gate), generate


if hasattr(os, "sched_yield"):
    _let_others_run = types.ExternalFunction("sched_yield", types.int32())
else:

    @compiled
    def _let_others_run():
        return 0


@optional
def barrier(thread):
    """Wait until all threads are here."""
    number = _arrive(thread.gate)
    full = (number + thread.size - 1) // thread.size * thread.size
    looks = 0
    while _arrived(thread.gate) < full:
        looks += 1
        if looks > PATIENCE:
            _let_others_run()
            looks = 0


@optional
def portion(thread, count):
    """First and last (excluded) of `count` items for this thread."""
    return thread.me * count // thread.size, (thread.me + 1) * count // thread.size


@optional
def follows(thread):
    """Whether this thread leaves to another what only one must do."""
    return thread.me > 0
