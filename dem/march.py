"""Many steps in one call: the time step chosen, lists kept, guards watched, measurements taken."""

import math
from typing import NamedTuple

from dem.columns import X, Y
from dem.compilation import compiled, inlined
from dem.integrate import advance
from dem.listing import relist
from dem.optional import optional
from dem.survey import expected_speed, look

FINE, LOST, TOO_DEEP, OUTSIDE = range(4)


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
    distance or overlap); time (s); steps and intervals done; shortest time step (s)."""

    outcome: int
    value: float
    granule: int
    time: float
    steps: int
    intervals: int
    shortest: float


@inlined
def longest_step(world, parts, rules, glance):
    if rules.time_step > 0.0:
        return rules.time_step
    speed = max(expected_speed(world, parts, glance.fastest), 1e-300)
    return min(rules.fraction * glance.critical_time_step, rules.flight / speed)


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


@optional
def take_impulses(barrier, row, at, interval):
    """Mean forces (N) on walls or cylinder into row[at] ..., their sums back to zero."""
    for k in range(barrier.impulse.shape[0]):
        row[at + k] = barrier.impulse[k] / interval
        barrier.impulse[k] = 0.0


@optional
def measure(record, n, world, glance, interval, shortest):
    """Row n of the record: see Simulation.record."""
    row = record[n]
    row[0], row[1] = glance.kinetic_energy, glance.coordination_number
    row[2], row[3] = glance.max_overlap, shortest
    take_impulses(world.roller, row, 4, interval)
    take_impulses(world.walls, row, 8, interval)


@compiled
def march(world, parts, rules, time, interval, intervals, record):
    """Advance over a number of equal intervals (s); returns the world and a Report.

    record: an array with a row for each interval, or None. The step is chosen at the start of
    each interval and whenever the contacts are listed anew.
    """
    steps, shortest = 0, math.inf
    glance = look(world, parts)
    for n in range(intervals):
        end, least = time + interval, math.inf
        while time < end:
            if not glance.max_overlap <= rules.max_overlap:
                stop = Report(
                    TOO_DEEP, glance.max_overlap, glance.deepest, time, steps, n, shortest
                )
                return world, stop
            longest = longest_step(world, parts, rules, glance)
            left = max(1, math.ceil((end - time) / longest * (1.0 - 1e-9)))
            dt = (end - time) / left
            least = min(least, dt)
            done, moved = advance(world, dt, left, rules.room)
            steps += done
            time = end if done == left else time + done * dt
            if not moved <= rules.room:
                if not moved <= rules.reach:
                    return world, Report(LOST, moved, -1, time, steps, n, shortest)
                lost = outside(world.walls, world.bodies)
                if lost >= 0:
                    return world, Report(OUTSIDE, moved, lost, time, steps, n, shortest)
                world = relist(world, parts)
                glance = look(world, parts)
        shortest = min(shortest, least)
        glance = look(world, parts)
        measure(record, n, world, glance, interval, least)
    return world, Report(FINE, 0.0, -1, time, steps, intervals, shortest)
