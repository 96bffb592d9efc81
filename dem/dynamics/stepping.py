"""Many steps in one call: choose the time step, rebuild lists, check limits, take measurements."""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numba.extending import overload

from dem.dynamics.boundaries import move_boundaries, surface_moved
from dem.dynamics.diagnostics import Diagnostics, diagnose, kinetic, touch
from dem.dynamics.forces import forces
from dem.dynamics.integration import advance, drift, look_ahead
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.dynamics.skin import MARGIN
from dem.dynamics.world import Boundaries, Surface, World
from dem.jit.address import by_address
from dem.jit.block_memory import Lanes
from dem.jit.columns import X, Y
from dem.jit.compilation import INLINED, compiled, inlined
from dem.jit.optional import either, optional

FINE, LOST, TOO_DEEP, OUTSIDE, TOO_LONG, COLLAPSED, UNSTABLE, PAUSED = range(8)
MOST_STEPS = 1e11  # an hour or more for two granules, weeks for a bed of hundreds
MOST_WORK = 4e8  # steps times granules, once the step has collapsed: less than a minute
SURVEY = 20  # steps that take as long as a survey, roughly
OFTEN = 1000  # steps without a survey, at most
QUIET = 2000  # steps for which the bound must have allowed a longer step before it is taken
RUNGS = 8  # steps of the ladder to a factor of two
NEARLY = 1e-9  # of a step: a time is reached that is no farther off


class StepControl(NamedTuple):
    """How the time step is chosen, and when lists are rebuilt or a run stops.

    time_step (s): fixed, or 0 for a rung of the ladder below the bound. max_overlap: over the smaller
    radius. reach (m): displacement of a constituent that stops the run, because a contact may have been
    missed; lists are rebuilt before. flies: whether no step is shortened for fast granules, and a fixed one may
    be longer than the critical one. frame (2,): velocity (m/s) that is taken off all. collapsed (s): a step below has collapsed
    (dem.dynamics.assembly.least_step); 0 where the step is fixed.
    """

    time_step: float
    max_overlap: float
    reach: float
    flies: bool
    frame: tuple[float, float]
    collapsed: float


class Schedule(NamedTuple):
    """`intervals` intervals of `interval` (s) after the time `begin` (s).

    until (s): end of the whole run, used only to refuse more than MOST_STEPS steps. starts: whether
    lists and forces are still to be made. looks: whether nothing is done but to return a copy of the
    world at the time `begin`, surveyed. budget: steps after which the call returns, if need
    be inside an interval, so that Python can answer an interrupt. calls (1,): how many calls have begun.
    """

    begin: float
    interval: float
    intervals: int
    until: float
    starts: bool
    looks: bool
    budget: int
    calls: np.ndarray


class Progress(NamedTuple):
    """How a run went: FINE, PAUSED or why it stopped, with the value and the granule that say so (moved
    distance, overlap or time step); seen (s): the time that was asked for, or that of the last step
    where it is not reached; time (s) and steps since the start of the simulation, of the last whole
    step, which is not later than that; intervals done; shortest time step (s); the last Diagnostics; calls
    begun with this one.

    What the next call goes on from: the time step dt (s), taken `taken` times since the time `begun` (s);
    owed (s): kicks that velocities lack at `time`; surveyed: step of the last survey, -1 if one is due; least
    (s): rung that has been allowed since step `since`, inf if it is the one taken; pace (s): shortest step of the
    interval.
    """

    outcome: int
    value: float
    granule: int
    seen: float
    time: float
    steps: int
    intervals: int
    shortest: float
    diagnostics: Diagnostics
    calls: int
    dt: float
    taken: int
    begun: float
    owed: float
    surveyed: int
    least: float
    since: int
    pace: float


NOTHING_DONE = Progress(
    FINE, 0.0, -1, 0.0, 0.0, 0, 0, math.inf, Diagnostics(0.0, 0.0, 0.0, 0.0, 0, 0.0, 0.0), 0,
    0.0, 0, 0.0, 0.0, -1, math.inf, 0, math.inf,
)  # fmt: skip


@compiled
def rung(step):
    """The longest step (s) of the ladder up to one (s): its powers of two, and seven between each."""
    return 2.0 ** (math.floor(RUNGS * math.log2(step) + NEARLY) / RUNGS)


@inlined
def longest_step(rules, diagnostics):
    """The step (s) that a survey asks for: by stiffness, and short enough that nothing flies past the lists."""
    if rules.time_step > 0.0:
        return rules.time_step
    flight = 0.5 * rules.reach / max(diagnostics.speed_bound, 1e-300)
    bound = diagnostics.longest_time_step
    return rung(bound if rules.flies else min(bound, flight))


@inlined
def within(ahead, dt):
    """A time (s) from a step on, none if it is only rounding."""
    return ahead if abs(ahead) > NEARLY * dt else 0.0


@inlined
def rebuild_at(rules, dt, diagnostics):
    """Displacement (m) from which on a step of dt (s) could lead beyond the lists."""
    near = rules.reach - dt * diagnostics.speed_bound
    return min(max(near, (1.0 - MARGIN) * rules.reach), MARGIN * rules.reach)


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
def measure(row, sums, rate, boundaries, walls):
    """What a row of the record says of boundaries; sums: those that go on, of which that is taken off."""
    motion, found = boundaries.motion, boundaries.sums
    for b in range(sums.shape[0]):
        at = OF_BED + OF_BOUNDARY * b
        for c in range(PLACE):
            row[at + c] = found[b, c] * rate
            sums[b, c] -= found[b, c]
        row[at + PLACE], row[at + PLACE + 1] = motion[b, X], motion[b, Y]
    put_offsets(walls, row)


@optional
def copied(array):
    return array.copy()


@optional
def copied_walls(walls):
    return Surface(walls.first, walls.end, walls.planes.copy(), walls.radius, walls.contacts)


@compiled(allocates=True)
def look(world, owed, ahead):
    """A world at a time `ahead` (s) after the positions of this one, which stays as it is; owed: see
    dem.dynamics.integration.look_ahead. Lists and what contacts remember are shared."""
    b, bodies, lanes = world.boundaries, world.bodies.copy(), world.lanes
    alone = world.constituents.shape[0] == world.bodies.shape[0]
    rows = bodies if alone else world.constituents.copy()  # one array where a granule is its own
    boundaries = Boundaries(
        b.motion.copy(), b.reference, b.force, b.loads, b.sums.copy(), b.last.copy(), b.clock.copy(),
        b.first, b.table, b.drive,
    )  # fmt: skip
    seen = World(
        world.shape, bodies, world.angle.copy(), copied(world.frame), world.inverse_mass,
        world.inverse_inertia, world.force, rows, world.constituent_force, world.reference,
        copied(world.last), world.pairs, boundaries, copied_walls(world.walls), world.cylinder,
        world.gravity, Lanes(lanes.motion, lanes.values, copied(lanes.account)), world.patches, world.held,
    )  # fmt: skip
    look_ahead(by_address(seen), owed, ahead)
    return seen


def step_on(threads, world, kick, dt, steps, rebuild_at):
    """dem.dynamics.integration.advance, by several threads or alone."""
    return threads.advance(world, kick, dt, steps, rebuild_at)


@overload(step_on, jit_options=INLINED)
def _step_alone(threads, world, kick, dt, steps, rebuild_at):
    return lambda threads, world, kick, dt, steps, rebuild_at: advance(
        world, kick, dt, steps, rebuild_at, None
    )


def diagnose_on(threads, world, table, later, frame):
    """dem.dynamics.diagnostics.diagnose, by several threads or alone."""
    return threads.diagnose(world, table, later, frame)


@overload(diagnose_on, jit_options=INLINED)
def _diagnose_alone(threads, world, table, later, frame):
    return lambda threads, world, table, later, frame: diagnose(world, table, later, frame)


def later(time, steps, dt):
    """Time (s) after some steps, rounded once, as the processor does it in compiled code: the time
    steps of several threads are then those of one."""
    return float(Fraction(time) + steps * Fraction(dt))


@overload(later, jit_options=INLINED)
def _later(time, steps, dt):
    return lambda time, steps, dt: time + steps * dt


@compiled(allocates=True)
def run_steps(world, table, rules, schedule, before, record, threads):
    """Advance as a Schedule says; returns the world and a Progress.

    before: the Progress of the call before, which this one goes on from. record: an array with one row per
    interval, or none of it. threads: None, or those that take the steps and survey the bed
    (dem.dynamics.threads.Threads; this function then runs as it is here, uncompiled).

    Steps are whole: no interval cuts one, and what lies within a step is seen by `look`. The step is chosen
    where the lists are made, and every OFTEN steps: down at once, up once the bound has allowed it for QUIET
    steps. A step that follows its bound closely would be long on the way into a contact and short on the way
    out, and heat the bed. Bits do not depend on where intervals and calls end.
    """
    begin, interval, intervals, until, starts, looks, budget, calls = schedule
    calls[0] += 1
    outcome, value, granule = FINE, 0.0, -1
    time, steps, n, diagnostics = before.time, before.steps, 0, before.diagnostics
    dt, taken, begun, owed = before.dt, before.taken, before.begun, before.owed
    surveyed, least, since = before.surveyed, before.least, before.since
    shortest, pace = math.inf, dt if dt > 0.0 else math.inf
    if before.outcome == PAUSED:
        n, shortest, pace = before.intervals, before.shortest, before.pace
    table = by_address(table)
    if looks:
        world = look(world, owed, begin - time)
        diagnostics = diagnose_on(threads, by_address(world), table, 0.0, rules.frame)
    if starts:
        world = rebuild_neighbor_list(world, table)
        forces(world, 0.0, math.inf)
        move_boundaries(by_address(world), 0.0, 0.0)  # accelerations before are those of now
        drift(by_address(world), 0.0, 0.0, 0, world.bodies.shape[0])
        granule = outside(world.walls, world.bodies)
    while not looks:
        here = by_address(world)
        if granule >= 0:
            outcome = OUTSIDE
            break
        if surveyed < 0:
            diagnostics = diagnose_on(threads, here, table, owed, rules.frame)
            budget, surveyed = budget - SURVEY, steps
            asked, former = longest_step(rules, diagnostics), dt
            if dt == 0.0 or not asked > dt:
                dt, least, since = asked, math.inf, steps
            else:
                least = min(least, asked)
                if steps - since >= QUIET:
                    dt, least, since = least, math.inf, steps
            if dt != former:
                begun, taken = time, 0
                pace = min(pace, dt)
        if n < intervals and not diagnostics.max_overlap <= rules.max_overlap:
            outcome, value, granule = TOO_DEEP, diagnostics.max_overlap, diagnostics.deepest
            break
        if rules.time_step > diagnostics.critical_time_step and not rules.flies:
            outcome, value = UNSTABLE, diagnostics.critical_time_step
            break
        ends = begin + (n + 1) * interval
        if not max(until, ends) - time <= MOST_STEPS * dt:
            outcome, value = TOO_LONG, dt
            break
        work = (max(until, ends) - time) * here.bodies.shape[0]
        if dt < rules.collapsed and work > MOST_WORK * dt:
            outcome, value = COLLAPSED, dt
            break
        ahead = math.floor((ends - time) / dt + NEARLY) if n < intervals else 0
        if ahead <= 0:
            if n < record.shape[0] and n < intervals:
                seen = look(world, owed, within(ends - time, dt))
                row = record[n]  # `seen` is freed after its last use, whatever has its address
                row[ENERGY] = kinetic(by_address(seen), 0.0, rules.frame)[0]
                row[CONTACTS], row[OVERLAP] = touch(seen, table)
                row[STEP] = pace
                measure(row, here.boundaries.sums, 1.0 / interval, seen.boundaries, seen.walls)
                budget -= 1
            shortest, pace = min(shortest, pace), dt
            n += 1
            if n >= intervals:
                break
            continue
        if budget <= 0:
            outcome = PAUSED
            break
        some = min(ahead, budget, surveyed + OFTEN - steps)
        kick, limit = owed + 0.5 * dt, rebuild_at(rules, dt, diagnostics)
        done, moved = step_on(threads, here, kick, dt, some, limit)
        owed = 0.5 * dt
        steps, taken, budget = steps + done, taken + done, budget - done
        time = later(begun, taken, dt)
        if steps - surveyed >= OFTEN:
            surveyed = -1
        if not moved <= limit:
            granule = outside(here.walls, here.bodies)
            if not (moved <= rules.reach or nearing(here) <= 2.0 * rules.reach):
                outcome, value = LOST, moved
                break
            world = rebuild_neighbor_list(world, table)  # by value: what it replaces must live on
            budget, surveyed = budget - SURVEY, -1
    reached = begin + intervals * interval if outcome == FINE else max(begin, time)
    return world, Progress(
        outcome, value, granule, time + within(reached - time, dt), time, steps, n, shortest, diagnostics, calls[0],
        dt, taken, begun, owed, surveyed, least, since, pace,
    )  # fmt: skip
