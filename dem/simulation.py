"""Run a scene: the documented call for a user's own arrays, and the object behind it.

    result = dem.simulate(scene, state, duration=1e-3)

Two discs that collide in empty space need no more than that; the paper's experiment
(dem.drag) is the first user of the same object.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.assembly import assemble, constants, relist
from dem.columns import VX, VY, W
from dem.contact_law import damped_step, effective_modulus, impact_overlap
from dem.errors import InputError, OverlapError, StateError
from dem.integrate import advance
from dem.kernel import forces
from dem.scene import Scene, State
from dem.survey import kinetic, survey

SKIN = 0.3  # of the mean bounding radius; timings are flat from 0.1 to 0.5
MARGIN = 0.8  # share of skin / 2 that a part may move before the lists are made anew
STEP_FRACTION = 0.3  # of the critical time step
DAMPED_FRACTION = 0.5  # at most, of the critical time step with damping
LARGEST_OVERLAP = 1.2  # of the smaller radius
LONGEST_FLIGHT = 0.02  # of the smallest radius, in one step


class Glance(NamedTuple):
    """The bed at one moment; coordination number: touching pairs of parts, twice, a granule."""

    kinetic_energy: float  # J
    fastest: float  # m/s
    coordination_number: float
    max_overlap: float  # over the smaller radius
    critical_time_step: float  # s


class Result(NamedTuple):
    """What simulate returns: f frames of n granules and w walls, and the last state.

    time (f,) in s; position (f, n, 2) in m; angle (f, n) in rad; velocity (f, n, 2) in m/s;
    angular_velocity (f, n) in rad/s; cylinder_force (f, 2) and wall_force (f, w) in N: the mean
    force on the cylinder and the mean normal force on each wall since the frame before (NaN in
    the first frame). time_step (s): the shortest step taken.
    """

    time: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    cylinder_force: np.ndarray
    wall_force: np.ndarray
    state: State
    time_step: float


class Simulation:
    """A scene in motion: advances in place, to be read between calls.

    time_step (s): fixed, or None to take `step_fraction` of the critical step of the bed as it is
    at each call of advance and each new contact list, less where damping is strong. max_overlap: greatest allowed overlap over the smaller radius.
    skin: of the contact lists, over the mean bounding radius.
    """

    def __init__(
        self,
        scene: Scene,
        state: State,
        time_step: float | None = None,
        step_fraction: float = STEP_FRACTION,
        max_overlap: float = LARGEST_OVERLAP,
        skin: float = SKIN,
    ):
        if time_step is not None and not (math.isfinite(time_step) and time_step > 0.0):
            raise InputError(f"time_step is {time_step!r}; it must be a positive number (s).")
        limits = {"step_fraction": (step_fraction, 1.0), "max_overlap": (max_overlap, 1.5)}
        for name, (value, most) in (limits | {"skin": (skin, 100.0)}).items():
            if not 0.0 < value <= most:
                raise InputError(f"{name} is {value!r}; it must lie above 0 and up to {most:g}.")
        self.scene = scene
        self.time_step = time_step
        self.step_fraction = step_fraction
        self.max_overlap = max_overlap
        self.time = 0.0
        self.steps = 0
        self._glance = None  # what look found, until something moves
        self._parts = constants(scene, skin)
        self._room = MARGIN * 0.5 * self._parts.skin
        self.world = assemble(scene, state.checked(scene.granules), self._parts)
        self._relist()
        forces(self.world, 0.0)

    # What can be read between calls

    @property
    def state(self) -> State:
        """Copies of position (m), velocity (m/s), angle (rad) and angular velocity (rad/s)."""
        bodies = self.world.bodies
        return State(
            bodies[:, :2].copy(),
            bodies[:, [VX, VY]],
            self.world.angle.copy(),
            bodies[:, W].copy(),
        )

    def collect_impulses(self):
        """Impulses since the last call, in N s: on the cylinder (2, 2), on the walls (w,).

        Rows of the first: of the normal parts and of the tangential parts; of the second: normal.
        """
        roller, walls = self.world.roller, self.world.walls
        on_cylinder = np.zeros((2, 2)) if roller is None else roller.impulse.reshape(2, 2).copy()
        on_walls = np.zeros(0) if walls is None else walls.impulse.copy()
        for barrier in (roller, walls):
            if barrier is not None:
                barrier.impulse[:] = 0.0
        return on_cylinder, on_walls

    def look(self) -> Glance:
        """Energy, contacts and greatest overlap of the bed as it is, and its critical time step.

        The critical step is 2 / omega_max without damping, bounded from below by the stiffness of
        all contacts; pairs that are near but do not touch count with the overlap of a collision
        at the greatest speed to be expected. Raises OverlapError where the guard on overlaps trips.
        """
        if self._glance is not None:
            return self._glance
        world, parts = self.world, self._parts
        energy, fastest = kinetic(world)
        least = self._impact(self._speed(fastest))
        touching, overlap, part, bound = survey(
            world, parts.radius, parts.per, least, parts.wn, parts.wt
        )
        if not overlap <= self.max_overlap:
            raise OverlapError(
                f"granule {part // parts.per} overlaps by {overlap:.3g} of the smaller radius "
                f"{self._when()}; the limit is {self.max_overlap:g}: take a smaller time step, a "
                "stiffer material or a lower packing fraction."
            )
        alone = (
            4.0
            * effective_modulus(self.scene.material, self.scene.material)
            * math.sqrt(parts.radius.max() * least)
            * np.max(parts.wt) ** 2
        )  # a granule that meets its like
        self._glance = Glance(
            energy, fastest, 2.0 * touching / self.scene.granules, overlap,
            2.0 / math.sqrt(max(bound, alone)),
        )  # fmt: skip
        return self._glance

    def _speed(self, fastest):
        """Greatest speed (m/s) before the lists are made anew: of granules, cylinder, and a fall."""
        speed, world = fastest, self.world
        if world.roller is not None:
            speed = max(speed, math.hypot(*world.roller.motion[0, [VX, VY]]))
        if world.gravity is not None:
            speed = math.sqrt(speed**2 + 2.0 * math.hypot(*world.gravity) * self._parts.skin)
        return speed

    def _impact(self, speed):
        """Overlap (m) of a collision of mean granules at a speed (m/s)."""
        parts = self._parts
        modulus = effective_modulus(self.scene.material, self.scene.material)
        radius = 0.5 * parts.radius.mean()
        overlap = impact_overlap(0.5 * parts.mass.mean(), radius, modulus, speed)
        return max(overlap, 1e-8 * radius)

    # Motion

    def advance(self, duration: float) -> float:
        """Advance by a duration (s); returns the shortest time step taken (s).

        The step is chosen at the start and again whenever the contacts are listed anew. Raises
        StateError or OverlapError (both RunError), naming step, time and granule.
        """
        if not 0.0 <= duration < math.inf:
            raise InputError(
                f"duration is {duration!r}; it must be a finite time (s), not negative."
            )
        end, shortest = self.time + duration, math.inf
        longest = self._longest_step(self.look())
        while True:
            left = max(1, math.ceil((end - self.time) / longest * (1.0 - 1e-9)))
            dt = (end - self.time) / left
            shortest = min(shortest, dt)
            done, moved = advance(self.world, dt, left, self._room)
            self._glance = None
            self.steps += done
            self.time = end if done == left else self.time + done * dt
            if not moved <= self._room:
                self._check_motion(moved)
                longest = self._longest_step(self.look())
                self._relist()
            if done == left:
                return shortest

    def _longest_step(self, glance):
        if self.time_step is not None:
            return self.time_step
        speed = max(self._speed(glance.fastest), 1e-300)
        flight = LONGEST_FLIGHT * self._parts.radius.min() / speed
        fraction = min(self.step_fraction, DAMPED_FRACTION * damped_step(self._parts.alpha))
        return min(fraction * glance.critical_time_step, flight)

    # Guards: between two lists no part moves by more than half the skin, so that checks at a new
    # list see every overlap before it has grown by more than the skin.

    def _when(self):
        return f"at step {self.steps}, time {self.time:.6g} s"

    def _check_motion(self, moved):
        lost = ~np.isfinite(self.world.bodies).all(axis=1)
        if lost.any():
            raise StateError(
                f"the motion of granule {lost.argmax()} is not a number {self._when()}: take a "
                "smaller time step."
            )
        if moved > 0.5 * self._parts.skin:
            raise StateError(
                f"a granule moved {moved:.3g} m before its contacts were listed again "
                f"{self._when()}; it may move {0.5 * self._parts.skin:.3g} m: take a smaller "
                "time step."
            )

    def _relist(self):
        walls, bodies = self.world.walls, self.world.bodies
        if walls is not None:
            beyond = bodies[:, :2] @ walls.planes[:, :2].T - walls.planes[:, 2]
            granule, wall = np.unravel_index(beyond.argmax(), beyond.shape)
            if beyond[granule, wall] > 0.0:
                raise StateError(
                    f"granule {granule} has its centre {beyond[granule, wall]:.3g} m behind wall "
                    f"{wall} {self._when()}: put it inside, or take a smaller time step."
                )
        self.world = relist(self.scene, self._parts, self.world)


def simulate(
    scene: Scene,
    state: State,
    duration: float,
    time_step: float | None = None,
    frames: int = 1,
    **options,
) -> Result:
    """Simulate a scene from a state for a duration (s) and return arrays.

    time_step (s): None to choose it from the stiffness of the contacts (recommended). frames:
    number of equal intervals after each of which the state is kept. Further options as for
    Simulation. Raises InputError for values that can not be used and RunError (StateError,
    OverlapError) where a run fails.
    """
    if not (math.isfinite(duration) and duration > 0.0):
        raise InputError(f"duration is {duration!r}; it must be a positive number (s).")
    if not (isinstance(frames, int) and frames > 0):
        raise InputError(f"frames is {frames!r}; it must be a positive whole number.")
    run = Simulation(scene, state, time_step, **options)
    run.look()
    nothing = np.full(2, np.nan), np.full(len(run.collect_impulses()[1]), np.nan)
    history = [(0.0, run.state, *nothing)]
    shortest, interval = math.inf, duration / frames
    for _ in range(frames):
        shortest = min(shortest, run.advance(interval))
        on_cylinder, on_walls = run.collect_impulses()
        force = on_cylinder.sum(axis=0) / interval
        history.append((run.time, run.state, force, on_walls / interval))
    times, states, cylinder_force, wall_force = zip(*history, strict=True)
    return Result(
        np.array(times),
        np.stack([s.position for s in states]),
        np.stack([s.angle for s in states]),
        np.stack([s.velocity for s in states]),
        np.stack([s.angular_velocity for s in states]),
        np.stack(cylinder_force),
        np.stack(wall_force),
        states[-1],
        shortest,
    )
