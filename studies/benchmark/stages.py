"""Where a step goes: the stages of the kernel, timed by leaving out the later ones.

A bed is held as it is, by a time step that moves nothing, and each part of a step runs many times.
"""

import math
import time
from functools import partial

import numpy as np

from dem.contacts.geometry import find_pairs, gather
from dem.contacts.layout import BLOCK, NUMBERS
from dem.contacts.response import accumulate, respond
from dem.dynamics.assembly import assemble
from dem.dynamics.forces import FORCES, clear, clear_boundaries, contact_forces
from dem.dynamics.kinds import bound
from dem.dynamics.motion import drift, farthest_of
from dem.dynamics.skin import SKIN, bounded_skin
from dem.dynamics.system import NONE
from dem.dynamics.world import SECTIONS, WALLS, friction_of
from dem.jit.kernel import kernel
from studies.benchmark.scenes import Case

STILL = 1e-3  # of the time step: nothing moves to speak of, and no list is rebuilt
WARM = 100  # steps

# Constants of the kernels
STRIDE = np.uint64(0)
STAGE = 0

STAGES = (  # of a pair, each after those before it
    "copy both bodies",
    "overlap, normal, velocities",
    "force law",
    "add to both granules",
)


def pairs(world, place, dt, times):
    """The loop of dem.dynamics.forces.contact_forces up to a stage."""
    contacts, constituents, shape, law = world.contacts, world.constituents, world.shape, world.law
    motion, turned = constituents.motion.reshape(-1), constituents.orientation.reshape(-1)
    numbers, table, flat = contacts.numbers, contacts.table, constituents.force.reshape(-1)
    pair, lanes = place.pair, place.lanes
    for _ in range(times):
        for block in range(contacts.first[WALLS]):
            at, base = NUMBERS * np.uint64(block), STRIDE * np.uint64(block)
            count = contacts.count[block]
            gather(motion, turned, numbers, table, at, base, count, pair, lanes)
            if STAGE > 0:
                find_pairs(shape, table, base, count, pair, lanes)
            if STAGE > 1:
                respond(
                    law,
                    table,
                    base,
                    contacts.friction,
                    friction_of(contacts, block),
                    count,
                    dt,
                    lanes,
                )
            if STAGE > 2:
                accumulate(numbers, at, count, lanes, flat)


def boundaries(world, place, dt, times, rows):
    blocks, pair, lanes = world.contacts.first, place.pair, place.lanes
    for _ in range(times):
        clear_boundaries(world.boundaries)
        contact_forces(world, FORCES, blocks[WALLS], blocks[SECTIONS], dt, pair, lanes, rows)


def looks(world, place, limit, times):
    moved, constituents = 0.0, world.constituents
    motion, reference = constituents.motion, constituents.reference
    for _ in range(times):
        clear(constituents.force, 0, reference.shape[0])
        moved += farthest_of(motion, reference, 0, reference.shape[0], limit)
    return moved


def moves(world, place, dt, times):
    granules, constituents, held = world.granules, world.constituents, world.held
    moving, gravity, account = world.boundaries.motion, world.gravity, world.account
    for _ in range(times):
        count = granules.angle.shape[0]
        drift(granules, constituents, held, moving, gravity, account, 0.0, 0.0, 0, count)


def roots(numbers, times):
    for _ in range(times):
        for k in range(numbers.shape[0]):
            numbers[k] = math.sqrt(numbers[k])


def divisions(numbers, times):
    for _ in range(times):
        for k in range(numbers.shape[0]):
            numbers[k] = 1.0 / numbers[k]


def slow_operations(times: int) -> tuple[float, float]:
    """Time (s) of a square root and of a division, with load and store, a BLOCK side by side."""
    numbers = np.linspace(1.0, 2.0, BLOCK)
    durations = (
        timed(partial(call, numbers.copy(), times)) for call in map(kernel, (roots, divisions))
    )
    return tuple(spent / times / BLOCK for spent in durations)


def timed(call) -> float:
    started = time.perf_counter()
    call()
    return time.perf_counter() - started


def stage_times(case: Case, times: int) -> dict[str, float]:
    """Time (s) of one step by stage, and of the whole step; the mean of a number of `times`."""
    granules, dt = case.scene.granules, STILL * case.time_step
    system = assemble(case.scene, case.state.checked(granules), np.arange(granules))
    system.rebuild(bounded_skin(case.scene, system.table, SKIN))
    system.advance(dt, dt, WARM, math.inf)
    world, flags, layout = system.world, system.kernels.flags, system.kernels.layout

    def call(function, *given, **constants):
        parts = flags, layout, world.shape, world.outlines, world.law
        return partial(bound(function, *parts, **constants), world, system.place, *given)

    calls = {name: call(pairs, dt, times, STAGE=k) for k, name in enumerate(STAGES)}
    calls["walls and cylinder"] = call(boundaries, dt, times, NONE)
    calls["clear forces, look for the farthest"] = call(looks, math.inf, times)
    calls["move"] = call(moves, dt, times)
    calls["whole step"] = partial(system.advance, dt, dt, times, math.inf)
    spent = {name: timed(call) / times for name, call in calls.items()}
    upto = [spent[name] for name in STAGES]
    return spent | dict(zip(STAGES, np.diff(upto, prepend=0.0), strict=True))
