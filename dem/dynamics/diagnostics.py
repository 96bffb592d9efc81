"""One look at the bed, between steps: energy, contacts, greatest overlap, critical time step."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import remembered
from dem.jit.columns import FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.contacts.force_law import damping_ratio, impact_overlap
from dem.dynamics.stable_step import (
    COLUMNS,
    anchor,
    couple,
    critical_step,
    normal_damping,
    share,
    shortest,
    stiffen,
    tangential_damping,
    tangential_stiffness,
)
from dem.contacts.loops import greater
from dem.jit.optional import either, optional, plus
from dem.contacts.response import local_stiffness
from dem.shapes.geometry import outline, round_outline, support, touch


class Glance(NamedTuple):
    """The bed at one moment; coordination number: touching pairs of parts, twice, a granule."""

    kinetic_energy: float  # J
    fastest: float  # m/s: greatest speed to be expected before the lists are made anew
    coordination_number: float
    max_overlap: float  # over the smaller radius
    deepest: int  # the granule it belongs to
    critical_time_step: float  # s


@optional
def spin_energy(inverse_inertia, i, spin):
    return 0.5 * spin * spin / inverse_inertia[i]


@compiled
def kinetic(bodies, inverse_mass, inverse_inertia):
    """Kinetic energy (J) and greatest speed (m/s); NaN wins."""
    energy, fastest = 0.0, 0.0
    for i in range(bodies.shape[0]):
        squared = bodies[i, VX] ** 2 + bodies[i, VY] ** 2
        energy += 0.5 * squared / inverse_mass[i]
        energy = plus(energy, spin_energy(inverse_inertia, i, bodies[i, W]))
        fastest = greater(fastest, squared)
    return energy, math.sqrt(fastest)


@inlined
def deeper(worst, overlap, i, size):
    """Greater of two relative overlaps, each with the granule it belongs to; NaN wins."""
    relative = overlap / size
    if relative <= worst[0] or worst[0] != worst[0]:
        return worst
    return relative, i


@inlined
def levers(bodies, parts, g, i, nx, ny, along, across):
    """Levers (m) of the normal and of the tangential force about the centre of granule g.

    The contact lies at along n + across t from the centre of part i.
    """
    x = parts[i, X] - bodies[g, X] + along * nx - across * ny
    y = parts[i, Y] - bodies[g, Y] + along * ny + across * nx
    return x * ny - y * nx, x * nx + y * ny


@optional
def couple_tangent(tangent, blocks, g, h, stiffness, root, damping, nx, ny, one, two):
    k = tangential_stiffness(tangent, stiffness, root)
    couple(blocks, g, h, k, tangential_damping(damping, tangent), -ny, nx, one, two)


@optional
def anchor_tangent(tangent, blocks, g, stiffness, root, damping, nx, ny, one):
    k = tangential_stiffness(tangent, stiffness, root)
    anchor(blocks, g, k, tangential_damping(damping, tangent), -ny, nx, one)


@compiled
def survey_pairs(
    shape, bodies, parts, frame, contacts, tangent, light, turns, constants, least, blocks
):
    """light, turns: inverse masses and inverse moments of inertia."""
    first, other = contacts.first, contacts.other
    radius, per, bend = constants.radius, constants.per, constants.bend
    touching = 0
    worst = (0.0, 0)
    for i in range(parts.shape[0]):
        own = outline(shape, i, frame)
        for p in range(first[i], first[i + 1]):
            j = np.int64(other[p])
            dx, dy = parts[j, X] - parts[i, X], parts[j, Y] - parts[i, Y]
            guess = remembered(contacts.normal_x, contacts.normal_y, p)
            hit = touch(shape, dx, dy, own, outline(shape, j, frame), guess)
            overlap, nx, ny, n1, t1, n2, t2, rho = hit
            if not overlap <= 0.0:
                touching += 1
                worst = deeper(worst, overlap, i, min(radius[i], radius[j]))
            stiffness = either(local_stiffness(rho, contacts.modulus), contacts.stiffness[p])
            root, g, h = math.sqrt(max(overlap, least)), i // per, j // per
            apart = 0.5 * min(overlap, 0.0)  # the surfaces, not the middle of a gap
            mine = levers(bodies, parts, g, i, nx, ny, n1 + apart, either(t1, 0.0))
            theirs = levers(bodies, parts, h, j, nx, ny, -n2 - apart, either(t2, 0.0))
            damping = normal_damping(contacts.damping, p, root)
            k = 1.5 * stiffness * root
            one, two = share(light, turns, g, mine[0]), share(light, turns, h, theirs[0])
            couple(blocks, g, h, k, damping, nx, ny, one, two)
            one, two = share(light, turns, g, mine[1]), share(light, turns, h, theirs[1])
            couple_tangent(tangent, blocks, g, h, stiffness, root, damping, nx, ny, one, two)
            stiffen(blocks, g, k, overlap, bend)
            stiffen(blocks, h, k, overlap, bend)
    return touching, worst


@compiled
def survey_listed(barrier, hits, bodies, parts, light, turns, constants, least, blocks, worst):
    """Walls or cylinder, with hits (m, 6) from one of the two functions below."""
    contacts, radius = barrier.contacts, constants.radius
    for p in range(contacts.part.shape[0]):
        i = np.int64(contacts.part[p])
        g = i // constants.per
        overlap, nx, ny, along, across, stiffness = hits[p]
        if not overlap <= 0.0:
            worst = deeper(worst, overlap, i, radius[i])
        root = math.sqrt(max(overlap, least))
        along += 0.5 * min(overlap, 0.0)
        normal, tangential = levers(bodies, parts, g, i, nx, ny, along, across)
        damping = normal_damping(contacts.damping, p, root)
        k = 1.5 * stiffness * root
        anchor(blocks, g, k, damping, nx, ny, share(light, turns, g, normal))
        one = share(light, turns, g, tangential)
        anchor_tangent(barrier.tangent, blocks, g, stiffness, root, damping, nx, ny, one)
        stiffen(blocks, g, k, overlap, constants.bend)
    return worst


@compiled(allocates=True)
def pair_hits(shape, parts, frame, contacts):
    """Rows (m, 6), one a listed pair, seen from its first part; see wall_hits."""
    hits = np.empty((contacts.part.shape[0], 6))
    for p in range(hits.shape[0]):
        i, j = contacts.part[p], contacts.other[p]
        dx, dy = parts[j, X] - parts[i, X], parts[j, Y] - parts[i, Y]
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        hit = touch(shape, dx, dy, outline(shape, i, frame), outline(shape, j, frame), guess)
        stiffness = either(local_stiffness(hit[7], contacts.modulus), contacts.stiffness[p])
        hits[p] = hit[0], hit[1], hit[2], hit[3], either(hit[4], 0.0), stiffness
    return hits


@compiled(allocates=True)
def wall_hits(shape, parts, frame, walls):
    """Rows (m, 6), one a listed contact with a wall.

    Overlap (m; negative: a gap), normal, place of the contact from the part's centre along normal
    and tangent (m), and stiffness (N m^-1.5).
    """
    contacts = walls.contacts
    hits = np.empty((contacts.part.shape[0], 6))
    for p in range(hits.shape[0]):
        i, k = contacts.part[p], contacts.other[p]
        nx, ny = walls.planes[k, 0], walls.planes[k, 1]
        reach, across, rho = support(shape, outline(shape, i, frame), nx, ny)
        overlap = reach + parts[i, X] * nx + parts[i, Y] * ny - walls.planes[k, 2]
        stiffness = either(local_stiffness(rho, contacts.modulus), contacts.stiffness[p])
        hits[p] = overlap, nx, ny, reach - 0.5 * overlap, either(across, 0.0), stiffness
    return hits


@compiled(allocates=True)
def roller_hits(shape, parts, frame, roller):
    """The same of the contacts with the cylinder."""
    contacts = roller.contacts
    hits = np.empty((contacts.part.shape[0], 6))
    circle = round_outline(shape, roller.radius)
    for p in range(hits.shape[0]):
        i = contacts.part[p]
        dx, dy = roller.motion[0, X] - parts[i, X], roller.motion[0, Y] - parts[i, Y]
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        hit = touch(shape, dx, dy, outline(shape, i, frame), circle, guess)
        stiffness = either(local_stiffness(hit[7], contacts.modulus), contacts.stiffness[p])
        hits[p] = hit[0], hit[1], hit[2], hit[3], either(hit[4], 0.0), stiffness
    return hits


@optional
def survey_walls(walls, world, constants, least, blocks, worst):
    hits = wall_hits(world.shape, world.parts, world.frame, walls)
    return survey_listed(
        walls, hits, world.bodies, world.parts, world.inverse_mass, world.inverse_inertia,
        constants, least, blocks, worst,
    )  # fmt: skip


@optional
def survey_roller(roller, world, constants, least, blocks, worst):
    hits = roller_hits(world.shape, world.parts, world.frame, roller)
    return survey_listed(
        roller, hits, world.bodies, world.parts, world.inverse_mass, world.inverse_inertia,
        constants, least, blocks, worst,
    )  # fmt: skip


@compiled(allocates=True)
def survey(world, parts, least):
    """Look at the whole bed.

    parts: dem.dynamics.assembly.Constants; least (m): overlap that a pair in the lists counts with, at
    least, as to stiffness. Returns the number of touching pairs of parts, the greatest overlap over
    the smaller radius with the part it belongs to, and the bound on the critical time step (s).
    """
    blocks = np.zeros((world.bodies.shape[0], COLUMNS))
    touching, worst = survey_pairs(
        world.shape, world.bodies, world.parts, world.frame, world.pairs, world.tangent,
        world.inverse_mass, world.inverse_inertia, parts, least, blocks,
    )  # fmt: skip
    worst = either(survey_walls(world.walls, world, parts, least, blocks, worst), worst)
    worst = either(survey_roller(world.roller, world, parts, least, blocks, worst), worst)
    return touching, worst[0], worst[1], shortest(blocks)


@optional
def fall_squared(gravity, distance):
    """Square of the speed (m/s) that a fall over a distance (m) adds."""
    return 2.0 * distance * math.sqrt(gravity[0] ** 2 + gravity[1] ** 2)


@optional
def swing(inverse_inertia, i, torque, lever):
    return abs(torque) * inverse_inertia[i] * lever


@compiled
def greatest_acceleration(force, inverse_mass, inverse_inertia, parts):
    """Of any part (m/s2), from the forces on its granule; gravity not counted."""
    greatest = 0.0
    for i in range(inverse_mass.shape[0]):
        push = math.sqrt(force[i, FX] ** 2 + force[i, FY] ** 2) * inverse_mass[i]
        lever = parts.radius[i * parts.per] if parts.per > 1 else 0.0
        greatest = greater(greatest, plus(push, swing(inverse_inertia, i, force[i, TAU], lever)))
    return greatest


@optional
def roller_squared(roller):
    return roller.motion[0, VX] ** 2 + roller.motion[0, VY] ** 2


@inlined
def expected_speed(roller, gravity, skin, fastest):
    """Greatest speed (m/s) before the lists are made anew: of granules, cylinder, and a fall."""
    squared = max(fastest * fastest, either(roller_squared(roller), 0.0))
    return math.sqrt(plus(squared, fall_squared(gravity, skin)))


@compiled(allocates=True)
def look(world, parts):
    """Glance at the bed and its critical time step.

    The critical step is bounded from below by stiffness and damping of all contacts; pairs that
    are near but do not touch count with the overlap of a collision at the greatest speed to be
    expected, and so does a granule that meets its like.
    """
    energy, fastest = kinetic(world.bodies, world.inverse_mass, world.inverse_inertia)
    speed = expected_speed(world.roller, world.gravity, parts.skin, fastest)
    radius, mass = 0.5 * parts.mean_radius, 0.5 * parts.mean_mass
    least = max(impact_overlap(mass, radius, parts.modulus, speed), 1e-8 * radius)
    touching, overlap, part, step = survey(world, parts, least)
    stiffness = 4.0 * parts.modulus * math.sqrt(parts.radius.max() * least) * parts.mobility
    damping = 2.0 * damping_ratio(parts.alpha) * math.sqrt(2.0 * stiffness)
    granules = world.bodies.shape[0]
    push = greatest_acceleration(world.force, world.inverse_mass, world.inverse_inertia, parts)
    return Glance(
        energy, math.sqrt(speed * speed + 2.0 * parts.skin * push), 2.0 * touching / granules, overlap, part // parts.per,
        min(step, critical_step(stiffness, damping)),
    )  # fmt: skip
