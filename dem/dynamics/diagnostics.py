"""The scan of a bed between steps: energy, contacts, greatest overlap, critical time step."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import last_normal, shifted
from dem.contacts.response import stiffness_of
from dem.dynamics.boundary_motion import driven_acceleration, fastest
from dem.dynamics.contact_output import deeper, geometries
from dem.dynamics.critical_step import (
    COLUMNS,
    Body,
    Bounds,
    add_contact,
    shortest,
    stable_step,
)
from dem.dynamics.energy import kinetic
from dem.dynamics.forces import clear, greater
from dem.dynamics.world import INVERSE_MASS
from dem.jit.address import local
from dem.jit.columns import FX, FY, TAU, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either
from dem.laws.protocol import impact_overlap, length, measure, root, slope, stiffest
from dem.shapes.protocol import collect, first_of, local_radius, outline, owner_of, solve_contact


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
def body_of(world, table, g, i, normal, point):
    """Granule g at a contact of constituent i as a Body: its group where it is held.

    The contact is at point[0] n + point[1] t from the centre of constituent i.
    """
    (nx, ny), granules, constituents = normal, world.bodies, world.constituents
    x = constituents[i, X] - granules[g, X] + point[0] * nx - point[1] * ny
    y = constituents[i, Y] - granules[g, Y] + point[0] * ny + point[1] * nx
    arms, held, spin = (x * ny - y * nx, x * nx + y * ny), world.held, 0.0
    if held is not None and held.group[g] >= 0:
        return boundary_of(world, table, held.group[g], arms)
    if world.inverse_inertia is not None:
        spin = math.sqrt(world.inverse_inertia[g])
    return Body(g, math.sqrt(world.inverse_mass[g]), spin, arms, table.bend[g])


@inlined
def boundary_of(world, table, b, arms):
    """Boundary b at a contact as a Body."""
    drive = world.boundaries.drive
    size = math.sqrt(max(drive[b, INVERSE_MASS], drive[b, INVERSE_MASS + 1]))
    spin = math.sqrt(drive[b, INVERSE_MASS + 2])
    # a flat side has no curvature: its size bounds the arm
    bend = table.bulk * world.boundaries.reach[b] * drive[b, INVERSE_MASS + 2]
    return Body(world.bodies.shape[0] + b, size, spin, arms, bend)


@compiled
def scan_pairs(world, table, bounds, begin, end, spare):
    """Fill the rows of Bounds of granules begin to end with what their pairs do.

    The share of another granule goes to row `spare`, which nobody reads: the thread that scans that
    granule adds it to its row. Sums have one order, however granules are shared out. Returns how
    many pairs touch, and the greatest relative overlap with its constituent, of the pairs that
    begin with these granules.
    """
    shape, motion, orientation = world.shape, world.constituents, world.orientation
    contacts, table, radius = local(world.pairs), local(table), table.radius
    touching, worst = 0, (0.0, 0)
    clear(bounds.rows, begin, end)
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
            # the points are on the surfaces of both bodies, not in the middle of a gap
            apart, t1, t2 = 0.5 * min(overlap, 0.0), either(t1, 0.0), either(t2, 0.0)
            g, h, normal = owner_of(shape, i), owner_of(shape, j), (nx, ny)
            body_1 = body_of(world, table, g, i, normal, (n1 + apart, t1))
            body_2 = body_of(world, table, h, j, normal, (-n2 - apart, t2))
            pair = body_1.row if i >= low else spare, body_2.row if j < high else spare
            geometry = overlap, nx, ny, stiffness_of(contacts, p, rho), rho
            add_contact(contacts, p, bounds, geometry, pair, body_1, body_2)
    return touching, worst


@compiled(allocates=True)
def scan_contacts(surface, world, table, bounds, worst):
    """Add what all contacts with walls, or with solids, do to the rows of Bounds.

    Returns the greatest relative overlap with its constituent; worst: that so far.
    """
    boundaries, motion = world.boundaries, world.constituents
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
        n1 += 0.5 * min(overlap, 0.0)
        one, far = body_of(world, constants, g, i, (nx, ny), (n1, t1)), (0.0, 0.0)
        if surface.planes is None:
            dx, dy = shifted(contacts, p, moving[b, X] - motion[i, X], moving[b, Y] - motion[i, Y])
            x, y = n1 * nx - t1 * ny - dx, n1 * ny + t1 * nx - dy
            far = x * ny - y * nx, x * nx + y * ny
        two = boundary_of(world, constants, b, far)
        geometry = overlap, nx, ny, constant, local_radius(world.shape)
        add_contact(contacts, p, bounds, geometry, (one.row, two.row), one, two)
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
def usual_overlap(table, speed):
    """Overlap (m) of a collision of two mean granules at a speed (m/s), which is not too small."""
    radius, mass = 0.5 * table.mean_radius, 0.5 * table.mean_mass
    return max(impact_overlap(table.law, table.modulus, radius, mass, speed), 1e-8 * radius)


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
    worst = scan_contacts(world.walls, world, table, bounds, worst)
    worst = scan_contacts(world.circles, world, table, bounds, worst)
    if world.outlines is not None:
        worst = scan_contacts(world.outlines, world, table, bounds, worst)
    if world.polygons is not None:
        worst = scan_contacts(world.polygons, world, table, bounds, worst)
    bodies = world.bodies.shape[0] + world.boundaries.motion.shape[0]
    return worst, shortest(bounds.rows, bodies, table.fraction)


@compiled(allocates=True)
def critical_step(world, table, least):
    """Critical time step (s) of the contacts; least (m): smallest overlap of a listed pair in
    it."""
    bounds = empty_bounds(world, least, 0)
    _, worst = scan_pairs(world, table, bounds, 0, world.bodies.shape[0], 0)
    return scan_boundaries(world, table, bounds, worst)[1][0]


@compiled(allocates=True)
def begin_scan(world, table, later, frame, spare):
    """Kinetic energy (J), expected speed (m/s) and empty Bounds, with a number of spare rows."""
    granules = world.bodies.shape[0]
    collect(world.shape, world.constituent_force, world.orientation, world.force, 0, granules)
    energy, speed_bound = kinetic(world, later, frame)
    speed = expected_speed(world, table.skin, speed_bound)
    return energy, speed, empty_bounds(world, usual_overlap(table, speed), spare)


@compiled(allocates=True)
def end_scan(world, table, begun, pairs):
    """Diagnostics from what begin_scan and scan_pairs have returned."""
    energy, speed, bounds = begun
    touching, worst = pairs
    (overlap, deepest), steps = scan_boundaries(world, table, bounds, worst)
    granules, (critical, chosen) = world.bodies.shape[0], steps
    push = greatest_acceleration(world.force, world.inverse_mass, world.inverse_inertia, table)
    push = greater(driven_acceleration(world.boundaries), push)
    return Diagnostics(
        kinetic_energy=energy,
        speed_bound=math.sqrt(speed * speed + 2.0 * table.skin * push),
        coordination_number=2.0 * touching / granules,
        max_overlap=overlap,
        deepest=owner_of(world.shape, deepest),
        critical_time_step=min(critical, step_alone(table, bounds.least, 1.0)),
        longest_time_step=min(chosen, step_alone(table, bounds.least, table.fraction)),
    )


@compiled(allocates=True)
def diagnose(world, table, later, frame):
    """Diagnostics of the bed and its time step; later, frame: as for `kinetic`.

    Stiffness and damping of all contacts give a lower bound on the critical step. Pairs that are
    near but do not touch count with the overlap of a collision at the greatest expected speed, and
    any granule could collide with one of its own size.
    """
    begun = begin_scan(world, table, later, frame, 0)
    pairs = scan_pairs(world, table, begun[2], 0, world.bodies.shape[0], 0)
    return end_scan(world, table, begun, pairs)
