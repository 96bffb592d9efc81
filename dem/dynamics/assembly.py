"""From a scene and a state to the arrays of the kernels."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.force_law import (
    damping_from_restitution,
    effective_modulus,
    effective_shear_modulus,
)
from dem.dynamics.stable_step import critical_step
from dem.dynamics.world import (
    CHUNK,
    Chunks,
    Contacts,
    CylinderBoundary,
    FrictionParameters,
    Guide,
    HeldGroups,
    Orders,
    WallBoundary,
    World,
)
from dem.jit.block_memory import make_lanes
from dem.jit.columns import VX, VY, W, X, Y, rows
from dem.motion import Drive, PrescribedMotion
from dem.scene import Scene, State, reach
from dem.shapes.protocol import resized

CONTACT_KINDS = "granule", "wall", "cylinder"


class GranuleTable(NamedTuple):
    """Constants of the granules that the lists and the surveys need.

    root_inverse_mass (n,): 1/sqrt(m) in kg^-0.5; root_inverse_inertia (n,): 1/sqrt(I) in
    kg^-0.5 m^-1, None where nothing turns; both are zero for held granules. per: constituents per
    granule; radius, bounding (constituents,) in m: for Hertz's law, and of the circle that holds one; mass (constituents,) in kg: of the whole granule; mobility: greatest
    1/m + lever^2/I (1/kg) of a contact; bend (n,) in 1/(kg m): 2/3 normal_bend / I, which bounds
    the rotational stiffness that a normal force adds, over k delta; skin (m); period along x and y
    (m), None where the scene does not repeat itself; alpha: dashpot constant; modulus: E* of two
    granules (Pa); mean_radius (m), mean_mass (kg). held (constituents,): which are held, None if none
    is.
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
    period: tuple[float | None, float | None]
    alpha: float
    modulus: float
    mean_radius: float
    mean_mass: float
    held: np.ndarray | None


def own(shape):
    """The granules with writable arrays, because read-only ones are another type to Numba."""
    return resized(shape, np.copy)


def widest_skins(scene: Scene, period) -> list[float]:
    """Skins (m) with which no list holds two images of one body, nor finds one pair by another image
    than the list before: for each period."""
    return [0.25 * (each - 2.0 * reach(scene)) for each in period if each is not None]


def granule_table(scene: Scene, skin: float) -> GranuleTable:
    """GranuleTable of a scene; skin as a share of the mean bounding radius."""
    shape, (inverse_mass, inverse_inertia), held = (
        own(scene.shape),
        mobilities(scene),
        scene.is_held,
    )
    bounding = shape.constituent_bounding_radius
    per = len(bounding) // scene.granules
    period = scene.periodic or (None, None)
    return GranuleTable(
        root_inverse_mass=np.sqrt(inverse_mass),
        root_inverse_inertia=np.sqrt(inverse_inertia) if can_turn(scene) else None,
        per=per,
        radius=shape.constituent_radius,
        bounding=bounding,
        mass=np.repeat(scene.mass, per),
        mobility=float((inverse_mass + shape.bounding_radius**2 * inverse_inertia).max()),
        bend=2.0 / 3.0 * shape.normal_bend * inverse_inertia,
        skin=min([float(skin * bounding.mean()), *widest_skins(scene, period)]),
        period=period,
        alpha=damping_from_restitution(scene.material.restitution),
        modulus=effective_modulus(scene.material, scene.material),
        mean_radius=float(shape.constituent_radius.mean()),
        mean_mass=float(scene.mass.mean()),
        held=np.repeat(held, per) if scene.held else None,
    )


def mobilities(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """1/mass and 1/inertia (n,) of all granules in 1/kg and 1/(kg m2): no contact moves a held one."""
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

    Where only some kinds have friction, the others have it with a coefficient of zero: all kinds share
    the lanes of a block, and torques that one kind leaves there must not be read as those of another.
    """
    friction = scene.friction
    if friction is None or not any(getattr(friction, each) for each in CONTACT_KINDS):
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


def motion(position, velocity, spin):
    """Rows (n, 8) of dem.jit.columns."""
    position = np.atleast_2d(np.asarray(position, float))
    motion = rows(len(position), 8)
    motion[:, [X, Y]], motion[:, [VX, VY]], motion[:, W] = position, velocity, spin
    return motion


def start_of(motion) -> tuple[tuple[float, float], float]:
    """Velocity (m/s) and spin (rad/s) of a boundary at the start."""
    if isinstance(motion, PrescribedMotion):
        x, y = (float(np.interp(0.0, motion.time, column)) for column in motion.velocity.T)
        return (x, y), 0.0 if motion.spin is None else float(
            np.interp(0.0, motion.time, motion.spin)
        )
    return (motion.velocity if isinstance(motion, Drive) else motion), 0.0


def table_of(motion) -> np.ndarray:
    """Rows of Orders.table for one boundary."""
    if isinstance(motion, Drive):
        return np.empty((0, 4))
    if isinstance(motion, PrescribedMotion):
        spin = np.zeros(len(motion.time)) if motion.spin is None else motion.spin
        return np.column_stack([motion.time, motion.velocity, spin])
    return np.array([[0.0, *motion, 0.0]])


def guide(motions) -> Guide:
    """What moves boundaries with these motions."""
    tables = [table_of(each) for each in motions]
    push, inverse_mass = np.zeros((2, len(motions), 2))
    damping = np.zeros(len(motions))
    for b, each in enumerate(motions):
        if isinstance(each, Drive):
            damping[b] = each.damping
            for c, force in enumerate(each.force):
                if force is not None:
                    push[b, c], inverse_mass[b, c] = force, 1.0 / each.mass
    first = np.cumsum([0, *map(len, tables)])
    orders = Orders(first, np.concatenate(tables), push, inverse_mass, damping)
    return Guide(orders, np.zeros(1), rows(len(motions), 4))


def started(position, motions) -> np.ndarray:
    """Rows of dem.jit.columns for boundaries at the start."""
    velocity, spin = zip(*map(start_of, motions), strict=True)
    return motion(position, np.array(velocity), np.array(spin))


def wall_boundary(scene: Scene, table: GranuleTable) -> WallBoundary:
    planes = np.array(scene.walls, float)
    count = len(planes)
    given = scene.wall_motion or ()
    moved = any(each is not None for each in given)
    motions = [(0.0, 0.0) if each is None else each for each in given]
    return WallBoundary(
        planes=planes,
        motion=started(np.zeros((count, 2)), motions) if moved else rows(count, 8),
        contacts=contacts(scene, table, "wall"),
        impulse=np.zeros(count),
        shear=np.zeros(count),
        reference=planes[:, 2].copy() if moved else None,
        guide=guide(motions) if moved else None,
    )


def cylinder_boundary(scene: Scene, table: GranuleTable) -> CylinderBoundary:
    cylinder = scene.cylinder
    assert cylinder is not None
    axis = started(cylinder.position, [cylinder.velocity])
    axis[0, W] += cylinder.spin  # that of the path is then zero, see Cylinder
    guided = (
        guide([cylinder.velocity])
        if isinstance(cylinder.velocity, PrescribedMotion | Drive)
        else None
    )
    if guided is not None:
        guided.orders.table[:, 3] += cylinder.spin
    return CylinderBoundary(
        radius=0.5 * cylinder.diameter,
        motion=axis,
        reference=np.zeros(2),
        contacts=contacts(scene, table, "cylinder"),
        impulse=np.zeros(4),
        twist=np.zeros(1),
        guide=guided,
    )


def held_groups(scene: Scene, bodies: np.ndarray) -> HeldGroups | None:
    """The groups of a scene, whose granules take their velocities at once."""
    if not scene.held:
        return None
    group = np.full(scene.granules, -1)
    for b, each in enumerate(scene.held):
        group[each.granules] = b
    member = np.flatnonzero(group >= 0)
    motions = [each.motion for each in scene.held]
    moved = started(np.zeros((len(motions), 2)), motions)
    bodies[np.ix_(member, [VX, VY])] = moved[np.ix_(group[member], [VX, VY])]
    return HeldGroups(
        group, member, bodies[np.ix_(member, [X, Y])], moved, np.zeros((len(motions), 2)),
        guide(motions),
    )  # fmt: skip


def contacts(scene: Scene, table: GranuleTable, kind: str) -> Contacts:
    """The contacts of one kind (granule, wall or cylinder), none yet: see dem.dynamics.neighbor_list."""
    index, numbers = np.empty(0, np.uint32), np.empty(0)
    friction = friction_parameters(scene, kind)
    memory = numbers if friction else None
    guesses = numbers if kind != "wall" and scene.shape.guesses else None
    period = (None, None) if kind == "wall" else table.period
    return Contacts(
        first=np.zeros(len(table.radius) + 1, np.uint32) if kind == "granule" else None,
        constituent=index,
        partner=index,
        force_row=index,
        stiffness=numbers,
        modulus=4.0 / 3.0 * effective_modulus(*partners(scene, boundary=kind != "granule")),
        damping=numbers if table.alpha > 0.0 else None,
        friction=friction,
        tangential_force=memory,
        sqrt_overlap=memory,
        normal_x=guesses,
        normal_y=guesses,
        shift_x=None if period[0] is None else numbers,
        shift_y=None if period[1] is None else numbers,
        sizes=np.empty((0, 0)) if kind == "granule" and scene.shape.lists_sizes else None,
    )


def assemble(scene: Scene, state: State, table: GranuleTable, accounted: bool = False) -> World:
    """All arrays of the kernels, with empty neighbour lists; accounted: keep an energy ledger."""
    n, index = scene.granules, np.empty(0, np.uint32)
    has_angle = scene.shape.needs_angle
    bodies, force = motion(state.position, state.velocity, state.angular_velocity), rows(n, 4)
    alone, first = table.per == 1, np.zeros(0, np.int64)
    inverse_mass, inverse_inertia = mobilities(scene)
    return World(
        shape=own(scene.shape),
        bodies=bodies,
        angle=state.angle,
        frame=np.column_stack([np.cos(state.angle), np.sin(state.angle)]) if has_angle else None,
        inverse_mass=inverse_mass,
        inverse_inertia=inverse_inertia if can_turn(scene) else None,
        force=force,
        constituents=bodies if alone else rows(n * table.per, 8),
        constituent_force=force if alone else rows(n * table.per, 4),
        reference=np.zeros((n * table.per, 2)),
        pairs=contacts(scene, table, "granule"),
        walls=None if scene.walls is None else wall_boundary(scene, table),
        cylinder=None if scene.cylinder is None else cylinder_boundary(scene, table),
        gravity=None if scene.gravity is None else np.array(scene.gravity, float),
        lanes=make_lanes(accounted),
        chunks=Chunks(index, index, first, first) if n > CHUNK else None,
        held=held_groups(scene, bodies),
    )


NEIGHBOURS = 6  # of a granule, all as deep as can be and in the worst direction
CAUTION = 0.03  # sides that are nearly flat are stiffer than the radii say


def least_step(scene, table, max_overlap: float, fraction: float) -> float:
    """A time step (s) that no state of a scene can ask for by its contacts: a shorter one has collapsed.

    It is CAUTION times the critical step if all contacts were as deep as `max_overlap` (over the smaller
    radius) allows, times the `fraction` of it that a run takes. No run with sound speeds takes such
    steps: granules much faster than sound in them end in an OverlapError when they collide.
    """
    moduli = [effective_modulus(*partners(scene, boundary)) for boundary in (False, True)]
    rough = [friction_parameters(scene, kind) for kind in CONTACT_KINDS]
    ratio = max((each.stiffness_ratio for each in rough if each), default=0.0)
    damped = max((each.damping_ratio for each in rough if each), default=0.0)
    inverse_mass, inverse_inertia = mobilities(scene)
    radius = table.radius.reshape(-1, table.per).max(axis=1)
    mobility = inverse_mass + scene.shape.bounding_radius**2 * inverse_inertia
    drives = [
        each for each in (
            *(scene.wall_motion or ()), *(group.motion for group in scene.held),
            scene.cylinder and scene.cylinder.velocity,
        ) if isinstance(each, Drive)
    ]  # fmt: skip
    many = 2.0 * NEIGHBOURS
    if drives:  # all granules may lie on one body
        mobility = mobility + max(1.0 / each.mass for each in drives)
        many = 2.0 * max(NEIGHBOURS, scene.granules)
    k = 2.0 * max(moduli) * math.sqrt(max_overlap) * radius
    stiffness = k * ((1.0 + ratio) * mobility + max_overlap * radius * table.bend)
    damping = table.alpha * (1.0 + damped) * np.sqrt(k * mobility * mobility * scene.mass)
    return CAUTION * fraction * min(map(critical_step, many * stiffness, many * damping))
