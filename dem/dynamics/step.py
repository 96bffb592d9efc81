"""The step: kick, drift, forces; many of them in one call, by one thread or several."""

import math
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from typing import NamedTuple

import numpy as np

from dem.contacts.layout import LANES, LINE, aligned
from dem.dynamics.base_plate import rub_boundaries, rub_granules
from dem.dynamics.forces import (
    FORCES,
    RESPOND,
    SHOW,
    add_forces_across_patches,
    clear_boundaries,
    clear_patch,
    contact_forces,
    integrate_account,
    knows_forces,
    sum_held_forces,
)
from dem.dynamics.motion import (
    boundaries_moved,
    collect,
    drift,
    farthest_of,
    greater,
    move_boundaries,
    place,
)
from dem.dynamics.world import SECTIONS, WALLS, granules_of
from dem.jit.intrinsics import barrier

LEDGER = COMPOSED = True


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
    lanes : ndarray
        Scratch memory of this thread (dem.contacts.layout).
    """

    number: int
    size: int
    arrivals: np.ndarray
    moved: np.ndarray
    lanes: np.ndarray


def places(size: int) -> list[Place]:
    """The places of so many threads."""
    shared = np.zeros(1, np.int64), np.zeros(LINE * size)
    return [Place(k, size, *shared, aligned(LANES)) for k in range(size)]


class Threads(ThreadPoolExecutor):
    """A pool of threads, each with a Place in `places`."""

    def __init__(self, size: int):
        super().__init__(size)
        self.places = places(size)

    def together(self, function, *arguments):
        """What a kernel returns that all threads run, each with its Place."""
        first, *_ = self.map(function, *map(repeat, arguments), self.places)
        return first


def share_of(thread, count):
    """First and last (excluded) of `count` items for a thread."""
    return thread.number * count // thread.size, (thread.number + 1) * count // thread.size


def move_patch(world, kick, dt, patch, limit):
    """`drift` of a patch; returns its largest squared displacement (m2) since the lists were made,
    0 if none is above `limit`."""
    constituents, granules, held = world.constituents, world.granules, world.held
    if world.base.grip.shape[0] > 0:
        low, high = granules_of(granules.angle.shape[0], patch)
        given = world.base, granules, constituents, world.gravity, world.account
        rub_granules(*given, kick, low, high)
    given = world.boundaries.motion, world.gravity, world.account, kick, dt, limit, patch
    beyond = drift(granules, constituents, held, *given)
    return farthest_of(constituents, patch) if beyond > 0 else 0.0


STEPS, DRIFT = range(RESPOND + 1, RESPOND + 3)  # tasks beside FORCES, SHOW and RESPOND


def advance(world, task, kick, dt, steps, limit, rows, thread):
    """What a bed is asked for, in one kernel, so that its parts are compiled once.

    STEPS: take up to `steps` steps of dt (s); stop when a constituent has moved farther than `limit`
    (m). DRIFT: kick and move all bodies, without forces. FORCES: at the present positions, over
    a step dt. SHOW, RESPOND: see dem.dynamics.forces.contact_forces, of the blocks from `steps` on.

    kick (s): of the first step, what the step before has left of its own and half of this one. A
    kick of dt goes on as if there had been no call. Returns the number of steps done and the
    largest displacement (m); granules count as 0 up to `limit`. Half a step of kicks is
    then still to come.

    A patch moves as soon as this thread knows all forces on it, while they are in the cache. The
    other patches wait until all threads have done their pairs.
    """
    patches, boundaries, constituents = world.patches, world.boundaries, world.constituents
    lanes, blocks = thread.lanes, world.contacts.first
    begin, end = share_of(thread, patches.lowest.shape[0])
    squared, done, further = limit * limit, 0, 0.0
    granules = world.granules.angle.shape[0]
    if task in (SHOW, RESPOND):
        contact_forces(world, task, steps, steps + rows.shape[0], 0.0, lanes, rows)
        return 0, 0.0
    while True:
        # Kick and drift: boundaries, then the patches that wait for them
        if task != FORCES:
            if thread.number == 0:
                if world.base.grip.shape[0] > 0:
                    rub_boundaries(world.base, boundaries, kick)
                move_boundaries(boundaries, constituents, world.account, kick, dt)
                walls, solids = boundaries_moved(boundaries)
                further = greater(further, greater(walls, solids))
            barrier(thread.arrivals, thread.size)
            for patch in range(begin, end):
                if done == 0 or not knows_forces(patches.lowest, patch, begin):
                    further = greater(further, move_patch(world, kick, dt, patch, squared))
            if thread.size > 1:  # all threads know the largest displacement
                thread.moved[LINE * thread.number] = further
                barrier(thread.arrivals, thread.size)
                for member in range(thread.size):
                    further = greater(further, thread.moved[LINE * member])
            if task == DRIFT:
                return 0, 0.0
        elif COMPOSED:
            place(world.granules.motion, constituents, 0, granules, 0.0)
        moved = further
        done += 1
        last = done >= steps or not moved <= squared
        if LEDGER:
            integrate_account(world.account, kick)
        kick, further = dt, 0.0
        # Forces of pairs, and the next drift of patches that know all of theirs
        for patch in range(begin, end):
            low, high = world.contacts.of_patch[patch], world.contacts.of_patch[patch + 1]
            clear_patch(constituents, patch)
            contact_forces(world, FORCES, low, high, dt, lanes, rows)
            if knows_forces(patches.lowest, patch, begin):
                add_forces_across_patches(constituents, patches, patch)
                if not last:
                    further = greater(further, move_patch(world, kick, dt, patch, squared))
        barrier(thread.arrivals, thread.size)
        # Forces of pairs of two patches, then of boundaries
        for patch in range(begin, end):
            if not knows_forces(patches.lowest, patch, begin):
                add_forces_across_patches(constituents, patches, patch)
        barrier(thread.arrivals, thread.size)
        if thread.number == 0:
            clear_boundaries(boundaries)
            contact_forces(world, FORCES, blocks[WALLS], blocks[SECTIONS], dt, lanes, rows)
            sum_held_forces(constituents, world.held, boundaries)
        if last:
            if COMPOSED and task == FORCES:
                collect(world.granules.force, constituents, 0, granules)
            return done, math.sqrt(moved)
