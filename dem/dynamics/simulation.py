"""A scene in motion, which you advance and look at between calls."""

import math
import os
import warnings
from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from dem.base.errors import InputError
from dem.base.validate import (
    LEAST,
    checked,
    flag,
    not_negative,
    number,
    one_of,
    or_none,
    positive,
    refuse,
    up_to,
    vector,
    whole,
)
from dem.dynamics.assembly import assemble, granule_table, least_step
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
from dem.dynamics.engine import Engine
from dem.dynamics.ordering import order_of, ordered
from dem.dynamics.result import Record, bearings, shares
from dem.dynamics.skin import SKIN, skin_for
from dem.dynamics.stepping import (
    MOST_STEPS,
    OF_BED,
    OF_BOUNDARY,
    PLACE,
    TOO_DEEP,
    StepControl,
)
from dem.dynamics.stress import Stress, edges, stress
from dem.dynamics.world import World
from dem.jit.columns import VX, VY, W
from dem.scene import Scene, State

STEP_FRACTION = 0.3  # of the bound on the critical time step
LARGEST_OVERLAP = 1.2  # of the smaller radius
MOST_THREADS = max(64, 4 * (os.cpu_count() or 1))
PIECES = whole(1, 10_000_000)  # beyond that their arrays fill any memory
DURATION = positive("s")
STABLE = "lie above 0 and up to 1, or with allow_unstable above 0"
FRACTION = number(STABLE, LEAST)


class Simulation(Engine):
    """A scene in motion, which you advance and look at between calls.

    Parameters
    ----------
    scene : Scene
        Granules, materials and boundaries.
    state : State
        Positions and velocities at the start.
    time_step : float, optional
        Fixed time step (s), not longer than the critical one at any time. None for one that is held below
        it (recommended).
    step_fraction : float
        Time step over the critical one, both without damping, without unit, above 0 and up to 1. The
        default keeps the energy of elastic gases; 0.5 is enough for dense beds with damping.
    max_overlap : float
        Largest allowed overlap over the smaller radius, without unit, up to 1.5.
    skin : float, optional
        Skin of the neighbour list over the mean bounding radius, without unit. It changes the speed, and
        at which steps the time step is chosen again. None for one that follows from the speeds at the
        start (recommended). A short period makes it smaller.
    threads : int
        Number of threads, without unit, for beds of thousands of granules. The result does not
        depend on it. A small bed uses fewer.
    ledger : bool
        Keep an energy ledger. A run takes about ten per cent longer.
    allow_unstable : bool
        Take the requested step, even if it is unstable. `step_fraction` may then exceed 1, no step is
        shortened for fast granules, and a `time_step` that is longer than the critical one at the start
        is a RuntimeWarning.

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
        If a value cannot be used, or the state is not for the granules and the boundaries of the scene.
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
    2000 steps that allowed it; it is one of the powers of two, or of seven steps between two of them.
    Steps are whole: what you see at a time within a step is a copy, taken there from the last whole
    step, so that the motion does not depend on when you look. `Material` and `Friction` give the forces.

    Ctrl-C is answered within about a second, and within some seconds while the kernel is compiled. `time`
    and everything else then say what has been simulated until then, and you can go on from there. A
    simulation can be pickled and copied, and used in a forked process.

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

    @checked()
    def __init__(
        self,
        scene: Annotated[Scene, one_of(Scene)],
        state: Annotated[State, one_of(State)],
        time_step: Annotated[float | None, or_none(positive("s"))] = None,
        step_fraction: Annotated[float, FRACTION] = STEP_FRACTION,
        max_overlap: Annotated[float, up_to(1.5)] = LARGEST_OVERLAP,
        skin: Annotated[float | None, or_none(up_to(100.0))] = None,
        threads: Annotated[int, whole(1, MOST_THREADS)] = 1,
        ledger: Annotated[bool, flag] = False,
        allow_unstable: Annotated[bool, flag] = False,
    ):
        if step_fraction > 1.0 and not allow_unstable:
            refuse("step_fraction", step_fraction, STABLE)
        if ledger and threads > 1:
            raise InputError(f"threads is {threads}; with an energy ledger it must be 1.")
        self.scene, self.time_step = scene, time_step
        self.step_fraction, self.max_overlap = step_fraction, max_overlap
        state, frame = state.checked(scene.granules), (0.0, 0.0)
        reached = state.boundaries
        if scene.walls is None and not scene.cylinder and not scene.held:
            x, y = np.average(state.velocity, axis=0, weights=scene.mass)
            frame = float(x), float(y)
            state.velocity -= frame
        self._order = order_of(scene, state)
        scene, state = ordered(scene, state, self._order)
        table, least = granule_table(scene, skin or SKIN, step_fraction), 0.0
        world = assemble(scene, state, table, ledger)
        self._begun = bearings(scene, world)
        if reached is not None and not np.array_equal(reached, self._begun):
            raise InputError(
                "state was reached with boundaries in other places or at other speeds than those of scene; "
                "go on with a Simulation, or move them in the scene and make boundaries of the state None."
            )
        if skin is None:
            table = table._replace(skin=skin_for(scene, world, table, time_step))
        if not time_step:
            drive = world.boundaries.drive
            least = least_step(scene, table, drive, float(max_overlap), step_fraction)
        rules = StepControl(
            time_step=float(time_step or 0.0),
            max_overlap=float(max_overlap),
            reach=0.5 * table.skin,
            flies=allow_unstable,
            frame=frame,
            collapsed=least,
        )
        super().__init__(world, table, rules, self._order, threads)
        critical = self._latest()[1].diagnostics.critical_time_step
        if rules.time_step > critical:
            warnings.warn(
                f"time_step is {time_step:.4g} s, longer than the critical one, {critical:.4g} s: "
                "motions can grow.",
                RuntimeWarning,
                stacklevel=3,
            )
        self._start = (sum(balance(self._world)), fallen(self._world)) if ledger else None

    @property
    def time(self) -> float:
        """Time since the start (s)."""
        return self._latest()[1].seen

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
        return int(self._latest()[1].steps)

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
        return read_only(self._world)

    @property
    def state(self) -> State:
        """Copy of positions (m), velocities (m/s), angles (rad), angular velocities (rad/s) and `boundaries`."""
        back = np.argsort(self._order)
        bodies, angle = self._world.bodies[back], self._world.angle[back]
        reached = bearings(self.scene, self._world)
        moved = None if np.array_equal(reached, self._begun) else reached
        return State(bodies[:, :2].copy(), bodies[:, [VX, VY]], angle, bodies[:, W].copy(), moved)

    def collect_impulses(self) -> tuple[np.ndarray, np.ndarray]:
        """Impulses of the granules on cylinder and walls since the last call.

        Returns
        -------
        on_cylinder : ndarray of shape (2, 2)
            Impulses (x, y) in N s: of the normal forces in the first row, of the tangential forces
            in the second.
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
        ...     cylinder=dem.Cylinder(diameter=2e-3, position=(5e-3, 15e-3)),
        ... )
        >>> run = dem.Simulation(scene, dem.State([[8.9e-3, 5e-3]], velocity=[[1.0, 0.0]]))
        >>> shortest = run.advance(4e-4)
        >>> left, right, bottom, top = run.collect_impulses()[1]
        >>> print(f"{right / (scene.mass[0] * (1.0 - run.state.velocity[0, 0])):.3f}")
        1.000
        """
        walls, cylinder, _ = self._collect()
        return cylinder[:4].reshape(2, 2), walls[:, 0]

    def _collect(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Boundaries.sums since the last call, of walls, cylinder and held groups."""
        seen = self._world.boundaries.sums
        found = seen.copy()
        for sums in (self._latest()[0].boundaries.sums, seen):
            sums -= found
        return shares(self.scene, found)

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
        diagnostics = self._seen()[1]
        if not diagnostics.max_overlap <= self.max_overlap:
            value, granule = diagnostics.max_overlap, diagnostics.deepest
            report = self._latest()[1]
            self._fail(report._replace(outcome=TOO_DEEP, value=value, granule=granule))
        return diagnostics._replace(deepest=int(self._order[diagnostics.deepest]))

    @checked(duration=DURATION)
    def check_duration(self, duration: float) -> None:
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
        step = self._latest()[1].dt
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
        return list_contacts(self._world, self._order)

    @checked(x=or_none(edges), y=or_none(edges))
    def stress(self, x: ArrayLike | None = None, y: ArrayLike | None = None) -> Stress:
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
            If edges do not rise, are given along both axes, or leave a container that is not closed.

        Notes
        -----
        The stress of the contacts is the sum of ``f l`` over the volume: force f on the partner,
        branch vector l of `ContactList`. The volume is the thickness times the area between walls,
        edges and periodic sides, without the cylinder. In bins a contact counts for the share of its branch vector
        that is in the bin. The fabric counts contacts by their points, the other measures granules
        by their centres.

        Examples
        --------
        A disc of 1 mm radius is pressed between floor and lid, 1 um on either side. The force on either
        over its area, 4 mm times 1 mm, is the stress:

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
        world = self._world
        planes = np.empty((0, 3)) if world.walls is None else world.walls.planes
        _, place, _ = shares(self.scene, world.boundaries.motion)
        bins = next(((k, np.asarray(e)) for k, e in enumerate((x, y)) if e is not None), None)
        return stress(self.contacts(), self.state, self.scene, planes, place, bins)

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
        >>> bed = dem.pack(shape, width=8e-3, height=9e-3, cylinder=cylinder, seed=1)
        >>> scene = dem.Scene(
        ...     shape, friction=dem.Friction(), walls=bed.walls, cylinder=cylinder
        ... )
        >>> run = dem.Simulation(scene, bed.state, ledger=True)
        >>> shortest = run.advance(1e-5)
        >>> energies = run.ledger()
        >>> energies.work > energies.held > 0.0
        True
        >>> energies.residual < 1e-3
        True
        """
        if self._start is None:
            raise InputError("ledger is False; make the Simulation with ledger=True.")
        report = self._latest()[1]
        return energies(self._world, *self._start, report.owed + report.seen - report.time)

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
        world, report = self._latest()
        return written(world, progress=numbers_of(report._replace(calls=0)), scene=self._fingerprint())

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
        world, report = self._latest()
        world = replaced(writable(world), saved)
        alone = self._table.per == 1  # a granule is its own only constituent: one array for both
        world = world._replace(force=world.constituent_force) if alone else world
        progress = with_numbers(report, saved["progress"])
        self._now[:] = [(world, progress._replace(calls=report.calls))]

    def _fingerprint(self) -> np.ndarray:
        """Hash that differs between scenes, options and orders of granules in memory."""
        rules = self._rules._replace(collapsed=0.0)  # it depends on the start
        return fingerprint(self.scene, rules, self._order, self._start is None)

    # Motion

    @checked(velocity=vector("m/s"))
    def set_cylinder_velocity(self, velocity: tuple[float, float]) -> None:
        """Change the velocity of the cylinder from now on.

        Parameters
        ----------
        velocity : tuple of float
            Velocity (x, y) in m/s.

        Raises
        ------
        InputError
            If the scene has no cylinder, if it follows a PrescribedMotion or a Drive, or if `velocity` does not
            hold two finite numbers.

        Examples
        --------
        A cylinder that stops does no more work. Here it stops before it moves:

        >>> import dem
        >>> import numpy as np
        >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
        >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3), velocity=(0.0, 1.0))
        >>> bed = dem.pack(shape, width=8e-3, height=9e-3, cylinder=cylinder, seed=1)
        >>> scene = dem.Scene(
        ...     shape, friction=dem.Friction(), walls=bed.walls, cylinder=cylinder
        ... )
        >>> run = dem.Simulation(scene, bed.state)
        >>> run.set_cylinder_velocity((0.0, 0.0))
        >>> shortest = run.advance(1e-5)
        >>> print(f"{1e6 * run.diagnose().kinetic_energy:.3f} uJ")
        0.000 uJ
        """
        if self.scene.cylinder is None:
            raise InputError("velocity cannot be set: the scene has no cylinder.")
        if not isinstance(self.scene.cylinder.velocity, tuple):
            raise InputError(
                "velocity cannot be set: the cylinder follows a PrescribedMotion or a Drive."
            )
        (world, report), seen = self._latest(), self._world.boundaries
        boundaries, ahead = world.boundaries, report.seen - report.time
        axis = len(boundaries.motion) - len(self.scene.held) - 1
        before, after = boundaries.table[boundaries.first[axis] :][:2]  # until now, and from now on
        before[0] = after[0] = boundaries.clock[0] + ahead
        before[1:3] = after[1:3] = velocity
        if ahead > 0.0:
            before[1:3] = (seen.motion[axis, :2] - boundaries.motion[axis, :2]) / ahead
        self._now[:] = [(world, report._replace(surveyed=-1))]
        self._allow(0.5 * self._rules.reach / max(math.hypot(*velocity), LEAST))

    @checked(duration=not_negative("s"))
    def advance(self, duration: float) -> float:
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
            shrinks too far, or the critical one becomes shorter than a fixed one. The message names step, time and granule.
        OverlapError
            If an overlap exceeds `max_overlap`.

        Notes
        -----
        A time step has collapsed if it is below three hundredths of the first one, and of what the deepest
        contacts that `max_overlap` allows could ask for. A run then goes on only if what remains takes less than
        4e8 steps times granules, a million steps for 400 granules; otherwise it is a StateError. With a
        fixed `time_step` the limit is 1e11 steps, as for all runs.

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
        return self._run_steps("duration", self.time, duration, 1)

    @checked(interval=DURATION, count=PIECES)
    def record(self, interval: float, count: int) -> Record:
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
        >>> bed = dem.pack(shape, width=8e-3, height=9e-3, cylinder=cylinder, seed=1)
        >>> scene = dem.Scene(
        ...     shape, friction=dem.Friction(), walls=bed.walls, cylinder=cylinder
        ... )
        >>> run = dem.Simulation(scene, bed.state)
        >>> record = run.record(interval=1e-5, count=4)
        >>> drag = -(record.normal_force + record.tangential_force)[:, 1]  # N
        >>> bool((drag > 0.0).all())
        True
        """
        self.collect_impulses()
        rows = self._rows(count)
        self._run_steps("interval * count", self.time, interval, count, rows)
        self.diagnose()  # the guard on overlaps, also for the end of the last interval
        walls, cylinder, held = shares(self.scene, rows[:, OF_BED:].reshape(count, -1, OF_BOUNDARY))
        energy, contacts, overlap, step = rows[:, :OF_BED].T
        place = cylinder[:, PLACE:]
        return Record(
            cylinder[:, :2], cylinder[:, 2:4], walls[..., 0],
            energy, contacts, overlap, step, cylinder[:, 4],
            np.full_like(place, math.nan) if self.scene.cylinder is None else place,
            walls[..., 3], walls[..., PLACE], held[..., :2],
        )  # fmt: skip
