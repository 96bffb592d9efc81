"""The step: kick, drift, forces; many of them in one call, by one thread or several."""

import math
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from typing import NamedTuple

import numpy as np

from dem.contacts.layout import LANES, PAIR, aligned
from dem.dynamics.forces import (
    add_forces_across_patches,
    all_forces,
    boundary_forces,
    integrate_account,
    knows_forces,
    pair_forces,
    show,
)
from dem.dynamics.motion import boundaries_moved, drift, farthest_of, greater, move_boundaries
from dem.dynamics.world import granules_of
from dem.jit.intrinsics import barrier

LEDGER = True
LINE = 8  # numbers to a cache line: each thread writes into its own

# Functions that a kernel has once; all others become part of them
APART = frozenset(
    [
        "gather",
        "find_pairs",
        "refine_pairs",
        "find_walls",
        "find_outlines",
        "find_polygons",
        "average_roots",
        "respond",
        "accumulate",
        "load_boundaries",
        "drift",
        "collect",
        "place",
        "move_held",
        "move_boundaries",
        "farthest_of",
        "pair_forces",
        "boundary_forces",
        "all_forces",
        "show",
        "find_block",
        "respond_block",
        "kick",  # and what dem.packing.minimise has beside
        "halt",
        "move",
    ]
)


class Place(NamedTuple):
    """One thread among those that run a loop together.

    Attributes
    ----------
    number, size : int
        Number of the thread, from 0, and how many there are.
    arrivals : ndarray of shape (1,)
        How often threads have arrived at a barrier so far.
    moved : ndarray of shape (8 size,)
        Largest squared displacement (m2) that each thread has seen.
    pair, lanes : ndarray
        Scratch memory of this thread (dem.contacts.layout).
    """

    number: int
    size: int
    arrivals: np.ndarray
    moved: np.ndarray
    pair: np.ndarray
    lanes: np.ndarray


def places(size: int) -> list[Place]:
    """The places of so many threads."""
    shared = np.zeros(1, np.int64), np.zeros(LINE * size)
    return [Place(k, size, *shared, aligned(PAIR), aligned(LANES)) for k in range(size)]


class Threads(ThreadPoolExecutor):
    """A pool of threads, each with a Place in `places`."""

    def __init__(self, size: int):
        super().__init__(size)
        self.places = places(size)

    def together(self, function, *arguments):
        """What a kernel returns that all threads run, each with its Place."""
        first, *_ = self.map(function, *map(repeat, arguments), self.places)
        return first


def share_of(place, count):
    """First and last (excluded) of `count` items for a thread."""
    return place.number * count // place.size, (place.number + 1) * count // place.size


def move_patch(world, kick, dt, patch, limit):
    """`drift` of a patch; returns its largest squared displacement (m2) since the lists were made,
    0 if none is above `limit`."""
    constituents, granules = world.constituents, world.granules
    low, high = granules_of(granules.angle.shape[0], patch)
    drift(
        granules,
        constituents,
        world.held,
        world.boundaries.motion,
        world.gravity,
        world.account,
        kick,
        dt,
        low,
        high,
    )
    first = constituents.first
    return farthest_of(constituents.motion, constituents.reference, first[low], first[high], limit)


def advance(world, kick, dt, steps, limit, place):
    """Take up to `steps` steps of dt (s); stop when a constituent has moved farther than `limit` (m).

    kick (s): of the first step, what the step before has left of its own and half of this one. A
    kick of dt goes on as if there had been no call. Returns the number of steps done and the
    largest displacement (m); that of granules counts as 0 up to `limit`. Half a step of kicks is
    then still to come.

    A patch moves as soon as this thread knows all forces on it, while they are in the cache. The
    other patches wait until all threads have done their pairs.
    """
    patches, boundaries, constituents = world.patches, world.boundaries, world.constituents
    pair, lanes, count = place.pair, place.lanes, patches.lowest.shape[0]
    begin, end = share_of(place, count)
    squared, done, further = limit * limit, 0, 0.0
    while True:
        # Kick and drift: boundaries, then the patches that wait for them
        if place.number == 0:
            move_boundaries(boundaries, constituents, world.account, kick, dt)
            walls, solids = boundaries_moved(boundaries)
            further = greater(further, greater(walls, solids))
        barrier(place.arrivals, place.size)
        for patch in range(begin, end):
            if done == 0 or not knows_forces(patches.lowest, patch, begin):
                further = greater(further, move_patch(world, kick, dt, patch, squared))
        if place.size > 1:  # all threads know the largest displacement
            place.moved[LINE * place.number] = further
            barrier(place.arrivals, place.size)
            for member in range(place.size):
                further = greater(further, place.moved[LINE * member])
        moved = further
        done += 1
        last = done == steps or not moved <= squared
        if LEDGER:
            integrate_account(world.account, kick)
        kick, further = dt, 0.0
        # Forces of pairs, and the next drift of patches that know all of theirs
        for patch in range(begin, end):
            pair_forces(world, dt, patch, pair, lanes)
            if knows_forces(patches.lowest, patch, begin):
                add_forces_across_patches(constituents, patches, patch)
                if not last:
                    further = greater(further, move_patch(world, kick, dt, patch, squared))
        barrier(place.arrivals, place.size)
        # Forces of pairs of two patches, then of boundaries
        for patch in range(begin, end):
            if not knows_forces(patches.lowest, patch, begin):
                add_forces_across_patches(constituents, patches, patch)
        barrier(place.arrivals, place.size)
        if place.number == 0:
            boundary_forces(world, dt, pair, lanes)
        if last:
            return done, math.sqrt(moved)


STEPS, DRIFT, FORCES, SHOW, RESPOND = range(5)  # what `work` does


def work(world, task, kick, dt, steps, limit, rows, place):
    """What a bed is asked for, in one kernel, so that its parts are compiled once.

    STEPS: see `advance`. DRIFT: kick (s) and move (dt, s) all bodies, without forces. FORCES: those
    of the present positions, over a step dt (s). SHOW: geometry of the contacts of blocks from `steps` on,
    into rows (blocks, SEEN or more, BLOCK); RESPOND: with their forces.
    """
    if task == STEPS:
        return advance(world, kick, dt, steps, limit, place)
    if task == DRIFT:
        granules = world.granules.angle.shape[0]
        move_boundaries(world.boundaries, world.constituents, world.account, kick, dt)
        drift(
            world.granules,
            world.constituents,
            world.held,
            world.boundaries.motion,
            world.gravity,
            world.account,
            kick,
            dt,
            0,
            granules,
        )
    elif task == FORCES:
        all_forces(world, dt, place.pair, place.lanes)
    else:
        end = steps + rows.shape[0]
        show(world, steps, end, task == RESPOND, rows, place.pair, place.lanes)
    return 0, 0.0
