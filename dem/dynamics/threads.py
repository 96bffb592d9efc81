"""Several threads that run one compiled loop in step.

All threads run the same loop (dem.dynamics.integration.advance), each over its own granules, and
wait for each other several times per step. A barrier of the operating system would take longer than
a short step. The threads spin instead, and yield the processor when they wait for long.
"""

import os
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import intrinsic

from dem.jit.block_memory import make_lanes
from dem.jit.compilation import compiled, inlined

SPINS = 2000  # checks of the barrier before the thread yields the processor
LINE = 8  # numbers to a cache line: each thread writes into its own


class Place(NamedTuple):
    """One thread among those that run a loop together.

    Attributes
    ----------
    number : int
        Number of the thread, from 0.
    size : int
        Number of threads.
    arrivals : ndarray of shape (1,)
        How often threads have arrived at a barrier so far.
    moved : ndarray of shape (8 size,)
        Largest squared displacement (m2) that each thread has seen.
    """

    number: int
    size: int
    arrivals: np.ndarray
    moved: np.ndarray


class Threads(ThreadPoolExecutor):
    """A pool of threads, each with a Place in `places`."""

    def __init__(self, size: int):
        super().__init__(size)
        arrivals, moved = np.zeros(1, np.int64), np.zeros(LINE * size)
        self.places = [Place(number, size, arrivals, moved) for number in range(size)]

    def together(self, function, world, *arguments):
        """What a compiled loop returns that all threads run, each with its lanes and its Place."""
        worlds = [world._replace(lanes=make_lanes()) for _ in self.places]
        first, *_ = self.map(function, worlds, *map(repeat, arguments), self.places)
        return first


def _first(context, builder, signature, arguments):
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return array.data


@intrinsic
def _arrive(typing, arrivals):
    """Add one to arrivals[0], as one indivisible operation; returns the new number."""

    def generate(context, builder, signature, arguments):
        one = context.get_constant(types.int64, 1)
        old = builder.atomic_rmw(
            "add", _first(context, builder, signature, arguments), one, "seq_cst"
        )
        return builder.add(old, one)

    return types.int64(arrivals), generate


@intrinsic
def _arrived(typing, arrivals):
    """arrivals[0], read from memory."""

    def generate(context, builder, signature, arguments):
        return builder.load_atomic(
            _first(context, builder, signature, arguments), "seq_cst", align=8
        )

    return types.int64(arrivals), generate


if hasattr(os, "sched_yield"):
    _yield_processor = types.ExternalFunction("sched_yield", types.int32())
else:

    @compiled
    def _yield_processor():
        return 0


@inlined
def barrier(place):
    """Wait until all threads have arrived; without a Place, nothing."""
    if place is not None:
        number = _arrive(place.arrivals)
        full = (number + place.size - 1) // place.size * place.size
        spins = 0
        while _arrived(place.arrivals) < full:
            spins += 1
            if spins > SPINS:
                _yield_processor()
                spins = 0


@inlined
def share_of(place, count):
    """First and last (excluded) of `count` items for a thread; all of them without a Place."""
    if place is None:
        return 0, count
    return place.number * count // place.size, (place.number + 1) * count // place.size


@inlined
def leads(place):
    """Whether a thread does what only one must do."""
    return place is None or place.number == 0
