"""The bed at one moment, between steps: energy, contacts, greatest overlap, critical time step."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import imaged, remembered
from dem.contacts.force_law import damping_ratio, impact_overlap
from dem.contacts.response import local_stiffness
from dem.dynamics.forces import clear, greater
from dem.dynamics.guide import count_guided, driven_acceleration, fastest, lightness
from dem.dynamics.stable_step import (
    COLUMNS,
    Bounds,
    add_force_stiffness,
    add_pair_stiffness,
    add_pair_tangent,
    add_wall_stiffness,
    add_wall_tangent,
    critical_step,
    normal_damping,
    shortest,
    weight,
)
from dem.jit.address import by_address, local
from dem.jit.columns import FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, optional, plus, unless
from dem.shapes.protocol import circle, outline, solve_contact, support


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
    """

    kinetic_energy: float
    speed_bound: float
    coordination_number: float
    max_overlap: float
    deepest: int
    critical_time_step: float


@optional
def spin_energy(inverse_inertia, i, spin):
    return 0.5 * spin * spin / inverse_inertia[i]


@compiled
def kinetic(bodies, inverse_mass, inverse_inertia):
    """Kinetic energy (J) of the granules that are free, and greatest speed (m/s) of all; NaN wins."""
    energy, speed_bound = 0.0, 0.0
    for i in range(bodies.shape[0]):
        squared = bodies[i, VX] ** 2 + bodies[i, VY] ** 2
        if inverse_mass[i] > 0.0:
            energy += 0.5 * squared / inverse_mass[i]
            energy = plus(energy, spin_energy(inverse_inertia, i, bodies[i, W]))
        speed_bound = greater(speed_bound, squared)
    return energy, math.sqrt(speed_bound)


@inlined
def deeper(worst, overlap, i, size):
    """Greater of two relative overlaps, each with the granule it belongs to; NaN wins."""
    relative = overlap / size
    if relative <= worst[0] or worst[0] != worst[0]:
        return worst
    return relative, i


@inlined
def levers(granules, constituents, g, i, normal, point):
    """Levers (m) of the normal and of the tangential force about the centre of granule g.

    The contact is at point[0] n + point[1] t from the centre of constituent i.
    """
    nx, ny = normal
    x = constituents[i, X] - granules[g, X] + point[0] * nx - point[1] * ny
    y = constituents[i, Y] - granules[g, Y] + point[0] * ny + point[1] * nx
    return x * ny - y * nx, x * nx + y * ny


@optional
def row_of_member(held, i):
    b = held.group[i]
    return i if b < 0 else held.group.shape[0] + b


@inlined
def row_of(held, i):
    """Row of Bounds for granule i: that of its group where it is held."""
    return either(row_of_member(held, i), i)


@optional
def weight_of_member(held, table, i, lever):
    b = held.group[i]
    if b < 0:
        return weight(table, i, lever)
    return lightness(held.guide, b)


@inlined
def weight_of(held, table, i, lever):
    """As `weight`; that of its group where granule i is held."""
    return either(weight_of_member(held, table, i, lever), weight(table, i, lever))


@compiled
def survey_pairs(world, table, bounds, begin, end, spare):
    """Fill the rows of Bounds of granules begin to end with what their pairs do.

    The share of another granule goes to row `spare`, which nobody reads: who surveys that granule adds
    it to its row. Sums have one order, however granules are shared out. Returns how many pairs touch,
    and the greatest relative overlap with its constituent, of the pairs that begin with these granules.
    """
    world = by_address(world)
    shape, motion, frame = world.shape, world.constituents, world.frame
    granules, held, contacts, table = world.bodies, world.held, local(world.pairs), local(table)
    rows, least, radius = bounds.rows, bounds.least, table.radius
    touching, worst = 0, (0.0, 0)
    clear(rows, begin, end)
    low, high = table.per * begin, table.per * end
    for i in range(high):
        own = outline(shape, i, frame)
        for p in range(contacts.first[i], contacts.first[i + 1]):
            j = np.int64(contacts.partner[p])
            if i < low and not low <= j < high:
                continue
            dx, dy = motion[j, X] - motion[i, X], motion[j, Y] - motion[i, Y]
            dx, dy = imaged(contacts, p, dx, dy)
            guess = remembered(contacts.normal_x, contacts.normal_y, p)
            geometry = solve_contact(shape, dx, dy, own, outline(shape, j, frame), guess)
            overlap, nx, ny, n1, t1, n2, t2, rho = geometry
            if i >= low and not overlap <= 0.0:
                touching += 1
                worst = deeper(worst, overlap, i, min(radius[i], radius[j]))
            stiffness = either(local_stiffness(rho, contacts.modulus), contacts.stiffness[p])
            sqrt_overlap, g, h = math.sqrt(max(overlap, least)), i // table.per, j // table.per
            apart = 0.5 * min(overlap, 0.0)  # the surfaces, not the middle of a gap
            mine = levers(granules, motion, g, i, (nx, ny), (n1 + apart, either(t1, 0.0)))
            theirs = levers(granules, motion, h, j, (nx, ny), (-n2 - apart, either(t2, 0.0)))
            damping = normal_damping(contacts.damping, p, sqrt_overlap)
            k = 1.5 * stiffness * sqrt_overlap
            first, second = g if i >= low else spare, h if j < high else spare
            pair = row_of(held, first), row_of(held, second)
            one = weight_of(held, table, g, mine[0])
            two = weight_of(held, table, h, theirs[0])
            add_pair_stiffness(rows, pair, k, damping, (nx, ny), (one, two))
            one = weight_of(held, table, g, mine[1])
            two = weight_of(held, table, h, theirs[1])
            spring = stiffness, sqrt_overlap, damping
            add_pair_tangent(contacts.friction, rows, pair, spring, (-ny, nx), (one, two))
            add_force_stiffness(rows, first, k, overlap, table.bend[g])
            add_force_stiffness(rows, second, k, overlap, table.bend[h])
    return touching, worst


@optional
def add_guided_stiffness(guide, wall, friction, rows, pair, k, spring, normal, weights):
    """Stiffness k (N/m) along the normal, and the tangential one, of a granule and a boundary.

    pair: rows of both; spring: as of add_pair_tangent; weights: of the granule, for both directions.
    """
    nx, ny = normal
    other = lightness(guide, wall)
    add_pair_stiffness(rows, pair, k, spring[2], normal, (weights[0], other))
    add_pair_tangent(friction, rows, pair, spring, (-ny, nx), (weights[1], other))


@compiled
def survey_boundary(boundary, geometries, world, table, bounds, worst, first):
    """Add what all contacts with walls, or with the cylinder, do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent. geometries (m, 6): from one of the
    functions below; worst: the greatest relative overlap so far, with its constituent; first: row of Bounds of the
    first of these boundaries, if they are guided.
    """
    world = by_address(world)
    contacts, table, held = local(boundary.contacts), local(table), world.held
    granules, motion, rows = world.bodies, world.constituents, bounds.rows
    for p in range(contacts.constituent.shape[0]):
        i = np.int64(contacts.constituent[p])
        g = i // table.per
        overlap, nx, ny = geometries[p, 0], geometries[p, 1], geometries[p, 2]
        n1, t1, stiffness = geometries[p, 3], geometries[p, 4], geometries[p, 5]
        if not overlap <= 0.0:
            worst = deeper(worst, overlap, i, table.radius[i])
        sqrt_overlap = math.sqrt(max(overlap, bounds.least))
        n1 += 0.5 * min(overlap, 0.0)
        normal, tangential = levers(granules, motion, g, i, (nx, ny), (n1, t1))
        damping = normal_damping(contacts.damping, p, sqrt_overlap)
        k = 1.5 * stiffness * sqrt_overlap
        row, spring = row_of(held, g), (stiffness, sqrt_overlap, damping)
        along = weight_of(held, table, g, normal)
        across = weight_of(held, table, g, tangential)
        still = unless(boundary.guide, rows)
        add_wall_stiffness(still, row, k, damping, (nx, ny), along)
        add_wall_tangent(contacts.friction, still, row, spring, (-ny, nx), across)
        wall = np.int64(contacts.partner[p])
        add_guided_stiffness(
            boundary.guide, wall, contacts.friction, rows, (row, first + wall), k, spring, (nx, ny),
            (along, across),
        )  # fmt: skip
        add_force_stiffness(rows, g, k, overlap, table.bend[g])
    return worst


@inlined
def put_row(found, p, overlap, normal, point, stiffness):
    """One row of the geometries below; number by number, because a row brings in the text of its error message."""
    found[p, 0], found[p, 1], found[p, 2] = overlap, normal[0], normal[1]
    found[p, 3], found[p, 4], found[p, 5] = point[0], point[1], stiffness


@compiled(allocates=True)
def pair_geometries(shape, motion, frame, contacts):
    """Rows (m, 6), one per listed pair, seen from its first constituent; see wall_geometries."""
    found = np.empty((contacts.constituent.shape[0], 6))
    for p in range(found.shape[0]):
        i, j = contacts.constituent[p], contacts.partner[p]
        dx, dy = motion[j, X] - motion[i, X], motion[j, Y] - motion[i, Y]
        dx, dy = imaged(contacts, p, dx, dy)
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        own, other = outline(shape, i, frame), outline(shape, j, frame)
        one = solve_contact(shape, dx, dy, own, other, guess)
        stiffness = either(local_stiffness(one.radius, contacts.modulus), contacts.stiffness[p])
        put_row(found, p, one.overlap, (one.nx, one.ny), (one.n1, either(one.t1, 0.0)), stiffness)
    return found


@compiled(allocates=True)
def wall_geometries(shape, motion, frame, walls):
    """Rows (m, 6), one per listed contact with a wall.

    Overlap (m; negative: a gap), normal, levers n1 and t1 (m), and stiffness (N m^-1.5).
    """
    contacts = walls.contacts
    found = np.empty((contacts.constituent.shape[0], 6))
    for p in range(found.shape[0]):
        i, k = contacts.constituent[p], contacts.partner[p]
        nx, ny = walls.planes[k, 0], walls.planes[k, 1]
        reach, t1, rho = support(shape, outline(shape, i, frame), nx, ny)
        overlap = reach + motion[i, X] * nx + motion[i, Y] * ny - walls.planes[k, 2]
        stiffness = either(local_stiffness(rho, contacts.modulus), contacts.stiffness[p])
        point = reach - 0.5 * overlap, either(t1, 0.0)
        put_row(found, p, overlap, (nx, ny), point, stiffness)
    return found


@compiled(allocates=True)
def cylinder_geometries(shape, motion, frame, cylinder):
    """The same of the contacts with the cylinder."""
    contacts = cylinder.contacts
    found = np.empty((contacts.constituent.shape[0], 6))
    other = circle(shape, cylinder.radius)
    for p in range(found.shape[0]):
        i = contacts.constituent[p]
        dx, dy = cylinder.motion[0, X] - motion[i, X], cylinder.motion[0, Y] - motion[i, Y]
        dx, dy = imaged(contacts, p, dx, dy)
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        one = solve_contact(shape, dx, dy, outline(shape, i, frame), other, guess)
        stiffness = either(local_stiffness(one.radius, contacts.modulus), contacts.stiffness[p])
        put_row(found, p, one.overlap, (one.nx, one.ny), (one.n1, either(one.t1, 0.0)), stiffness)
    return found


@optional
def guided(boundary):
    """Number of guided boundaries, None if there is none."""
    return count_guided(boundary.guide)


@optional
def survey_walls(walls, world, table, bounds, worst, first):
    found = wall_geometries(world.shape, world.constituents, world.frame, walls)
    return survey_boundary(walls, found, world, table, bounds, worst, first)


@optional
def survey_cylinder(cylinder, world, table, bounds, worst, first):
    found = cylinder_geometries(world.shape, world.constituents, world.frame, cylinder)
    return survey_boundary(cylinder, found, world, table, bounds, worst, first)


@inlined
def first_rows(world):
    """Of the rows of Bounds: the first of the walls, that of the cylinder, and how many there are."""
    walls = world.bodies.shape[0] + either(guided(world.held), 0)
    cylinder = walls + either(guided(world.walls), 0)
    return walls, cylinder, cylinder + either(guided(world.cylinder), 0)


@inlined
def empty_bounds(world, least, spare):
    """Bounds with a number of spare rows at the end. Only the rows after those of granules are zero:
    survey_pairs clears the others, each thread its own, which is then near its memory."""
    rows = np.empty((first_rows(world)[2] + spare, COLUMNS))
    clear(rows, world.bodies.shape[0], rows.shape[0])
    return Bounds(rows, least)


@inlined
def survey_boundaries(world, table, bounds, worst):
    """Add what contacts with walls and cylinder do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent, and the bound on the critical step (s).
    """
    first_wall, first_cylinder, count = first_rows(world)
    worst = either(survey_walls(world.walls, world, table, bounds, worst, first_wall), worst)
    worst = either(
        survey_cylinder(world.cylinder, world, table, bounds, worst, first_cylinder), worst
    )
    return worst, shortest(bounds.rows, count)


@compiled(allocates=True)
def survey(world, table, least):
    """All contacts of the bed.

    table: dem.dynamics.assembly.GranuleTable; least (m): smallest overlap that the stiffness of a
    listed pair is computed for. Returns the number of touching pairs of constituents, the
    greatest overlap over the smaller radius with the constituent it belongs to, and the bound on
    the critical time step (s).
    """
    world, table = by_address(world), by_address(table)
    bounds = empty_bounds(world, least, 0)
    touching, worst = survey_pairs(world, table, bounds, 0, world.bodies.shape[0], 0)
    worst, step = survey_boundaries(world, table, bounds, worst)
    return touching, worst[0], worst[1], step


@optional
def fall_squared(gravity, distance):
    """Square of the speed (m/s) that a fall over a distance (m) adds."""
    return 2.0 * distance * math.sqrt(gravity[0] ** 2 + gravity[1] ** 2)


@optional
def swing(inverse_inertia, i, torque, lever):
    return abs(torque) * inverse_inertia[i] * lever


@compiled
def greatest_acceleration(force, inverse_mass, inverse_inertia, table):
    """Of any constituent (m/s2), from the forces on its granule; gravity not counted."""
    greatest = 0.0
    for i in range(inverse_mass.shape[0]):
        push = math.sqrt(force[i, FX] ** 2 + force[i, FY] ** 2) * inverse_mass[i]
        lever = table.radius[i * table.per] if table.per > 1 else 0.0
        greatest = greater(greatest, plus(push, swing(inverse_inertia, i, force[i, TAU], lever)))
    return greatest


@optional
def speed_squared(cylinder):
    now = cylinder.motion[0, VX] ** 2 + cylinder.motion[0, VY] ** 2
    return either(fastest(cylinder.guide, cylinder.motion), now)


@optional
def guided_speed_squared(boundary):
    """Of walls or held groups; None if they are at rest."""
    return fastest(boundary.guide, boundary.motion)


@inlined
def expected_speed(world, skin, speed_bound):
    """Greatest speed (m/s) before the lists are rebuilt: of granules, boundaries, and a fall."""
    squared = max(speed_bound * speed_bound, either(speed_squared(world.cylinder), 0.0))
    squared = either(faster(guided_speed_squared(world.walls), squared), squared)
    squared = either(faster(guided_speed_squared(world.held), squared), squared)
    return math.sqrt(plus(squared, fall_squared(world.gravity, skin)))


@optional
def faster(more, than):
    return greater(more, than)


@optional
def push_on(boundary):
    """Greatest acceleration (m/s2) of walls, cylinder or held groups; None if nothing drives them."""
    return driven_acceleration(boundary.guide)


@compiled(allocates=True)
def begin_survey(world, table, spare):
    """Kinetic energy (J), expected speed (m/s) and empty Bounds, with a number of spare rows."""
    world, table = by_address(world), by_address(table)
    energy, speed_bound = kinetic(world.bodies, world.inverse_mass, world.inverse_inertia)
    speed = expected_speed(world, table.skin, speed_bound)
    radius, mass = 0.5 * table.mean_radius, 0.5 * table.mean_mass
    least = max(impact_overlap(mass, radius, table.modulus, speed), 1e-8 * radius)
    return energy, speed, empty_bounds(world, least, spare)


@compiled(allocates=True)
def end_survey(world, table, begun, found):
    """Diagnostics from what begin_survey and survey_pairs have returned."""
    world, table = by_address(world), by_address(table)
    energy, speed, bounds = begun
    touching, worst = found
    (overlap, deepest), step = survey_boundaries(world, table, bounds, worst)
    stiffness = 4.0 * table.modulus * math.sqrt(table.radius.max() * bounds.least) * table.mobility
    damping = 2.0 * damping_ratio(table.alpha) * math.sqrt(2.0 * stiffness)
    granules = world.bodies.shape[0]
    push = greatest_acceleration(world.force, world.inverse_mass, world.inverse_inertia, table)
    push = either(faster(push_on(world.walls), push), push)
    push = either(faster(push_on(world.cylinder), push), push)
    push = either(faster(push_on(world.held), push), push)
    return Diagnostics(
        energy, math.sqrt(speed * speed + 2.0 * table.skin * push), 2.0 * touching / granules, overlap, deepest // table.per,
        min(step, critical_step(stiffness, damping)),
    )  # fmt: skip


@compiled(allocates=True)
def diagnose(world, table):
    """Diagnostics of the bed and its critical time step.

    Stiffness and damping of all contacts give a lower bound on the critical step. Pairs that are
    near but do not touch count with the overlap of a collision at the greatest expected speed, and
    any granule could collide with one of its own size.
    """
    world, table = by_address(world), by_address(table)
    begun = begin_survey(world, table, 0)
    found = survey_pairs(world, table, begun[2], 0, world.bodies.shape[0], 0)
    return end_survey(world, table, begun, found)
