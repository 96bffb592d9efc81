"""A random bed at rest, at a prescribed packing fraction, around the cylinder.

Granules start at random places and angles, so small that no two bounding circles overlap. They
then grow in small steps, and after each step the elastic energy is minimised without friction
(dem.packing.minimise). Dumbbells do not interlock, because they start apart. The bed depends only
on the geometry and the seed: moduli and masses cancel.
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, InstanceOf

from dem.base.errors import InputError, PackingError
from dem.base.types import Count, Length, checked
from dem.contacts.force_law import effective_modulus
from dem.dynamics.contact_list import list_contacts
from dem.dynamics.world import World
from dem.jit.columns import X, Y
from dem.packing.minimise import Rest, minimise, state_of
from dem.periodic import SIDES, Periods, Sides, nearest_image, periods_of, wrapped
from dem.scene import Cylinder, Friction, Granules, Material, Scene, State, walls_of

REST = 1e-9  # E* R^2: a bed is at rest when no granule feels a greater net force
LOOSE = 0.3  # area fraction of the bounding circles at the start
GROWTH = 1.02  # of all lengths, in one step
SETTLED = 1e-5  # E* R^2: enough between two steps of growth
PATIENCE = 400  # iterations between two steps of growth
LONGEST = 100_000  # iterations of the last relaxation
DEEPEST = 0.2  # greatest overlap over the smaller radius in a finished bed
SOFT = Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=1.0)


class Bed(NamedTuple):
    """A packed bed at rest, as `pack` returns it.

    Attributes
    ----------
    position : ndarray of shape (n, 2)
        Centres of the granules (m).
    angle : ndarray of shape (n,)
        Angles of the granules (rad).
    width : float
        Width of the box (m).
    height : float
        Height of the box (m).
    net_force : float
        Largest net force on a granule over E* R^2, without unit.
    pressure : float
        Mean normal force on the walls per length, over E* and a thickness of one metre, without
        unit. Without walls, the mean normal stress of the contacts over E*.
    coordination_number : float
        Contacts per granule, without unit; contacts with walls and cylinder do not count.
    max_overlap : float
        Largest overlap over the smaller radius, without unit.
    periodic : tuple of float or None
        Periods (x, y) in m, as `Scene` takes them; None without a periodic side.

    See Also
    --------
    pack : Make a bed.

    Examples
    --------
    >>> import dem
    >>> import numpy as np
    >>> shape = dem.Disc(np.full(60, 0.5e-3))
    >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3))
    >>> bed = dem.pack(shape, width=8e-3, height=8e-3, cylinder=cylinder, seed=1)
    >>> scene = dem.Scene(shape, walls=bed.walls, cylinder=cylinder)
    >>> bed.state.position.shape
    (60, 2)
    """

    position: np.ndarray
    angle: np.ndarray
    width: float
    height: float
    net_force: float
    pressure: float
    coordination_number: float
    max_overlap: float
    periodic: Periods = None

    @property
    def state(self) -> State:
        """State of the granules at rest, as `Simulation` takes it."""
        return State(self.position, angle=self.angle)

    @property
    def walls(self) -> np.ndarray | None:
        """Walls (4, 3) of the box, as `box` returns them and `Scene` takes them.

        Periodic sides have none: two walls (2, 3) are left, or None.
        """
        return walls_of(self.width, self.height, self.periodic)


class Room(NamedTuple):
    """Where a bed is packed, and the seed of its random places and angles: what `pack` takes beside
    the granules, in the same order."""

    width: float
    height: float
    cylinder: Cylinder | None
    seed: int
    periodic: str = "none"

    @property
    def size(self) -> np.ndarray:
        """Width and height (m)."""
        return np.array([self.width, self.height])

    @property
    def radius(self) -> float:
        """Radius of the cylinder (m)."""
        return 0.0 if self.cylinder is None else 0.5 * self.cylinder.diameter

    @property
    def area(self) -> float:
        """Area (m2) beside the cylinder."""
        return self.width * self.height - math.pi * self.radius**2

    @property
    def periods(self) -> Periods:
        """Periods (x, y) in m, as `Scene` takes them."""
        return periods_of(self.width, self.height, self.periodic)

    def scene(
        self, shape: Any, material: Material = SOFT, friction: Friction | None = None
    ) -> Scene:
        """The box with granules one metre thick and the cylinder at rest."""
        still = self.cylinder and Cylinder(self.cylinder.diameter, self.cylinder.position)
        walls = walls_of(self.width, self.height, self.periods)
        return Scene(shape, material, friction, walls, still, thickness=1.0, periodic=self.periods)

    def name(self, shape: Any) -> str:
        """Name of a bed in an error message."""
        return f"the bed at packing fraction {shape.area.sum() / self.area:.4g} (seed {self.seed})"


def scatter(shape: Any, room: Room, rng: np.random.Generator) -> np.ndarray:
    """Random sequential addition of the bounding circles: positions (n, 2) in m.

    A grid finds the neighbours, so that the work is proportional to the number of granules. Its
    squares are at least as wide as the largest circle.
    """
    radius, side, periodic = shape.bounding_radius, room.size, room.periods
    turns = np.array(SIDES[room.periodic])
    size = max(2.0 * radius.max(), math.sqrt(room.width * room.height / len(radius)))
    count = np.where(turns, np.maximum(side // size, 1.0), np.inf)  # squares that make a period
    sizes = np.where(turns, side / count, size)
    grid: dict[tuple[float, float], list[int]] = {}
    position = np.empty((len(radius), 2))
    for i, r in enumerate(radius):
        for _ in range(1000):
            trial = np.where(turns, 0.0, r) + np.where(turns, side, side - 2.0 * r) * rng.random(2)
            column, row = trial // sizes
            if room.cylinder:
                away = nearest_image(trial - room.cylinder.position, periodic)
                if math.hypot(*away) < r + room.radius:
                    continue
            around = {
                (c % count[0], k % count[1])
                for c in (column - 1.0, column, column + 1.0)
                for k in (row - 1.0, row, row + 1.0)
            }
            near = [j for square in around for j in grid.get(square, ())]
            gap = nearest_image(position[near] - trial, periodic)
            if (np.einsum("ij,ij->i", gap, gap) >= (r + radius[near]) ** 2).all():
                position[i] = trial
                grid.setdefault((column % count[0], row % count[1]), []).append(i)
                break
        else:
            raise PackingError(
                f"granule {i} of {len(radius)} found no free place in 1000 trials: the box of "
                f"{room.width:.3g} m by {room.height:.3g} m is too small for granules of {r:.3g} m."
            )
    return position


BedSeed = Annotated[Count, Field(ge=0, lt=2**63)]


@checked
def pack(
    shape: Granules,
    width: Length,
    height: Length,
    cylinder: InstanceOf[Cylinder] | None,
    seed: BedSeed,
    periodic: Sides = "none",
) -> Bed:
    """Pack granules at random into a box and bring them to rest.

    The packing fraction follows from the granules and the box, equation (18) of the paper.

    Parameters
    ----------
    shape : Disc, Dumbbell, Ellipse or Superellipse
        Granules, n in all, with their sizes (m).
    width : float
        Width of the box (m).
    height : float
        Height of the box (m).
    cylinder : Cylinder or None
        Cylinder that the granules leave room for. Its velocity is ignored.
    seed : int
        Seed of the random places and angles, without unit, zero or positive.
    periodic : str
        Along which sides the box repeats itself: "none", "x", "y" or "xy". There are no walls
        across these.

    Returns
    -------
    Bed
        The bed, with the net force and the pressure that remain in it.

    Raises
    ------
    PackingError
        If no bed at rest is found, usually because the packing fraction is too high.
    InputError
        If a value cannot be used, for instance if the cylinder does not fit into the box.

    Notes
    -----
    The granules start small and apart, and grow in steps of 2 %. After each step FIRE (Bitzek et
    al. 2006, with the corrections of Guenole et al. 2020) minimises the elastic energy without
    friction. The finished bed is at rest when no granule feels a net force above 1e-9 E* R^2.

    Examples
    --------
    Pack 60 discs of 0.8 to 1.2 mm around a cylinder:

    >>> import dem
    >>> import numpy as np
    >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
    >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3))
    >>> bed = dem.pack(shape, width=8e-3, height=9e-3, cylinder=cylinder, seed=1)
    >>> print(f"packing fraction {shape.area.sum() / (72e-6 - np.pi * 1e-6):.2f}")
    packing fraction 0.69
    >>> bool(bed.net_force < 1e-9)
    True

    With a periodic side there are no walls to the left and right:

    >>> bed = dem.pack(shape, width=8e-3, height=9e-3, cylinder=cylinder, seed=1, periodic="x")
    >>> bed.walls.tolist()
    [[0.0, -1.0, 0.0], [0.0, 1.0, 0.009]]
    >>> scene = dem.Scene(shape, walls=bed.walls, cylinder=cylinder, periodic=bed.periodic)
    >>> scene.periodic
    (0.008, None)
    """
    room = Room(width, height, cylinder, seed, periodic)
    factor, state = dilute_start(shape, room)
    while factor < 1.0:
        world, _ = relax(room.scene(shape.scaled(factor)), state, PATIENCE, SETTLED)
        state = state_of(world)
        factor = min(factor * GROWTH, 1.0)
    return at_rest(shape, room, state)


def dilute_start(shape: Any, room: Room) -> tuple[float, State]:
    """Small granules at random places and angles, apart from each other.

    Returns the factor by which lengths are scaled at the start, and the State at the start.
    """
    if room.cylinder is not None:
        for place, side, turns in zip(
            room.cylinder.position, room.size, SIDES[room.periodic], strict=True
        ):
            if not (turns or room.radius < place < side - room.radius):
                raise InputError(
                    f"the cylinder at {room.cylinder.position} m does not fit into the box."
                )
    rng = np.random.default_rng([room.seed, 1])
    circles = np.pi * (shape.bounding_radius**2).sum()
    factor = min(1.0, math.sqrt(LOOSE * room.area / circles))
    position = scatter(shape.scaled(factor), room, rng)
    return factor, State(position, angle=rng.uniform(0.0, 2.0 * np.pi, len(position)))


def relax(scene: Scene, state: State, iterations: int, enough: float) -> tuple[World, Rest]:
    """Minimise the energy of a soft scene; forces, also of the Rest, over E* R^2."""
    unit = unit_of(scene.shape)
    world, rest = minimise(scene, state, iterations, enough * unit)
    return world, rest._replace(net_force=rest.net_force / unit)


def unit_of(shape: Any) -> float:
    """The unit E* R^2 (N) of forces in a soft scene."""
    return float(effective_modulus(SOFT, SOFT) * shape.constituent_radius.mean() ** 2)


def at_rest(shape: Any, room: Room, state: State) -> Bed:
    """The bed of full-sized granules, brought to rest; raises PackingError if it finds none."""
    world, rest = relax(room.scene(shape), state, LONGEST, REST)
    if not rest.net_force <= REST:
        raise PackingError(
            f"{room.name(shape)} is not at rest after {LONGEST} iterations: net force "
            f"{rest.net_force:.2g} E* R^2, asked for {REST:g}."
        )
    return finished(shape, room, world, rest, rest.net_force)


def finished(shape: Any, room: Room, world: World, rest: Rest, net_force: float) -> Bed:
    """Bed from the arrays of the kernels after `minimise`, with net_force over E* R^2.

    Raises PackingError if a granule is outside the box or overlaps too much.
    """
    position = wrapped(world.bodies[:, :2].copy(), room.periods)
    lost = ((position < 0.0) | (position > room.size)).any(axis=1)
    if room.cylinder is not None:
        away = nearest_image(position - room.cylinder.position, room.periods)
        lost |= np.hypot(*away.T) < room.radius
    if lost.any():
        raise PackingError(
            f"{room.name(shape)} cannot be made: the centre of granule {lost.argmax()} was pushed "
            "into the cylinder or out of the box: ask for a lower packing fraction."
        )
    if not rest.max_overlap <= DEEPEST:
        raise PackingError(
            f"{room.name(shape)} cannot be made: granule {rest.deepest} overlaps by "
            f"{rest.max_overlap:.2g} of the smaller radius, at most {DEEPEST:g} is allowed: ask "
            "for a lower packing fraction."
        )
    return Bed(
        position=position,
        angle=np.mod(world.angle, 2.0 * np.pi),
        width=room.width,
        height=room.height,
        net_force=net_force,
        pressure=pressure_of(world, room),
        coordination_number=2.0 * rest.touching / len(position),
        max_overlap=rest.max_overlap,
        periodic=room.periods,
    )


def pressure_of(world: World, room: Room) -> float:
    """Pressure of a soft Bed."""
    if world.walls.end == 0:  # none
        stress = mean_stress(world, room.periods, room.width * room.height)
    else:
        x, y = SIDES[room.periodic]
        length = 2.0 * ((0.0 if y else room.width) + (0.0 if x else room.height))
        stress = float(world.boundaries.contact_forces[: world.walls.end, 0].sum()) / length
    return float(stress / effective_modulus(SOFT, SOFT))


def mean_stress(world: World, periodic: Periods, area: float) -> float:
    """Mean normal stress (N/m: times the thickness) in an area (m2) without walls.

    Half the sum over contacts of force times the branch from centre to centre, over the area.
    """
    contacts, cylinder = list_contacts(world, np.arange(len(world.bodies))), world.cylinder
    # the number of the cylinder as a partner is -1
    moving = np.vstack([world.bodies, world.boundaries.motion[cylinder.first : cylinder.end]])
    place = moving[:, [X, Y]]
    branch = nearest_image(place[contacts.partner] - place[contacts.granule], periodic)
    work = contacts.force * (contacts.normal * branch).sum(axis=1)
    return float(work.sum()) / (2.0 * area)
