"""From a scene and a state to the arrays of the kernels."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.force_law import (
    damping_from_restitution,
    effective_modulus,
    effective_shear_modulus,
)
from dem.dynamics.world import (
    DAMPING,
    EXTERNAL_FORCE,
    INVERSE_MASS,
    PATCH,
    Boundaries,
    Contacts,
    FrictionParameters,
    HeldGroups,
    Patches,
    Surface,
    World,
)
from dem.jit.block_memory import make_lanes
from dem.jit.columns import VX, VY, W, X, Y, rows
from dem.motion import Drive, PrescribedMotion
from dem.scene import Scene, State, reach
from dem.shapes.protocol import resized

CONTACT_KINDS = "granule", "wall", "cylinder"


class GranuleTable(NamedTuple):
    """Constants of the granules that the lists and the scans need.

    Attributes
    ----------
    root_inverse_mass : ndarray of shape (n,)
        1/sqrt(m) (kg^-0.5), zero for held granules.
    root_inverse_inertia : ndarray of shape (n,) or None
        1/sqrt(I) (kg^-0.5 m^-1), zero for held granules; None where nothing turns.
    per : int
        Constituents per granule.
    radius : ndarray of shape (constituents,)
        Radius for Hertz's law (m).
    bounding : ndarray of shape (constituents,)
        Radius of the circle that holds the constituent (m).
    mass : ndarray of shape (constituents,)
        Mass of the whole granule (kg).
    mobility : float
        Greatest 1/m + arm^2/I of a contact (1/kg).
    bend : ndarray of shape (n,)
        2/3 normal_bend / I (1/(kg m)): bounds the rotational stiffness that a normal force adds,
        over k delta.
    skin : float
        Skin of the neighbour lists (m).
    fraction : float
        Time step over the critical one, without unit.
    period : tuple of float
        Period along x and y (m), 0 where the scene does not repeat itself.
    alpha : float
        Dashpot constant, without unit.
    modulus : float
        E* of two granules (Pa).
    mean_radius, mean_mass : float
        Means (m, kg).
    held : ndarray of shape (constituents,) or None
        Which are held.
    """

    root_inverse_mass: np.ndarray
    root_inverse_inertia: np.ndarray | None
    per: int
    radius: np.ndarray
    bounding: np.ndarray
    mass: np.ndarray
    mobility: float
    bend: np.ndarray
    skin: float
    fraction: float
    period: tuple[float, float]
    alpha: float
    modulus: float
    mean_radius: float
    mean_mass: float
    held: np.ndarray | None


def writable(shape):
    """The granules with arrays that can be written, because read-only ones are another type to
    Numba."""
    return resized(shape, np.copy)


def widest_skins(scene: Scene) -> list[float]:
    """Skins (m) with which no list holds two images of one body, nor finds one pair by another
    image than the list before: for each period."""
    return [0.25 * (period - 2.0 * reach(scene)) for period in scene.periodic or () if period]


def granule_table(scene: Scene, skin: float, fraction: float = 1.0) -> GranuleTable:
    """GranuleTable of a scene; skin as a share of the mean bounding radius, fraction of the
    critical step."""
    shape, (inverse_mass, inverse_inertia) = writable(scene.shape), mobilities(scene)
    bounding = shape.constituent_bounding_radius
    per = len(bounding) // scene.granules
    x, y = scene.periodic or (None, None)
    return GranuleTable(
        root_inverse_mass=np.sqrt(inverse_mass),
        root_inverse_inertia=np.sqrt(inverse_inertia) if can_turn(scene) else None,
        per=per,
        radius=shape.constituent_radius,
        bounding=bounding,
        mass=np.repeat(scene.mass, per),
        mobility=float((inverse_mass + shape.bounding_radius**2 * inverse_inertia).max()),
        bend=2.0 / 3.0 * shape.normal_bend * inverse_inertia,
        skin=min([float(skin * bounding.mean()), *widest_skins(scene)]),
        fraction=float(fraction),
        period=(x or 0.0, y or 0.0),
        alpha=damping_from_restitution(scene.material.restitution),
        modulus=effective_modulus(scene.material, scene.material),
        mean_radius=float(shape.constituent_radius.mean()),
        mean_mass=float(scene.mass.mean()),
        held=np.repeat(scene.is_held, per) if scene.held else None,
    )


def mobilities(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """1/mass and 1/inertia (n,) of all granules in 1/kg and 1/(kg m2): no contact moves a held
    one."""
    inverse_mass, inverse_inertia = 1.0 / scene.mass, 1.0 / scene.inertia
    if scene.held:
        inverse_mass[scene.is_held] = inverse_inertia[scene.is_held] = 0.0
    return inverse_mass, inverse_inertia


def partners(scene: Scene, boundary: bool):
    """The elastic materials that meet at a contact between granules, or with the boundary."""
    if not boundary:
        return scene.material, scene.material
    return (scene.material,) if scene.boundary is None else (scene.material, scene.boundary)


def friction_parameters(scene: Scene, kind: str) -> FrictionParameters | None:
    """Friction of the contacts of one kind: granule, wall or cylinder; None if no kind has any.

    Where only some kinds have friction, the others have it with a coefficient of zero: all kinds
    share the lanes of a block, and torques that one kind leaves there must not be read as those of
    another.
    """
    friction = scene.friction
    if friction is None or not any(getattr(friction, name) for name in CONTACT_KINDS):
        return None
    materials = partners(scene, boundary=kind != "granule")
    ratio = effective_shear_modulus(*materials) / effective_modulus(*materials)
    ratio *= friction.stiffness
    coefficient = float(getattr(friction, kind))
    return FrictionParameters(coefficient, 6.0 * ratio, math.sqrt(4.0 * ratio))


def can_turn(scene: Scene) -> bool:
    """Whether any contact turns a granule."""
    rough = friction_parameters(scene, "granule") is not None
    return rough or bool(np.any(scene.shape.normal_lever > 0.0))


def number_of_walls(scene: Scene) -> int:
    return 0 if scene.walls is None else len(scene.walls)


def waypoints_of(motion) -> np.ndarray:
    """Rows of Boundaries.waypoints for one boundary."""
    if isinstance(motion, Drive):
        return np.empty((0, 4))
    if isinstance(motion, PrescribedMotion):
        spin = np.zeros(len(motion.time)) if motion.spin is None else motion.spin
        return np.column_stack([motion.time, motion.velocity, spin])
    return np.array(2 * [[0.0, *motion, 0.0]])  # two rows, so that it can change once in a step


def boundaries(scene: Scene) -> Boundaries:
    """All that granules meet, as they move at the start."""
    walls, cylinder = number_of_walls(scene), scene.cylinder
    motions = [motion or (0.0, 0.0) for motion in scene.wall_motion or [None] * walls]
    motions += [cylinder.velocity] if cylinder else []
    motions += [group.motion for group in scene.held]
    r = len(motions)
    paths = [waypoints_of(motion) for motion in motions]
    moved, drive = rows(r, 8), np.zeros((r, 5))
    if cylinder:
        moved[walls, [X, Y]], moved[walls, W] = cylinder.position, cylinder.spin
        paths[walls][:, 3] += cylinder.spin  # that of the path is then zero, see Cylinder
    for b, motion in enumerate(motions):
        if isinstance(motion, Drive):
            moved[b, [VX, VY]], drive[b, DAMPING] = motion.velocity, motion.damping
            for c, force in enumerate(motion.force):
                if force is not None:
                    drive[b, [EXTERNAL_FORCE + c, INVERSE_MASS + c]] = force, 1.0 / motion.mass
        else:
            time, *columns = paths[b].T
            moved[b, [VX, VY, W]] = [np.interp(0.0, time, column) for column in columns]
    return Boundaries(
        motion=moved,
        reference=np.zeros((r, 2)),
        force=rows(r, 4),
        contact_forces=np.zeros((r, 5)),
        impulses=np.zeros((r, 5)),
        previous_acceleration=np.zeros((r, 2)),
        time=np.zeros(1),
        first_waypoint=np.cumsum([0, *map(len, paths)]),
        waypoints=np.concatenate([np.empty((0, 4)), *paths]),
        drive=drive,
    )


def held_groups(scene: Scene, bodies: np.ndarray, motion: np.ndarray) -> HeldGroups | None:
    """The groups of a scene, whose granules take their velocities (of Boundaries.motion) at
    once."""
    if not scene.held:
        return None
    first, group = len(motion) - len(scene.held), np.full(scene.granules, -1)
    for b, held in enumerate(scene.held):
        group[held.granules] = first + b
    member = np.flatnonzero(group >= 0)
    bodies[np.ix_(member, [VX, VY])] = motion[np.ix_(group[member], [VX, VY])]
    return HeldGroups(first, group, member, bodies[np.ix_(member, [X, Y])])


def contacts(scene: Scene, table: GranuleTable, kind: str, drive: np.ndarray) -> Contacts:
    """The contacts of one kind (granule, wall or cylinder), none yet: see
    dem.dynamics.neighbor_list.

    drive: rows of Boundaries.drive of those that may be part of them.
    """
    index, numbers = np.empty(0, np.uint32), np.empty(0)
    friction = friction_parameters(scene, kind)
    memory = numbers if friction else None
    guesses = numbers if kind != "wall" and scene.shape.guesses else None
    x, y = (0.0, 0.0) if kind == "wall" else table.period
    return Contacts(
        first=np.zeros(len(table.radius) + 1, np.uint32) if kind == "granule" else None,
        constituent=index,
        partner=index,
        force_row=index,
        stiffness=numbers,
        modulus=4.0 / 3.0 * effective_modulus(*partners(scene, boundary=kind != "granule")),
        damping=numbers if table.alpha > 0.0 else None,
        mass_ratio=np.empty((2, 0))
        if table.alpha > 0.0 and drive[:, INVERSE_MASS:DAMPING].any()
        else None,
        friction=friction,
        tangential_force=memory,
        sqrt_overlap=memory,
        normal_x=guesses,
        normal_y=guesses,
        shift_x=numbers if x else None,
        shift_y=numbers if y else None,
        sizes=np.empty((0, 0)) if kind == "granule" and scene.shape.lists_sizes else None,
    )


def assemble(scene: Scene, state: State, table: GranuleTable, accounted: bool = False) -> World:
    """All arrays of the kernels, with empty neighbour lists; accounted: keep an energy ledger."""
    n, index, alone = scene.granules, np.empty(0, np.uint32), table.per == 1
    bodies, force = rows(n, 8), rows(n, 4)
    bodies[:, [X, Y]], bodies[:, [VX, VY]] = state.position, state.velocity
    bodies[:, W] = state.angular_velocity
    inverse_mass, inverse_inertia = mobilities(scene)
    turned = np.column_stack([np.cos(state.angle), np.sin(state.angle)])
    moving, none = boundaries(scene), np.zeros(0, np.int64)
    count, cylinder = number_of_walls(scene), scene.cylinder
    return World(
        shape=writable(scene.shape),
        bodies=bodies,
        angle=state.angle,
        orientation=turned if scene.shape.needs_angle else None,
        inverse_mass=inverse_mass,
        inverse_inertia=inverse_inertia if can_turn(scene) else None,
        force=force,
        constituents=bodies if alone else rows(n * table.per, 8),
        constituent_force=force if alone else rows(n * table.per, 4),
        reference=np.zeros((n * table.per, 2)),
        previous_acceleration=rows(n, 4) if table.alpha > 0.0 else None,
        pairs=contacts(
            scene, table, "granule", moving.drive[len(moving.drive) - len(scene.held) :]
        ),
        boundaries=moving,
        walls=Surface(
            first=0,
            end=count,
            planes=np.empty((0, 3)) if scene.walls is None else np.array(scene.walls),
            radius=None,
            contacts=contacts(scene, table, "wall", moving.drive),
        ),
        cylinder=Surface(
            first=count,
            end=count + bool(cylinder),
            planes=None,
            radius=0.5 * cylinder.diameter if cylinder else 0.0,
            contacts=contacts(scene, table, "cylinder", moving.drive),
        ),
        gravity=scene.gravity or (0.0, 0.0),
        lanes=make_lanes(accounted),
        patches=Patches(index, index, none, none) if n > PATCH else None,
        held=held_groups(scene, bodies, moving.motion),
    )
