"""The loop of a run: choose the time step, renew lists, check limits, measure; and why a run stops.

Between two neighbour lists nothing moves by more than half the skin. A check at each new list
therefore sees every overlap before it has grown by more than the skin.

Steps are whole: no interval cuts one, and what lies within a step is seen on a copy. Only where a
solid is removed, or driven otherwise, or granules come or go, a step ends at that time. The step is chosen where the lists
are made, and every SCAN_INTERVAL steps: down at once, up once the bound has allowed it for QUIET
steps. A step that follows its bound closely would be long on the way into a contact and short on
the way out, and heat the bed. Bits do not depend on where intervals and calls end, nor on who looks.
"""

import math
import time
from collections.abc import Iterable
from contextlib import nullcontext
from copy import deepcopy
from typing import Any, NamedTuple

import numpy as np

from dem.base.errors import OverlapError, RunError, StateError
from dem.contacts.layout import (
    ACCOUNTS,
    BLOCK,
    BROUGHT,
    POWER_SPRINGS,
    RAISED,
    VX,
    VY,
    WORK,
    X,
    Y,
)
from dem.dynamics.base_plate import step_with
from dem.dynamics.checkpoint import copied
from dem.dynamics.contact_output import list_contacts, partner_words
from dem.dynamics.critical_step import steps_alone
from dem.dynamics.energy import balance, fallen
from dem.dynamics.forces import integrate_account
from dem.dynamics.neighbours import without
from dem.dynamics.paths import is_driven, places, shown, with_motion
from dem.dynamics.scan import (
    CHOSEN,
    CRITICAL,
    DEEP_CONSTITUENT,
    DEEPEST,
    KINETIC,
    LEAST_OVERLAP,
    SPEED,
    TOUCHING,
    Moment,
)
from dem.dynamics.skin import best_skin
from dem.dynamics.step import Threads
from dem.dynamics.system import System, is_finite, longest_move
from dem.dynamics.world import REMOVED, World, number_of_patches
from dem.jit.interrupts import signals_deferred
from dem.motion import Drive, Turn

LOST, TOO_DEEP, OUTSIDE, TOO_LONG, UNSTABLE = range(5)
MOST_STEPS = 1e11  # an hour or more for two granules, weeks for a bed of hundreds
COLLAPSE = 1e-3  # of the first step: a shorter one has collapsed
MOST_WORK = 4e8  # steps times granules, once the step has collapsed: less than a minute
SCAN_INTERVAL = 1000  # steps without a scan, at most
QUIET = 2000  # steps for which the bound must have allowed a longer step before it is taken
PER_OCTAVE = 8  # quantised steps to a factor of two
MARGIN = 0.75  # share of skin / 2 that a constituent may move before the lists are rebuilt
PATIENCE = 20  # lists without a break for which a wider skin must be best
NEARLY = 1e-9  # of a step: a time is reached that is no farther off
FIRST_BUDGET = 20_000  # constituents times steps of the first call of a kernel
BRIEF, LONG = 0.05, 0.15  # s: between these a call returns, so that Python can answer Ctrl-C

NOT_A_NUMBER = -1
WHEN = "at step {steps}, time {time:.6g} s"
LESS = "take a smaller time step, a stiffer material or a lower packing fraction"
SENTENCES = {
    NOT_A_NUMBER: f"the motion of granule {{granule}} is not a number {WHEN}: take a smaller time "
    "step.",
    LOST: f"{{what}} moved {{value:.3g}} m before its contacts were listed again {WHEN}; it may "
    "move {reach:.3g} m: take a smaller time step.",
    TOO_LONG: f"the time step is {{value:.3g}} s {WHEN}, and what remains would take too many of "
    "them: granules are too small, stiff, light or fast for a run of this duration.",
    UNSTABLE: "time_step is {time_step:.4g} s, longer than the critical one, {value:.4g} s, "
    f"{WHEN}: make it shorter, leave it out, or set allow_unstable.",
    OUTSIDE: f"granule {{granule}} has its centre {{far:.3g}} m behind wall {{wall}} {WHEN}: "
    f"put it inside, or {LESS}.",
    TOO_DEEP: f"granule {{granule}} overlaps {{what}} by {{value:.3g}} of the smaller radius {WHEN}; "
    "the limit is {max_overlap:g}: {remedy}.",
}

# Columns of a record: of the bed; then of each boundary, its impulses over the interval, its place
# and its angle
ENERGY, CONTACTS, OVERLAP, STEP, OF_BED = range(5)
PLACE, ANGLE, OF_BOUNDARY = 5, 7, 8


class StepControl(NamedTuple):
    """How the time step is chosen, and when lists are rebuilt or a run stops.

    Attributes
    ----------
    time_step : float
        Fixed time step (s), or 0 for a quantised step below the bound.
    max_overlap : float
        Largest allowed overlap over the smaller radius, without unit.
    skins : tuple of float
        The least and the widest skin (m) of the lists.
    allow_unstable : bool
        Whether no step is shortened for fast granules, and a fixed one may be longer than the
        critical one.
    frame : tuple of float
        Velocity (m/s) that is taken off all.
    """

    time_step: float
    max_overlap: float
    skins: tuple[float, float]
    allow_unstable: bool
    frame: tuple[float, float]


class Diagnostics(NamedTuple):
    """The bed at one moment, as `Simulation.diagnose` returns it.

    Attributes
    ----------
    kinetic_energy : float
        Kinetic energy (J) of all granules that are not held.
    speed_bound : float
        Bound on the speed (m/s) of any granule until the next neighbour list.
    coordination_number : float
        Contacts with other granules per granule, without unit.
    max_overlap : float
        Largest overlap over the smaller radius, without unit.
    deepest : int
        Number of the granule with that overlap, without unit.
    critical_time_step : float
        Lower bound on the critical time step (s).
    longest_time_step : float
        The time step (s) of which `step_fraction` is that fraction; in steps of an eighth root of
        two it is taken.
    """

    kinetic_energy: float
    speed_bound: float
    coordination_number: float
    max_overlap: float
    deepest: int
    critical_time_step: float
    longest_time_step: float


class Progress(NamedTuple):
    """How far a run is, and what it goes on from.

    Attributes
    ----------
    seen : float
        The requested time (s), or the time of the last step if it is not reached.
    time : float
        Time (s) of the last whole step, which is not later than `seen`.
    steps : int
        Whole steps since the start.
    speed_bound : float
        Of the last scan (m/s).
    dt : float
        Time step (s).
    first_dt : float
        The first time step (s).
    dt_since : float
        Time (s) when dt was last changed.
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
    skin : float
        Skin of the lists (m).
    listed : int
        Step of the last list.
    narrow : int
        Lists without a break before it for which a wider skin was best.
    """

    seen: float = 0.0
    time: float = 0.0
    steps: int = 0
    speed_bound: float = 0.0
    dt: float = 0.0
    first_dt: float = 0.0
    dt_since: float = 0.0
    steps_at_dt: int = 0
    pending_kick: float = 0.0
    scanned: int = -1
    candidate_dt: float = math.inf
    candidate_since: int = 0
    skin: float = 0.0
    listed: int = 0
    narrow: int = 0

    @property
    def reach(self) -> float:
        """Displacement (m) of a constituent that stops the run, because a contact may have been
        missed; lists are rebuilt before."""
        return 0.5 * self.skin


def quantised(step: float) -> float:
    """The longest of the powers of two, and of seven steps between two of them, up to a step
    (s)."""
    return 2.0 ** (math.floor(PER_OCTAVE * math.log2(step) + NEARLY) / PER_OCTAVE)


def within(ahead: float, dt: float) -> float:
    """A time (s) from a step on, none if it is only rounding."""
    return ahead if abs(ahead) > NEARLY * dt else 0.0


def first_outside(world: World) -> int:
    """The first granule whose centre is behind a wall, or -1."""
    planes = world.boundaries.planes
    beyond = world.bodies[:, :2] @ planes[:, :2].T > planes[:, 2]
    return int(beyond.any(axis=1).argmax()) if beyond.any() else -1


class Engine:
    """The loop of a run.

    Attributes
    ----------
    system : System
        The bed at the last whole step, and its kernels.
    rules : StepControl
        How the time step is chosen.
    order : ndarray of shape (n,)
        Number of each granule of the arrays, which has those that are there.
    progress : Progress
        How far they are.
    until : float
        End of the whole run (s), where that is known.
    """

    def __init__(self, system: System, skin: float, rules: StepControl, order, threads: int):
        self.system, self.rules, self.order = system, rules, order
        self.until, self.threads = 0.0, threads
        self.budget = max(FIRST_BUDGET // len(system.world.constituents.owner), 1)
        self.progress = Progress(skin=skin)
        self._view: tuple[Progress, System, Diagnostics] | None = None
        self.start()

    @property
    def world(self) -> World:
        """The arrays at the last whole step."""
        return self.system.world

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: no two arrays that share memory."""
        return vars(self) | {"_view": None, "system": self.system.with_world(copied(self.world))}

    def start(self) -> None:
        """Lists and forces at the start, and the first time step."""
        self.begin()
        if (granule := first_outside(self.world)) >= 0:
            self.stop(OUTSIDE, granule=granule)
        self.choose_step()

    def begin(self) -> None:
        """Lists and forces for velocities of a full step; previous accelerations are the present
        ones."""
        self.rebuild()
        self.system.forces(0.0)
        self.system.drift(0.0, 0.0)

    def rebuild(self) -> None:
        """Lists for the present positions."""
        self.system.rebuild(self.progress.skin)
        self.progress = self.progress._replace(listed=self.progress.steps)

    def end_step(self) -> None:
        """End the step at the time that was asked for, with velocities of a full step, so that what
        changes now acts from there on."""
        now, account = self.progress, self.world.account
        if now.seen > now.time:
            self.progress = now._replace(dt=now.seen - now.time, dt_since=now.time, steps_at_dt=0)
            self.take_steps(1, None)
        kick = self.progress.pending_kick
        self.system.drift(kick, 0.0)
        integrate_account(account, kick)
        self.progress = self.progress._replace(
            pending_kick=0.0,
            dt=now.dt,
            time=now.seen,
            seen=now.seen,
            dt_since=now.seen,
            steps_at_dt=0,
            scanned=-1,
        )

    def changed(self, b: int, velocity, spin, removed: bool = False) -> "Engine":
        """The same, where boundary b, a solid, moves otherwise from the time on that was asked for, or
        is met no more.

        velocity, spin: as of dem.dynamics.paths.with_motion. Where b follows paths before and after,
        this one itself, whose step goes on; otherwise a copy, so that an interrupt changes nothing.
        """
        now, world = self.progress, self.world
        forced = isinstance(velocity, Drive) or isinstance(spin, Turn)
        if not (removed or forced or is_driven(world.boundaries, b)):
            way = places(self.seen().world.boundaries)[b] - places(world.boundaries)[b]
            seen = now.seen - now.time, way
            boundaries = with_motion(world.boundaries, b, velocity, spin, seen)
            self.system.world = world._replace(boundaries=boundaries)
            self.progress = now._replace(scanned=-1)
            return self
        engine = deepcopy(self)
        engine.end_step()
        elastic = engine.system.elastic()
        boundaries = with_motion(engine.world.boundaries, b, velocity, spin)
        if removed:
            boundaries.section[b] = REMOVED
        engine.system = engine.system.changed(boundaries)
        engine.begin()
        if removed:  # what its contacts held it takes along: work, and no loss of springs
            taken, account = elastic - engine.system.elastic(), engine.world.account
            account[WORK] -= taken.sum()
            account[ACCOUNTS + POWER_SPRINGS : WORK] -= taken[1:]
        return engine

    def replace_granules(self, system: System, order: np.ndarray) -> None:
        """Go on from the end of a step with other granules: those that stay, in the same order, then
        those that come. Pairs that stay keep what they remember, and all that stay their anchors.

        system: has these, the boundaries of now, and no list yet.
        """
        old, before, kept = self.world, self.content(), np.isin(self.order, order)
        moving = np.ones(len(old.boundaries.motion), bool)
        stays = np.append(kept[old.constituents.owner], moving)
        contacts = without(old.contacts, system.kernels.layout.stride // BLOCK, stays)
        base = system.world.base
        if len(anchor := old.base.anchor):
            base.anchor[: kept.sum()] = anchor[: len(kept)][kept]
            base.anchor[len(order) :] = anchor[len(kept) :]
            base = base._replace(slip=old.base.slip, delay=old.base.delay)
        system.world = system.world._replace(contacts=contacts, account=old.account, base=base)
        self.system, self.order, self._view = system, order, None
        self.begin()
        change, account = self.content() - before, self.world.account
        self._view = None  # which has the account of before
        account[BROUGHT] += change[:4].sum()
        account[ACCOUNTS + POWER_SPRINGS : WORK] += change[2:4]
        account[RAISED] += change[4]

    def content(self) -> np.ndarray:
        """Kinetic energy of the bed, elastic ones of all springs, and what gravity did (J)."""
        system = self.observe()[0]
        return np.array([*balance(system), fallen(system.world)])

    def diagnose(self, system: System, later: float) -> Diagnostics:
        """How a bed is, and how long a step may be; later (s): kicks that velocities lack.

        Stiffness and damping of all contacts give a lower bound on the critical step. Pairs that
        are near but do not touch count with the overlap of a collision at the greatest expected
        speed, and any granule could collide with one of its own size.
        """
        world, table = system.world, system.table
        result = system.scan(Moment(later, self.rules.frame, self.progress.skin))
        alone = steps_alone(world.law, table, float(result[LEAST_OVERLAP]))
        steps = map(min, alone, result[[CRITICAL, CHOSEN]].tolist())
        critical, chosen = (step_with(world.base, step) for step in steps)
        return Diagnostics(
            kinetic_energy=float(result[KINETIC]),
            speed_bound=float(result[SPEED]),
            coordination_number=float(2.0 * result[TOUCHING] / len(world.granules.angle)),
            max_overlap=float(result[DEEPEST]),
            deepest=int(world.constituents.owner[int(result[DEEP_CONSTITUENT])]),
            critical_time_step=critical,
            longest_time_step=chosen,
        )

    def longest_step(self, diagnostics: Diagnostics) -> float:
        """The step (s) that a scan asks for: by stiffness, and short enough that nothing flies past
        the lists."""
        rules, bound = self.rules, diagnostics.longest_time_step
        if rules.time_step > 0.0:
            return rules.time_step
        flight = 0.5 * self.progress.reach / max(diagnostics.speed_bound, 1e-300)
        return quantised(bound if rules.allow_unstable else min(bound, flight))

    def choose_step(self, checks_overlap: bool = False) -> None:
        """Scan the bed, choose the time step, and check the limits."""
        now = self.progress
        diagnostics = self.diagnose(self.system, now.pending_kick)
        allowed, dt = self.longest_step(diagnostics), now.dt
        candidate, since = now.candidate_dt, now.candidate_since
        if dt == 0.0 or not allowed > dt:
            dt, candidate, since = allowed, math.inf, now.steps
        else:
            candidate = min(candidate, allowed)
            if now.steps - since >= QUIET:
                dt, candidate, since = candidate, math.inf, now.steps
        changed = {"dt_since": now.time, "steps_at_dt": 0} if dt != now.dt else {}
        self.progress = now._replace(
            dt=dt,
            first_dt=now.first_dt or dt,
            candidate_dt=candidate,
            candidate_since=since,
            scanned=now.steps,
            speed_bound=diagnostics.speed_bound,
            **changed,
        )
        if checks_overlap and not diagnostics.max_overlap <= self.rules.max_overlap:
            self.stop(TOO_DEEP, diagnostics.max_overlap, diagnostics.deepest)
        critical = diagnostics.critical_time_step
        if self.rules.time_step > critical and not self.rules.allow_unstable:
            self.stop(UNSTABLE, critical)

    def stop(self, outcome: int, value: float = 0.0, granule: int = -1) -> None:
        """Raise the error of a run that cannot go on, see `failure`."""
        self.progress = self.progress._replace(seen=self.progress.time)
        raise failure(self, outcome, value, granule)

    def check_work(self, end: float) -> None:
        """Stop a run that would take too many steps up to its end (s)."""
        now = self.progress
        collapsed = now.dt < COLLAPSE * now.first_dt
        most = MOST_WORK / len(self.world.granules.angle) if collapsed else MOST_STEPS
        if not max(self.until, end) - now.time <= most * now.dt:
            self.stop(TOO_LONG, now.dt)

    def limit(self) -> float:
        """Displacement (m) from which on a step could lead beyond the lists."""
        reach = self.progress.reach
        near = reach - self.progress.dt * self.progress.speed_bound
        return min(max(near, (1.0 - MARGIN) * reach), MARGIN * reach)

    def run(self, ends: Iterable[float], record: np.ndarray | None = None) -> float:
        """Go on to each of some times (s), and measure there; returns the shortest step (s) taken.

        record: an array with a row for each; an interval begins where the last one ended. Raises
        RunError where the run stops. A kernel returns every so often, so that Python can answer an
        interrupt.
        """
        begin, shortest = self.progress.seen, math.inf
        size = min(self.threads, number_of_patches(len(self.order)))
        with (
            nullcontext() if size == 1 else Threads(size) as threads,
            signals_deferred() as answer,
        ):
            for n, end in enumerate(ends):
                shortest_here = self.advance_to(end, threads, answer)
                shortest = min(shortest, shortest_here)
                self.progress = self.progress._replace(
                    seen=self.progress.time + within(end - self.progress.time, self.progress.dt)
                )
                if record is not None:
                    self.measure(record[n], end - begin)
                    record[n, STEP] = shortest_here
                begin = end
        return shortest

    def advance_to(self, end: float, threads, answer) -> float:
        """Take whole steps up to a time (s); returns the shortest step (s).

        answer: called where nothing is half done, so that Python can answer an interrupt.
        """
        shortest = self.progress.dt if self.progress.scanned >= 0 else math.inf
        while True:
            now = self.progress
            if now.scanned < 0:
                if self.best_skin() < now.skin:
                    self.renew_lists(0.0)
                self.choose_step(checks_overlap=True)
                now = self.progress
                shortest = min(shortest, now.dt)
            self.check_work(end)
            ahead = math.floor((end - now.time) / now.dt + NEARLY)
            if ahead <= 0:
                return shortest
            self.take_steps(min(ahead, now.scanned + SCAN_INTERVAL - now.steps), threads)
            answer()

    def take_steps(self, count: int, threads) -> None:
        """Take up to so many steps, and renew the lists where they are out of date."""
        now, limit, clock = self.progress, self.limit(), time.perf_counter()
        count = min(count, self.budget)
        kick = now.pending_kick + 0.5 * now.dt
        done, moved = self.system.advance(kick, now.dt, count, limit, threads)
        steps, at_dt = now.steps + done, now.steps_at_dt + done
        ends = now.dt_since + at_dt * now.dt
        self.progress = now._replace(
            pending_kick=0.5 * now.dt,
            steps=steps,
            steps_at_dt=at_dt,
            time=ends,
            seen=ends,
            scanned=-1 if steps - now.scanned >= SCAN_INTERVAL else now.scanned,
        )
        if not moved <= limit:
            self.renew_lists(moved)
        took = time.perf_counter() - clock
        if took < BRIEF and done == self.budget:
            self.budget *= 2
        elif took > LONG:
            self.budget = max(self.budget // 2, 1)

    def best_skin(self) -> float:
        """The skin (m) by how long the list of now has lasted."""
        now = self.progress
        return best_skin(now.skin, now.steps - now.listed, *self.rules.skins)

    def renew_lists(self, moved: float) -> None:
        """Lists with a skin that suits how long the last ones were good for; stops where a contact may
        have been missed. One list that lasts says enough, and a few short ones do not."""
        now, reach = self.progress, self.progress.reach
        granule = first_outside(self.world)
        if not (moved <= reach or longest_move(self.world) <= 2.0 * reach):
            self.stop(LOST, moved, granule)
        best = self.best_skin()
        narrow = now.narrow + 1 if best > now.skin else 0
        if narrow == PATIENCE or best < now.skin:
            now, narrow = now._replace(skin=best), 0
        self.progress = now._replace(narrow=narrow, scanned=-1)
        self.rebuild()
        if granule >= 0:
            self.stop(OUTSIDE, granule=granule)

    def observe(self) -> tuple[System, Diagnostics]:
        """A copy of the bed at the time that was asked for, which may lie within a step, and how it
        is. It shares lists and contact history with the bed."""
        if self._view is None or self._view[0] is not self.progress:
            seen = self.seen()
            diagnostics = self.diagnose(seen, 0.0)
            moved = [seen.world.bodies]
            if not seen.alone:
                moved.append(seen.world.constituents.motion[: len(seen.world.constituents.owner)])
            for rows in moved:
                rows[:, [X, Y]] += np.multiply(self.rules.frame, self.progress.seen)
                rows[:, [VX, VY]] += self.rules.frame
            self._view = self.progress, seen, diagnostics
        return self._view[1:]

    def seen(self) -> System:
        """A copy of the bed at the time that was asked for, without its frame."""
        now = self.progress
        return self.system.later(now.pending_kick, now.seen - now.time)

    def take_impulses(self) -> np.ndarray:
        """Boundaries.impulses since the last call."""
        now = self.progress
        since = self.system.impulses(now.pending_kick + now.seen - now.time)
        self.world.boundaries.impulses[:] -= since
        self._view = None
        return since

    def measure(self, row: np.ndarray, duration: float) -> None:
        """Fill a row of the record but for the step, after an interval of a duration (s); its impulses
        do not count again."""
        seen = self.seen()
        boundaries, result = (
            seen.world.boundaries,
            seen.scan(Moment(frame=self.rules.frame), steps=False),
        )
        row[ENERGY], row[OVERLAP] = result[KINETIC], result[DEEPEST]
        row[CONTACTS] = 2.0 * result[TOUCHING] / len(self.world.granules.angle)
        of = row[OF_BED:].reshape(-1, OF_BOUNDARY)
        of[:, :PLACE] = boundaries.impulses / duration
        of[:, PLACE:] = shown(boundaries)
        planes = boundaries.planes
        of[: len(planes), PLACE] = planes[:, 2]  # the place of a wall is its offset (m)
        self.world.boundaries.impulses[:] -= boundaries.impulses


@np.errstate(all="ignore")
def failure(engine: Engine, outcome: int, value: float, granule: int) -> RunError:
    """The error of a run that stops.

    outcome: why, one of SENTENCES; value: what says so, a moved distance (m), an overlap or a time
    step (s); granule: which says so.
    """
    world, order, now, what = engine.world, engine.order, engine.progress, "a boundary"
    beyond = np.zeros(1)
    if not is_finite(world.bodies):
        outcome, granule = NOT_A_NUMBER, np.isfinite(world.bodies).all(axis=1).argmin()
    elif outcome == LOST:
        constituents = world.constituents
        moved = constituents.motion[: len(constituents.owner), :2] - constituents.reference
        moved = np.linalg.norm(moved, axis=1)
        if moved.max() >= value:
            what = f"granule {order[constituents.owner[moved.argmax()]]}"
    elif outcome == OUTSIDE:
        planes = world.boundaries.planes
        beyond = planes[:, :2] @ world.bodies[granule, :2] - planes[:, 2]
    elif outcome == TOO_DEEP:
        what = partner_words(world, list_contacts(engine.system, order), order[granule])
    words = SENTENCES[outcome].format(
        **engine.rules._asdict(),
        **now._asdict(),
        value=value,
        granule=order[granule],
        reach=now.reach,
        what=what,
        far=beyond.max(),
        wall=beyond.argmax(),
        remedy=LESS if now.steps else "place the granules farther apart",
    )
    return (OverlapError if outcome == TOO_DEEP else StateError)(words)
