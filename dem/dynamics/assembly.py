"""From a scene and a state to the arrays of the kernels."""

import math
from dataclasses import astuple, replace
from typing import NamedTuple

import numpy as np

from dem.contacts.force_law import (
    damping_from_restitution,
    effective_modulus,
    effective_shear_modulus,
)
from dem.dynamics.boundary_motion import fastest
from dem.dynamics.diagnostics import step_alone, usual_overlap
from dem.dynamics.world import (
    ALPHA,
    DAMPING,
    DRIVE,
    EXTERNAL_FORCE,
    FRICTION,
    INVERSE_MASS,
    LAW,
    PATCH,
    Boundaries,
    Contacts,
    Faces,
    HeldGroups,
    Patches,
    Surface,
    World,
)
from dem.jit.block_memory import make_lanes
from dem.jit.columns import VX, VY, W, X, Y, rows
from dem.laws.protocol import length, slope
from dem.motion import Drive, PrescribedMotion, Turn
from dem.periodic import wrapped
from dem.scene import ARRAYS, Scene, State, reach
from dem.shapes.ellipse import Ellipse
from dem.shapes.protocol import is_alone
from dem.solids import Polygon

# Skins of neighbour lists over the mean bounding radius. They change the speed of a run, and at which
# steps the time step is chosen.
SKIN = 0.12  # of runs, at least; timings of beds are flat from 0.1 to 0.2
WIDEST = 1.0
SKIN_OF_PACKING = 0.3  # while a bed is packed, where granules move far
REBUILD_COST = 60.0  # of a list over what a wider skin costs, fitted to gases and dense beds


class GranuleTable(NamedTuple):
    """Constants of the granules that the lists and the scans need.

    Attributes
    ----------
    law : tuple
        The law of contacts, as kernels take it.
    alone : bool
        Whether each granule is its own only constituent.
    arm : ndarray of shape (n,)
        Bound of the distances of centres of constituents from that of the granule (m).
    radius : ndarray of shape (constituents,)
        Radius in the law (m).
    bounding : ndarray of shape (constituents,)
        Radius of the circle that holds the constituent (m).
    mass : ndarray of shape (constituents,)
        Mass of the whole granule (kg).
    mobility : float
        Greatest 1/m + arm^2/I of a contact (1/kg).
    bend : ndarray of shape (n,)
        normal_bend / I (1/(kg m)), times bulk: bounds the rotational stiffness that a normal force
        adds, over k delta.
    bulk : float
        Of the law (dem.laws.protocol.Law).
    skin : float
        Skin of the neighbour lists (m).
    fraction : float
        Time step over the critical one, without unit.
    period : tuple of float
        Period along x and y (m), 0 where the scene does not repeat itself.
    laws : ndarray of shape (s + w + k, s, 6)
        Constants of contacts of a granule of each of s materials (second axis) with one of each
        material, then with each wall and solid: see dem.dynamics.world.MODULUS.
    species : ndarray of shape (n,)
        Number of the material of each granule.
    solid_radius : ndarray of shape (w + k,)
        Radius in the law (m) of solids that have the outline of a granule; zero of others.
    alpha : float
        Dashpot constant of granules, without unit; the greatest, times the margin of the law.
    modulus : float
        Modulus of the law for two granules (Pa or N/m); the greatest.
    mean_radius, mean_mass : float
        Means (m, kg).
    held : ndarray of shape (constituents,) or None
        Which are held.
    rolling : tuple of float or None
        Coefficients of rolling resistance with granules, walls and solids, and the damping ratio.
    """

    law: tuple
    alone: bool
    arm: np.ndarray
    radius: np.ndarray
    bounding: np.ndarray
    mass: np.ndarray
    mobility: float
    bend: np.ndarray
    bulk: float
    skin: float
    fraction: float
    period: tuple[float, float]
    laws: np.ndarray
    species: np.ndarray
    solid_radius: np.ndarray
    alpha: float
    modulus: float
    mean_radius: float
    mean_mass: float
    held: np.ndarray | None
    rolling: tuple[float, float, float, float] | None


def widest_skins(scene: Scene) -> list[float]:
    """Skins (m) with which no list holds two images of one body, nor finds one pair by another
    image than the list before: for each period."""
    return [0.25 * (period - 2.0 * reach(scene)) for period in scene.periodic or () if period]


def granule_table(scene: Scene, skin: float, fraction: float = 1.0) -> GranuleTable:
    """GranuleTable of a scene; skin as a share of the mean bounding radius, fraction of the
    critical step."""
    shape, (inverse_mass, inverse_inertia) = scene.shape, mobilities(scene)
    laws, count = laws_of(scene), len(scene.materials)
    bounding, owner, arm = shape.constituent_bounding_radius, shape.owner, np.zeros(scene.granules)
    np.maximum.at(arm, owner, shape.bounding_radius[owner] - bounding)
    x, y = scene.periodic or (None, None)
    solid_radius = np.zeros(len(scene.walls) + len(scene.solids))
    for b, solid in enumerate(scene.solids, len(scene.walls)):
        if not isinstance(solid.outline, Polygon):
            solid_radius[b] = solid.outline.constituent_radius[0]
    return GranuleTable(
        # values that are None would be another type: these constants follow from `laws`
        law=scene.law._replace(**{k: 0.0 for k, v in scene.law._asdict().items() if v is None}),
        alone=is_alone(shape),
        arm=arm,
        radius=shape.constituent_radius,
        bounding=bounding,
        mass=scene.mass[owner],
        mobility=float((inverse_mass + shape.bounding_radius**2 * inverse_inertia).max()),
        bend=scene.law.bulk * shape.normal_bend * inverse_inertia,
        bulk=scene.law.bulk,
        skin=min([float(skin * bounding.mean()), *widest_skins(scene)]),
        fraction=float(fraction),
        period=(x or 0.0, y or 0.0),
        laws=laws,
        species=scene.species.copy(),
        solid_radius=solid_radius,
        alpha=float(scene.law.margin * laws[:count, :, ALPHA].max()),
        modulus=max(modulus(scene, material, material) for material in scene.materials),
        mean_radius=float(shape.constituent_radius.mean()),
        mean_mass=float(scene.mass.mean()),
        held=scene.is_held[owner] if scene.held else None,
        rolling=astuple(scene.rolling) if scene.rolling else None,
    )


def mobilities(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """1/mass and 1/inertia (n,) of all granules in 1/kg and 1/(kg m2): no contact moves a held
    one."""
    inverse_mass, inverse_inertia = 1.0 / scene.mass, 1.0 / scene.inertia
    if scene.held:
        inverse_mass[scene.is_held] = inverse_inertia[scene.is_held] = 0.0
    return inverse_mass, inverse_inertia


def modulus(scene: Scene, *materials) -> float:
    """Modulus of the law of a scene (Pa or N/m) for the elastic materials that meet."""
    return float(scene.law.modulus(effective_modulus(*materials), scene.thickness))


def law(scene: Scene, friction: float, material, partner) -> list[float]:
    """Row of GranuleTable.laws for a granule of a material and its partner, None if it is rigid.

    Tangential over normal stiffness is that of Mindlin, 4 G*/E*, under every law.
    """
    materials = (material,) if partner is None else (material, partner)
    young = effective_modulus(*materials)
    ratio = effective_shear_modulus(*materials) / young
    ratio *= scene.friction.stiffness if scene.friction else 1.0
    restitution = material.restitution
    if partner is not None and partner.restitution != restitution:
        restitution = math.sqrt(restitution * partner.restitution)
    return [
        modulus(scene, *materials),
        damping_from_restitution(restitution, scene.law.dashpot),
        young / effective_modulus(material),
        friction,
        slope(scene.law, 1.0, 1.0) * (4.0 * ratio),
        math.sqrt(4.0 * ratio),
    ]


def laws_of(scene: Scene) -> np.ndarray:
    """GranuleTable.laws of a scene."""
    materials, friction = scene.materials, scene.friction
    table = np.zeros((len(materials), len(materials))) + (friction.granule if friction else 0.0)
    laws = [
        [law(scene, float(table[a, b]), one, other) for b, one in enumerate(materials)]
        for a, other in enumerate(materials)
    ]
    for bodies, name in ((scene.walls, "wall"), (scene.solids, "solid")):
        for body in bodies:
            coefficient, partner = body.friction, body.material or scene.boundary
            if coefficient is None:
                coefficient = getattr(friction, name) if friction else 0.0
            laws.append([law(scene, coefficient, one, partner) for one in materials])
    return np.array(laws).reshape(-1, len(materials), LAW)


def has_friction(laws: np.ndarray) -> bool:
    """Whether any contact has friction. If so, all have it, if need be with a coefficient of zero:
    all lists share the lanes of a block."""
    return bool((laws[..., FRICTION] > 0.0).any())


def can_turn(scene: Scene, laws: np.ndarray) -> bool:
    """Whether any contact turns a granule, or a solid that is not round."""
    return bool(
        scene.rolling
        or not all(solid.is_round for solid in scene.solids)
        or np.any(scene.shape.normal_lever > 0.0)
        or has_friction(laws)
    )


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
    walls, solids = len(scene.walls), scene.solids
    motions = [wall.motion for wall in scene.walls]
    motions += [solid.velocity for solid in solids]
    motions += [group.motion for group in scene.held]
    r = len(motions)
    paths = [waypoints_of(motion) for motion in motions]
    moved, drive, angle, reach = rows(r, 8), np.zeros((r, DRIVE)), np.zeros(r), np.zeros(r)
    for b, motion in enumerate(motions):
        if isinstance(motion, Drive):
            moved[b, [VX, VY]] = motion.velocity
            for c, force in enumerate(motion.force):
                drive[b, DAMPING + c] = motion.damping
                if force is not None:
                    drive[b, [EXTERNAL_FORCE + c, INVERSE_MASS + c]] = force, 1.0 / motion.mass
    for b, solid in enumerate(solids, walls):
        moved[b, [X, Y]], angle[b] = solid.position, solid.angle
        reach[b] = 0.0 if solid.is_round else solid.radius
        turn = solid.spin
        if isinstance(turn, Turn):
            moved[b, W] = turn.spin
            drive[b, EXTERNAL_FORCE + 2 :: 3] = turn.torque, 1.0 / turn.inertia, turn.damping
        else:
            moved[b, W] = turn
            paths[b][:, 3] += turn  # that of the path is then zero, see Solid
    for b, path in enumerate(paths):
        for column in (VX, VY) if drive[b, INVERSE_MASS + 2] else (VX, VY, W):
            if len(path):
                moved[b, column] = np.interp(0.0, path[:, 0], path[:, 1 + column - VX])
    return Boundaries(
        motion=moved,
        angle=angle,
        orientation=np.column_stack([np.cos(angle), np.sin(angle)]) if reach.any() else None,
        reach=reach,
        reference=np.zeros((r, 3)),
        force=rows(r, 4),
        contact_forces=np.zeros((r, 5)),
        impulses=np.zeros((r, 5)),
        previous_acceleration=np.zeros((r, 3)),
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


def contacts(
    scene: Scene, table: GranuleTable, yields: bool, partner: str = "granule", shape=None
) -> Contacts:
    """The contacts of granules with granules, walls or solids, none yet: see
    dem.dynamics.neighbor_list.

    yields: whether forces move a boundary that may be part of them; shape: of the contact search,
    that of the granules if absent.
    """
    index, numbers = np.empty(0, np.uint32), np.empty(0)
    rolls = table.rolling is not None
    damped, rough = rolls or table.laws[..., ALPHA].any(), rolls or has_friction(table.laws)
    memory = numbers if rough else None
    remembers = (scene.shape if shape is None else shape).guesses
    guesses = numbers if partner != "wall" and remembers else None
    x, y = (0.0, 0.0) if partner == "wall" else table.period
    return Contacts(
        first=np.zeros(len(table.radius) + 1, np.uint32) if partner == "granule" else None,
        constituent=index,
        partner=index,
        force_row=index,
        law=table.law,
        stiffness=numbers,
        length=None if length(table.law, 1.0, 1.0, 1.0, 1.0) is None else numbers,
        damping=numbers if damped else None,
        mass_ratio=np.empty((3, 0)) if damped and yields else None,
        friction=np.empty((3, 0)) if rough else None,
        tangential_force=memory,
        measure=memory,
        rolling=np.empty((2, 0)) if rolls else None,
        rolling_moment=numbers if rolls else None,
        normal_x=guesses,
        normal_y=guesses,
        shift_x=numbers if x else None,
        shift_y=numbers if y else None,
        sizes=np.empty((0, 0)) if partner == "granule" and scene.shape.lists_sizes else None,
    )


def meeting(outlines, shape):
    """Outlines of solids that granules meet as each other; with one R* a pair, if these are discs."""
    if not isinstance(outlines, Ellipse):
        return outlines
    if not isinstance(shape, Ellipse):
        return outlines._replace(hertz_radius=None)
    return outlines._replace(contact=shape.contact, hertz_radius=shape.hertz_radius)


def yielding(moving: Boundaries) -> np.ndarray:
    """Whether normal forces move each boundary (r,), or turn it."""
    inverse = moving.drive[:, INVERSE_MASS : INVERSE_MASS + 3]
    return inverse[:, :2].any(axis=1) | (inverse[:, 2] * moving.reach > 0.0)


def surfaces(scene: Scene, table: GranuleTable, yields: bool) -> dict[str, Surface | None]:
    """Walls, and solids by their outlines, as members of a World."""
    walls = len(scene.walls)
    r = walls + len(scene.solids) + len(scene.held)
    radius, rounding, first = np.zeros(r), np.zeros(r), np.zeros(r + 1, np.int64)
    circles, polygons, faces, others = [], [], [], {}
    for b, solid in enumerate(scene.solids, walls):
        outline = solid.outline
        if solid.is_round:
            circles.append(b)
            radius[b] = solid.radius
        elif isinstance(outline, Polygon):
            polygons.append(b)
            rounding[b], first[b + 1] = outline.radius, len(outline.faces)
            faces.append(outline.faces)
        else:
            others[b] = outline

    def surface(boundary, partner="solid", **outline) -> Surface:
        listed = contacts(scene, table, yields, partner, outline.get("outlines"))
        forms = dict.fromkeys(("planes", "radius", "outlines", "faces")) | outline
        return Surface(boundary=np.array(boundary, np.int64), **forms, contacts=listed)

    members = {
        "walls": surface(range(walls), "wall", planes=scene.planes),
        "circles": surface(circles, radius=radius),
        "outlines": None,
        "polygons": None,
    }
    if others:
        number = np.zeros(r, np.int64)  # of the outline of each boundary
        number[[*others]] = range(len(others))
        one, *more = others.values()
        outlines = meeting(one.appended(*more).take(number), scene.shape)
        members["outlines"] = surface([*others], outlines=outlines)
    if polygons:
        listed = Faces(np.cumsum(first), np.concatenate(faces), rounding)
        members["polygons"] = surface(polygons, faces=listed)
    return members


def assemble(scene: Scene, state: State, table: GranuleTable, accounted: bool = False) -> World:
    """All arrays of the kernels, with empty neighbour lists; accounted: keep an energy ledger."""
    n, index, count = scene.granules, np.empty(0, np.uint32), len(table.radius)
    bodies, force = rows(n, 8), rows(n, 4)
    bodies[:, [X, Y]], bodies[:, [VX, VY]] = state.position, state.velocity
    bodies[:, W] = state.angular_velocity
    inverse_mass, inverse_inertia = mobilities(scene)
    turns = can_turn(scene, table.laws)
    turned = np.column_stack([np.cos(state.angle), np.sin(state.angle)])
    moving, none = boundaries(scene), np.zeros(0, np.int64)
    yields = yielding(moving)
    pairs = contacts(scene, table, yields[len(yields) - len(scene.held) :].any())
    return World(
        shape=scene.shape,
        bodies=bodies,
        angle=state.angle,
        orientation=turned if scene.shape.needs_angle else None,
        inverse_mass=inverse_mass,
        # None is a type, and zeros let round ellipses keep theirs
        inverse_inertia=inverse_inertia * turns if turns or scene.shape.needs_angle else None,
        force=force,
        constituents=bodies if table.alone else rows(count, 8),
        constituent_force=force if table.alone else rows(count, 4),
        reference=np.zeros((count, 2)),
        previous_acceleration=None if pairs.damping is None else rows(n, 4),
        pairs=pairs,
        boundaries=moving,
        **surfaces(scene, table, yields.any()),
        gravity=scene.gravity or (0.0, 0.0),
        lanes=make_lanes(accounted),
        patches=Patches(index, index, none, none) if n > PATCH else None,
        held=held_groups(scene, bodies, moving.motion),
    )


# Order in memory: that of Morton (1966), the bits of two cell numbers interleaved, so that a patch
# (dem.dynamics.world) is compact, and has few neighbours in others


def _spread(number):
    """A zero between any two bits of numbers below 2^32."""
    bit, one, two = np.arange(32, dtype=np.uint64), np.uint64(1), np.uint64(2)
    bits = number.astype(np.uint64)[:, None] >> bit & one
    return (bits << two * bit).sum(axis=1)


def order_of(scene: Scene, state: State) -> np.ndarray:
    """Granules (n,) in the order of memory: that of the user for a bed of one patch."""
    if scene.granules <= PATCH:
        return np.arange(scene.granules)
    cell = 2.0 * scene.shape.bounding_radius.mean()
    position = wrapped(state.position, scene.periodic)
    cells = np.minimum((position - position.min(axis=0)) / cell, 2.0**31)
    return np.argsort(_spread(cells[:, 0]) | _spread(cells[:, 1]) << np.uint64(1), kind="stable")


def ordered(scene: Scene, state: State, order) -> tuple[Scene, State]:
    """The same scene and state with granules in the order of memory."""
    if scene.granules <= PATCH:
        return scene, state
    state = State(*(getattr(state, name)[order] for name in ARRAYS))
    places = np.argsort(order)
    held = tuple(replace(group, granules=places[group.granules]) for group in scene.held)
    return replace(
        scene, shape=scene.shape.take(order), held=held, species=scene.species[order]
    ), state


def skin_for(scene, world, table, time_step: float | None) -> float:
    """Skin (m) for the speeds of a scene at the start, at least SKIN and at most WIDEST.

    What flies farther in a step needs its lists more often, or wider ones. The sum of both costs is
    least for a skin that grows with the root of the flight in a step. The speed is that of the
    fastest boundary, or three times the mean of granules.
    """
    squared = (world.bodies[:, [VX, VY]] ** 2).sum(axis=1).mean()
    speed = math.sqrt(max(9.0 * float(squared), fastest(world.boundaries)))
    usual = step_alone(table, usual_overlap(table, speed), table.fraction)
    step, size = time_step or usual, table.bounding.mean()
    wanted = np.clip(math.sqrt(REBUILD_COST * speed * step * size), SKIN * size, WIDEST * size)
    return min([float(wanted), *widest_skins(scene)])
