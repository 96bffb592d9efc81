"""A scene in motion, which you advance and look at between calls, or simulate in one call."""

import math
from collections.abc import Mapping
from copy import deepcopy
from typing import Annotated, Any

import numpy as np
from pydantic import InstanceOf

from dem.base.errors import InputError
from dem.base.types import Count, NotNegative, Time, Unit, checked
from dem.contacts.layout import VX, VY, W
from dem.dynamics.assembly import assemble, granule_table, order_of, ordered
from dem.dynamics.checkpoint import fingerprint, replaced, restored, written
from dem.dynamics.contact_output import ContactList, list_contacts, partner_words
from dem.dynamics.energy import Ledger, balance, energies, fallen
from dem.dynamics.engine import (
    ANGLE,
    MOST_STEPS,
    OF_BED,
    OF_BOUNDARY,
    PLACE,
    TOO_DEEP,
    Diagnostics,
    Engine,
    StepControl,
    failure,
)
from dem.dynamics.numerics import (
    MAX_OVERLAP,
    STEP_FRACTION,
    MaxOverlap,
    OneOrMore,
    Skin,
    StepFraction,
    check_stable,
)
from dem.dynamics.paths import shown
from dem.dynamics.result import Record, Result, shares
from dem.dynamics.skin import skin_for, skin_of, skins_of
from dem.dynamics.stress import Edges, Stress, stress
from dem.dynamics.system import System
from dem.dynamics.world import REMOVED, Boundaries, World
from dem.motion import Motion, Numbers, Spin, Velocities
from dem.scene import ARRAYS, TOUCHING, Scene, State


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
        speeds (recommended). A short period makes it smaller.
    threads : int
        Number of threads, without unit, for beds of thousands of granules. The result does not
        depend on it. A small bed uses fewer.
    ledger : bool
        Keep an energy ledger. A run takes about ten per cent longer.
    allow_unstable : bool
        Take the requested step, even if it is unstable. `step_fraction` may then exceed 1, and no
        step is shortened for fast granules.

    Attributes
    ----------
    scene : Scene
        The scene, with the motions of solids at the start.
    engine : Engine
        Its arrays, and the calls of the kernel: for the package itself.

    Raises
    ------
    InputError
        If a value cannot be used, or the state is not for the granules of the scene.
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

    Ctrl-C is answered within about a second, and you can go on from what has been simulated until
    then. A simulation can be pickled and copied, and used in a forked process.

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
    >>> print(f"{run.time:g} s, {run.steps > 100}")
    0.0002 s, True
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
        threads: OneOrMore = 1,
        ledger: bool = False,
        allow_unstable: bool = False,
    ):
        check_stable(step_fraction, allow_unstable)
        if ledger and threads > 1:
            raise InputError(f"threads is {threads}; with an energy ledger it must be 1.")
        self.scene, self.step_fraction, self._keeps_ledger = scene, step_fraction, ledger
        state, frame = state.checked(scene.granules), (0.0, 0.0)
        present = state.present
        self._check_free(present, "state")
        if not (scene.walls or scene.solids or scene.held or scene.base_plate):
            x, y = np.average(state.velocity[present], axis=0, weights=scene.mass[present])
            frame = float(x), float(y)
            state.velocity -= frame
        order = order_of(scene, state)
        system = self._assembled(state, order)
        if skin is None:
            width = skin_for(scene, system.world, system.table, time_step)
            skins = skins_of(scene, system.table)
        else:
            width = skin_of(scene, system.table, skin)
            skins = width, width
        rules = StepControl(
            time_step=float(time_step or 0.0),
            max_overlap=float(max_overlap),
            skins=skins,
            allow_unstable=allow_unstable,
            frame=frame,
        )
        self.engine = Engine(system, width, rules, order, threads)
        system = self.engine.observe()[0]
        self._at_start = (sum(balance(system)), fallen(system.world)) if ledger else None

    @property
    def time(self) -> float:
        """Time since the start (s)."""
        return self.engine.progress.seen

    @property
    def steps(self) -> int:
        """Number of time steps taken, without unit."""
        return int(self.engine.progress.steps)

    @property
    def world(self) -> World:
        """The arrays of the kernels, in SI units.

        Their granules may be in another order than those of the scene (dem.dynamics.assembly). Do
        not write to them, because the neighbour list and the time step rely on them;
        dem.dynamics.checkpoint.copied copies them.

        Examples
        --------
        >>> import dem
        >>> run = dem.Simulation(dem.Scene(dem.Disc([1e-3, 1e-3])), dem.State([[0, 0], [1, 0]]))
        >>> run.world.bodies.shape
        (2, 8)
        """
        return self.engine.observe()[0].world

    @property
    def state(self) -> State:
        """Copy of positions (m) and angles (rad) of granules with their rates (1/s), NaN of those that
        are not there. Another run that starts from it has its boundaries at their start;
        `checkpoint` keeps them."""
        return self._state(self.world, self.engine.order)

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
        >>> walls = dem.box(10e-3, 20e-3)
        >>> scene = dem.Scene(dem.Disc([1e-3]), friction=dem.Friction(), walls=walls)
        >>> run = dem.Simulation(scene, dem.State([[8.9e-3, 5e-3]], velocity=[[1.0, 0.0]]))
        >>> shortest = run.advance(4e-4)
        >>> left, right, bottom, top = run.collect_impulses()[1]
        >>> print(f"{right / (scene.mass[0] * (1.0 - run.state.velocity[0, 0])):.3f}")
        1.000
        """
        walls, solids, _ = shares(self.scene, self.engine.take_impulses())
        return solids[:, :4].reshape(-1, 2, 2), walls[:, 0]

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
        engine, diagnostics = self.engine, self.engine.observe()[1]
        value, granule = diagnostics.max_overlap, diagnostics.deepest
        if not value <= engine.rules.max_overlap:
            report = engine.progress._replace(outcome=TOO_DEEP, value=value, granule=granule)
            raise failure(report, engine.rules, engine.system, engine.order)
        return diagnostics._replace(deepest=int(engine.order[granule]))

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
        step = self.engine.progress.dt
        if not duration <= MOST_STEPS * step:
            raise InputError(
                f"duration is {duration:g} s, more than {MOST_STEPS:.0e} time steps of {step:.3g} s: "
                "granules are too small, stiff, light or fast for it."
            )
        self.engine.until = self.time + duration

    def contacts(self) -> ContactList:
        """All contacts at the present time.

        Returns
        -------
        ContactList
            Granules, points (m), normals, branch vectors (m), overlaps (m) and forces (N). A
            simulation starts without tangential springs.

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
        return list_contacts(self.engine.observe()[0], self.engine.order)

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
        A disc of 1 mm radius is pressed between floor and lid, 1 um on either side:

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
        """
        if x is not None and y is not None:
            raise InputError("x and y are both given; give edges along one of them.")
        bins = next(((k, np.asarray(e)) for k, e in enumerate((x, y)) if e is not None), None)
        return stress(self.contacts(), self.state, self.scene, self.world, bins)

    def ledger(self) -> Ledger:
        """Energies held, gained and lost since the start.

        Returns
        -------
        Ledger
            Energies (J).

        Raises
        ------
        InputError
            Without ``ledger=True``.

        Examples
        --------
        Two discs collide head-on, and their dashpot takes three quarters of their energy:

        >>> import dem
        >>> material = dem.Material(restitution=0.5)
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), material, dem.Friction())
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state, step_fraction=0.05, ledger=True)
        >>> shortest = run.advance(2e-4)
        >>> print(f"{run.ledger().damped / run.ledger().before:.2f}")
        0.75
        """
        if self._at_start is None:
            raise InputError("ledger is False; make the Simulation with ledger=True.")
        report = self.engine.progress
        later = report.pending_kick + report.seen - report.time
        return energies(self.engine.observe()[0], *self._at_start, later)

    def checkpoint(self) -> dict[str, np.ndarray]:
        """Save the simulation as arrays, from which `restore` continues it exactly.

        Returns
        -------
        dict of str to ndarray
            Arrays by name (SI units), as ``numpy.savez`` takes them.

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
        engine = self.engine
        own = {"scene": self._fingerprint(), "order": engine.order}
        return written(world=engine.world, progress=engine.progress, **own)

    def restore(self, saved: Mapping[str, np.ndarray]) -> None:
        """Continue from a checkpoint of a simulation with the same scene and start, also where other
        granules were there.

        Further calls give the same bits as without the interruption.

        Parameters
        ----------
        saved : mapping of str to ndarray
            What `checkpoint` returned, or what ``numpy.load`` reads (SI units).

        Raises
        ------
        InputError
            If the checkpoint is of another scene, or lacks arrays. The simulation is then
            unchanged.
        """
        if not np.array_equal(saved.get("scene"), self._fingerprint()):  # type: ignore[arg-type]
            raise InputError("saved is no checkpoint of this simulation; it is of another scene.")
        if lacking := self.checkpoint().keys() - saved.keys():
            raise InputError(f"saved is no whole checkpoint; it lacks {min(lacking)}.")
        engine, order = self.engine, saved["order"]
        system = self._assembled(State(np.zeros((self.scene.granules, 2))), order)
        engine.system, engine.order = system.suited(restored(system, saved)), np.array(order)
        engine.progress = replaced(engine.progress, saved, "progress")

    def _fingerprint(self) -> np.ndarray:
        """Hash that differs between scenes and options."""
        return fingerprint(self.scene, self.engine.rules, self._keeps_ledger)

    @checked
    def set_motion(
        self, solid: Count, velocity: Motion | None = None, spin: Spin | None = None
    ) -> None:
        """Let a solid move otherwise from now on.

        Parameters
        ----------
        solid : int
            Number of the solid in the scene, without unit.
        velocity : tuple of float, PrescribedMotion or Drive, optional
            Velocity (x, y) in m/s, or what it follows, as of `Solid`; None to leave it as it is.
        spin : float or Turn, optional
            Angular velocity (rad/s), anticlockwise, added to that of a `PrescribedMotion`, or a
            `Turn`; None to leave it as it is, but for a `PrescribedMotion` that has one.

        Raises
        ------
        InputError
            If the scene has no such solid, if it was removed, or if a value cannot be used.

        Notes
        -----
        A motion begins when it is set: times of a `PrescribedMotion` count from now, and a `Drive`
        or a `Turn` begins at its own velocity or spin. To drive the first solid that a normal force
        moves takes other kernels, which may have to be compiled. `scene` keeps the motion at the
        start.

        Examples
        --------
        A cylinder stops before it moves, and is then pulled by a force:

        >>> import dem
        >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3), velocity=(0.0, 1.0))
        >>> sides = {"friction": dem.Friction(), "periodic": (2e-2, 2e-2)}
        >>> scene = dem.Scene(dem.Disc([1e-3]), solids=cylinder, **sides)
        >>> run = dem.Simulation(scene, dem.State([[0.0, 0.0]]))
        >>> run.set_motion(0, velocity=(0.0, 0.0))
        >>> run.record(interval=1e-3, count=1).solid_position[0, 0].tolist()
        [0.004, 0.004]
        >>> run.set_motion(0, velocity=dem.Drive(force=(0.2, None), mass=1e-4))
        >>> run.record(interval=1e-3, count=1).solid_position[0, 0].round(6).tolist()
        [0.005, 0.004]
        """
        self._change(solid, velocity, spin)

    @checked
    def remove(self, solid: Count) -> None:
        """Take a solid out of the scene: from now on no granule meets it.

        Parameters
        ----------
        solid : int
            Number of the solid in the scene, without unit; others keep theirs.

        Raises
        ------
        InputError
            If the scene has no such solid, or if it was removed before.

        Notes
        -----
        Its contacts end with what they remember, and forces on it are zero from then on; its
        position and angle are NaN in records and frames. The ledger counts the elastic energy of
        its contacts, which it takes along, as negative work.

        Examples
        --------
        A disc lies on a plate. For 10 ms after the plate is removed it falls freely:

        >>> import dem
        >>> plate = dem.Solid(dem.plate(6e-3, 1e-3), position=(0.0, 0.0))
        >>> soft = dem.Material(young_modulus=1e6, restitution=0.1)
        >>> scene = dem.Scene(
        ...     dem.Disc([1e-3]), soft, dem.Friction(), solids=plate, gravity=(0.0, -9.81)
        ... )
        >>> run = dem.Simulation(scene, dem.State([[0.0, 1.5e-3]]))
        >>> shortest = run.advance(0.05)
        >>> rest = run.state.position[0, 1]
        >>> run.remove(0)
        >>> shortest = run.advance(0.01)
        >>> print(f"{1e3 * (rest - run.state.position[0, 1]):.2f} mm")
        0.49 mm
        """
        self._change(solid, (0.0, 0.0), 0.0, removed=True)

    def _change(self, solid: int, velocity: Any, spin: Any, removed: bool = False) -> None:
        """See dem.dynamics.engine.Engine.changed."""
        count = len(self.scene.solids)
        if not 0 <= solid < count:
            raise InputError(f"solid is {solid}; the scene has {count}, numbered from 0.")
        b = len(self.scene.walls) + solid
        if self.engine.world.boundaries.section[b] == REMOVED:
            raise InputError(f"solid is {solid}, which was removed; it must be one of the others.")
        self.engine = self.engine.changed(b, velocity, spin, removed)

    @checked
    def remove_granules(self, granules: Numbers) -> None:
        """Take granules out of the bed.

        Parameters
        ----------
        granules : array_like of int of shape (h,), or of bool of shape (n,)
            Their numbers in the scene, or for each granule whether it goes (without unit).

        Raises
        ------
        InputError
            If the scene has no such granule, if one is not there, or if no free one would be left.

        See Also
        --------
        insert_granules : Put them into the bed, also again.

        Notes
        -----
        Others keep their numbers, and their contacts what these remember. The step ends now. Those
        that are not there are NaN in `state` and in frames, and count in no mean. The ledger counts
        the energy that they take along.

        Examples
        --------
        Two discs lie on each other. Once the lower one is gone, the other falls freely for 10 ms:

        >>> import dem
        >>> scene = dem.Scene(
        ...     dem.Disc([1e-3, 1e-3]),
        ...     dem.Material(young_modulus=1e6, restitution=0.1),
        ...     dem.Friction(),
        ...     walls=dem.box(2e-3, 20e-3),
        ...     gravity=(0.0, -9.81),
        ... )
        >>> run = dem.Simulation(scene, dem.State([[1e-3, 9.9e-4], [1e-3, 2.9e-3]]))
        >>> shortest = run.advance(0.2)
        >>> height = run.state.position[1, 1]
        >>> run.remove_granules([0])
        >>> shortest = run.advance(0.01)
        >>> print(f"{1e3 * (height - run.state.position[1, 1]):.2f} mm")
        0.49 mm
        >>> run.state.position[0]
        array([nan, nan])
        """
        self._populate(np.unique(granules))

    @checked
    def insert_granules(
        self,
        granules: Numbers,
        position: Velocities,
        velocity: Any = None,
        angle: Any = None,
        angular_velocity: Any = None,
    ) -> None:
        """Put granules of the scene that are not there into the bed.

        The scene has all granules that ever are in the bed; a row of NaN in the position of its
        `State` leaves one out at the start.

        Parameters
        ----------
        granules : array_like of int of shape (h,)
            Their numbers in the scene (without unit).
        position : array_like of shape (h, 2)
            Centres of mass (m).
        velocity : array_like of shape (h, 2), optional
            Velocities of the centres (m/s), zero if not given; held granules have that of their
            group.
        angle : array_like of shape (h,), optional
            Angles (rad), anticlockwise, zero if not given.
        angular_velocity : array_like of shape (h,), optional
            Angular velocities (rad/s), anticlockwise, zero if not given.

        Raises
        ------
        InputError
            If the scene has no such granule, if one is there already, if one would overlap a
            granule, a solid or a wall, or if an array is not for these granules. The simulation is
            then unchanged.

        See Also
        --------
        remove_granules : Take granules out.

        Examples
        --------
        A disc leaves a box at its right side, and comes again at the left one:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), friction=dem.Friction())
        >>> state = dem.State([[9e-3, 0.0], [0.0, 5e-3]], velocity=[[1.0, 0.0], [0.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> shortest = run.advance(2e-3)
        >>> run.remove_granules(run.state.position[:, 0] > 1e-2)
        >>> run.insert_granules([0], [[0.0, 0.0]], velocity=[[1.0, 0.0]])
        >>> shortest = run.advance(1e-3)
        >>> run.state.position[0].round(6).tolist()
        [0.001, 0.0]
        """
        new = State(position, velocity, angle, angular_velocity)
        if len(new.position) != len(granules):
            raise InputError(
                f"position has {len(new.position)} rows; it must have {len(granules)}, as granules."
            )
        self._populate(granules, new)

    def _populate(self, granules: np.ndarray, new: State | None = None) -> None:
        """Let granules go, or come in a state."""
        count, order = self.scene.granules, self.engine.order
        known, wrong = np.unique(granules), np.isin(granules, order, invert=new is None)
        if known[-1] >= count:
            raise InputError(f"granules has {known[-1]}; the scene has {count}, numbered from 0.")
        if len(known) < len(granules):
            raise InputError("granules has a number twice; each granule is there once.")
        if wrong.any():
            words = "is not there" if new is None else "is there already"
            raise InputError(f"granules has {granules[wrong][0]}, which {words}; leave it out.")
        order = order[np.isin(order, granules, invert=True)] if new is None else [*order, *granules]
        order = np.array(order, np.int64)
        self._check_free(order, "granules")
        engine = deepcopy(self.engine)  # an interrupt changes nothing
        engine.end_step()
        state = self._state(engine.world, engine.order)
        if new is not None:
            frame = np.array(engine.rules.frame)
            new.position -= frame * engine.progress.seen
            new.velocity -= frame
            for name in ARRAYS:
                getattr(state, name)[granules] = getattr(new, name)
        engine.populate(self._assembled(state, order, engine.world.boundaries), order)
        if new is not None:
            self._check_room(engine, granules)
        self.engine = engine

    def _check_room(self, engine: Engine, granules: np.ndarray) -> None:
        """Raise InputError where granules overlap others, solids or walls."""
        contacts = list_contacts(engine.system, engine.order)
        met = np.isin(contacts.granule, granules) | np.isin(contacts.partner, granules)
        overlap = np.where(met, contacts.overlap, 0.0)
        if overlap.max(initial=0.0) > TOUCHING * self.scene.shape.bounding_radius.min():
            granule = contacts.granule[overlap.argmax()]
            raise InputError(
                f"granule {granule} would be {overlap.max():.3g} m inside "
                f"{partner_words(engine.world, contacts, granule)}; insert granules where there is room."
            )

    def _check_free(self, present: np.ndarray, name: str) -> None:
        """Raise InputError where no granule is there that is free."""
        if self.scene.is_held[present].all():
            raise InputError(f"{name} must leave at least one granule there that is not held.")

    def _assembled(
        self, state: State, order: np.ndarray, moving: Boundaries | None = None
    ) -> System:
        """The arrays of the granules that are there; moving: boundaries as they are now."""
        scene, state = ordered(self.scene, state, order)
        table = granule_table(scene, self.step_fraction)
        return assemble(scene, state, table, self._keeps_ledger, whole=self.scene, moving=moving)

    def _state(self, world: World, order: np.ndarray) -> State:
        """The state of all granules, NaN of those that are not there."""
        state = State(np.full((self.scene.granules, 2), np.nan))
        rows = (
            world.bodies[:, :2],
            world.bodies[:, [VX, VY]],
            world.granules.angle,
            world.bodies[:, W],
        )
        for name, values in zip(ARRAYS, rows, strict=True):
            getattr(state, name)[order] = values
        return state

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
        StateError
            If a position or velocity is not a number, a granule leaves the walls, the duration
            takes too many time steps, or the critical one becomes shorter than a fixed one. The
            message names step, time and granule.
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
        >>> scene, velocity = dem.Scene(dem.Disc([1e-3])), [[1.0, 0.0]]
        >>> run = dem.Simulation(scene, dem.State([[0.0, 0.0]], velocity))
        >>> shortest = run.advance(2e-5)
        >>> print(f"{1e6 * run.state.position[0, 0]:.3f} um")
        20.000 um
        """
        return self.engine.run([self.time + duration])

    @checked
    def record(self, interval: Time, count: OneOrMore) -> Record:
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
        StateError, OverlapError
            As for `advance`.

        Examples
        --------
        A disc resists a cylinder that moves upwards into it:

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
        rows = np.zeros((count, OF_BED + OF_BOUNDARY * len(self.engine.world.boundaries.motion)))
        begin = self.time
        self.engine.run((begin + (n + 1) * interval for n in range(count)), rows)
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


@checked
def simulate(
    scene: InstanceOf[Scene],
    state: InstanceOf[State],
    duration: Time,
    time_step: Time | None = None,
    frames: OneOrMore = 1,
    **options: Any,
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
        Number of equal intervals after each of which the state is kept (without unit).
    **options
        As of Simulation: step_fraction, max_overlap, skin, threads, allow_unstable.

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
    return result_of(Simulation(scene, state, time_step, **options), duration, frames)


def result_of(run: Simulation, duration: float, frames: int) -> Result:
    """Frames of a further duration (s) of a simulation."""
    run.check_duration(duration)
    interval, shortest, rows = duration / frames, math.inf, [frame_of(run, math.nan)]
    begin = run.time
    for frame in range(1, frames + 1):
        # the last one ends at the duration itself, however many there are
        shortest = min(shortest, run.engine.run([begin + duration * (frame / frames)]))
        rows.append(frame_of(run, interval))
    series = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    return Result(**series, state=run.state, time_step=shortest, scene=run.scene, simulation=run)


def frame_of(run: Simulation, interval: float) -> dict[str, Any]:
    """The simulation as it is, and the mean forces (N) since the frame before, an interval (s)
    ago."""
    world, state, scene = run.world, run.state, run.scene
    walls, solids, held = shares(scene, run.engine.take_impulses())
    place = shares(scene, shown(world.boundaries))[1]
    return {name: getattr(state, name) for name in ARRAYS} | {
        "time": run.time,
        "solid_force": (solids[:, :2] + solids[:, 2:4]) / interval,
        "solid_torque": solids[:, 4] / interval,
        "solid_position": place[:, :2],
        "solid_angle": place[:, 2],
        "wall_force": walls[:, 0] / interval,
        "wall_tangential_force": walls[:, 3] / interval,
        "wall_offset": world.boundaries.planes[:, 2],
        "held_force": held[:, :2] / interval,
    }
