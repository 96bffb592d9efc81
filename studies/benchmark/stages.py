"""Where a step goes: the stages of the kernel, timed by leaving out the later ones.

A bed is held as it is, by a time step that moves nothing, and each part of a step runs many times.
"""

import math
import time
from functools import partial
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import (
    accumulate,
    contact_forces,
    find_contacts,
    gather,
    gather_pairs,
)
from dem.contacts.loops import boundary_contacts
from dem.dynamics.assembly import SKIN, assemble, granule_table
from dem.dynamics.forces import clear, farthest_of
from dem.dynamics.integration import advance, drift
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.dynamics.world import number_of_patches
from dem.jit.address import local
from dem.jit.block_memory import BLOCK
from dem.jit.compilation import compiled
from studies.benchmark.scenes import Case

STILL = 1e-3  # of the time step: nothing moves to speak of, and no list is rebuilt
WARM = 100  # steps


class Wanted(NamedTuple):
    """Stages of a pair that run after its two bodies were copied: True, or None for not."""

    geometry: bool | None = None
    forces: bool | None = None
    sums: bool | None = None


UPTO = {
    "copy both bodies": Wanted(),
    "overlap, normal, velocities": Wanted(True),
    "force law": Wanted(True, True),
    "add to both granules": Wanted(True, True, True),
}


@compiled
def pairs(world, dt, times, parts):
    """The loop of dem.contacts.loops.pair_contacts with the stages that are wanted, for a bed of
    one patch without an energy ledger."""
    shape, contacts, lanes = world.shape, local(world.pairs), world.lanes
    rows, flat = world.constituents.reshape(-1), world.constituent_force.reshape(-1)
    turns, count = world.inverse_inertia, contacts.constituent.shape[0]
    for _ in range(times):
        for start in range(0, count, BLOCK):
            stop = min(start + BLOCK, count)
            gather(turns, rows, rows, contacts, start, stop, lanes)
            gather_pairs(shape, world.orientation, contacts, start, stop, lanes.values)
            if parts.geometry is not None:
                find_contacts(shape, turns, contacts, start, stop, lanes)
            if parts.forces is not None:
                contact_forces(
                    contacts.friction, shape, None, turns, contacts, start, stop, dt, lanes
                )
            if parts.sums is not None:
                accumulate(contacts, start, stop, lanes.values, turns, flat)


@compiled
def boundaries(world, dt, times):
    for _ in range(times):
        boundary_contacts(world.walls, world, dt)
        boundary_contacts(world.circles, world, dt)


@compiled
def looks(world, limit, times):
    moved, patches = 0.0, number_of_patches(world.bodies.shape[0])
    for _ in range(times):
        clear(world.constituent_force, 0, world.constituents.shape[0])
        for patch in range(patches):
            moved += farthest_of(world, patch, limit)
    return moved


@compiled
def moves(world, times):
    for _ in range(times):
        drift(world, 0.0, 0.0, 0, world.bodies.shape[0])


@compiled
def roots(numbers, times):
    for _ in range(times):
        for k in range(numbers.shape[0]):
            numbers[k] = math.sqrt(numbers[k])


@compiled
def divisions(numbers, times):
    for _ in range(times):
        for k in range(numbers.shape[0]):
            numbers[k] = 1.0 / numbers[k]


def slow_operations(times: int) -> tuple[float, float]:
    """Time (s) of a square root and of a division, with load and store, a BLOCK side by side."""
    numbers = np.linspace(1.0, 2.0, BLOCK)
    durations = (timed(partial(call, numbers.copy(), times)) for call in (roots, divisions))
    return tuple(spent / times / BLOCK for spent in durations)


def timed(call) -> float:
    started = time.perf_counter()
    call()
    return time.perf_counter() - started


def stage_times(case: Case, times: int) -> dict[str, float]:
    """Time (s) of one step by stage, and of the whole step; the mean of a number of `times`."""
    table, dt = granule_table(case.scene, SKIN), STILL * case.time_step
    world = assemble(case.scene, case.state.checked(case.scene.granules), table)
    world = rebuild_neighbor_list(world, table)
    advance(world, dt, dt, WARM, math.inf, None)
    calls = {name: partial(pairs, world, dt, times, parts) for name, parts in UPTO.items()}
    calls["walls and cylinder"] = partial(boundaries, world, dt, times)
    calls["clear forces, look for the farthest"] = partial(looks, world, math.inf, times)
    calls["move"] = partial(moves, world, times)
    calls["whole step"] = partial(advance, world, dt, dt, times, math.inf, None)
    spent = {name: timed(call) / times for name, call in calls.items()}
    upto = [spent[name] for name in UPTO]
    return spent | dict(zip(UPTO, np.diff(upto, prepend=0.0), strict=True))
