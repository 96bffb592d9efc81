"""A random bed at rest, at a prescribed packing fraction, around solids.

Granules start at random places and angles, so small that no two bounding circles overlap. They
then grow in small steps, and after each step the elastic energy is minimised without friction
(dem.packing.minimise). Dumbbells do not interlock, because they start apart. The bed depends only
on the geometry, the law of contacts and the seed: moduli and masses cancel.
"""

import math
from dataclasses import replace
from itertools import chain, product
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from dem.base.errors import InputError, PackingError
from dem.base.types import Count, Length, checked
from dem.contacts.effective import effective_modulus
from dem.contacts.layout import X, Y
from dem.dynamics.contact_output import list_contacts
from dem.dynamics.numerics import OneOrMore
from dem.dynamics.system import System
from dem.laws.hertz import Hertz
from dem.material import Friction, Material
from dem.packing.cost import most_iterations, near_jamming
from dem.packing.job import Job
from dem.packing.minimise import Minimum, minimise
from dem.periodic import SIDES, Periods, Sides, nearest_image, periods_of, wrapped
from dem.scene import ContactLaw, Granules, Scene, State
from dem.solids import Solid, Solids, walls_of

LOOSE = 0.3  # area fraction of the bounding circles at the start
GROWTH = 1.02  # of all lengths, in one step
SETTLED = 1e-5  # E* R^2: enough between two steps of growth
PATIENCE = 400  # iterations between two steps of growth
DEEPEST = 0.2  # greatest overlap over the smaller radius in a finished bed
NEAR = [*product((-1.0, 0.0, 1.0), repeat=2)]  # a square and those around it
HERTZ = Hertz()
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
        Largest net force on a granule over E* R^2, without unit; over K R under a law whose
        constant K of two granules is a stiffness (N/m).
    pressure : float
        Mean normal force on the walls per length, over E* and a thickness of one metre or over K,
        without unit. Without walls, the mean normal stress of the contacts over the same.
    coordination_number : float
        Contacts per granule, without unit; contacts with walls and solids do not count.
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
    >>> bed = dem.pack(shape, width=8e-3, height=8e-3, solids=cylinder, seed=1)
    >>> scene = dem.Scene(shape, walls=bed.walls, solids=cylinder)
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
    periodic: tuple[float | None, float | None] | None = None

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
    """Where a bed is packed, the seed of its random places and angles, and the law of contacts: what
    `pack` takes beside the granules, in the same order. Then E* of two granules of each material, over
    E* of the stiffest, and the number (n,) of the material of each granule."""

    width: float
    height: float
    solids: tuple[Solid, ...]
    seed: int
    periodic: str = "none"
    law: Any = HERTZ
    moduli: tuple[float, ...] = (1.0,)
    species: np.ndarray | None = None

    @property
    def modulus(self) -> float:
        """Modulus of the law (Pa or N/m) for two soft granules, the stiffest of them."""
        return float(self.law.modulus(effective_modulus(SOFT, SOFT), 1.0))

    def unit(self, shape: Any) -> float:
        """The unit of forces (N) in a soft scene: E* R^2, or K R."""
        radius = shape.constituent_radius.mean()
        return float(self.law.scale(self.modulus, radius) * radius)

    @property
    def size(self) -> np.ndarray:
        """Width and height (m)."""
        return np.array([self.width, self.height])

    @property
    def area(self) -> float:
        """Area (m2) beside the solids."""
        return self.width * self.height - sum(solid.area for solid in self.solids)

    @property
    def periods(self) -> Periods:
        """Periods (x, y) in m, as `Scene` takes them."""
        return periods_of(self.width, self.height, self.periodic)

    def scene(
        self, shape: Any, material: Material = SOFT, friction: Friction | None = None
    ) -> Scene:
        """The box with granules one metre thick and the solids at rest."""
        still = [Solid(s.outline, s.position, s.angle, friction=None) for s in self.solids]
        return Scene(
            shape,
            [replace(material, young_modulus=modulus) for modulus in self.moduli],  # type: ignore[arg-type]
            friction,
            walls_of(self.width, self.height, self.periods),
            still,
            thickness=1.0,
            periodic=self.periods,
            law=self.law.repulsion,
            species=self.species,
        )

    def name(self, shape: Any) -> str:
        """Name of a bed in an error message."""
        return f"the bed at packing fraction {shape.area.sum() / self.area:.4g} (seed {self.seed})"


def scatter(shape: Any, factor: float, room: Room, rng: np.random.Generator) -> np.ndarray:
    """Random sequential addition of the bounding circles: positions (n, 2) in m.

    Lengths of granules are scaled by a factor. None begins between two solids where it would not fit
    at its full size: it could be caught there as it grows.

    A grid finds the neighbours, so that the work is proportional to the number of granules. Its
    squares are at least as wide as the largest circle, and the first ones follow the last ones.
    """
    radius, side, periods = factor * shape.bounding_radius, room.size, room.periods or (None, None)
    widest = 2.0 * np.sqrt(shape.area / np.pi)
    lowest = np.where(SIDES[room.periodic], 0.0, radius[:, None])
    size = max(2.0 * radius.max(), math.sqrt(room.width * room.height / len(radius)))
    count = np.maximum(side // size, 1.0)  # of squares along each side
    columns, rows = count.tolist()
    grid: dict[tuple[float, float], list[tuple[float, float, float]]] = {}
    position = np.empty((len(radius), 2))

    def is_free(x: float, y: float, r: float, column: float, row: float) -> bool:
        """Whether a circle meets no other. Numbers and no arrays: there are only a few others."""
        squares = {((column + i) % columns, (row + j) % rows) for i, j in NEAR}
        for other_x, other_y, other in chain.from_iterable(grid.get(at, ()) for at in squares):
            dx, dy = (
                d - period * round(d / period) if period else d
                for d, period in zip((other_x - x, other_y - y), periods, strict=True)
            )
            if dx * dx + dy * dy < (r + other) ** 2:
                return False
        return True

    for i, r in enumerate(radius.tolist()):
        for _ in range(1000):
            trial = lowest[i] + (side - 2.0 * lowest[i]) * rng.random(2)
            (x, y), (column, row) = trial.tolist(), (trial * count // side).tolist()
            if not is_free(x, y, r, column, row):
                continue
            gaps = sorted(-solid.depth(trial[None], room.periods)[0] for solid in room.solids)
            if not gaps or (gaps[0] >= r and (not gaps[1:] or gaps[0] + gaps[1] >= widest[i])):
                position[i] = trial
                grid.setdefault((column, row), []).append((x, y, r))
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
    solids: Solids,
    seed: BedSeed,
    periodic: Sides = "none",
    law: ContactLaw = HERTZ,
    threads: OneOrMore = 1,
    checkpoint: Any = None,
) -> Bed:
    """Pack granules at random into a box and bring them to rest.

    The packing fraction follows from the granules and the box, equation (18) of the paper.

    Parameters
    ----------
    shape : Disc, Dumbbell, Ellipse, Superellipse, Clump or a shape of your own
        Granules, n in all, with their sizes (m).
    width : float
        Width of the box (m).
    height : float
        Height of the box (m).
    solids : Solid, sequence of Solid or None
        Solids that the granules leave room for. Their motion, friction and material are ignored.
    seed : int
        Seed of the random places and angles, without unit, zero or positive.
    periodic : str
        Along which sides the box repeats itself: "none", "x", "y" or "xy". There are no walls
        across these.
    law : Hertz, Linear, Line or a class of your own
        Law of contacts, as `Scene` takes it.
    threads : int
        Number of threads, without unit, for beds of tens of thousands of granules. The bed does not depend
        on it. A small bed uses fewer.
    checkpoint : path, optional
        File that keeps a bed every minute and when it is interrupted; the same call goes on from it
        to the same bed. You may delete it after.

    Returns
    -------
    Bed
        The bed, with the net force and the pressure that remain in it.

    Raises
    ------
    PackingError
        If no bed at rest is found, usually because the packing fraction is too high.
    InputError
        If a value cannot be used, for instance if a solid does not fit into the box.

    Notes
    -----
    The granules start small and apart, and grow in steps of 2 %. After each step FIRE (Bitzek et
    al. 2006, with the corrections of Guenole et al. 2020) minimises the elastic energy without
    friction. The finished bed is at rest when no granule feels a net force above 1e-9 E* R^2; of
    more than 1024 granules, above 0.5 % of the mean contact force if that is more, and at most 1e-6
    E* R^2. Near random close packing (0.842) a large bed of discs is slow to come to rest.

    Examples
    --------
    Pack 60 discs of 0.8 to 1.2 mm around a cylinder:

    >>> import dem
    >>> import numpy as np
    >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
    >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 4e-3))
    >>> bed = dem.pack(shape, width=8e-3, height=9e-3, solids=cylinder, seed=1)
    >>> print(f"packing fraction {shape.area.sum() / (72e-6 - np.pi * 1e-6):.2f}")
    packing fraction 0.69
    >>> bool(bed.net_force < 1e-9)
    True

    With a periodic side there are no walls to the left and right:

    >>> bed = dem.pack(shape, width=8e-3, height=9e-3, solids=cylinder, seed=1, periodic="x")
    >>> bed.walls.tolist()
    [[0.0, -1.0, 0.0], [0.0, 1.0, 0.009]]
    >>> scene = dem.Scene(shape, walls=bed.walls, solids=cylinder, periodic=bed.periodic)
    >>> scene.periodic
    (0.008, None)
    """
    room, job = Room(width, height, solids, seed, periodic, law), Job(threads, checkpoint)
    job.begin(shape, room)
    return relaxed(shape, room, job)


def relaxed(shape: Any, room: Room, job: Job) -> Bed:
    """`pack` in a room."""
    factor, state = dilute_start(shape, room)
    factor, scene = float(job.stage.get("factor", factor)), room.scene(shape)
    while factor < 1.0:
        job.stage["factor"] = factor  # type: ignore[assignment]  # beside a count
        object.__setattr__(scene, "shape", shape.scaled(factor))  # checking a scene takes long
        state = minimise(scene, state, PATIENCE, SETTLED * room.unit(scene.shape), job).state
        factor = min(factor * GROWTH, 1.0)
    return at_rest(shape, room, state, job)


def dilute_start(shape: Any, room: Room) -> tuple[float, State]:
    """Small granules at random places and angles, apart from each other.

    Returns the factor by which lengths are scaled at the start, and the State at the start.
    """
    for solid in room.solids:
        ring = solid.placed(solid.position, solid.angle)
        inside = ((ring > 0.0) & (ring < room.size)) | SIDES[room.periodic]
        if not inside.all():
            raise InputError(f"the solid at {solid.position} m does not fit into the box.")
    rng = np.random.default_rng([room.seed, 1])
    circles = np.pi * (shape.bounding_radius**2).sum()
    factor = min(1.0, math.sqrt(LOOSE * room.area / circles))
    position = scatter(shape, factor, room, rng)
    return factor, State(position, angle=rng.uniform(0.0, 2.0 * np.pi, len(position)))


def at_rest(shape: Any, room: Room, state: State, job: Job) -> Bed:
    """The bed of full-sized granules, brought to rest; raises PackingError if it finds none."""
    job.stage["factor"] = 1.0  # type: ignore[assignment]
    fraction = float(shape.area.sum() / room.area)
    limit = most_iterations(len(shape.area), fraction)
    bed = minimise(room.scene(shape), state, limit, None, job)
    if not bed.net_force <= bed.enough:
        job.save(left=limit)  # whoever tries again goes on
        unit = room.unit(shape)
        hint = None if shape.needs_angle else near_jamming(len(shape.area), fraction)
        raise PackingError(
            f"{room.name(shape)} is not at rest after {limit} iterations: net force "
            f"{bed.net_force / unit:.2g} E* R^2, asked for {bed.enough / unit:.2g}"
            f"{f'; {hint}' if hint else ''}."
        )
    return finished(shape, room, bed)


def finished(shape: Any, room: Room, bed: Minimum, net_force: float | None = None) -> Bed:
    """Bed from what `minimise` returned; net_force (E* R^2): of the bed, where that is another.

    Raises PackingError if a granule is outside the box or overlaps too much.
    """
    position = wrapped(bed.state.position, room.periods)
    lost = ((position < 0.0) | (position > room.size)).any(axis=1)
    for solid in room.solids:
        lost |= solid.depth(position, room.periods) > 0.0
    if lost.any():
        raise PackingError(
            f"{room.name(shape)} cannot be made: the centre of granule {lost.argmax()} was pushed "
            "into a solid or out of the box: ask for a lower packing fraction."
        )
    if not bed.max_overlap <= DEEPEST:
        raise PackingError(
            f"{room.name(shape)} cannot be made: granule {bed.deepest} overlaps by "
            f"{bed.max_overlap:.2g} of the smaller radius, at most {DEEPEST:g} is allowed: ask "
            "for a lower packing fraction."
        )
    return Bed(
        position,
        np.mod(bed.state.angle, 2.0 * np.pi),
        room.width,
        room.height,
        bed.net_force / room.unit(shape) if net_force is None else net_force,
        pressure_of(bed.system, room),
        2.0 * bed.touching / len(position),
        bed.max_overlap,
        room.periods,
    )


def pressure_of(system: System, room: Room) -> float:
    """Pressure of a soft Bed."""
    world = system.world
    walls, periodic = len(world.boundaries.planes), SIDES[room.periodic]
    if walls:
        length = 2.0 * (room.size * ~np.array(periodic)[::-1]).sum()
        return float(world.boundaries.contact_forces[:walls, 0].sum() / length / room.modulus)
    # Half the sum over contacts of force times the branch from centre to centre, over the area
    contacts = list_contacts(system, np.arange(len(world.bodies)))
    # without walls the numbers of solids as partners are -1, -2 and so on
    place = np.vstack([world.bodies, world.boundaries.motion[::-1]])[:, [X, Y]]
    branch = nearest_image(place[contacts.partner] - place[contacts.granule], room.periods)
    work = contacts.force * (contacts.normal * branch).sum(axis=1)
    return float(work.sum() / (2.0 * (room.width * room.height)) / room.modulus)
