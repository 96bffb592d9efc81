"""From a scene and a state to the arrays of the kernels."""

import math
from dataclasses import astuple
from typing import NamedTuple

import numpy as np

from dem.contacts.effective import effective_modulus, effective_shear_modulus
from dem.contacts.layout import ACCOUNT, VX, VY, W, X, Y, aligned, layout_of
from dem.contacts.restitution import damping_from_restitution
from dem.dynamics.base_plate import base_of
from dem.dynamics.neighbours import Bodies, Lists, new_contacts, new_patches
from dem.dynamics.paths import RATES, motion_of
from dem.dynamics.step import advance
from dem.dynamics.system import System, yields
from dem.dynamics.world import (
    ALPHA,
    CIRCLES,
    COULOMB,
    DRIVE,
    OUTLINES,
    PAIR_CONSTANTS,
    PATCH,
    POLYGONS,
    WALLS,
    WAYPOINT,
    Boundaries,
    Constituents,
    Faces,
    Granules,
    Held,
    World,
    number_of_patches,
)
from dem.laws.protocol import length, slope
from dem.outlines import Polygon
from dem.periodic import wrapped
from dem.scene import ARRAYS, Scene, State
from dem.shapes.ellipse import Ellipse
from dem.shapes.protocol import is_alone


class GranuleTable(NamedTuple):
    """Constants of the granules that the lists and the scans need.

    Attributes
    ----------
    arm : ndarray of shape (n,)
        Bound of the distances (m) of centres of constituents from the centre of the granule.
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
    fraction : float
        Time step over the critical one, without unit.
    pair_constants : ndarray of shape (s + w + k, s, 6)
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
    held : ndarray of shape (constituents,)
        Which are held.
    rolling : tuple of float
        Coefficients of rolling resistance with granules, walls and solids, and the damping ratio;
        zeros without.
    """

    arm: np.ndarray
    radius: np.ndarray
    bounding: np.ndarray
    mass: np.ndarray
    mobility: float
    bend: np.ndarray
    bulk: float
    fraction: float
    pair_constants: np.ndarray
    species: np.ndarray
    solid_radius: np.ndarray
    alpha: float
    modulus: float
    mean_radius: float
    mean_mass: float
    held: np.ndarray
    rolling: tuple[float, float, float, float]


def granule_table(scene: Scene, fraction: float) -> GranuleTable:
    """GranuleTable of a scene; fraction: time step over the critical one."""
    shape, (inverse_mass, inverse_inertia) = scene.shape, mobilities(scene)
    constants, count = pair_constants_of(scene), len(scene.materials)
    bounding, owner, arm = shape.constituent_bounding_radius, shape.owner, np.zeros(scene.granules)
    np.maximum.at(arm, owner, shape.bounding_radius[owner] - bounding)
    solid_radius = np.zeros(len(scene.walls) + len(scene.solids))
    for b, solid in enumerate(scene.solids, len(scene.walls)):
        if not isinstance(solid.outline, Polygon):
            solid_radius[b] = solid.outline.constituent_radius[0]
    return GranuleTable(
        arm=arm,
        radius=np.array(shape.constituent_radius, float),
        bounding=np.array(bounding, float),
        mass=scene.mass[owner],
        mobility=float((inverse_mass + shape.bounding_radius**2 * inverse_inertia).max()),
        bend=scene.law.bulk * shape.normal_bend * inverse_inertia,
        bulk=float(scene.law.bulk),
        fraction=float(fraction),
        pair_constants=constants,
        species=scene.species.copy(),
        solid_radius=solid_radius,
        alpha=float(scene.law.margin * constants[:count, :, ALPHA].max()),
        modulus=max(modulus(scene, material, material) for material in scene.materials),
        mean_radius=float(shape.constituent_radius.mean()),
        mean_mass=float(scene.mass.mean()),
        held=scene.is_held[owner],
        rolling=astuple(scene.rolling) if scene.rolling else (0.0, 0.0, 0.0, 0.0),
    )


def mobilities(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """1/mass and 1/inertia (n,) of all granules in 1/kg and 1/(kg m2): no contact moves a held
    one."""
    inverse_mass, inverse_inertia = 1.0 / scene.mass, 1.0 / scene.inertia
    inverse_mass[scene.is_held] = inverse_inertia[scene.is_held] = 0.0
    return inverse_mass, inverse_inertia


def modulus(scene: Scene, *materials) -> float:
    """Modulus of the law of a scene (Pa or N/m) for the elastic materials that meet."""
    return float(scene.law.modulus(effective_modulus(*materials), scene.thickness))


def pair_constants(scene: Scene, friction: float, material, partner) -> list[float]:
    """Row of GranuleTable.pair_constants for a granule of a material and its partner, None if it is rigid.

    Tangential over normal stiffness is Mindlin's ratio, 4 G*/E*, under every law.
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


def pair_constants_of(scene: Scene) -> np.ndarray:
    """GranuleTable.pair_constants of a scene."""
    materials, friction = scene.materials, scene.friction
    table = np.zeros((len(materials), len(materials))) + (friction.granule if friction else 0.0)
    rows = [
        [pair_constants(scene, float(table[a, b]), one, other) for b, one in enumerate(materials)]
        for a, other in enumerate(materials)
    ]
    for bodies, name in ((scene.walls, "wall"), (scene.solids, "solid")):
        for body in bodies:
            coefficient, partner = body.friction, body.material or scene.boundary
            if coefficient is None:
                coefficient = getattr(friction, name) if friction else 0.0
            rows.append([pair_constants(scene, coefficient, one, partner) for one in materials])
    return np.array(rows).reshape(-1, len(materials), PAIR_CONSTANTS)


def has_friction(constants: np.ndarray) -> bool:
    """Whether any contact has friction. If so, all have it, if need be with a coefficient of zero:
    all lists share the lanes of a block."""
    return bool((constants[..., COULOMB] > 0.0).any())


def can_turn(scene: Scene, constants: np.ndarray) -> bool:
    """Whether a contact or the base plate turns a granule, or a solid that is not round."""
    return bool(
        scene.rolling
        or scene.base_plate
        or not all(solid.is_round for solid in scene.solids)
        or np.any(scene.shape.normal_lever > 0.0)
        or has_friction(constants)
    )


def boundaries(scene: Scene, sections: np.ndarray) -> Boundaries:
    """All that granules meet, in these sections, as they move at the start."""
    walls, solids = len(scene.walls), scene.solids
    motions = [(wall.motion, 0.0) for wall in scene.walls]
    motions += [(solid.velocity, solid.spin) for solid in solids]
    motions += [(group.motion, 0.0) for group in scene.held]
    r, bodies = len(motions), walls + len(solids)
    moved, drive, angle, reach = aligned(r, 8), np.zeros((r, DRIVE)), np.zeros(r), np.zeros(bodies)
    paths = [np.empty((0, WAYPOINT))] * r
    for b, motion in enumerate(motions):
        paths[b], drive[b], moved[b, RATES] = motion_of(*motion)
    for b, solid in enumerate(solids, walls):
        moved[b, [X, Y]], angle[b] = solid.position, solid.angle
        reach[b] = 0.0 if solid.is_round else solid.radius
    return Boundaries(
        planes=scene.planes,
        motion=moved,
        angle=angle,
        reach=reach,
        section=sections,
        reference=np.zeros((bodies, 3)),
        force=aligned(r, 4),
        contact_forces=np.zeros((r, 5)),
        impulses=np.zeros((r, 5)),
        previous_acceleration=np.zeros((r, 3)),
        time=np.zeros(1),
        first_waypoint=np.cumsum([0, *map(len, paths)]),
        waypoints=np.concatenate([np.empty((0, WAYPOINT)), *paths]),
        drive=drive,
    )


def held_groups(scene: Scene, bodies: np.ndarray, motion: np.ndarray) -> Held:
    """The groups of a scene, whose granules take their velocities (of Boundaries.motion) at
    once; motion: where the groups are."""
    first, group = len(motion) - len(scene.held), np.full(scene.granules, -1)
    for b, held in enumerate(scene.held):
        group[held.granules] = first + b
    member = np.flatnonzero(group >= 0)
    bodies[np.ix_(member, [VX, VY])] = motion[np.ix_(group[member], [VX, VY])]
    place = np.ix_(member, [X, Y]), np.ix_(group[member], [X, Y])
    return Held(group, member, bodies[place[0]] - motion[place[1]])


def meeting(outlines, shape):
    """Outlines of solids for the granules' own contact search; one R* a pair if these are discs."""
    if not isinstance(outlines, Ellipse):
        return outlines
    if not isinstance(shape, Ellipse):
        return outlines._replace(hertz_radius=None)
    return outlines._replace(contact=shape.contact, hertz_radius=shape.hertz_radius)


def sections_of(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Section of the list of each wall and solid, and radius (m) of the circle that holds it."""
    sections, sizes = [WALLS] * len(scene.walls), [0.0] * len(scene.walls)
    for solid in scene.solids:
        is_polygon = isinstance(solid.outline, Polygon)
        sections.append(CIRCLES if solid.is_round else POLYGONS if is_polygon else OUTLINES)
        sizes.append(solid.radius)
    return np.array(sections, np.int64), np.array(sizes, float)


def faces_of(scene: Scene) -> Faces:
    """Faces of the polygons of a scene, and what else contacts aim at."""
    none, outlines = np.empty((0, 5)), [None] * len(scene.walls)
    outlines += [solid.outline for solid in scene.solids]
    alone = [(none, 0.0, False)]
    chains = [line.chains if isinstance(line, Polygon) else alone for line in outlines]
    count = np.array([len(rows) for rows in chains], np.int64)
    every = [chain for rows in chains for chain in rows]
    rows = [none, *(row for row, _, _ in every)]
    return Faces(
        boundary=np.repeat(np.arange(len(count)), count),
        first=np.cumsum([len(row) for row in rows]),
        row=np.concatenate(rows),
        radius=np.array([radius for _, radius, _ in every], float),
        has_ends=np.array([ends for _, _, ends in every], bool),
    )


def outlines_of(scene: Scene, sections: np.ndarray, faces: Faces):
    """The granules, and solids with the outline of a granule; the numbers of outlines of both: of
    constituents, then of boundaries (c + r, s), of granules then of the corners of targets too."""
    shape, walls = scene.shape, len(scene.walls)
    r = walls + len(scene.solids) + len(scene.held)
    like = [
        solid.outline
        for s, solid in zip(sections[walls:], scene.solids, strict=True)
        if s == OUTLINES
    ]
    solids = meeting(like[0].appended(*like[1:]), shape) if like else shape
    of_granules = np.zeros((len(shape.owner) + r + len(faces.radius), shape.outlines.shape[1]))
    of_solids = np.zeros((len(shape.owner) + r, solids.outlines.shape[1]))
    of_granules[: len(shape.owner)] = shape.outlines
    bodies = of_granules[len(shape.owner) :]
    for b, solid in enumerate(scene.solids, walls):
        if sections[b] == CIRCLES:
            bodies[b] = shape.circle_outline(solid.radius)
    for t in np.flatnonzero(faces.radius):
        bodies[r + t] = shape.circle_outline(faces.radius[t])
    if like:
        own = type(solids) is type(shape)
        rows = shape.outlines if own else map(solids.circle_outline, shape.constituent_radius)
        of_solids[: len(shape.owner)] = [*rows]
        of_solids[len(shape.owner) + np.flatnonzero(sections == OUTLINES)] = solids.outlines
    return solids, of_granules, of_solids


def flags_of(scene: Scene, table: GranuleTable, moving: Boundaries, sections, solids) -> dict:
    """What a scene has: see dem.dynamics.kinds."""
    shape, rolls, rough = scene.shape, scene.rolling is not None, has_friction(table.pair_constants)
    damps = rolls or bool(table.pair_constants[..., ALPHA].any())
    others = bool((sections == OUTLINES).any()), bool((sections == POLYGONS).any())
    return {
        "FRICTION": rolls or rough,
        "DAMPING": damps,
        "TURNS": can_turn(scene, table.pair_constants) or shape.needs_angle,
        "ROTATES": shape.needs_angle,
        "LEVERS": shape.oriented or any(others),
        "ORIENTED": shape.oriented,
        "COMPOSED": not is_alone(shape),
        "GUESSES": bool(shape.guesses or (others[0] and solids.guesses)),
        "ROLLING": rolls,
        "LOCAL": bool(shape.local_radius),
        "LONG": length(scene.law, 1.0, 1.0, 1.0, 1.0) != 0.0,
        "PERIODIC": any(scene.periodic or ()),
        "YIELDS": damps and yields(moving),
        "WITH_OUTLINES": others[0],
        "WITH_POLYGONS": others[1],
    }


def assemble(
    whole: Scene,
    state: State,
    order: np.ndarray,
    fraction: float = 1.0,
    ledger: bool = False,
    work=advance,
    moving: Boundaries | None = None,
) -> System:
    """The arrays of those granules of a scene that are there, in an order of their numbers, the
    kernels of the scene and what makes its lists; no list is made yet.

    fraction: time step over the critical one; work: see System; moving: boundaries as they are now,
    those of the start if there are none.
    """
    scene, state = ordered(whole, state, order)
    table, faces = granule_table(scene, fraction), faces_of(scene)
    n, c = scene.granules, len(table.radius)
    sections, sizes = sections_of(scene)
    moving = moving or boundaries(scene, sections)
    inverse_mass, inverse_inertia = mobilities(scene)
    solids, of_granules, of_solids = outlines_of(scene, sections, faces)
    flags = flags_of(whole, table, moving, sections, solids)
    flags |= {"FULL": flags["DAMPING"] and not flags["TURNS"], "LEDGER": ledger}
    layout = layout_of(flags, of_granules.shape[1], of_solids.shape[1])
    r, alone = len(moving.motion), is_alone(scene.shape)
    motion, force = aligned(c + r, 8), aligned(c + r, 4)
    bodies, pushed = (motion, force) if alone else (aligned(n, 8), aligned(n, 4))
    bodies[:n, [X, Y]], bodies[:n, [VX, VY]] = state.position, state.velocity
    bodies[:n, W] = state.angular_velocity
    turned = np.concatenate([state.angle, moving.angle])
    owner = np.ascontiguousarray(scene.shape.owner, np.int64)
    patches, places = number_of_patches(n), np.vstack([state.position, moving.motion[:, [X, Y]]])
    x, y = scene.periodic or (None, None)
    listed = Bodies(
        radius=table.bounding,
        held=table.held,
        largest=float(table.bounding.max()),
        sizes=sizes[faces.boundary],
        outlines=of_granules,
        others=of_solids,
        period=(x or 0.0, y or 0.0),
        layout=layout,
        rotates=flags["ROTATES"],
        composed=flags["COMPOSED"],
        alike=len(scene.materials) == 1,
    )
    world = World(
        shape=scene.shape,
        outlines=solids,
        # values that are None would be another type: these follow from `pair_constants`
        law=scene.law._replace(**{k: 0.0 for k, v in scene.law._asdict().items() if v is None}),
        granules=Granules(
            motion=bodies,
            angle=state.angle,
            inverse_mass=inverse_mass,
            # zeros let round ellipses keep their angles
            inverse_inertia=inverse_inertia * can_turn(whole, table.pair_constants),
            force=pushed,
            previous_acceleration=aligned(n, 4),
        ),
        constituents=Constituents(
            motion=motion,
            orientation=np.column_stack([np.cos(turned), np.sin(turned), *np.zeros((2, n + r))]),
            force=force,
            reference=np.zeros((c, 2)),
            first=np.searchsorted(owner, np.arange(n + 1)),
            owner=owner,
            place=np.zeros((c, 2)) if alone else np.ascontiguousarray(scene.shape.places),
        ),
        contacts=new_contacts(0, listed, patches),
        boundaries=moving,
        faces=faces,
        held=held_groups(scene, bodies[:n], moving.motion),
        base=base_of(scene, places, turned),
        patches=new_patches(0, patches),
        gravity=np.array(scene.acceleration, float),
        account=np.zeros(ACCOUNT),
    )
    return System(world, table, flags, Lists(listed), work)


# Order in memory: Morton's (1966), the bits of two cell numbers interleaved, so that a patch
# (dem.dynamics.world) is compact, and has few neighbours in others


def _spread(number):
    """A zero between any two bits of numbers below 2^32."""
    bit, one, two = np.arange(32, dtype=np.uint64), np.uint64(1), np.uint64(2)
    bits = number.astype(np.uint64)[:, None] >> bit & one
    return (bits << two * bit).sum(axis=1)


def order_of(scene: Scene, state: State) -> np.ndarray:
    """Granules (n,) that are present, in the order of memory: the user's order for a bed of one
    patch."""
    present = state.present
    if len(present) <= PATCH:
        return present
    cell = 2.0 * scene.shape.bounding_radius.mean()
    position = wrapped(state.position[present], scene.periodic)
    cells = np.minimum((position - position.min(axis=0)) / cell, 2.0**31)
    rank = _spread(cells[:, 0]) | _spread(cells[:, 1]) << np.uint64(1)
    return present[np.argsort(rank, kind="stable")]


def ordered(scene: Scene, state: State, order) -> tuple[Scene, State]:
    """The same scene and state with granules in the order of memory, but for those not there."""
    if np.array_equal(order, np.arange(scene.granules)):
        return scene, state
    return scene.taken(order), State(*(getattr(state, name)[order] for name in ARRAYS))


def state_of(world: World, order: np.ndarray, granules: int) -> State:
    """The state of all granules of a scene, from those that are there, NaN of the others."""
    state, bodies = State(np.full((granules, 2), np.nan)), world.bodies
    rows = bodies[:, [X, Y]], bodies[:, [VX, VY]], world.granules.angle, bodies[:, W]
    for name, values in zip(ARRAYS, rows, strict=True):
        getattr(state, name)[order] = values
    return state
