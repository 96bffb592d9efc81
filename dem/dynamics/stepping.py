"""Many steps in one call: the time step chosen, lists kept, guards watched, measurements taken."""

import math
from typing import NamedTuple

from numba.extending import overload

from dem.jit.columns import X, Y
from dem.jit.compilation import INLINED, compiled, inlined
from dem.dynamics.integration import advance
from dem.dynamics.neighbor_list import relist
from dem.jit.optional import optional
from dem.dynamics.diagnostics import look

FINE, LOST, TOO_DEEP, OUTSIDE, TOO_LONG = range(5)
MOST_STEPS = 1e11  # an hour or more for two granules, weeks for a bed of hundreds


class Rules(NamedTuple):
    """time_step (s): fixed, or 0 to take `fraction` of the critical one, less where a granule would
    move farther than `flight` (m) in it. max_overlap over the smaller radius. room (m): lists are
    made anew when a part has moved as far; reach (m): it must not have moved farther than this.
    """

    time_step: float
    fraction: float
    flight: float
    max_overlap: float
    room: float
    reach: float


class Report(NamedTuple):
    """How a march went: FINE or why it stopped, with the value and the granule that say so (moved
    distance, overlap or time step); time (s); steps and intervals done; shortest time step (s)."""

    outcome: int
    value: float
    granule: int
    time: float
    steps: int
    intervals: int
    shortest: float


@inlined
def longest_step(rules, glance):
    if rules.time_step > 0.0:
        return rules.time_step
    flight = rules.flight / max(glance.fastest, 1e-300)
    return min(rules.fraction * glance.critical_time_step, flight)


@compiled
def outside(walls, bodies):
    """A granule whose centre is behind a wall, or -1."""
    if walls is None:
        return -1
    for i in range(bodies.shape[0]):
        for k in range(walls.planes.shape[0]):
            here = bodies[i, X] * walls.planes[k, 0] + bodies[i, Y] * walls.planes[k, 1]
            if here > walls.planes[k, 2]:
                return i
    return -1


@compiled
def nearing(world):
    """Most by which two bodies can have come nearer since the lists were made (m)."""
    first, second = displacement(world.roller), 0.0
    for i in range(world.parts.shape[0]):
        dx = world.parts[i, X] - world.reference[i, 0]
        dy = world.parts[i, Y] - world.reference[i, 1]
        moved = math.sqrt(dx * dx + dy * dy)
        if not moved <= first:
            first, second = moved, first
        elif moved > second:
            second = moved
    return first + second


@compiled
def displacement(roller):
    """How far the cylinder has moved since the lists were made (m)."""
    if roller is None:
        return 0.0
    dx = roller.motion[0, X] - roller.reference[0]
    dy = roller.motion[0, Y] - roller.reference[1]
    return math.sqrt(dx * dx + dy * dy)


@optional
def take_impulses(barrier, row, at, interval):
    """Mean forces (N) on walls or cylinder into row[at] ..., their sums back to zero."""
    rate = 1.0 / interval
    for k in range(barrier.impulse.shape[0]):
        row[at + k] = barrier.impulse[k] * rate
        barrier.impulse[k] = 0.0


@optional
def measure(record, n, roller, walls, glance, interval, shortest):
    """Row n of the record: see Simulation.record."""
    row = record[n]
    row[0], row[1] = glance.kinetic_energy, glance.coordination_number
    row[2], row[3] = glance.max_overlap, shortest
    take_impulses(roller, row, 4, interval)
    take_impulses(walls, row, 8, interval)


def step_on(crew, world, dt, steps, room):
    """dem.dynamics.integration.advance, by a crew of threads or alone."""
    return crew.advance(world, dt, steps, room)


@overload(step_on, jit_options=INLINED)
def _step_alone(crew, world, dt, steps, room):
    return lambda crew, world, dt, steps, room: advance(world, dt, steps, room, None)


@compiled(allocates=True)
def march(world, parts, rules, time, interval, intervals, until, record, crew):
    """Advance over a number of equal intervals (s); returns the world and a Report.

    until (s): the time to which the caller will go on, if that is later; more than MOST_STEPS to
    there, at any step that is chosen, are not begun. record: an array with a row for each interval,
    or None. crew: None, or the threads that take
    the steps (dem.dynamics.threads.Crew; this function then runs as it stands here, uncompiled). The step is chosen at the start of
    each interval and whenever the contacts are listed anew.
    """
    outcome, value, granule = FINE, 0.0, -1
    steps, done, n, shortest, least = 0, 0, 0, math.inf, math.inf
    end, finished = time + interval, False
    until = max(until, time + intervals * interval)
    while True:
        glance = look(world, parts)
        if finished:
            measure(record, n, world.roller, world.walls, glance, interval, least)
            shortest = min(shortest, least)
            n, end, least = n + 1, time + interval, math.inf
        if n == intervals:
            break
        if not glance.max_overlap <= rules.max_overlap:
            outcome, value, granule = TOO_DEEP, glance.max_overlap, glance.deepest
            break
        longest = longest_step(rules, glance)
        if not until - time <= MOST_STEPS * longest:
            outcome, value = TOO_LONG, longest
            break
        left = max(1, math.ceil((end - time) / longest * (1.0 - 1e-9)))
        dt = (end - time) / left
        least = min(least, dt)
        done, moved = step_on(crew, world, dt, left, rules.room)
        steps += done
        finished = done == left
        time = end if finished else time + done * dt
        if not moved <= rules.room:
            granule = outside(world.walls, world.bodies)
            if not (moved <= rules.reach or nearing(world) <= 2.0 * rules.reach):
                outcome, value = LOST, moved
                break
            if granule >= 0:
                outcome = OUTSIDE
                break
            world = relist(world, parts)
    return world, Report(outcome, value, granule, time, steps, n, shortest)
