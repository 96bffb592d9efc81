"""A scene in motion, which you advance and look at between calls."""

import itertools
import math
import os
import time
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from dem.base.errors import InputError, OverlapError, StateError
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
from dem.dynamics.assembly import CAUTION, assemble, granule_table, least_step
from dem.dynamics.checkpoint import (
    clock,
    fingerprint,
    moving,
    read,
    read_only,
    replaced,
    writable,
)
from dem.dynamics.diagnostics import Diagnostics
from dem.dynamics.energy import Bookkeeper, Ledger
from dem.dynamics.ordering import order_of, ordered
from dem.dynamics.result import Impulses, Record
from dem.dynamics.skin import MARGIN, SKIN
from dem.dynamics.stepping import (
    AXIS,
    COLLAPSED,
    FINE,
    LOST,
    MOST_STEPS,
    MOST_WORK,
    NOTHING_DONE,
    ON_CYLINDER,
    ON_WALLS,
    OUTSIDE,
    PAUSED,
    TOO_DEEP,
    TOO_LONG,
    TORQUE,
    Schedule,
    StepControl,
    StepOutcome,
    longest_step,
    run_steps,
)
from dem.dynamics.stress import Container, Stress, edges, stress
from dem.dynamics.threads import Threads
from dem.dynamics.touching import Touching, touching
from dem.dynamics.world import CHUNK, World
from dem.jit.columns import VX, VY, W, X, Y
from dem.scene import Scene, State

STEP_FRACTION = 0.5  # of the bound on the critical time step
LARGEST_OVERLAP = 1.2  # of the smaller radius
LONGEST_FLIGHT = 0.02  # of the smallest radius, in one step
MOST_THREADS = max(64, 4 * (os.cpu_count() or 1))
PIECES = whole(1, 10_000_000)  # beyond that their arrays fill any memory
DURATION = positive("s")
BRIEF, LONG = 0.05, 0.15  # s: between these the kernel returns, so that Python can answer Ctrl-C
AT_FIRST = 20_000  # constituents times steps until it returns for the first time
STABLE = "lie above 0 and up to 1, or with allow_unstable above 0"
FRACTION = number(STABLE, LEAST)


class Simulation:
    """A scene in motion, which you advance and look at between calls.

    Parameters
    ----------
    scene : Scene
        Granules, materials and boundaries.
    state : State
        Positions and velocities at the start.
    time_step : float, optional
        Fixed time step (s). None for a step that follows the critical one (recommended).
    step_fraction : float
        Time step over the critical one, without unit, above 0 and up to 1.
    max_overlap : float
        Largest allowed overlap over the smaller radius, without unit, up to 1.5.
    skin : float
        Skin of the neighbour list over the mean bounding radius, without unit. It changes only the
        speed. A short period makes it smaller.
    threads : int
        Number of threads, without unit, for beds of thousands of granules. The result does not
        depend on it. A small bed uses fewer.
    ledger : bool
        Keep an energy ledger. A run takes about ten per cent longer.
    allow_unstable : bool
        Take the requested step, even if it is unstable. `step_fraction` may then exceed
        1, and no step is shortened for fast granules.

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
        If a value cannot be used, or the state is not for the granules of the scene.
    StateError
        If a granule is outside the walls.

    See Also
    --------
    simulate : One call that returns arrays.

    Notes
    -----
    Equations (1) and (2) of the paper, integrated with velocity Verlet. The critical step is a
    proven lower bound for small motions of the bed as it is. It is recomputed at every call of
    `advance` and whenever the neighbour list is rebuilt. `Material` and `Friction` give the forces.

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

    @checked(
        scene=one_of(Scene),
        state=one_of(State),
        time_step=or_none(positive("s")),
        step_fraction=FRACTION,
        max_overlap=up_to(1.5),
        skin=up_to(100.0),
        threads=whole(1, MOST_THREADS),
        ledger=flag,
        allow_unstable=flag,
    )
    def __init__(
        self,
        scene: Scene,
        state: State,
        time_step: float | None = None,
        step_fraction: float = STEP_FRACTION,
        max_overlap: float = LARGEST_OVERLAP,
        skin: float = SKIN,
        threads: int = 1,
        ledger: bool = False,
        allow_unstable: bool = False,
    ):
        if step_fraction > 1.0 and not allow_unstable:
            refuse("step_fraction", step_fraction, STABLE)
        if ledger and threads > 1:
            raise InputError(f"threads is {threads}; with an energy ledger it must be 1.")
        self.scene = scene
        threads = min(threads, math.ceil(scene.granules / CHUNK))
        self._threads = Threads(threads) if threads > 1 else None
        self.time_step = time_step
        self.step_fraction = step_fraction
        self.max_overlap = max_overlap
        self._until = 0.0
        state = state.checked(scene.granules)
        self._order = order_of(scene, state)
        if self._order is not None:
            scene, state = ordered(scene, state, self._order)
        self._table = granule_table(scene, skin)
        self._rules = self._make_rules(allow_unstable)
        self._calls = np.zeros(1, np.int64)
        world = assemble(scene, state, self._table, ledger)
        self._now = [(world, NOTHING_DONE)]
        self._free = [None]  # whoever advances holds what is in it
        self._budget = max(AT_FIRST // len(world.constituents), 1)
        self._check_inside()
        self._allow(longest_step(self._rules, self._take(0.0, 0, starts=True).diagnostics))
        self._bookkeeper = Bookkeeper(self._world) if ledger else None

    def _make_rules(self, allow_unstable: bool) -> StepControl:
        reach = 0.5 * self._table.skin
        farthest = min(LONGEST_FLIGHT * self._table.radius.min(), (1.0 - MARGIN) * reach)
        return StepControl(
            time_step=float(self.time_step or 0.0),
            fraction=self.step_fraction,
            largest_motion=math.inf if allow_unstable else float(farthest),
            max_overlap=float(self.max_overlap),
            rebuild_at=MARGIN * reach,
            list_range=reach,
            collapsed=0.0 if self.time_step else least_step(
                self.scene, self._table, float(self.max_overlap), self.step_fraction
            ),
        )  # fmt: skip

    def _allow(self, step: float) -> None:
        """A time step (s) that was asked for, and what is not much shorter, is no collapse."""
        least = min(self._rules.collapsed, CAUTION * step)
        self._rules = self._rules._replace(collapsed=float(least))

    # What can be read between calls. An interrupt may come between any two instructions of Python, so that
    # all that an advance changes is in one place, `_now`, which changes at once.

    def _latest(self) -> tuple[World, StepOutcome]:
        """The arrays and how far they are; raises StateError where a call has not come to its end."""
        if self._threads is not None:
            self._threads.finish()
        world, report = self._now[0]
        if self._calls[0] != report.calls:
            raise StateError(
                "the simulation is in the midst of a step: another thread advances it, this process was "
                "forked from it there, or an error cut it off there; wait, or make it again."
            )
        return world, report

    def _ended(self) -> tuple[World, StepOutcome]:
        """The latest arrays with velocities of full steps, also after an interrupt inside an interval.

        It works on a copy, and may itself be interrupted. Whoever looks from within a signal handler
        does not change a run that goes on after it.
        """
        world, report = self._latest()
        if report.outcome != PAUSED:
            return world, report
        schedule = Schedule(0.0, 0, self._until, False, 0, np.zeros(1, np.int64))
        ended: list[tuple[World, StepOutcome]] = []
        while not ended:
            self._call(ended, (writable(world), report), schedule, self._rows(0))
        found = ended[0][0], report._replace(outcome=FINE)
        if self._free:
            self._now[:] = [found]
        return found

    @property
    def _world(self) -> World:
        """The arrays of the kernels; they can be written."""
        return self._ended()[0]

    @property
    def time(self) -> float:
        """Time since the start (s)."""
        return self._latest()[1].time

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

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: everything but the threads, and no two arrays that share memory."""
        world, report = self._ended()
        threads = None if self._threads is None else self._threads.count
        kept = {"_now": [(writable(world), report)], "_threads": threads, "_free": [None]}
        return vars(self) | kept | {"_calls": self._calls.copy()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        threads = state["_threads"]
        vars(self).update(state, _threads=None if threads is None else Threads(threads))

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
        """Copy of positions (m), velocities (m/s), angles (rad) and angular velocities (rad/s)."""
        bodies, angle = self._world.bodies, self._world.angle
        if self._order is not None:
            back = np.argsort(self._order)
            bodies, angle = bodies[back], angle[back]
        return State(bodies[:, :2].copy(), bodies[:, [VX, VY]], angle.copy(), bodies[:, W].copy())

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
        found = self._collect()
        return found.on_cylinder, found.on_walls

    def _collect(self) -> Impulses:
        """All impulses since the last call."""
        world = self._world
        cylinder, walls, held = world.cylinder, world.walls, world.held
        none = np.zeros(0)
        sums = (
            np.zeros(4) if cylinder is None else cylinder.impulse,
            none if walls is None else walls.impulse,
            np.zeros(1) if cylinder is None else cylinder.twist,
            none if walls is None else walls.shear,
            np.zeros((0, 2)) if held is None else held.impulse,
        )
        on_cylinder, on_walls, twist, shear, on_held = (each.copy() for each in sums)
        deque(map(np.ndarray.fill, sums, itertools.repeat(0.0)), 0)  # no interrupt cuts it in two
        return Impulses(on_cylinder.reshape(2, 2), on_walls, float(twist[0]), shear, on_held)

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
        diagnostics = self._take(0.0, 0).diagnostics
        if not diagnostics.max_overlap <= self.max_overlap:
            self._fail(TOO_DEEP, diagnostics.max_overlap, diagnostics.deepest)
        return diagnostics._replace(deepest=self._name(diagnostics.deepest))

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
        step = longest_step(self._rules, self.diagnose())
        if not duration <= MOST_STEPS * step:
            raise InputError(self._endless("duration", duration, step))
        self._until = self.time + duration

    def contacts(self) -> Touching:
        """All contacts at the present time.

        Returns
        -------
        Touching
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
        unordered = np.arange(self.scene.granules)
        return touching(self._world, unordered if self._order is None else self._order)

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
        branch vector l of `Touching`. The volume is the thickness times the area between walls,
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
        world, cylinder = self._world, None
        if world.cylinder is not None:
            axis = world.cylinder.motion[0]
            cylinder = float(axis[X]), float(axis[Y]), world.cylinder.radius
        planes = np.empty((0, 3)) if world.walls is None else world.walls.planes
        container = Container(
            planes, self.scene.thickness, cylinder, self.scene.periodic or (None, None)
        )
        bins = next(((k, np.asarray(e)) for k, e in enumerate((x, y)) if e is not None), None)
        state = self.state
        return stress(
            self.contacts(), state.position, state.velocity, self.scene.mass, container, bins
        )

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
        if self._bookkeeper is None:
            raise InputError("ledger is False; make the Simulation with ledger=True.")
        return self._bookkeeper.ledger(self._world)

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
        world, report = self._ended()
        saved = {name: array.copy() for name, array in moving(world).items()}
        saved |= {"time": np.array(report.time), "steps": np.array(report.steps, np.int64)}
        return saved | {"scene": self._fingerprint()}

    def restore(self, saved: Mapping[str, np.ndarray]) -> None:
        """Continue from a checkpoint of a simulation with the same scene and start.

        Further calls give the same bits as without the interruption, if they advance by the same
        durations.

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
        if saved.get("scene", np.empty(0)).tobytes() != self._fingerprint().tobytes():
            raise InputError("saved is no checkpoint of this simulation; it is of another scene.")
        time, steps = clock(saved)
        world, report = self._ended()
        world = replaced(writable(world), saved, self._table)
        alone = self._table.per == 1  # a granule is its own only constituent: one array for both
        world = world._replace(force=world.constituent_force) if alone else world
        self._now[:] = [(world, report._replace(time=time, steps=steps))]

    def _fingerprint(self) -> np.ndarray:
        """Hash that differs between scenes, options and orders of granules in memory."""
        world, order = self._world, None if self._order is None else self._order.copy()
        boundaries = [b for b in (world.walls, world.cylinder) if b is not None]
        fixed = [
            (b.contacts.friction, b.contacts.modulus, b.contacts.damping is None)
            for b in boundaries
        ]
        guided = [b.guide.orders for b in (*boundaries, world.held) if b is not None and b.guide]
        rules = self._rules._replace(collapsed=0.0)  # it depends on the start
        held = [world.shape, self._table, rules, world.pairs.friction, world.pairs.modulus]
        arrays = [world.inverse_mass, world.inverse_inertia, world.gravity, order]
        groups = None if world.held is None else world.held.group
        radius = None if world.cylinder is None else world.cylinder.radius
        return fingerprint(*held, fixed, radius, *arrays, self.scene.walls, groups, *guided)

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
        cylinder = self._world.cylinder
        if cylinder is None:
            raise InputError("velocity cannot be set: the scene has no cylinder.")
        if cylinder.guide is not None:
            raise InputError(
                "velocity cannot be set: the cylinder follows a PrescribedMotion or a Drive."
            )
        cylinder.motion[0, [VX, VY]] = velocity
        self._allow(self._rules.largest_motion / max(math.hypot(*velocity), LEAST))

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
            If a position or velocity is not a number, a granule leaves the walls, or the time step
            shrinks too far. The message names step, time and granule.
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
        return self._run_steps("duration", duration, 1)

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
        self._run_steps("interval * count", interval, count, rows)
        self.diagnose()  # the guard on overlaps, also for the end of the last interval
        energy, contacts, overlap, step = rows[:, :4].T
        walls, groups = self._walls, len(self.scene.held)
        of_walls = np.split(rows[:, ON_WALLS : ON_WALLS + 3 * walls], 3, axis=1)
        return Record(
            rows[:, ON_CYLINDER : ON_CYLINDER + 2], rows[:, ON_CYLINDER + 2 : TORQUE], of_walls[0],
            energy, contacts, overlap, step, rows[:, TORQUE], rows[:, AXIS:ON_WALLS], of_walls[1],
            of_walls[2], rows[:, ON_WALLS + 3 * walls :].reshape(count, groups, 2),
        )  # fmt: skip

    @property
    def _walls(self) -> int:
        return 0 if self.scene.walls is None else len(self.scene.walls)

    def _rows(self, count: int) -> np.ndarray:
        """Room for what `record` measures in a number of intervals."""
        rows = np.zeros((count, ON_WALLS + 3 * self._walls + 2 * len(self.scene.held)))
        if self.scene.cylinder is None:
            rows[:, AXIS:ON_WALLS] = math.nan
        return rows

    def _take(
        self,
        interval: float,
        count: int,
        rows: np.ndarray | None = None,
        starts: bool = False,
    ) -> StepOutcome:
        """Call the kernel, the only one that a simulation needs, until it has done all intervals.

        It returns every so often, also inside an interval, so that Python can answer an interrupt. Bits
        do not depend on how often.
        """
        rows = self._rows(0) if rows is None else rows
        mine: list[None] = []
        try:
            with suppress(IndexError):
                mine[:] = map(self._free.pop, (-1,))
            if not mine:
                raise StateError(
                    "the simulation advances already, in another thread or outside this signal handler; "
                    "wait until that has ended."
                )
            now = self._ended()
            if self._threads is not None and count:
                self._threads.compile(now[0])
            self._now[:] = [now]
            while True:
                began = time.perf_counter()
                schedule = Schedule(
                    float(interval), count, self._until, starts, self._budget, self._calls
                )
                self._call(self._now, now, schedule, rows)
                before, now = now, self._now[0]
                if now is before:  # the call was cancelled
                    continue
                if now[1].outcome != PAUSED:
                    return now[1]
                starts, took = False, time.perf_counter() - began
                if took < BRIEF:
                    self._budget *= 2
                elif took > LONG:
                    self._budget = max(self._budget // 2, 1)
        finally:
            self._free.extend(mine)

    def _call(
        self,
        found: list[tuple[World, StepOutcome]],
        now: tuple[World, StepOutcome],
        schedule: Schedule,
        rows: np.ndarray,
    ) -> None:
        """Call the kernel once and put what it returns into `found`, unless the call is cancelled.

        An interrupt comes before the kernel starts or after `found` has it, never between.
        """
        (world, before), threads = now, self._threads
        given = world, self._table, self._rules, schedule, before, rows, threads
        if schedule.starts and threads is not None:  # in the thread that an interrupt stops
            found[:] = [run_steps.py_func(*given)]
        elif (
            threads is None
        ):  # one instruction of Python, and boxing has none (dem.jit.return_values)
            found[:] = map(run_steps, *zip(given, strict=True))
        else:

            def work() -> None:
                found[:] = [run_steps.py_func(*given)]

            threads.lead(work)

    def _run_steps(
        self, name: str, interval: float, count: int, rows: np.ndarray | None = None
    ) -> float:
        steps = self.steps
        report = self._take(interval, count, rows)
        if report.outcome == TOO_LONG and report.steps == steps:
            raise InputError(self._endless(name, interval * count, report.value))
        if report.outcome:
            self._fail(report.outcome, report.value, report.granule)
        return report.shortest

    def _endless(self, name: str, duration: float, step: float) -> str:
        return (
            f"{name} is {duration:g} s, more than {MOST_STEPS:.0e} time steps of {step:.3g} s: "
            "granules are too small, stiff, light or fast for it."
        )

    def _collapse(self, step: float) -> str:
        return (
            f"The time step is {step:.3g} s, less than the contacts of this scene and its speeds at the start can "
            f"ask for ({self._rules.collapsed:.3g} s), and what remains would take more than "
            f"{MOST_WORK / self.scene.granules:.0e} steps: granules are too fast."
        )

    # Guards: between two neighbour lists nothing moves by more than half the skin. A check at each
    # new list therefore sees every overlap before it has grown by more than the skin.

    def _name(self, granule: int) -> int:
        """The user's number of a granule."""
        return granule if self._order is None else int(self._order[granule])

    @np.errstate(all="ignore")
    def _fail(self, outcome: int, value: float, granule: int) -> NoReturn:
        when = f"at step {self.steps}, time {self.time:.6g} s"
        lost = ~np.isfinite(self._world.bodies).all(axis=1)
        if lost.any():
            raise StateError(
                f"the motion of granule {self._name(int(lost.argmax()))} is not a number {when}: take a smaller "
                "time step."
            )
        if outcome == LOST:
            moved = np.linalg.norm(self._world.constituents[:, :2] - self._world.reference, axis=1)
            farthest = int(moved.argmax()) // self._table.per
            what = f"granule {self._name(farthest)}" if moved.max() >= value else "a boundary"
            raise StateError(
                f"{what} moved {value:.3g} m before its contacts were listed "
                f"again {when}; it may move {self._rules.list_range:.3g} m: take a smaller time "
                "step."
            )
        if outcome == TOO_LONG:
            raise StateError(
                f"the time step has shrunk to {value:.3g} s {when}, and what remains would take more "
                f"than {MOST_STEPS:.0e}: granules are too fast for a run of this duration."
            )
        if outcome == COLLAPSED:
            raise StateError(f"the time step has shrunk too far {when}. {self._collapse(value)}")
        if outcome == OUTSIDE:
            assert self._world.walls is not None
            planes = self._world.walls.planes
            beyond = planes[:, :2] @ self._world.bodies[granule, :2] - planes[:, 2]
            raise StateError(
                f"granule {self._name(granule)} has its centre {beyond.max():.3g} m behind wall "
                f"{beyond.argmax()} {when}: put it inside, or take a smaller time step."
            )
        remedy = "take a smaller time step, a stiffer material or a lower packing fraction"
        if not self.steps:
            remedy = "place the granules farther apart"
        raise OverlapError(
            f"granule {self._name(granule)} overlaps by {value:.3g} of the smaller radius {when}; the limit is "
            f"{self.max_overlap:g}: {remedy}."
        )

    def _check_inside(self) -> None:
        walls = self._world.walls
        if walls is None:
            return
        beyond = self._world.bodies[:, :2] @ walls.planes[:, :2].T > walls.planes[:, 2]
        if beyond.any():
            self._fail(OUTSIDE, 0.0, int(beyond.any(axis=1).argmax()))
