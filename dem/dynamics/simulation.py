"""A scene in motion, which you advance, and may change between calls."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import InstanceOf

from dem.base.errors import InputError
from dem.base.types import Count, NotNegative, Time, Unit, checked
from dem.dynamics.assembly import assemble, order_of
from dem.dynamics.checkpoint import replaced, restored
from dem.dynamics.energy import balance, fallen
from dem.dynamics.engine import MOST_STEPS, OF_BED, OF_BOUNDARY, Engine, StepControl
from dem.dynamics.moving_scene import MovingScene
from dem.dynamics.numerics import (
    MAX_OVERLAP,
    STEP_FRACTION,
    MaxOverlap,
    OneOrMore,
    Skin,
    StepFraction,
    check_stable,
)
from dem.dynamics.population import check_free, system_of, with_granules
from dem.dynamics.record import Record, record_of, shares
from dem.dynamics.skin import initial_skin, skin_limits
from dem.dynamics.world import REMOVED
from dem.motion import Motion, Numbers, Spin, Velocities
from dem.scene import Scene, State


class Simulation(MovingScene):
    """A scene in motion, which you advance, look at and change between calls.

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
        Number of threads, without unit, for beds of tens of thousands of granules. The result does not
        depend on it. A small bed uses fewer.
    ledger : bool
        Keep an energy ledger. A run takes about ten per cent longer.
    allow_unstable : bool
        Take the requested step, even if it is unstable. `step_fraction` may then exceed 1, and no
        step is shortened for fast granules.

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
    lower bound for small motions of the bed as it is, computed whenever the neighbour list is
    rebuilt, and every 1000 steps. Steps are whole: what you see at a time within a step is a copy,
    taken there from the last whole step, so that the motion does not depend on when you look.

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
        state, frame = state.checked(scene.granules), (0.0, 0.0)
        present = state.present
        check_free(scene, present, "state")
        if not (scene.walls or scene.solids or scene.held or scene.base_plate):
            x, y = np.average(state.velocity[present], axis=0, weights=scene.mass[present])
            frame = float(x), float(y)
            state.velocity -= frame
        order = order_of(scene, state)
        system = assemble(scene, state, order, step_fraction, ledger)
        skins = skin_limits(scene, system.table, skin)
        width = initial_skin(system.world, system.table, time_step, skins)
        if allow_unstable:  # short lists must end a run that breaks
            skins = width, width
        rules = StepControl(time_step or 0.0, max_overlap, skins, allow_unstable, frame)
        self.scene, self.engine = scene, Engine(system, width, rules, order, threads)
        system = self.engine.observe()[0]
        self._at_start = (sum(balance(system)), fallen(system.world)) if ledger else None

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
        engine, order = self.engine, np.array(saved["order"])
        state = State(np.zeros((self.scene.granules, 2)))
        system = system_of(self.scene, engine, state, order)
        engine.system, engine.order = system.suited(restored(system, saved)), order
        engine.progress = replaced(engine.progress, saved, "progress")

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
            Angular velocity (rad/s), anticlockwise, added to the spin of a `PrescribedMotion`, or a
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
        A disc flies through the place of a plate that was removed:

        >>> import dem
        >>> plate = dem.Solid(dem.plate(6e-3, 1e-3), position=(0.0, 0.0))
        >>> scene = dem.Scene(dem.Disc([1e-3]), friction=dem.Friction(), solids=plate)
        >>> run = dem.Simulation(scene, dem.State([[0.0, 5e-3]], velocity=[[0.0, -1.0]]))
        >>> run.remove(0)
        >>> shortest = run.advance(0.01)
        >>> run.state.position[0].round(6).tolist()
        [0.0, -0.005]
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
        One of two discs that would collide is taken out, and the other flies on:

        >>> import dem
        >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
        >>> state = dem.State([[0.0, 0.0], [2.1e-3, 0.0]], velocity=[[1.0, 0.0], [-1.0, 0.0]])
        >>> run = dem.Simulation(scene, state)
        >>> run.remove_granules([1])
        >>> shortest = run.advance(0.01)
        >>> run.state.position.round(6)
        array([[0.01, 0.  ],
               [ nan,  nan]])
        """
        self.engine = with_granules(self.scene, self.engine, np.unique(granules))

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
            Velocities of the centres (m/s), zero if not given; held granules have the velocity of
            their group.
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
        self.engine = with_granules(self.scene, self.engine, granules, new)

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
        A disc bounces off a cylinder:

        >>> import dem
        >>> cylinder = dem.Cylinder(diameter=2e-3, position=(0.0, 0.0))
        >>> scene = dem.Scene(dem.Disc([1e-3]), friction=dem.Friction(), solids=cylinder)
        >>> run = dem.Simulation(scene, dem.State([[0.0, 2.05e-3]], velocity=[[0.0, -1.0]]))
        >>> record = run.record(interval=1e-4, count=2)
        >>> record.normal_force[:, 0, 1].round(2)  # N
        array([-0.37,  0.  ])
        """
        self.collect_impulses()
        rows = np.zeros((count, OF_BED + OF_BOUNDARY * len(self.engine.world.boundaries.motion)))
        begin = self.time
        self.engine.run((begin + n * interval for n in range(1, count + 1)), rows)
        self.diagnose()  # the guard on overlaps, also for the end of the last interval
        return record_of(self.scene, rows)
