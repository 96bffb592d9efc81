"""The scan of a bed between steps: energy, contacts, greatest overlap, critical time step."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import last_normal, shifted
from dem.contacts.response import dashpot_constant, measure_of, stiffness_of
from dem.dynamics.boundaries import boundary_weight, driven_acceleration, fastest
from dem.dynamics.contact_list import deeper, geometries
from dem.dynamics.critical_step import (
    COLUMNS,
    Bounds,
    add_contact,
    add_force_stiffness,
    shortest,
    stable_step,
    weight,
)
from dem.dynamics.energy import kinetic
from dem.dynamics.forces import clear, greater
from dem.dynamics.world import DAMPING_RATIO, INVERSE_MASS, STIFFNESS_RATIO
from dem.jit.address import by_address, local
from dem.jit.columns import FX, FY, TAU, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, optional, times
from dem.laws.protocol import impact_overlap, length, measure, root, slope, stiffest
from dem.shapes.protocol import collect, first_of, outline, owner_of, solve_contact


class Diagnostics(NamedTuple):
    """The bed at one moment, as `Simulation.diagnose` returns it.

    Attributes
    ----------
    kinetic_energy : float
        Kinetic energy (J) of all granules that are not held.
    speed_bound : float
        Bound on the speed (m/s) of any granule until the next neighbour list.
    coordination_number : float
        Contacts with other granules per granule, without unit.
    max_overlap : float
        Largest overlap over the smaller radius, without unit.
    deepest : int
        Number of the granule with that overlap, without unit.
    critical_time_step : float
        Lower bound on the critical time step (s).
    longest_time_step : float
        The time step (s) of which `step_fraction` is that fraction; in steps of an eighth root of
        two it is taken.
    """

    kinetic_energy: float
    speed_bound: float
    coordination_number: float
    max_overlap: float
    deepest: int
    critical_time_step: float
    longest_time_step: float


@inlined
def moment_arms(granules, constituents, g, i, normal, point):
    """Moment arms (m) of the normal and of the tangential force about the centre of granule g.

    The contact is at point[0] n + point[1] t from the centre of constituent i.
    """
    nx, ny = normal
    x = constituents[i, X] - granules[g, X] + point[0] * nx - point[1] * ny
    y = constituents[i, Y] - granules[g, Y] + point[0] * ny + point[1] * nx
    return x * ny - y * nx, x * nx + y * ny


@inlined
def body_of(world, table, g, arms):
    """Row of Bounds for granule g, and `weight` for both arms: those of its group where it is
    held."""
    held = world.held
    if held is not None:
        b = held.group[g]
        if b >= 0:
            size = boundary_weight(world.boundaries, b, 0.0)
            return held.group.shape[0] + b, size, size
    return g, weight(table, g, arms[0]), weight(table, g, arms[1])


@compiled
def scan_pairs(world, table, bounds, begin, end, spare):
    """Fill the rows of Bounds of granules begin to end with what their pairs do.

    The share of another granule goes to row `spare`, which nobody reads: the thread that scans that
    granule adds it to its row. Sums have one order, however granules are shared out. Returns how
    many pairs touch, and the greatest relative overlap with its constituent, of the pairs that
    begin with these granules.
    """
    view = by_address(world)
    shape, motion, orientation = view.shape, view.constituents, view.orientation
    granules, contacts, table = view.bodies, local(view.pairs), local(table)
    rows, least, radius = bounds.rows, bounds.least, table.radius
    touching, worst = 0, (0.0, 0)
    clear(rows, begin, end)
    low, high = first_of(shape, begin), first_of(shape, end)
    for i in range(high):
        one = outline(shape, i, orientation)
        for p in range(contacts.first[i], contacts.first[i + 1]):
            j = np.int64(contacts.partner[p])
            if i < low and not low <= j < high:
                continue
            # Geometry and overlap
            dx, dy = motion[j, X] - motion[i, X], motion[j, Y] - motion[i, Y]
            dx, dy = shifted(contacts, p, dx, dy)
            guess = last_normal(contacts, p)
            geometry = solve_contact(shape, dx, dy, one, outline(shape, j, orientation), guess)
            overlap, nx, ny, n1, t1, n2, t2, rho = geometry
            if i >= low and not overlap <= 0.0:
                touching += 1
                worst = deeper(worst, overlap, i, min(radius[i], radius[j]))
            # Stiffness and damping, from the surfaces of both bodies, not the middle of a gap
            law, held, constant = contacts.law, max(overlap, least), stiffness_of(contacts, p, rho)
            measured, g, h = measure_of(contacts, p, held), owner_of(shape, i), owner_of(shape, j)
            apart = 0.5 * min(overlap, 0.0)
            point_1, point_2 = (n1 + apart, either(t1, 0.0)), (-n2 - apart, either(t2, 0.0))
            arms_1 = moment_arms(granules, motion, g, i, (nx, ny), point_1)
            arms_2 = moment_arms(granules, motion, h, j, (nx, ny), point_2)
            damping = times(
                dashpot_constant(contacts.damping, contacts.mass_ratio, p, nx, ny),
                root(law, held, measured),
            )
            spring = constant, measured, damping
            body_1, body_2 = body_of(view, table, g, arms_1), body_of(view, table, h, arms_2)
            pair = body_1[0] if i >= low else spare, body_2[0] if j < high else spare
            along, across = (body_1[1], body_2[1]), (body_1[2], body_2[2])
            friction = friction_of(contacts.friction, p)
            k = add_contact(law, rows, pair, friction, spring, (nx, ny), along, across)
            add_force_stiffness(rows, pair[0], k, overlap, table.bend[g])
            add_force_stiffness(rows, pair[1], k, overlap, table.bend[h])
    return touching, worst


@optional
def friction_of(friction, p):
    """Tangential over normal stiffness and damping of contact p, without unit."""
    return friction[STIFFNESS_RATIO, p], friction[DAMPING_RATIO, p]


@inlined
def scan_surface(surface, world, table, bounds, worst):
    """Add what all contacts with walls, or with solids, do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent; worst: that so far.
    """
    if surface is None:
        return worst
    return scan_contacts(surface, world, table, bounds, worst)


@compiled(allocates=True)
def scan_contacts(surface, world, table, bounds, worst):
    """`scan_surface` of a surface that the scene has."""
    boundaries, rows = world.boundaries, bounds.rows
    granules, motion = world.bodies, world.constituents
    moving, frames = boundaries.motion, boundaries.orientation
    contact = geometries(world.shape, motion, world.orientation, moving, frames, surface)
    contacts, constants = local(surface.contacts), local(table)
    for p in range(contacts.constituent.shape[0]):
        i, b = np.int64(contacts.constituent[p]), np.int64(contacts.partner[p])
        g = owner_of(world.shape, i)
        overlap, nx, ny = contact[p, 0], contact[p, 1], contact[p, 2]
        n1, t1, constant = contact[p, 3], contact[p, 4], contact[p, 5]
        if not overlap <= 0.0:
            worst = deeper(worst, overlap, i, constants.radius[i])
        law, held = contacts.law, max(overlap, bounds.least)
        measured = measure_of(contacts, p, held)
        n1 += 0.5 * min(overlap, 0.0)
        arms = moment_arms(granules, motion, g, i, (nx, ny), (n1, t1))
        damping = times(
            dashpot_constant(contacts.damping, contacts.mass_ratio, p, nx, ny),
            root(law, held, measured),
        )
        spring = constant, measured, damping
        row, along, across = body_of(world, constants, g, arms)
        pair, far = (row, granules.shape[0] + b), (0.0, 0.0)
        if surface.planes is None:
            dx, dy = shifted(contacts, p, moving[b, X] - motion[i, X], moving[b, Y] - motion[i, Y])
            x, y = n1 * nx - t1 * ny - dx, n1 * ny + t1 * nx - dy
            far = x * ny - y * nx, x * nx + y * ny
        along = along, boundary_weight(boundaries, b, far[0])
        across = across, boundary_weight(boundaries, b, far[1])
        friction = friction_of(contacts.friction, p)
        k = add_contact(law, rows, pair, friction, spring, (nx, ny), along, across)
        add_force_stiffness(rows, g, k, overlap, constants.bend[g])
        if boundaries.reach[b] > 0.0:  # a flat side has no curvature: its size bounds the arm
            bend = constants.bulk * boundaries.reach[b] * boundaries.drive[b, INVERSE_MASS + 2]
            add_force_stiffness(rows, pair[1], k, overlap, bend)
    return worst


@compiled
def greatest_acceleration(force, inverse_mass, inverse_inertia, table):
    """Of any constituent (m/s2), from the forces on its granule; gravity not counted."""
    greatest = 0.0
    for i in range(inverse_mass.shape[0]):
        acceleration = math.sqrt(force[i, FX] ** 2 + force[i, FY] ** 2) * inverse_mass[i]
        if inverse_inertia is not None:
            acceleration += abs(force[i, TAU]) * inverse_inertia[i] * table.arm[i]
        greatest = greater(greatest, acceleration)
    return greatest


@inlined
def expected_speed(world, skin, speed_bound):
    """Greatest speed (m/s) before the lists are rebuilt: of granules, boundaries that may be
    driven, and a fall."""
    squared, gravity = greater(fastest(world.boundaries), speed_bound * speed_bound), world.gravity
    squared += 2.0 * skin * driven_acceleration(world.boundaries)
    squared += 2.0 * skin * math.sqrt(gravity[0] ** 2 + gravity[1] ** 2)
    return math.sqrt(squared)


@inlined
def step_alone(table, least, fraction):
    """Time step (s) for a granule that collides with one of its own size, up to an overlap (m)."""
    law, r = table.law, table.radius[0]
    stiffness = 2.0 * stiffest(law, table.modulus, table.radius, least) * table.mobility
    measured = measure(law, least, length(law, 1.0, r, r, r))
    ratio = 0.5 * table.alpha * root(law, least, measured) / math.sqrt(slope(law, 1.0, measured))
    damping = 2.0 * ratio * math.sqrt(2.0 * stiffness)
    return stable_step(stiffness, damping, fraction)


@inlined
def empty_bounds(world, least, spare):
    """Bounds with a number of spare rows at the end. Only the rows after those of granules are
    zero: scan_pairs clears the others, each thread its own, which is then near its memory."""
    granules = world.bodies.shape[0]
    rows = np.empty((granules + world.boundaries.motion.shape[0] + spare, COLUMNS))
    clear(rows, granules, rows.shape[0])
    return Bounds(rows=rows, least=least)


@inlined
def scan_boundaries(world, table, bounds, worst):
    """Add what contacts with boundaries do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent, and the bounds on the time step (s).
    """
    worst = scan_surface(world.walls, world, table, bounds, worst)
    worst = scan_surface(world.circles, world, table, bounds, worst)
    worst = scan_surface(world.outlines, world, table, bounds, worst)
    worst = scan_surface(world.polygons, world, table, bounds, worst)
    bodies = world.bodies.shape[0] + world.boundaries.motion.shape[0]
    return worst, shortest(bounds.rows, bodies, table.fraction)


@compiled(allocates=True)
def critical_step(world, table, least):
    """Critical time step (s) of the contacts; least (m): smallest overlap of a listed pair in
    it."""
    view, constants = by_address(world), by_address(table)
    bounds = empty_bounds(view, least, 0)
    _, worst = scan_pairs(view, constants, bounds, 0, view.bodies.shape[0], 0)
    return scan_boundaries(view, constants, bounds, worst)[1][0]


@compiled(allocates=True)
def begin_scan(world, table, later, frame, spare):
    """Kinetic energy (J), expected speed (m/s) and empty Bounds, with a number of spare rows."""
    view, constants = by_address(world), by_address(table)
    granules = view.bodies.shape[0]
    collect(view.shape, view.constituent_force, view.orientation, view.force, 0, granules)
    energy, speed_bound = kinetic(view, later, frame)
    speed = expected_speed(view, constants.skin, speed_bound)
    radius, mass = 0.5 * constants.mean_radius, 0.5 * constants.mean_mass
    least = impact_overlap(constants.law, constants.modulus, radius, mass, speed)
    least = max(least, 1e-8 * radius)
    return energy, speed, empty_bounds(view, least, spare)


@compiled(allocates=True)
def end_scan(world, table, begun, pairs):
    """Diagnostics from what begin_scan and scan_pairs have returned."""
    view, constants = by_address(world), by_address(table)
    energy, speed, bounds = begun
    touching, worst = pairs
    (overlap, deepest), steps = scan_boundaries(view, constants, bounds, worst)
    granules, (critical, chosen) = view.bodies.shape[0], steps
    push = greatest_acceleration(view.force, view.inverse_mass, view.inverse_inertia, constants)
    push = greater(driven_acceleration(view.boundaries), push)
    return Diagnostics(
        kinetic_energy=energy,
        speed_bound=math.sqrt(speed * speed + 2.0 * constants.skin * push),
        coordination_number=2.0 * touching / granules,
        max_overlap=overlap,
        deepest=owner_of(view.shape, deepest),
        critical_time_step=min(critical, step_alone(constants, bounds.least, 1.0)),
        longest_time_step=min(chosen, step_alone(constants, bounds.least, constants.fraction)),
    )


@compiled(allocates=True)
def diagnose(world, table, later, frame):
    """Diagnostics of the bed and its time step; later, frame: as for `kinetic`.

    Stiffness and damping of all contacts give a lower bound on the critical step. Pairs that are
    near but do not touch count with the overlap of a collision at the greatest expected speed, and
    any granule could collide with one of its own size.
    """
    view, constants = by_address(world), by_address(table)
    begun = begin_scan(view, constants, later, frame, 0)
    pairs = scan_pairs(view, constants, begun[2], 0, view.bodies.shape[0], 0)
    return end_scan(view, constants, begun, pairs)
