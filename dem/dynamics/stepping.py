"""Many steps in one call: choose the time step, rebuild lists, check limits, take measurements."""

import math
from itertools import repeat
from typing import NamedTuple

import numpy as np
from numba import literal_unroll

from dem.dynamics.boundary_motion import boundaries_moved, move_boundaries
from dem.dynamics.checkpoint import mapped
from dem.dynamics.contact_output import contact_summary, deeper
from dem.dynamics.diagnostics import Diagnostics, begin_scan, diagnose, end_scan, scan_pairs
from dem.dynamics.energy import kinetic
from dem.dynamics.forces import displaced, forces
from dem.dynamics.integration import advance, drift, look_ahead
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.dynamics.threads import share_of
from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined

FINE, LOST, TOO_DEEP, OUTSIDE, TOO_LONG, UNSTABLE, PAUSED = range(7)
MOST_STEPS = 1e11  # an hour or more for two granules, weeks for a bed of hundreds
COLLAPSE = 1e-3  # of the first step: a shorter one has collapsed
MOST_WORK = 4e8  # steps times granules, once the step has collapsed: less than a minute
SCAN_COST = 20  # steps that take as long as a scan, roughly
SCAN_INTERVAL = 1000  # steps without a scan, at most
QUIET = 2000  # steps for which the bound must have allowed a longer step before it is taken
PER_OCTAVE = 8  # quantised steps to a factor of two
MARGIN = 0.75  # share of skin / 2 that a constituent may move before the lists are rebuilt
NEARLY = 1e-9  # of a step: a time is reached that is no farther off


class StepControl(NamedTuple):
    """How the time step is chosen, and when lists are rebuilt or a run stops.

    Attributes
    ----------
    time_step : float
        Fixed time step (s), or 0 for a quantised step below the bound.
    max_overlap : float
        Largest allowed overlap over the smaller radius, without unit.
    reach : float
        Displacement (m) of a constituent that stops the run, because a contact may have been
        missed; lists are rebuilt before.
    allow_unstable : bool
        Whether no step is shortened for fast granules, and a fixed one may be longer than the
        critical one.
    frame : tuple of float
        Velocity (m/s) that is taken off all.
    """

    time_step: float
    max_overlap: float
    reach: float
    allow_unstable: bool
    frame: tuple[float, float]


class Schedule(NamedTuple):
    """What a call of run_steps does.

    Attributes
    ----------
    begin, interval : float
        It advances over intervals of a length (s) after the time `begin` (s).
    intervals : int
        Number of intervals.
    until : float
        End of the whole run (s), used only to refuse too many steps.
    initialise : bool
        Whether lists and forces are still to be made.
    observe_only : bool
        Whether nothing is done but to return a copy of the world at the time `begin`, and its
        Diagnostics.
    budget : int
        Steps after which the call returns, if need be inside an interval, so that Python can answer
        Ctrl-C.
    """

    begin: float = 0.0
    interval: float = 0.0
    intervals: int = 0
    until: float = 0.0
    initialise: bool = False
    observe_only: bool = False
    budget: int = 0


class Progress(NamedTuple):
    """How a run went, and what the next call goes on from; by default, that nothing is done.

    Attributes
    ----------
    outcome : int
        FINE, PAUSED or why the run stopped.
    value : float
        What says so: moved distance (m), overlap or time step (s).
    granule : int
        Granule that says so.
    seen : float
        The time (s) that was asked for, or that of the last step where it is not reached.
    time : float
        Time (s) of the last whole step, which is not later than `seen`.
    steps : int
        Whole steps since the start.
    intervals : int
        Intervals done.
    shortest : float
        Shortest time step (s).
    diagnostics : Diagnostics
        Of the last scan.
    dt : float
        Time step (s).
    first_dt : float
        The first time step (s).
    dt_since : float
        Time (s) since which dt is taken.
    steps_at_dt : int
        Steps since then.
    pending_kick : float
        Kicks (s) that velocities lack at `time`.
    scanned : int
        Step of the last scan, -1 if one is due.
    candidate_dt : float
        Longer step (s) that has been allowed since step `candidate_since`; inf if it is the one
        taken.
    candidate_since : int
        See candidate_dt.
    interval_dt : float
        Shortest step (s) of the interval.
    """

    outcome: int = FINE
    value: float = 0.0
    granule: int = -1
    seen: float = 0.0
    time: float = 0.0
    steps: int = 0
    intervals: int = 0
    shortest: float = math.inf
    diagnostics: Diagnostics = Diagnostics(0.0, 0.0, 0.0, 0.0, 0, 0.0, 0.0)
    dt: float = 0.0
    first_dt: float = 0.0
    dt_since: float = 0.0
    steps_at_dt: int = 0
    pending_kick: float = 0.0
    scanned: int = -1
    candidate_dt: float = math.inf
    candidate_since: int = 0
    interval_dt: float = math.inf


# Choice of the time step


@compiled
def quantised(step):
    """The longest of the powers of two, and of seven steps between two of them, up to a step
    (s)."""
    return 2.0 ** (math.floor(PER_OCTAVE * math.log2(step) + NEARLY) / PER_OCTAVE)


@inlined
def longest_step(rules, diagnostics):
    """The step (s) that a scan asks for: by stiffness, and short enough that nothing flies past the
    lists."""
    if rules.time_step > 0.0:
        return rules.time_step
    flight = 0.5 * rules.reach / max(diagnostics.speed_bound, 1e-300)
    bound = diagnostics.longest_time_step
    return quantised(bound if rules.allow_unstable else min(bound, flight))


@inlined
def within(ahead, dt):
    """A time (s) from a step on, none if it is only rounding."""
    return ahead if abs(ahead) > NEARLY * dt else 0.0


@inlined
def rebuild_at(rules, dt, diagnostics):
    """Displacement (m) from which on a step of dt (s) could lead beyond the lists."""
    near = rules.reach - dt * diagnostics.speed_bound
    return min(max(near, (1.0 - MARGIN) * rules.reach), MARGIN * rules.reach)


# Limits. Kernels of their own, because `run_steps` calls them uncompiled too.


@compiled
def later(time, steps, dt):
    """Time (s) after some steps, rounded once."""
    return time + steps * dt


@compiled
def first_outside(walls, bodies):
    """The first granule whose centre is behind a wall, or -1."""
    planes = walls.planes
    for i in range(bodies.shape[0]):
        for k in range(planes.shape[0]):
            height = bodies[i, X] * planes[k, 0] + bodies[i, Y] * planes[k, 1]
            if height > planes[k, 2]:
                return i
    return -1


@compiled
def nearing(world):
    """Most by which two bodies can have come nearer since the lists were made (m)."""
    walls, solids = boundaries_moved(world)
    first, second = math.sqrt(max(walls, solids)), math.sqrt(min(walls, solids))
    motion, reference = world.constituents, world.reference
    for i in range(motion.shape[0]):
        moved = math.sqrt(displaced(motion, reference, i))
        if not moved <= first:
            first, second = moved, first
        elif moved > second:
            second = moved
    return first + second


# Measurements

# Columns of a record: of the bed; then of each boundary, its impulses over the interval, its place
# and its angle
ENERGY, CONTACTS, OVERLAP, STEP, OF_BED = range(5)
PLACE, ANGLE, OF_BOUNDARY = 5, 7, 8


@compiled(allocates=True)
def measure(row, before, rate, world, table, frame):
    """Fill a row of the record but for the step; before: impulses that a call has not recorded, of
    which those since then go on.

    The impulses of the world become what is left of `before`.
    """
    motion, seen, planes = world.boundaries.motion, world.boundaries.impulses, world.walls.planes
    row[ENERGY] = kinetic(world, 0.0, frame)[0]
    touching, row[OVERLAP], _ = contact_summary(world, table)
    row[CONTACTS] = 2.0 * touching / world.bodies.shape[0]
    for b in range(seen.shape[0]):
        at = OF_BED + OF_BOUNDARY * b
        for c in range(PLACE):
            row[at + c] = seen[b, c] * rate
            seen[b, c] = before[b, c] - seen[b, c]
        row[at + PLACE], row[at + PLACE + 1] = motion[b, X], motion[b, Y]
        row[at + ANGLE] = world.boundaries.angle[b]
    for k in range(planes.shape[0]):  # the place of a wall is its offset (m)
        row[OF_BED + OF_BOUNDARY * k + PLACE] = planes[k, 2]


@inlined
def exchange(array, store, begin, restore):
    """Copy an array to `store` from index `begin` on where there is room, or back; returns the next
    index."""
    if array is None:
        return begin
    flat = array.reshape(-1)
    for k in range(min(flat.shape[0], store.shape[0] - begin)):
        if restore:
            flat[k] = store[begin + k]
        else:
            store[begin + k] = flat[k]
    return begin + flat.shape[0]


@inlined
def changed_by_looking(world):
    """Arrays that `look_ahead` changes, or None; without impulses."""
    boundaries = world.boundaries
    return (
        world.bodies,
        world.constituents,
        world.angle,
        world.orientation,
        world.previous_acceleration,
        world.walls.planes,
        world.lanes.account,
        boundaries.motion,
        boundaries.angle,
        boundaries.orientation,
        boundaries.previous_acceleration,
        boundaries.time,
    )


@compiled
def exchange_state(world, store, restore):
    """Copy what `look_ahead` changes to `store`, or back; returns how many numbers that is."""
    size = 0
    for array in literal_unroll(changed_by_looking(world)):
        size = exchange(array, store, size, restore)
    return size


def apart(world):
    """The world with copies of what `look_ahead` changes; lists and contact history are shared."""
    arrays = *changed_by_looking(world), world.boundaries.impulses
    copies = {id(array): array.copy() for array in arrays if array is not None}
    return mapped(world, lambda part, path: copies.get(id(part), part))


# Several threads


def diagnose_together(threads, world, table, later, frame):
    """dem.dynamics.diagnostics.diagnose, with the same result for any number of threads.

    Held granules share the row of their group, so that one thread scans all.
    """
    granules = len(world.bodies)
    shares = [share_of(place, granules) for place in threads.places]
    shares = shares if world.held is None else [(0, granules)]
    begun = begin_scan(world, table, later, frame, len(shares))
    bounds = begun[2]
    spare = range(len(bounds.rows) - len(shares), len(bounds.rows))
    same = map(repeat, (world, table, bounds))
    scans = [*threads.map(scan_pairs, *same, *zip(*shares, strict=True), spare)]
    worst = 0.0, 0
    for _, (overlap, constituent) in scans:
        worst = deeper(worst, overlap, constituent, 1.0)
    return end_scan(world, table, begun, (sum(touching for touching, _ in scans), worst))


@inlined
def scan(threads, world, table, later, frame):
    """dem.dynamics.diagnostics.diagnose, by threads or without."""
    if threads is None:
        return diagnose(world, table, later, frame)
    return diagnose_together(threads, world, table, later, frame)


@compiled(allocates=True)
def run_steps(world, table, rules, schedule, before, record, threads):
    """Advance as a Schedule says; returns the world and a Progress.

    before: the Progress of the call before, which this one goes on from. record: an array with one
    row per interval, or none of it. threads: None, or dem.dynamics.threads.Threads; this function
    then runs as it is written, uncompiled.

    Steps are whole: no interval cuts one, and what lies within a step is seen by `look`. The step
    is chosen where the lists are made, and every SCAN_INTERVAL steps: down at once, up once the
    bound has allowed it for QUIET steps. A step that follows its bound closely would be long on the
    way into a contact and short on the way out, and heat the bed. Bits do not depend on where
    intervals and calls end.
    """
    begin, interval, intervals, until, initialise, observe_only, budget = schedule
    outcome, value, granule = FINE, 0.0, -1
    time, steps, n, diagnostics = before.time, before.steps, 0, before.diagnostics
    dt, first_dt, dt_since = before.dt, before.first_dt, before.dt_since
    steps_at_dt, pending_kick, scanned = before.steps_at_dt, before.pending_kick, before.scanned
    candidate_dt, candidate_since = before.candidate_dt, before.candidate_since
    shortest, interval_dt = math.inf, dt if dt > 0.0 else math.inf
    if before.outcome == PAUSED:
        n, shortest, interval_dt = before.intervals, before.shortest, before.interval_dt
    state = np.empty(0)
    if observe_only:
        look_ahead(world, pending_kick, begin - time)
        diagnostics = scan(threads, world, table, 0.0, rules.frame)
    if initialise:
        world = rebuild_neighbor_list(world, table)
        forces(world, 0.0, math.inf)
        move_boundaries(world, 0.0, 0.0)  # previous accelerations are those of now
        drift(world, 0.0, 0.0, 0, world.bodies.shape[0])
        granule = first_outside(world.walls, world.bodies)
    while not observe_only:
        if granule >= 0:
            outcome = OUTSIDE
            break

        # Choose the time step
        if scanned < 0:
            diagnostics = scan(threads, world, table, pending_kick, rules.frame)
            budget, scanned = budget - SCAN_COST, steps
            allowed, former = longest_step(rules, diagnostics), dt
            if dt == 0.0 or not allowed > dt:
                dt, candidate_dt, candidate_since = allowed, math.inf, steps
            else:
                candidate_dt = min(candidate_dt, allowed)
                if steps - candidate_since >= QUIET:
                    dt, candidate_dt, candidate_since = candidate_dt, math.inf, steps
            if dt != former:
                dt_since, steps_at_dt = time, 0
                interval_dt = min(interval_dt, dt)
            if initialise:
                first_dt = dt

        # Check the limits
        if n < intervals and not diagnostics.max_overlap <= rules.max_overlap:
            outcome, value, granule = TOO_DEEP, diagnostics.max_overlap, diagnostics.deepest
            break
        if rules.time_step > diagnostics.critical_time_step and not rules.allow_unstable:
            outcome, value = UNSTABLE, diagnostics.critical_time_step
            break
        ends = begin + (n + 1) * interval
        work = max(until, ends) - time
        most = MOST_WORK / world.bodies.shape[0] if dt < COLLAPSE * first_dt else MOST_STEPS
        if not work <= most * dt:
            outcome, value = TOO_LONG, dt
            break

        # Measure at the end of an interval
        ahead = math.floor((ends - time) / dt + NEARLY) if n < intervals else 0
        if ahead <= 0:
            if n < record.shape[0] and n < intervals:
                if state.shape[0] == 0:
                    state = np.empty(exchange_state(world, state, False))
                exchange_state(world, state, False)
                impulses = world.boundaries.impulses.copy()
                look_ahead(world, pending_kick, within(ends - time, dt))
                record[n, STEP] = interval_dt
                measure(record[n], impulses, 1.0 / interval, world, table, rules.frame)
                exchange_state(world, state, True)
                budget -= 1
            shortest, interval_dt = min(shortest, interval_dt), dt
            n += 1
            if n >= intervals:
                break
            continue
        if budget <= 0:
            outcome = PAUSED
            break

        # Advance until the interval ends, a scan is due or a list is out of date
        count = min(ahead, budget, scanned + SCAN_INTERVAL - steps)
        kick, limit = pending_kick + 0.5 * dt, rebuild_at(rules, dt, diagnostics)
        if threads is None:
            done, moved = advance(world, kick, dt, count, limit, None)
        else:
            done, moved = threads.together(advance, world, kick, dt, count, limit)
        pending_kick = 0.5 * dt
        steps, steps_at_dt, budget = steps + done, steps_at_dt + done, budget - done
        time = later(dt_since, steps_at_dt, dt)
        if steps - scanned >= SCAN_INTERVAL:
            scanned = -1

        # Rebuild the neighbour lists
        if not moved <= limit:
            granule = first_outside(world.walls, world.bodies)
            if not (moved <= rules.reach or nearing(world) <= 2.0 * rules.reach):
                outcome, value = LOST, moved
                break
            world = rebuild_neighbor_list(world, table)
            budget, scanned = budget - SCAN_COST, -1
    reached = begin + intervals * interval if outcome == FINE else max(begin, time)
    return world, Progress(
        outcome=outcome,
        value=value,
        granule=granule,
        seen=time + within(reached - time, dt),
        time=time,
        steps=steps,
        intervals=n,
        shortest=shortest,
        diagnostics=diagnostics,
        dt=dt,
        first_dt=first_dt,
        dt_since=dt_since,
        steps_at_dt=steps_at_dt,
        pending_kick=pending_kick,
        scanned=scanned,
        candidate_dt=candidate_dt,
        candidate_since=candidate_since,
        interval_dt=interval_dt,
    )
