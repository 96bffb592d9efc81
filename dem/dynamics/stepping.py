"""Many steps in one call: choose the time step, rebuild lists, check limits, take measurements."""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numba.extending import overload

from dem.dynamics.boundaries import surface_moved
from dem.dynamics.diagnostics import Diagnostics, diagnose
from dem.dynamics.forces import forces
from dem.dynamics.integration import PAUSES, RESUMES, advance
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.jit.address import by_address
from dem.jit.columns import X, Y
from dem.jit.compilation import INLINED, compiled, inlined
from dem.jit.optional import either, optional

FINE, LOST, TOO_DEEP, OUTSIDE, TOO_LONG, COLLAPSED, PAUSED = range(7)
MOST_STEPS = 1e11  # an hour or more for two granules, weeks for a bed of hundreds
MOST_WORK = 4e8  # steps times granules, once the step has collapsed: less than a minute
SURVEY = 20  # steps that take as long as a survey, roughly


class StepControl(NamedTuple):
    """How the time step is chosen, and when lists are rebuilt or a run stops.

    time_step (s): fixed, or 0 for `fraction` of the critical one, less if a granule would move
    farther than `largest_motion` (m) in it. max_overlap: over the smaller radius. rebuild_at (m):
    displacement of a constituent that triggers a rebuild of the lists; list_range (m): displacement
    that stops the run, because a contact may have been missed. collapsed (s): a step below has
    collapsed (dem.dynamics.assembly.least_step); 0 where the step is fixed.
    """

    time_step: float
    fraction: float
    largest_motion: float
    max_overlap: float
    rebuild_at: float
    list_range: float
    collapsed: float


class Schedule(NamedTuple):
    """`intervals` intervals of `interval` (s).

    until (s): end of the whole run, used only to refuse more than MOST_STEPS steps. starts: whether
    lists and forces are still to be made. budget: steps after which the call returns, if need be
    inside an interval, so that Python can answer an interrupt; 0 only ends a pause there. calls (1,): how
    many calls have begun.
    """

    interval: float
    intervals: int
    until: float
    starts: bool
    budget: int
    calls: np.ndarray


class StepOutcome(NamedTuple):
    """How a run went: FINE, PAUSED or why it stopped, with the value and the granule that say so (moved
    distance, overlap or time step); time (s) and steps since the start of the simulation; intervals
    done; shortest time step (s); the last Diagnostics that were made; calls begun with this one.

    What a paused call goes on from: the time step dt (s) was chosen at the time `chosen` (s) for the
    `left` steps to the `end` (s) of the interval, of which `taken` are taken; finished: whether the
    last interval is, and not measured yet; least (s): shortest step of the interval; until (s): end of
    the whole run.
    """

    outcome: int
    value: float
    granule: int
    time: float
    steps: int
    intervals: int
    shortest: float
    diagnostics: Diagnostics
    calls: int
    chosen: float
    dt: float
    left: int
    taken: int
    end: float
    finished: bool
    least: float
    until: float


NOTHING_DONE = StepOutcome(
    FINE, 0.0, -1, 0.0, 0, 0, math.inf, Diagnostics(0.0, 0.0, 0.0, 0.0, 0, 0.0), 0,
    0.0, 0.0, 0, 0, 0.0, False, math.inf, 0.0,
)  # fmt: skip


@inlined
def longest_step(rules, diagnostics):
    if rules.time_step > 0.0:
        return rules.time_step
    largest_motion = rules.largest_motion / max(diagnostics.speed_bound, 1e-300)
    return min(rules.fraction * diagnostics.critical_time_step, largest_motion)


@optional
def behind(walls, bodies):
    """The first granule whose centre is behind a wall, or -1."""
    for i in range(bodies.shape[0]):
        for k in range(walls.planes.shape[0]):
            here = bodies[i, X] * walls.planes[k, 0] + bodies[i, Y] * walls.planes[k, 1]
            if here > walls.planes[k, 2]:
                return i
    return -1


@compiled
def outside(walls, bodies):
    """`behind` of walls, if there are any; a kernel, because `run_steps` calls it uncompiled too."""
    return either(behind(walls, bodies), -1)


@compiled
def nearing(world):
    """Most by which two bodies can have come nearer since the lists were made (m)."""
    one = math.sqrt(either(surface_moved(world.cylinder, world.boundaries), 0.0))
    other = math.sqrt(either(surface_moved(world.walls, world.boundaries), 0.0))
    first, second = max(one, other), min(one, other)
    motion, reference = world.constituents, world.reference
    for i in range(motion.shape[0]):
        dx = motion[i, X] - reference[i, 0]
        dy = motion[i, Y] - reference[i, 1]
        moved = math.sqrt(dx * dx + dy * dy)
        if not moved <= first:
            first, second = moved, first
        elif moved > second:
            second = moved
    return first + second


# Columns of a record: of the bed; then of each boundary, Boundaries.sums over the interval and its place
ENERGY, CONTACTS, OVERLAP, STEP, OF_BED = range(5)
PLACE, OF_BOUNDARY = 5, 7


@optional
def put_offsets(walls, row):
    """The place of a wall is its offset (m)."""
    for k in range(walls.planes.shape[0]):
        row[OF_BED + OF_BOUNDARY * k + PLACE] = walls.planes[k, 2]


@inlined
def measure(record, n, world, diagnostics, interval, shortest):
    """Row n of the record, see Simulation.record; all sums go back to zero."""
    row, sums, motion = record[n], world.boundaries.sums, world.boundaries.motion
    row[ENERGY], row[CONTACTS] = diagnostics.kinetic_energy, diagnostics.coordination_number
    row[OVERLAP], row[STEP] = diagnostics.max_overlap, shortest
    rate = 1.0 / interval
    for b in range(sums.shape[0]):
        at = OF_BED + OF_BOUNDARY * b
        for c in range(PLACE):
            row[at + c] = sums[b, c] * rate
            sums[b, c] = 0.0
        row[at + PLACE], row[at + PLACE + 1] = motion[b, X], motion[b, Y]
    put_offsets(world.walls, row)


def step_on(threads, world, dt, steps, rebuild_at, how):
    """dem.dynamics.integration.advance, by several threads or alone."""
    return threads.advance(world, dt, steps, rebuild_at, how)


@overload(step_on, jit_options=INLINED)
def _step_alone(threads, world, dt, steps, rebuild_at, how):
    return lambda threads, world, dt, steps, rebuild_at, how: advance(
        world, dt, steps, rebuild_at, how, None
    )


def diagnose_on(threads, world, table):
    """dem.dynamics.diagnostics.diagnose, by several threads or alone."""
    return threads.diagnose(world, table)


@overload(diagnose_on, jit_options=INLINED)
def _diagnose_alone(threads, world, table):
    return lambda threads, world, table: diagnose(world, table)


def later(time, steps, dt):
    """Time (s) after some steps, rounded once, as the processor does it in compiled code: the time
    steps of several threads are then those of one."""
    return float(Fraction(time) + steps * Fraction(dt))


@overload(later, jit_options=INLINED)
def _later(time, steps, dt):
    return lambda time, steps, dt: time + steps * dt


@compiled(allocates=True)
def run_steps(world, table, rules, schedule, before, record, threads):
    """Advance as a Schedule says; returns the world and a StepOutcome.

    before: the StepOutcome of the call before; one that paused goes on where that one was. record: an
    array with one row per interval, or none of it. threads: None, or those that take the
    steps and survey the bed (dem.dynamics.threads.Threads; this function then runs as it is here, uncompiled). The
    step is chosen at the start of each interval and whenever the lists are rebuilt. Bits do not depend on
    where a call pauses.
    """
    interval, intervals, until, starts, budget, calls = schedule
    calls[0] += 1
    outcome, value, granule = FINE, 0.0, -1
    time, steps, diagnostics = before.time, before.steps, before.diagnostics
    n, shortest, least, finished = 0, math.inf, math.inf, False
    chosen, dt, left, taken, end = time, 0.0, 0, 0, time + interval
    if before.outcome == PAUSED:
        n, shortest, least, finished = (
            before.intervals, before.shortest, before.least, before.finished
        )  # fmt: skip
        chosen, dt, left, taken = before.chosen, before.dt, before.left, before.taken
        end, until = before.end, before.until
    else:
        until = max(until, time + intervals * interval)
    table = by_address(table)
    if starts:
        world = rebuild_neighbor_list(world, table)
        forces(world, 0.0, math.inf)
        granule = outside(world.walls, world.bodies)
    while True:
        here = by_address(world)
        if granule >= 0:
            outcome = OUTSIDE
            break
        if taken == left:
            if budget <= 0:
                outcome = PAUSED
                break
            last = finished and n + 1 == intervals
            if not last or n < record.shape[0]:  # after the last interval only a record asks
                diagnostics = diagnose_on(threads, here, table)
                budget -= SURVEY
            if finished:
                if n < record.shape[0]:
                    measure(record, n, here, diagnostics, interval, least)
                shortest = min(shortest, least)
                n, end, least = n + 1, time + interval, math.inf
            if n == intervals:
                break
            if not diagnostics.max_overlap <= rules.max_overlap:
                outcome, value, granule = TOO_DEEP, diagnostics.max_overlap, diagnostics.deepest
                break
            longest = longest_step(rules, diagnostics)
            if not until - time <= MOST_STEPS * longest:
                outcome, value = TOO_LONG, longest
                break
            work = (until - time) * here.bodies.shape[0]
            if longest < rules.collapsed and work > MOST_WORK * longest:
                outcome, value = COLLAPSED, longest
                break
            left = max(1, math.ceil((end - time) / longest * (1.0 - 1e-9)))
            dt = (end - time) / left
            least = min(least, dt)
            chosen, taken, finished = time, 0, False
            budget = max(budget, 1)
        some = min(left - taken, budget)
        how = (RESUMES if taken > 0 else 0) + (PAUSES if some < left - taken else 0)
        done, moved = step_on(threads, here, dt, some, rules.rebuild_at, how)
        if some == 0:  # the pause is over
            left = taken
            break
        steps += done
        taken += done
        budget -= done
        finished = taken == left
        time = end if finished else later(chosen, taken, dt)
        if not moved <= rules.rebuild_at:
            granule = outside(here.walls, here.bodies)
            left = taken
            if not (moved <= rules.list_range or nearing(here) <= 2.0 * rules.list_range):
                outcome, value = LOST, moved
                break
            world = rebuild_neighbor_list(world, table)  # by value: what it replaces must live on
            budget -= SURVEY
        elif not finished:
            outcome = PAUSED
            break
    return world, StepOutcome(
        outcome, value, granule, time, steps, n, shortest, diagnostics, calls[0],
        chosen, dt, left, taken, end, finished, least, until,
    )  # fmt: skip
