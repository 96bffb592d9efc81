"""From a scene and a state to the arrays of the kernels, and the contact lists between steps."""

import math
from typing import NamedTuple

import numpy as np

from dem import neighbors
from dem.columns import VX, VY, W, X, Y
from dem.compilation import compiled
from dem.contact_law import damping_from_restitution, effective_modulus, effective_shear_modulus
from dem.scene import Scene, State
from dem.shapes import SHAPES, Ellipse
from dem.shapes.geometry import place
from dem.world import Contacts, Roller, Tangent, Walls, World


class Constants(NamedTuple):
    """What the lists and the surveys need of the granules and does not change.

    per: parts a granule; radius, bounding (parts,) in m: for Hertz's law, and of the circle that
    holds the part; mass (parts,) in kg: of the whole granule; wn, wt (n,): see dem.survey.survey;
    skin (m); alpha: dashpot constant.
    """

    per: int
    radius: np.ndarray
    bounding: np.ndarray
    mass: np.ndarray
    wn: np.ndarray
    wt: np.ndarray
    skin: float
    alpha: float


NOTHING = Contacts(None, None, np.empty(0, np.uint32), np.empty(0), 0.0, None, None, None)


def constants(scene: Scene, skin: float) -> Constants:
    """Constants of a scene; skin as a share of the mean bounding radius."""
    shape, inverse_mass, inverse_inertia = scene.shape, 1.0 / scene.mass, 1.0 / scene.inertia
    bounding = shape.part_bounding_radius
    per = len(bounding) // scene.granules
    return Constants(
        per=per,
        radius=shape.part_radius,
        bounding=bounding,
        mass=np.repeat(scene.mass, per),
        wn=np.sqrt(inverse_mass + shape.normal_lever**2 * inverse_inertia),
        wt=np.sqrt(inverse_mass + shape.bounding_radius**2 * inverse_inertia),
        skin=skin * bounding.mean(),
        alpha=damping_from_restitution(scene.material.restitution),
    )


def partners(scene: Scene, boundary: bool):
    """The elastic materials that meet at a contact between granules, or with the boundary."""
    if not boundary:
        return scene.material, scene.material
    return (scene.material,) if scene.boundary is None else (scene.material, scene.boundary)


def tangent(scene: Scene, kind: str) -> Tangent | None:
    """Friction of the contacts of one kind: granule, wall or cylinder."""
    coefficient = 0.0 if scene.friction is None else getattr(scene.friction, kind)
    if coefficient == 0.0:
        return None
    materials = partners(scene, boundary=kind != "granule")
    ratio = effective_shear_modulus(*materials) / effective_modulus(*materials)
    return Tangent(float(coefficient), 6.0 * ratio, math.sqrt(4.0 * ratio))


def motion(position, velocity, spin):
    """Rows (n, 8) of dem.columns."""
    position = np.atleast_2d(np.asarray(position, float))
    rows = np.zeros((len(position), 8))
    rows[:, [X, Y]], rows[:, [VX, VY]], rows[:, W] = position, velocity, spin
    return rows


def assemble(scene: Scene, state: State, parts: Constants) -> World:
    """All arrays of the kernels, with empty contact lists."""
    n = scene.granules
    turns = next(turns for kind, turns in SHAPES.values() if isinstance(scene.shape, kind))
    tangents = {kind: tangent(scene, kind) for kind in ("granule", "wall", "cylinder")}
    turning = any(tangents.values()) or bool(np.any(scene.shape.normal_lever > 0.0))
    bodies, force = motion(state.position, state.velocity, state.angular_velocity), np.zeros((n, 4))
    alone = parts.per == 1
    walls = roller = None
    if scene.walls is not None:
        planes = np.ascontiguousarray(scene.walls, float)
        walls = Walls(planes, np.zeros((1, 8)), NOTHING, tangents["wall"], np.zeros(len(planes)))
    if scene.cylinder is not None:
        axis = motion(scene.cylinder.position, scene.cylinder.velocity, 0.0)
        radius = 0.5 * scene.cylinder.diameter
        roller = Roller(radius, axis, np.zeros(2), NOTHING, tangents["cylinder"], np.zeros(4))
    return World(
        shape=scene.shape,
        bodies=bodies,
        angle=state.angle,
        frame=np.column_stack([np.cos(state.angle), np.sin(state.angle)]) if turns else None,
        inverse_mass=1.0 / scene.mass,
        inverse_inertia=1.0 / scene.inertia if turning else None,
        force=force,
        parts=bodies if alone else np.zeros((n * parts.per, 8)),
        part_force=force if alone else np.zeros((n * parts.per, 4)),
        reference=np.zeros((n * parts.per, 2)),
        pairs=NOTHING,
        tangent=tangents["granule"],
        walls=walls,
        roller=roller,
        gravity=None if scene.gravity is None else np.array(scene.gravity, float),
    )


@compiled
def place_parts(shape, bodies, frame, parts):
    """Bring the parts to where their granules are."""
    place(shape, bodies, frame, parts)


def _unit(d):
    length = np.hypot(d[:, 0], d[:, 1])[:, None]
    return np.where(length > 0.0, d / np.where(length > 0.0, length, 1.0), [1.0, 0.0])


def _contacts(scene, parts, indices, radius, mass, friction, normals, old):
    """Contacts with their constants (R* in m, m* in kg) and what the old list remembers of them."""
    first, part, other = indices
    modulus = 4.0 / 3.0 * effective_modulus(*partners(scene, boundary=part is not None))
    stiffness = modulus * np.sqrt(radius)
    new = Contacts(
        first, part, other, stiffness, modulus,
        damping=parts.alpha * np.sqrt(mass * stiffness) if parts.alpha > 0.0 else None,
        spring=np.zeros((len(other), 2)) if friction is not None else None,
        normals=normals if isinstance(scene.shape, Ellipse) else None,
    )  # fmt: skip
    if old is not NOTHING:
        carry = neighbors.carry_pairs if part is None else neighbors.carry_listed
        start, old_start = (first, old.first) if part is None else (part, old.part)
        for memory, old_memory in ((new.spring, old.spring), (new.normals, old.normals)):
            if memory is not None:
                carry(start, other, memory, old_start, old.other, old_memory)
    return new


def relist(scene: Scene, parts: Constants, world: World) -> World:
    """The world with contact lists made anew for the present positions."""
    if world.frame is not None:
        world.frame[:, 0], world.frame[:, 1] = np.cos(world.angle), np.sin(world.angle)
    place_parts(world.shape, world.bodies, world.frame, world.parts)
    rows, radius, mass, skin = world.parts, parts.radius, parts.mass, parts.skin
    first, other = neighbors.near_pairs(rows, parts.bounding, skin, parts.per)
    i = np.repeat(np.arange(len(radius)), np.diff(first))
    pairs = _contacts(
        scene, parts, (first, None, other),
        radius[i] * radius[other] / (radius[i] + radius[other]),
        mass[i] * mass[other] / (mass[i] + mass[other]),
        world.tangent, _unit(rows[other, :2] - rows[i, :2]), world.pairs,
    )  # fmt: skip
    walls, roller = world.walls, world.roller
    if walls is not None:
        part, other = neighbors.near_planes(rows, parts.bounding, skin, walls.planes)
        near = _contacts(
            scene, parts, (None, part, other), radius[part], mass[part],
            walls.tangent, None, walls.contacts,
        )  # fmt: skip
        walls = walls._replace(contacts=near)
    if roller is not None:
        axis = roller.motion[0, :2]
        part, other = neighbors.near_circle(rows, parts.bounding, skin, *axis, roller.radius)
        near = _contacts(
            scene, parts, (None, part, other),
            radius[part] * roller.radius / (radius[part] + roller.radius), mass[part],
            roller.tangent, _unit(axis - rows[part, :2]), roller.contacts,
        )  # fmt: skip
        roller = roller._replace(contacts=near)
        roller.reference[:] = axis
    world.reference[:] = rows[:, :2]
    return world._replace(pairs=pairs, walls=walls, roller=roller)
