"""The bed at one moment, between steps: energy, contacts, greatest overlap, critical time step."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import imaged, remembered
from dem.contacts.force_law import damping_ratio, impact_overlap
from dem.contacts.response import dashpot_constant, local_stiffness
from dem.dynamics.boundaries import driven_acceleration, fastest, lightness
from dem.dynamics.forces import clear, greater
from dem.dynamics.stable_step import (
    COLUMNS,
    Bounds,
    add_force_stiffness,
    add_pair_stiffness,
    add_pair_tangent,
    longest_step,
    shortest,
    weight,
)
from dem.dynamics.world import Surface, at_full_steps
from dem.jit.address import by_address, local
from dem.jit.columns import DVX, FX, FY, TAU, VX, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, given, minus, optional, plus, times, unless
from dem.shapes.protocol import circle, collect, outline, solve_contact, support


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
        The time step (s) of which `step_fraction` is that fraction; in steps of an eighth root of two it is taken.
    """

    kinetic_energy: float
    speed_bound: float
    coordination_number: float
    max_overlap: float
    deepest: int
    critical_time_step: float
    longest_time_step: float


@optional
def weight_velocity(gravity, c, later):
    return later * gravity[c]


@inlined
def velocity_later(world, i, c, later):
    """Component c of the velocity of granule i after kicks of a time `later` (s)."""
    kick = later * world.inverse_mass[i] * world.force[i, c]
    here = minus(world.bodies[i, VX + c], given(at_full_steps(world), world.bodies[i, DVX + c]))
    return plus(here + kick, weight_velocity(world.gravity, c, later))


@optional
def spin_energy(inverse_inertia, world, i, later):
    spin = world.bodies[i, W] + later * inverse_inertia[i] * world.force[i, TAU]
    return 0.5 * spin * spin / inverse_inertia[i]


@compiled
def kinetic(world, later, frame):
    """Kinetic energy (J) of the granules that are free, and greatest speed (m/s) of all; NaN wins.

    later (s): kicks that velocities lack; frame: velocity (m/s) that is added to all for the energy.
    """
    energy, speed_bound = 0.0, 0.0
    for i in range(world.bodies.shape[0]):
        vx, vy = velocity_later(world, i, 0, later), velocity_later(world, i, 1, later)
        if world.inverse_mass[i] > 0.0:
            squared = (vx + frame[0]) ** 2 + (vy + frame[1]) ** 2
            energy += 0.5 * squared / world.inverse_mass[i]
            energy = plus(energy, spin_energy(world.inverse_inertia, world, i, later))
        speed_bound = greater(speed_bound, vx * vx + vy * vy)
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
def held_body(held, world, table, g, levers):
    b = held.group[g]
    if b < 0:
        return g, weight(table, g, levers[0]), weight(table, g, levers[1])
    light = lightness(world.boundaries, b)
    return held.group.shape[0] + b, light, light


@inlined
def body_of(world, table, g, levers):
    """Row of Bounds for granule g, and `weight` for both levers: those of its group where it is held."""
    free = g, weight(table, g, levers[0]), weight(table, g, levers[1])
    return either(held_body(world.held, world, table, g, levers), free)


@compiled
def survey_pairs(world, table, bounds, begin, end, spare):
    """Fill the rows of Bounds of granules begin to end with what their pairs do.

    The share of another granule goes to row `spare`, which nobody reads: who surveys that granule adds
    it to its row. Sums have one order, however granules are shared out. Returns how many pairs touch,
    and the greatest relative overlap with its constituent, of the pairs that begin with these granules.
    """
    world = by_address(world)
    shape, motion, frame = world.shape, world.constituents, world.frame
    granules, contacts, table = world.bodies, local(world.pairs), local(table)
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
            damping = dashpot_constant(contacts.damping, contacts.mass_ratio, p, nx, ny)
            damping = times(damping, math.sqrt(sqrt_overlap))
            k, spring = 1.5 * stiffness * sqrt_overlap, (stiffness, sqrt_overlap, damping)
            one, two = body_of(world, table, g, mine), body_of(world, table, h, theirs)
            pair = one[0] if i >= low else spare, two[0] if j < high else spare
            add_pair_stiffness(rows, pair, k, damping, (nx, ny), (one[1], two[1]))
            weights = one[2], two[2]
            add_pair_tangent(contacts.friction, rows, pair, spring, (-ny, nx), weights)
            add_force_stiffness(rows, pair[0], k, overlap, table.bend[g])
            add_force_stiffness(rows, pair[1], k, overlap, table.bend[h])
    return touching, worst


@optional
def survey_surface(surface, world, table, bounds, worst):
    return _survey_surface(surface, world, table, bounds, worst)


@compiled(allocates=True)
def _survey_surface(surface, world, table, bounds, worst):
    """Add what all contacts with walls, or with the cylinder, do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent; worst: that so far.
    """
    boundaries, rows = world.boundaries, bounds.rows
    granules, motion = world.bodies, world.constituents
    found = geometries(world.shape, motion, world.frame, boundaries.motion, surface)
    contacts, table = local(surface.contacts), local(table)
    for p in range(contacts.constituent.shape[0]):
        i, b = np.int64(contacts.constituent[p]), np.int64(contacts.partner[p])
        g = i // table.per
        overlap, nx, ny = found[p, 0], found[p, 1], found[p, 2]
        n1, t1, stiffness = found[p, 3], found[p, 4], found[p, 5]
        if not overlap <= 0.0:
            worst = deeper(worst, overlap, i, table.radius[i])
        sqrt_overlap = math.sqrt(max(overlap, bounds.least))
        n1 += 0.5 * min(overlap, 0.0)
        mine = levers(granules, motion, g, i, (nx, ny), (n1, t1))
        damping = dashpot_constant(contacts.damping, contacts.mass_ratio, p, nx, ny)
        damping = times(damping, math.sqrt(sqrt_overlap))
        k, spring = 1.5 * stiffness * sqrt_overlap, (stiffness, sqrt_overlap, damping)
        row, along, across = body_of(world, table, g, mine)
        pair, other = (row, granules.shape[0] + b), lightness(boundaries, b)
        add_pair_stiffness(rows, pair, k, damping, (nx, ny), (along, other))
        add_pair_tangent(contacts.friction, rows, pair, spring, (-ny, nx), (across, other))
        add_force_stiffness(rows, g, k, overlap, table.bend[g])
    return worst


@optional
def beside_plane(planes, shape, own, x, y, j):
    """Overlap, normal, levers and curvature of a constituent at x, y and wall j."""
    nx, ny = planes[j, 0], planes[j, 1]
    reach, t1, rho = support(shape, own, nx, ny)
    overlap = reach + x * nx + y * ny - planes[j, 2]
    return overlap, nx, ny, reach - 0.5 * overlap, either(t1, 0.0), rho


@optional
def beside_outline(other, shape, own, contacts, p, dx, dy):
    """The same for another outline, dx, dy (m) from it."""
    dx, dy = imaged(contacts, p, dx, dy)
    guess = remembered(contacts.normal_x, contacts.normal_y, p)
    one = solve_contact(shape, dx, dy, own, other, guess)
    return one.overlap, one.nx, one.ny, one.n1, either(one.t1, 0.0), one.radius


@optional
def cylinder_outline(radius, shape):
    return circle(shape, radius)


@optional
def partner_outline(pairs, shape, j, frame):
    return outline(shape, j, frame)


@compiled(allocates=True)
def geometries(shape, motion, frame, others, surface):
    """Rows (m, 6), one per listed contact with a surface, or between granules (`measured`), seen
    from its constituent: overlap (m; negative: a gap), normal, levers n1 and t1 (m), and
    stiffness (N m^-1.5). others: motion of the partners."""
    contacts, planes, radius = surface.contacts, surface.planes, surface.radius
    found = np.empty((contacts.constituent.shape[0], 6))
    for p in range(found.shape[0]):
        i, j = contacts.constituent[p], contacts.partner[p]
        own, x, y = outline(shape, i, frame), motion[i, X], motion[i, Y]
        pairs = unless(planes, unless(radius, True))
        other = either(cylinder_outline(radius, shape), partner_outline(pairs, shape, j, frame))
        dx, dy = others[j, X] - x, others[j, Y] - y
        one = either(
            beside_plane(planes, shape, own, x, y, j),
            beside_outline(other, shape, own, contacts, p, dx, dy),
        )
        stiffness = either(local_stiffness(one[5], contacts.modulus), contacts.stiffness[p])
        # number by number, because a row brings in the text of its error message
        found[p, 0], found[p, 1], found[p, 2] = one[0], one[1], one[2]
        found[p, 3], found[p, 4], found[p, 5] = one[3], one[4], stiffness
    return found


def measured(world, *surfaces):
    """Contacts between granules, then those with each of some surfaces: the Surface, motion of the partners,
    and the geometries."""
    pairs = Surface(0, 0, None, None, world.pairs), world.constituents
    others = [(each, world.boundaries.motion) for each in surfaces if each is not None]
    for surface, motion in (pairs, *others):
        found = geometries(world.shape, world.constituents, world.frame, motion, surface)
        yield surface, motion, found


@optional
def touch_surface(surface, world, table, worst):
    others = world.boundaries.motion
    found = geometries(world.shape, world.constituents, world.frame, others, surface)
    for p in range(found.shape[0]):
        if not found[p, 0] <= 0.0:
            i = np.int64(surface.contacts.constituent[p])
            worst = deeper(worst, found[p, 0], i, table.radius[i])
    return worst


@compiled(allocates=True)
def touch(world, table):
    """Coordination number and greatest overlap over the smaller radius, as Diagnostics have them, in a
    fraction of the time."""
    pairs, motion, touching, worst = world.pairs, world.constituents, 0, (0.0, 0)
    listed = Surface(0, 0, None, None, pairs)
    found = geometries(world.shape, motion, world.frame, motion, listed)
    for p in range(found.shape[0]):
        if not found[p, 0] <= 0.0:
            i, j = np.int64(pairs.constituent[p]), np.int64(pairs.partner[p])
            touching += 1
            worst = deeper(worst, found[p, 0], i, min(table.radius[i], table.radius[j]))
    worst = either(touch_surface(world.walls, world, table, worst), worst)
    worst = either(touch_surface(world.cylinder, world, table, worst), worst)
    return 2.0 * touching / world.bodies.shape[0], worst[0]


@inlined
def empty_bounds(world, least, spare):
    """Bounds with a number of spare rows at the end. Only the rows after those of granules are zero:
    survey_pairs clears the others, each thread its own, which is then near its memory."""
    granules = world.bodies.shape[0]
    rows = np.empty((granules + world.boundaries.motion.shape[0] + spare, COLUMNS))
    clear(rows, granules, rows.shape[0])
    return Bounds(rows, least)


@inlined
def survey_boundaries(world, table, bounds, worst):
    """Add what contacts with walls and cylinder do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent, and the bounds on the time step (s).
    """
    worst = either(survey_surface(world.walls, world, table, bounds, worst), worst)
    worst = either(survey_surface(world.cylinder, world, table, bounds, worst), worst)
    count = world.bodies.shape[0] + world.boundaries.motion.shape[0]
    return worst, shortest(bounds.rows, count, table.fraction)


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
    return touching, worst[0], worst[1], step[0]


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


@inlined
def expected_speed(world, skin, speed_bound):
    """Greatest speed (m/s) before the lists are rebuilt: of granules, boundaries that may be driven, and a fall."""
    squared = greater(fastest(world.boundaries), speed_bound * speed_bound)
    squared += 2.0 * skin * driven_acceleration(world.boundaries)
    return math.sqrt(plus(squared, fall_squared(world.gravity, skin)))


@compiled(allocates=True)
def begin_survey(world, table, later, frame, spare):
    """Kinetic energy (J), expected speed (m/s) and empty Bounds, with a number of spare rows."""
    world, table = by_address(world), by_address(table)
    collect(world.shape, world.constituent_force, world.frame, world.force, 0, len(world.bodies))
    energy, speed_bound = kinetic(world, later, frame)
    speed = expected_speed(world, table.skin, speed_bound)
    radius, mass = 0.5 * table.mean_radius, 0.5 * table.mean_mass
    least = max(impact_overlap(mass, radius, table.modulus, speed), 1e-8 * radius)
    return energy, speed, empty_bounds(world, least, spare)


@inlined
def step_alone(table, least, fraction):
    """Time step (s) for a granule that collides with one of its own size, up to an overlap (m)."""
    stiffness = 4.0 * table.modulus * math.sqrt(table.radius.max() * least) * table.mobility
    damping = 2.0 * damping_ratio(table.alpha) * math.sqrt(2.0 * stiffness)
    return longest_step(stiffness, damping, fraction)


@compiled(allocates=True)
def end_survey(world, table, begun, found):
    """Diagnostics from what begin_survey and survey_pairs have returned."""
    world, table = by_address(world), by_address(table)
    energy, speed, bounds = begun
    touching, worst = found
    (overlap, deepest), step = survey_boundaries(world, table, bounds, worst)
    granules = world.bodies.shape[0]
    push = greatest_acceleration(world.force, world.inverse_mass, world.inverse_inertia, table)
    push = greater(driven_acceleration(world.boundaries), push)
    return Diagnostics(
        energy, math.sqrt(speed * speed + 2.0 * table.skin * push), 2.0 * touching / granules, overlap, deepest // table.per,
        min(step[0], step_alone(table, bounds.least, 1.0)),
        min(step[1], step_alone(table, bounds.least, table.fraction)),
    )  # fmt: skip


@compiled(allocates=True)
def diagnose(world, table, later, frame):
    """Diagnostics of the bed and its time step; later, frame: as for `kinetic`.

    Stiffness and damping of all contacts give a lower bound on the critical step. Pairs that are
    near but do not touch count with the overlap of a collision at the greatest expected speed, and
    any granule could collide with one of its own size.
    """
    world, table = by_address(world), by_address(table)
    begun = begin_survey(world, table, later, frame, 0)
    found = survey_pairs(world, table, begun[2], 0, world.bodies.shape[0], 0)
    return end_survey(world, table, begun, found)
