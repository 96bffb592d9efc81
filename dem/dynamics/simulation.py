"""A scene in motion, which you advance and look at between calls."""

import math
import threading
import time
import warnings
from collections.abc import Mapping
from contextlib import nullcontext
from typing import Annotated, Any, NoReturn

import numpy as np
from pydantic import InstanceOf

from dem.base.errors import InputError, OverlapError, StateError
from dem.base.types import Count, NotNegative, Number, Time, Unit, Velocity, checked
from dem.dynamics.assembly import assemble, granule_table
from dem.dynamics.checkpoint import (
    fingerprint,
    numbers_of,
    read,
    read_only,
    replaced,
    with_numbers,
    writable,
    written,
)
from dem.dynamics.contact_list import ContactList, list_contacts
from dem.dynamics.diagnostics import Diagnostics
from dem.dynamics.energy import Ledger, balance, energies, fallen
from dem.dynamics.numerics import (
    MAX_OVERLAP,
    STEP_FRACTION,
    Intervals,
    MaxOverlap,
    Skin,
    StepFraction,
    ThreadCount,
    check_stable,
)
from dem.dynamics.ordering import order_of, ordered
from dem.dynamics.result import Record, Result, bearings, shares
from dem.dynamics.skin import SKIN, skin_for
from dem.dynamics.stepping import (
    ANGLE,
    COLLAPSE,
    COLLAPSED,
    FINE,
    LOST,
    MOST_STEPS,
    MOST_WORK,
    OF_BED,
    OF_BOUNDARY,
    OUTSIDE,
    PAUSED,
    PLACE,
    TOO_DEEP,
    TOO_LONG,
    UNSTABLE,
    Progress,
    Schedule,
    StepControl,
    run_steps,
)
from dem.dynamics.stress import Edges, Stress, stress
from dem.dynamics.threads import Threads
from dem.dynamics.world import World, number_of_patches
from dem.jit.columns import VX, VY, W, X, Y
from dem.jit.interrupts import signals_deferred
from dem.motion import Turn
from dem.scene import ARRAYS, Scene, State

FIRST_BUDGET = 20_000  # constituents times steps until the kernel returns for the first time
BRIEF, LONG = 0.05, 0.15  # s: between these it returns, so that Python can answer Ctrl-C
MOST_FRAME_BYTES = 2**30  # of the frames of a Result


class Simulation:
    """A scene in motion, which you advance and look at between calls.

    Parameters
    ----------
    scene : Scene
        Granules, materials and boundaries.
    state : State
        Positions and velocities at the start.
    time_step : float, optional
        Fixed time step (s), not longer than the critical one at any time. None for one that is held
        below it (recommended).
    step_fraction : float
        Time step over the critical one, both without damping, without unit, above 0 and up to 1.
        The default keeps the energy of elastic gases; 0.5 is enough for dense beds with damping.
    max_overlap : float
        Largest allowed overlap over the smaller radius, without unit, up to 1.5.
    skin : float, optional
        Skin of the neighbour list over the mean bounding radius, without unit. It changes the
        speed, and at which steps the time step is chosen again. None for one that follows from the
        speeds at the start (recommended). A short period makes it smaller.
    threads : int
        Number of threads, without unit, for beds of thousands of granules. The result does not
        depend on it. A small bed uses fewer.
    ledger : bool
        Keep an energy ledger. A run takes about ten per cent longer.
    allow_unstable : bool
        Take the requested step, even if it is unstable. `step_fraction` may then exceed 1, no step
        is shortened for fast granules, and a `time_step` that is longer than the critical one at
        the start is a RuntimeWarning.

    Attributes
    ----------
    scene : Scene
        The scene.
    time : float
        Time since the start (s).
    steps : int
        Number of time steps taken, without unit.

    Raises
    ------
    InputError
        If a value cannot be used, or the state is not for the granules and the boundaries of the
        scene.
    StateError
        If a granule is outside the walls, or `time_step` is longer than the critical one.

    See Also
    --------
    simulate : One call that returns arrays.

    Notes
    -----
    Equations (1) and (2) of the paper, integrated with velocity Verlet. The critical step is a
    lower bound for small motions of the bed as it is. It is computed whenever the neighbour list is
    rebuilt, and every 1000 steps. The time step then becomes shorter at once, and longer only after
    2000 steps that allowed it; it is one of the powers of two, or of seven steps between two of
    them. Steps are whole: what you see at a time within a step is a copy, taken there from the last
    whole step, so that the motion does not depend on when you look. `Material` and `Friction` give
    the forces.

    Ctrl-C is answered within about a second. `time` and everything else then say what has been
    simulated until then, and you can go on from there. A simulation can be pickled and copied, and
    used in a forked process. After an error within a step it raises StateError.

    Examples
    --------
    Two discs collide head-on, and the ratio of their speeds after and before is the coefficient
    of restitution:

    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
    >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
    >>> run = dem.Simulation(scene, state, step_fraction=0.05)
    >>> shortest = run.advance(2e-4)
    >>> run.state.velocity.round(2)
    array([[-0.5,  0. ],
           [ 0.5,  0. ]])
    >>> print(f"{run.time:g} s")
    0.0002 s
    """

    @checked
    def __init__(
        self,
        scene: InstanceOf[Scene],
        state: InstanceOf[State],
        time_step: Time | None = None,
        step_fraction: StepFraction = STEP_FRACTION,
        max_overlap: MaxOverlap = MAX_OVERLAP,
        skin: Skin | None = None,
        threads: ThreadCount = 1,
        ledger: bool = False,
        allow_unstable: bool = False,
    ):
        check_stable(step_fraction, allow_unstable)
        if ledger and threads > 1:
            raise InputError(f"threads is {threads}; with an energy ledger it must be 1.")
        self.scene, self.time_step = scene, time_step
        self.step_fraction, self.max_overlap = step_fraction, max_overlap
        state, frame = state.checked(scene.granules), (0.0, 0.0)
        reached = state.boundaries
        if not (scene.walls or scene.solids or scene.held):
            x, y = np.average(state.velocity, axis=0, weights=scene.mass)
            frame = float(x), float(y)
            state.velocity -= frame
        self._order = order_of(scene, state)
        scene, state = ordered(scene, state, self._order)
        table = granule_table(scene, skin or SKIN, step_fraction)
        self._world = assemble(scene, state, table, ledger)
        self._start = bearings(scene, self._world)
        if reached is not None and not np.array_equal(reached, self._start):
            raise InputError(
                "state was reached with boundaries in other places or at other speeds than those "
                "of scene; go on with a Simulation, or move them in the scene and make boundaries "
                "of the state None."
            )
        if skin is None:
            table = table._replace(skin=skin_for(scene, self._world, table, time_step))
        self._table, self._progress, self._until = table, Progress(), 0.0
        self._rules = StepControl(
            time_step=float(time_step or 0.0),
            max_overlap=float(max_overlap),
            reach=0.5 * table.skin,
            allow_unstable=allow_unstable,
            frame=frame,
        )
        self._threads = min(threads, number_of_patches(len(self._order)))
        self._budget = max(FIRST_BUDGET // len(self._world.constituents), 1)
        self._lock, self._in_kernel = threading.Lock(), False
        self._view: tuple[Progress, World, Diagnostics] | None = None
        report = self._run_kernel(0.0, 0.0, 0, initialise=True)
        if report.outcome:
            self._fail(report)
        critical = report.diagnostics.critical_time_step
        if self._rules.time_step > critical:
            warnings.warn(
                f"time_step is {time_step:.4g} s, longer than the critical one, {critical:.4g} s: "
                "motions can grow.",
                RuntimeWarning,
                stacklevel=3,
            )
        self._at_start = (sum(balance(self._seen)), fallen(self._seen)) if ledger else None

    @property
    def time(self) -> float:
        """Time since the start (s)."""
        return self._progress_now().seen

    @property
    def steps(self) -> int:
        """Number of time steps taken, without unit.

        Examples
        --------
        >>> import dem
        >>> run = dem.Simulation(dem.Scene(dem.Disc([1e-3])), dem.State([[0, 0]]), time_step=1e-6)
        >>> shortest = run.advance(1e-5)
        >>> run.steps
        10
        """
        return int(self._progress_now().steps)

    @property
    def world(self) -> World:
        """The arrays of the kernels, in SI units.

        Their granules may be in another order than those of the scene (dem.dynamics.ordering). They
        are read-only views, because the neighbour list and the time step rely on them;
        dem.dynamics.checkpoint.writable copies them.

        Examples
        --------
        >>> import dem
        >>> run = dem.Simulation(dem.Scene(dem.Disc([1e-3, 1e-3])), dem.State([[0, 0], [1, 0]]))
        >>> run.world.bodies.flags.writeable
        False
        """
        return read_only(self._seen)

    @property
    def state(self) -> State:
        """Copy of positions (m), angles (rad), their rates (1/s) and `boundaries`."""
        back = np.argsort(self._order)
        bodies, angle = self._seen.bodies[back], self._seen.angle[back]
        reached = bearings(self.scene, self._seen)
        moved = None if np.array_equal(reached, self._start) else reached
        return State(bodies[:, :2].copy(), bodies[:, [VX, VY]], angle, bodies[:, W].copy(), moved)

    def collect_impulses(self) -> tuple[np.ndarray, np.ndarray]:
        """Impulses of the granules on solids and walls since the last call.

        Returns
        -------
        on_solids : ndarray of shape (k, 2, 2)
            Impulses (x, y) in N s on each solid: of the normal forces in the first row, of the
            tangential forces in the second.
        on_walls : ndarray of shape (w,)
            Impulse of the normal forces (N s) on each wall.

        Examples
        --------
        A disc bounces off the right wall and hands over its change of momentum:

        >>> import dem
        >>> scene = dem.Scene(
        ...     dem.Disc([1e-3]),
        ...     friction=dem.Friction(),
        ...     walls=dem.box(10e-3, 20e-3),
        ...     solids=dem.Cylinder(diameter=2e-3, position=(5e-3, 15e-3)),
        ... )
        >>> run = dem.Simulation(scene, dem.State([[8.9e-3, 5e-3]], velocity=[[1.0, 0.0]]))
        >>> shortest = run.advance(4e-4)
        >>> left, right, bottom, top = run.collect_impulses()[1]
        >>> print(f"{right / (scene.mass[0] * (1.0 - run.state.velocity[0, 0])):.3f}")
        1.000
        """
        walls, solids, _ = self._take_impulses()
        return solids[:, :4].reshape(-1, 2, 2), walls[:, 0]

    def _take_impulses(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Boundaries.impulses since the last call, of walls, solids and held groups."""
        seen = self._seen.boundaries.impulses
        since = seen.copy()
        for impulses in (self._world.boundaries.impulses, seen):
            impulses -= since
        return shares(self.scene, since)

    def diagnose(self) -> Diagnostics:
        """Energy, contacts, largest overlap and critical time step at the present time.

        Returns
        -------
        Diagnostics
            Kinetic energy (J), coordination number, overlap and critical time step (s).

        Raises
        ------
        OverlapError
            If the largest overlap exceeds `max_overlap`.

        Examples
        --------
        Two discs of 24.5 mg approach each other at 1 m/s each:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> print(f"{1e6 * run.diagnose().kinetic_energy:.1f} uJ")
        24.5 uJ
        """
        diagnostics = self._observe()[1]
        if not diagnostics.max_overlap <= self.max_overlap:
            value, granule = diagnostics.max_overlap, diagnostics.deepest
            report = self._progress_now()
            self._fail(report._replace(outcome=TOO_DEEP, value=value, granule=granule))
        return diagnostics._replace(deepest=int(self._order[diagnostics.deepest]))

    @checked
    def check_duration(self, duration: Time) -> None:
        """Announce the duration of a run, so that an endless one is refused before it starts.

        Later calls of `advance` and `record` also refuse a time step that is too short for it.

        Parameters
        ----------
        duration : float
            Time (s) from now to the end of the run, over all calls.

        Raises
        ------
        InputError
            If the run would take too many time steps.
        OverlapError
            If the largest overlap exceeds `max_overlap`.

        Examples
        --------
        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> run.check_duration(1e6)
        Traceback (most recent call last):
            ...
        dem.base.errors.InputError: duration is 1e+06 s, more than ...
        """
        self.diagnose()
        step = self._progress_now().dt
        if not duration <= MOST_STEPS * step:
            raise InputError(self._endless("duration", duration, step))
        self._until = self.time + duration

    def contacts(self) -> ContactList:
        """All contacts at the present time.

        Returns
        -------
        ContactList
            Granules, points (m), normals, branch vectors (m), overlaps (m) and forces (N). A
            simulation starts without tangential springs.

        See Also
        --------
        stress : What the contacts carry, per area.

        Examples
        --------
        Two discs of 1 mm radius overlap by 1 um; Hertz's law gives the force:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]))
        >>> run = dem.Simulation(scene, dem.State([[0.0, 0.0], [1.999e-3, 0.0]]))
        >>> contacts = run.contacts()
        >>> print(contacts.granule, contacts.partner)
        [0] [1]
        >>> modulus = 70e9 / (1.0 - 0.22**2) / 2.0
        >>> hertz = 4.0 / 3.0 * modulus * 0.5e-3**0.5 * 1e-6**1.5
        >>> print(f"{contacts.force[0]:.3f} N, {hertz:.3f} N")
        1.097 N, 1.097 N
        """
        return list_contacts(self._seen, self._order)

    @checked
    def stress(self, x: Edges | None = None, y: Edges | None = None) -> Stress:
        """Stress and fabric of the bed at the present time, or of bins along x or y.

        Parameters
        ----------
        x : array_like of shape (b + 1,), optional
            Edges of bins along x (m), which rise. None for the whole bed.
        y : array_like of shape (b + 1,), optional
            Edges of bins along y (m); not together with x.

        Returns
        -------
        Stress
            Stress of contacts and motion (Pa), fabric and coordination number (without unit).
            Compression is positive.

        Raises
        ------
        InputError
            If edges do not rise, are given along both axes, or leave a container that is not
            closed.

        Notes
        -----
        The stress of the contacts is the sum of ``f l`` over the volume: force f on the partner,
        branch vector l of `ContactList`. The volume is the thickness times the area between walls,
        edges and periodic sides, without the solids. In bins a contact counts for the share of
        its branch vector that is in the bin. The fabric counts contacts by their points, the other
        measures granules by their centres.

        Examples
        --------
        A disc of 1 mm radius is pressed between floor and lid, 1 um on either side. The force on
        either over its area, 4 mm times 1 mm, is the stress:

        >>> import dem
        >>> scene = dem.Scene(
        ...     dem.Disc([1e-3]),
        ...     friction=dem.Friction(),
        ...     walls=dem.box(4e-3, 1.998e-3),
        ...     gravity=(0.0, -9.81),
        ...     thickness=1e-3,
        ... )
        >>> run = dem.Simulation(scene, dem.State([[2e-3, 0.999e-3]]))
        >>> print(f"{1e-3 * run.stress().contact[1, 1]:.0f} kPa")
        776 kPa
        >>> print(f"{1e-3 * run.contacts().force[0] / (4e-3 * 1e-3):.0f} kPa")
        775 kPa
        """
        if x is not None and y is not None:
            raise InputError("x and y are both given; give edges along one of them.")
        world = self._seen
        planes = world.walls.planes
        _, place, _ = shares(self.scene, world.boundaries.motion)
        angle = world.boundaries.angle[len(self.scene.walls) :]
        rings = [
            solid.placed(place[k, [X, Y]], angle[k]) for k, solid in enumerate(self.scene.solids)
        ]
        bins = next(((k, np.asarray(e)) for k, e in enumerate((x, y)) if e is not None), None)
        return stress(self.contacts(), self.state, self.scene, planes, rings, bins)

    def ledger(self) -> Ledger:
        """Energies held, gained and lost since the start.

        Returns
        -------
        Ledger
            Energies (J).

        Raises
        ------
        InputError
            If the simulation was made without ``ledger=True``.

        Examples
        --------
        A cylinder moves through a bed of discs, and its work is accounted for:

        >>> import dem
        >>> import numpy as np
        >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
        >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3), velocity=(0.0, 1.0))
        >>> bed = dem.pack(shape, width=8e-3, height=9e-3, solids=cylinder, seed=1)
        >>> scene = dem.Scene(
        ...     shape, friction=dem.Friction(), walls=bed.walls, solids=cylinder
        ... )
        >>> run = dem.Simulation(scene, bed.state, ledger=True)
        >>> shortest = run.advance(1e-5)
        >>> energies = run.ledger()
        >>> energies.work > energies.held > 0.0
        True
        >>> energies.residual < 1e-3
        True
        """
        if self._at_start is None:
            raise InputError("ledger is False; make the Simulation with ledger=True.")
        report = self._progress_now()
        later = report.pending_kick + report.seen - report.time
        return energies(self._seen, *self._at_start, later)

    # Saved and continued

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Save the simulation as arrays, from which `restore` continues it exactly.

        Returns
        -------
        dict of str to ndarray
            Arrays by name (SI units), as ``numpy.savez`` takes them.

        See Also
        --------
        restore : Continue from a checkpoint.

        Examples
        --------
        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> saved = run.checkpoint()
        >>> shortest = run.advance(1e-4)
        >>> run.restore(saved)
        >>> run.time
        0.0
        """
        progress = numbers_of(self._progress_now())
        return written(self._world, progress=progress, scene=self._fingerprint())

    def restore(self, saved: Mapping[str, np.ndarray]) -> None:
        """Continue from a checkpoint of a simulation with the same scene and start.

        Further calls give the same bits as without the interruption.

        Parameters
        ----------
        saved : mapping of str to ndarray
            What `checkpoint` returned, or what ``numpy.load`` reads (SI units).

        Raises
        ------
        InputError
            If the checkpoint is of another scene, or has arrays that no simulation writes. The
            simulation is then unchanged.

        See Also
        --------
        checkpoint : Save a simulation; its example restores one.
        """
        saved = read(saved)
        if saved["scene"].tobytes() != self._fingerprint().tobytes():
            raise InputError("saved is no checkpoint of this simulation; it is of another scene.")
        report = self._progress_now()
        world = replaced(writable(self._world), saved)
        if self._table.alone:  # a granule is its own only constituent: one array for both
            world = world._replace(force=world.constituent_force)
        self._world, self._progress = world, with_numbers(report, saved["progress"])

    def _fingerprint(self) -> np.ndarray:
        """Hash that differs between scenes, options and orders of granules in memory."""
        return fingerprint(self.scene, self._rules, self._order, self._at_start is None)

    # Motion

    @checked
    def set_velocity(
        self,
        velocity: Velocity,
        solid: Count = 0,
        spin: Annotated[Number, Unit("rad s-1")] | None = None,
    ) -> None:
        """Change the velocity of a solid from now on.

        Parameters
        ----------
        velocity : tuple of float
            Velocity (x, y) in m/s.
        solid : int
            Number of the solid in the scene, without unit.
        spin : float, optional
            Angular velocity (rad/s), anticlockwise; None to leave it as it is.

        Raises
        ------
        InputError
            If the scene has no such solid, if it follows a PrescribedMotion, a Drive or a Turn
            there, or if `velocity` does not hold two finite numbers.

        Examples
        --------
        A cylinder that stops does no more work. Here it stops before it moves:

        >>> import dem
        >>> import numpy as np
        >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
        >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3), velocity=(0.0, 1.0))
        >>> bed = dem.pack(shape, width=8e-3, height=9e-3, solids=cylinder, seed=1)
        >>> scene = dem.Scene(
        ...     shape, friction=dem.Friction(), walls=bed.walls, solids=cylinder
        ... )
        >>> run = dem.Simulation(scene, bed.state)
        >>> run.set_velocity((0.0, 0.0))
        >>> shortest = run.advance(1e-5)
        >>> print(f"{1e6 * run.diagnose().kinetic_energy:.3f} uJ")
        0.000 uJ
        """
        if not 0 <= solid < len(self.scene.solids):
            raise InputError(
                f"solid is {solid}; the scene has {len(self.scene.solids)}, numbered from 0."
            )
        moving = self.scene.solids[solid]
        if not isinstance(moving.velocity, tuple):
            raise InputError(
                f"velocity cannot be set: solids[{solid}] follows a PrescribedMotion or a Drive."
            )
        if spin is not None and isinstance(moving.spin, Turn):
            raise InputError(f"spin cannot be set: solids[{solid}] follows a Turn.")
        report, seen = self._progress_now(), self._seen.boundaries
        boundaries, ahead = self._world.boundaries, report.seen - report.time
        b = len(self.scene.walls) + solid
        # until now, and from now on
        before, after = boundaries.waypoints[boundaries.first_waypoint[b] :][:2]
        before[0] = after[0] = boundaries.time[0] + ahead
        before[1:3] = after[1:3] = velocity
        if spin is not None:
            before[3] = after[3] = spin
        if ahead > 0.0:
            before[1:3] = (seen.motion[b, :2] - boundaries.motion[b, :2]) / ahead
            if spin is not None:
                before[3] = (seen.angle[b] - boundaries.angle[b]) / ahead
        self._progress = report._replace(scanned=-1)

    @checked
    def advance(self, duration: Annotated[NotNegative, Unit("s")]) -> float:
        """Advance the motion by a duration.

        Parameters
        ----------
        duration : float
            Time to advance (s), zero or positive.

        Returns
        -------
        float
            Shortest time step taken (s).

        Raises
        ------
        InputError
            If the duration takes too many time steps.
        StateError
            If a position or velocity is not a number, a granule leaves the walls, the time step
            shrinks too far, or the critical one becomes shorter than a fixed one. The message names
            step, time and granule.
        OverlapError
            If an overlap exceeds `max_overlap`.

        Notes
        -----
        A time step has collapsed if it is below a thousandth of the first one. A run then goes on
        only if what remains takes less than 4e8 steps times granules, a million steps for 400
        granules; otherwise it is a StateError. All runs end at 1e11 steps.

        Examples
        --------
        Without contact or gravity a disc moves straight on:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> shortest = run.advance(2e-5)
        >>> print(f"{1e6 * run.state.position[0, 0]:.3f} um")
        20.000 um
        """
        return self._advance("duration", self.time, duration, 1)

    @checked
    def record(self, interval: Time, count: Intervals) -> Record:
        """Advance over equal intervals and measure forces, energy and contacts in each.

        Impulses from before do not count, and none are left for `collect_impulses`. An interrupt
        loses the record, and leaves the impulses since the last whole interval.

        Parameters
        ----------
        interval : float
            Length of an interval (s).
        count : int
            Number of intervals c, without unit.

        Returns
        -------
        Record
            Mean forces (N) and final values of each interval, one row per interval.

        Raises
        ------
        InputError
            If the intervals take too many time steps.
        StateError, OverlapError
            As for `advance`.

        Examples
        --------
        A bed of discs resists a cylinder that moves upwards:

        >>> import dem
        >>> import numpy as np
        >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
        >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3), velocity=(0.0, 1.0))
        >>> bed = dem.pack(shape, width=8e-3, height=9e-3, solids=cylinder, seed=1)
        >>> scene = dem.Scene(
        ...     shape, friction=dem.Friction(), walls=bed.walls, solids=cylinder
        ... )
        >>> run = dem.Simulation(scene, bed.state)
        >>> record = run.record(interval=1e-5, count=4)
        >>> drag = -(record.normal_force + record.tangential_force)[:, 0, 1]  # N
        >>> bool((drag > 0.0).all())
        True
        """
        self.collect_impulses()
        rows = np.zeros((count, OF_BED + OF_BOUNDARY * len(self._world.boundaries.motion)))
        self._advance("interval * count", self.time, interval, count, rows)
        self.diagnose()  # the guard on overlaps, also for the end of the last interval
        walls, solids, held = shares(self.scene, rows[:, OF_BED:].reshape(count, -1, OF_BOUNDARY))
        energy, contacts, overlap, step = rows[:, :OF_BED].T
        return Record(
            normal_force=solids[..., :2],
            tangential_force=solids[..., 2:4],
            wall_force=walls[..., 0],
            kinetic_energy=energy,
            coordination_number=contacts,
            max_overlap=overlap,
            time_step=step,
            torque=solids[..., 4],
            solid_position=solids[..., PLACE:ANGLE],
            solid_angle=solids[..., ANGLE],
            wall_tangential_force=walls[..., 3],
            wall_offset=walls[..., PLACE],
            held_force=held[..., :2],
        )

    # Calls of the kernel

    def _progress_now(self) -> Progress:
        """How far the arrays are; raises StateError where a call has not come to its end."""
        if self._in_kernel:
            raise StateError(
                "the simulation is in the midst of a step: another thread advances it, this "
                "process was forked from it there, or an error cut it off there; wait, or make it "
                "again."
            )
        return self._progress

    def _observe(self) -> tuple[World, Diagnostics]:
        """A copy of the arrays at the time that was asked for, which may lie within a step, and how
        they are.

        Lists and contact history are those of the arrays themselves.
        """
        report = self._progress_now()
        if self._view is None or self._view[0] is not report:
            schedule = Schedule(
                begin=report.seen,
                interval=0.0,
                intervals=0,
                until=self._until,
                initialise=False,
                observe_only=True,
                budget=0,
            )
            with signals_deferred():
                seen, observed = self._call(report, schedule, np.zeros((0, 0)))
            # one array for granules and constituents where they are alone
            for rows in (seen.bodies,) if self._table.alone else (seen.bodies, seen.constituents):
                rows[:, [X, Y]] += np.multiply(self._rules.frame, report.seen)
                rows[:, [VX, VY]] += self._rules.frame
            self._view = report, seen, observed.diagnostics
        return self._view[1:]

    @property
    def _seen(self) -> World:
        """The arrays at the time that was asked for."""
        return self._observe()[0]

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: no two arrays that share memory."""
        self._progress_now()
        return vars(self) | {"_world": writable(self._world), "_view": None, "_lock": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _lock=threading.Lock())

    def _call(self, before: Progress, schedule: Schedule, record: np.ndarray) -> Any:
        """World and Progress after one call of the kernel, the only one that a simulation needs."""
        given = self._world, self._table, self._rules, schedule, before, record
        if self._threads == 1:
            return run_steps(*given, None)
        with Threads(self._threads) as threads:
            return run_steps.py_func(*given, threads)

    def _run_kernel(
        self,
        begin: float,
        interval: float,
        intervals: int,
        record: np.ndarray | None = None,
        initialise: bool = False,
    ) -> Progress:
        """Call the kernel until it has done all intervals.

        It returns every so often, also inside an interval, so that Python can answer an interrupt.
        Bits do not depend on how often.
        """
        self._progress_now()
        if not self._lock.acquire(blocking=False):
            raise StateError(
                "the simulation advances already, in another thread or outside this signal "
                "handler; wait until that has ended."
            )
        try:
            record = np.zeros((0, 0)) if record is None else record
            report = self._progress._replace(outcome=FINE)
            while True:
                clock = time.perf_counter()
                schedule = Schedule(
                    begin=float(begin),
                    interval=float(interval),
                    intervals=intervals,
                    until=self._until,
                    initialise=initialise,
                    observe_only=False,
                    budget=self._budget,
                )
                # the first call compiles, and leaves nothing that is worth being kept
                with nullcontext() if initialise else signals_deferred():
                    self._in_kernel = True
                    self._world, self._progress = self._call(report, schedule, record)
                    self._in_kernel = False
                report = self._progress
                if report.outcome != PAUSED:
                    return report
                initialise, took = False, time.perf_counter() - clock
                if took < BRIEF:
                    self._budget *= 2
                elif took > LONG:
                    self._budget = max(self._budget // 2, 1)
        finally:
            self._lock.release()

    def _advance(
        self, name: str, begin: float, interval: float, count: int, record: np.ndarray | None = None
    ) -> float:
        """Advance to the end of `count` intervals (s) after a time (s); returns the shortest step
        (s)."""
        before = self._progress_now()
        report = self._run_kernel(begin, interval, count, record)
        if report.outcome == TOO_LONG and report.steps == before.steps:
            duration = begin + interval * count - before.seen
            raise InputError(self._endless(name, duration, report.value))
        if report.outcome:
            self._fail(report)
        return report.shortest

    def _endless(self, name: str, duration: float, step: float) -> str:
        return (
            f"{name} is {duration:g} s, more than {MOST_STEPS:.0e} time steps of {step:.3g} s: "
            "granules are too small, stiff, light or fast for it."
        )

    # Guards: between two neighbour lists nothing moves by more than half the skin. A check at each
    # new list therefore sees every overlap before it has grown by more than the skin.

    @np.errstate(all="ignore")
    def _fail(self, report: Progress) -> NoReturn:
        outcome, value, granule = report.outcome, report.value, report.granule
        when = f"at step {report.steps}, time {report.time:.6g} s"
        lost = ~np.isfinite(self._world.bodies).all(axis=1)
        if lost.any():
            raise StateError(
                f"the motion of granule {self._order[lost.argmax()]} is not a number {when}: take "
                "a smaller time step."
            )
        if outcome == LOST:
            moved = np.linalg.norm(self._world.constituents[:, :2] - self._world.reference, axis=1)
            farthest = int(self._world.shape.owner[moved.argmax()])
            what = f"granule {self._order[farthest]}" if moved.max() >= value else "a boundary"
            raise StateError(
                f"{what} moved {value:.3g} m before its contacts were listed again {when}; it may "
                f"move {self._rules.reach:.3g} m: take a smaller time step."
            )
        if outcome == TOO_LONG:
            raise StateError(
                f"the time step has shrunk to {value:.3g} s {when}, and what remains would take "
                f"more than {MOST_STEPS:.0e}: granules are too fast for a run of this duration."
            )
        if outcome == COLLAPSED:
            raise StateError(
                f"the time step has shrunk too far {when}: {value:.3g} s is less than {COLLAPSE:g} "
                "of the first one, and what remains would take more than "
                f"{MOST_WORK / len(self._order):.0e} steps: granules are too fast."
            )
        if outcome == UNSTABLE:
            raise StateError(
                f"time_step is {self._rules.time_step:.4g} s, longer than the critical one, "
                f"{value:.4g} s, {when}: make it shorter, leave it out, or set allow_unstable."
            )
        if outcome == OUTSIDE:
            planes = self._world.walls.planes
            beyond = planes[:, :2] @ self._world.bodies[granule, :2] - planes[:, 2]
            raise StateError(
                f"granule {self._order[granule]} has its centre {beyond.max():.3g} m behind wall "
                f"{beyond.argmax()} {when}: put it inside, or take a smaller time step."
            )
        remedy = "take a smaller time step, a stiffer material or a lower packing fraction"
        if not report.steps:
            remedy = "place the granules farther apart"
        raise OverlapError(
            f"granule {self._order[granule]} overlaps by {value:.3g} of the smaller radius {when}; "
            f"the limit is {self._rules.max_overlap:g}: {remedy}."
        )


@checked
def simulate(
    scene: InstanceOf[Scene],
    state: InstanceOf[State],
    duration: Time,
    time_step: Time | None = None,
    frames: Intervals = 1,
    *,
    step_fraction: StepFraction = STEP_FRACTION,
    max_overlap: MaxOverlap = MAX_OVERLAP,
    skin: Skin | None = None,
    threads: ThreadCount = 1,
    allow_unstable: bool = False,
) -> Result:
    """Simulate a scene from a state and return arrays.

    Parameters
    ----------
    scene : Scene
        What is simulated: n granules, walls, solids.
    state : State
        Where the granules start, and how they move.
    duration : float
        Time to simulate (s).
    time_step : float, optional
        Time step (s); None, which is recommended, chooses it from the stiffness of the contacts.
    frames : int
        Number of equal intervals after each of which the state is kept (without unit). All frames
        together must fit into a gibibyte.
    step_fraction : float
        As in Simulation (without unit).
    max_overlap : float
        As in Simulation (without unit).
    skin : float, optional
        As in Simulation (without unit).
    threads : int
        As in Simulation (without unit).
    allow_unstable : bool
        As in Simulation.

    Returns
    -------
    Result
        The start and a frame per interval, frames + 1 in all.

    Raises
    ------
    InputError
        If a value cannot be used.
    RunError
        If the run fails: StateError or OverlapError.

    Examples
    --------
    Two discs collide in empty space and part at half their speed:

    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
    >>> state = dem.State([[0, 0], [2.1e-3, 0]], velocity=[[1, 0], [-1, 0]])
    >>> result = dem.simulate(scene, state, duration=1e-4)
    >>> result.velocity[-1, :, 0].round(1)
    array([-0.5,  0.5])
    """
    run = Simulation(
        scene,
        state,
        time_step,
        step_fraction,
        max_overlap,
        skin,
        threads,
        allow_unstable=allow_unstable,
    )
    run.check_duration(duration)
    interval, shortest, first = duration / frames, math.inf, _frame(run, math.nan)
    size = 8 * (frames + 1) * sum(map(np.size, first.values()))
    if size > MOST_FRAME_BYTES:
        raise InputError(
            f"frames is {frames}; of {scene.granules} granules they fill {size / 2**30:.3g} GiB, "
            f"more than {MOST_FRAME_BYTES / 2**30:g}: keep fewer, or advance a Simulation and save "
            "what you need."
        )
    series = {name: np.empty((frames + 1, *np.shape(value))) for name, value in first.items()}
    for frame in range(frames + 1):
        if frame:  # the last one ends at the duration itself, however many there are
            end = duration * (frame / frames)
            shortest = min(shortest, run._advance("duration", end, 0.0, 1))
        for name, value in (_frame(run, interval) if frame else first).items():
            series[name][frame] = value
    optional: dict[str, Any] = {"held_force": None}
    return Result(**optional | series, state=run.state, time_step=shortest, scene=scene)


def _frame(run: Simulation, interval: float) -> dict[str, Any]:
    """The simulation as it is, and the mean forces (N) since the frame before, an interval (s)
    ago."""
    world, state, (walls, solids, held) = run.world, run.state, run._take_impulses()
    _, place, _ = shares(run.scene, world.boundaries.motion)
    frame = {name: getattr(state, name) for name in ARRAYS} | {
        "time": run.time,
        "solid_force": (solids[:, :2] + solids[:, 2:4]) / interval,
        "solid_torque": solids[:, 4] / interval,
        "solid_position": place[:, [X, Y]],
        "solid_angle": world.boundaries.angle[len(walls) : len(walls) + len(solids)],
        "wall_force": walls[:, 0] / interval,
        "wall_tangential_force": walls[:, 3] / interval,
        "wall_offset": world.walls.planes[:, 2],
    }
    if world.held is not None:
        frame["held_force"] = held[:, :2] / interval
    return frame
