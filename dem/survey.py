"""One look at the bed, between steps: energy, contacts, greatest overlap, bound on the stiffness."""

import math
from typing import NamedTuple

import numpy as np

from dem.blocks import remembered
from dem.columns import VX, VY, W, X, Y
from dem.compilation import compiled, inlined
from dem.contact_law import impact_overlap
from dem.kernel import greater
from dem.optional import either, optional, plus
from dem.response import local_stiffness
from dem.shapes.geometry import outline, round_outline, support, touch


class Glance(NamedTuple):
    """The bed at one moment; coordination number: touching pairs of parts, twice, a granule."""

    kinetic_energy: float  # J
    fastest: float  # m/s: the greatest speed to be expected, of granules and cylinder
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


@optional
def tangential_stiffness(tangent, stiffness, root):
    return tangent.stiffness_ratio * stiffness * root


@inlined
def stiff(tangent, stiffness, root):
    """Normal and tangential stiffness (N/m) of a contact of overlap root^2."""
    return 1.5 * stiffness * root, either(tangential_stiffness(tangent, stiffness, root), 0.0)


@inlined
def add_stiffness(rows, i, j, kn, kt, wn, wt):
    rows[i] += kn * wn[i] * (wn[i] + wn[j]) + kt * wt[i] * (wt[i] + wt[j])
    rows[j] += kn * wn[j] * (wn[i] + wn[j]) + kt * wt[j] * (wt[i] + wt[j])


@inlined
def deeper(worst, overlap, i, size):
    """Greater of two relative overlaps, each with the granule it belongs to; NaN wins."""
    relative = overlap / size
    if relative <= worst[0] or worst[0] != worst[0]:
        return worst
    return relative, i


@compiled
def survey_pairs(shape, parts, frame, contacts, tangent, radius, per, least, wn, wt, rows):
    first, other = contacts.first, contacts.other
    touching = 0
    worst = (0.0, 0)
    for i in range(parts.shape[0]):
        own = outline(shape, i, frame)
        for p in range(first[i], first[i + 1]):
            j = other[p]
            dx, dy = parts[j, X] - parts[i, X], parts[j, Y] - parts[i, Y]
            guess = remembered(contacts.normal_x, contacts.normal_y, p)
            hit = touch(shape, dx, dy, own, outline(shape, j, frame), guess)
            overlap = hit[0]
            if not overlap <= 0.0:
                touching += 1
                worst = deeper(worst, overlap, i, min(radius[i], radius[j]))
            stiffness = either(local_stiffness(hit[7], contacts.modulus), contacts.stiffness[p])
            kn, kt = stiff(tangent, stiffness, math.sqrt(max(overlap, least)))
            add_stiffness(rows, i // per, j // per, kn, kt, wn, wt)
    return touching, worst


@compiled
def survey_listed(barrier, overlaps, stiffness, radius, per, least, wn, wt, rows, worst):
    """Walls or cylinder, with overlaps (m,) in m and stiffness (m,) from one of the two below."""
    contacts = barrier.contacts
    for p in range(contacts.part.shape[0]):
        i = contacts.part[p]
        if not overlaps[p] <= 0.0:
            worst = deeper(worst, overlaps[p], np.int64(i), radius[i])
        root = math.sqrt(max(overlaps[p], least))
        kn, kt = stiff(barrier.tangent, stiffness[p], root)
        g = i // per
        rows[g] += kn * wn[g] * wn[g] + kt * wt[g] * wt[g]
    return worst


@compiled(allocates=True)
def wall_overlaps(shape, parts, frame, walls):
    """Overlap (m; negative: a gap) and stiffness (N m^-1.5) of each listed contact with a wall."""
    contacts = walls.contacts
    overlaps = np.empty(contacts.part.shape[0])
    stiffness = contacts.stiffness.copy()
    for p in range(overlaps.shape[0]):
        i, k = contacts.part[p], contacts.other[p]
        nx, ny = walls.planes[k, 0], walls.planes[k, 1]
        reach, _, rho = support(shape, outline(shape, i, frame), nx, ny)
        stiffness[p] = either(local_stiffness(rho, contacts.modulus), stiffness[p])
        overlaps[p] = reach + parts[i, X] * nx + parts[i, Y] * ny - walls.planes[k, 2]
    return overlaps, stiffness


@compiled(allocates=True)
def roller_overlaps(shape, parts, frame, roller):
    """Overlap (m) and stiffness (N m^-1.5) of each listed contact with the cylinder."""
    contacts = roller.contacts
    overlaps = np.empty(contacts.part.shape[0])
    stiffness = contacts.stiffness.copy()
    circle = round_outline(shape, roller.radius)
    for p in range(overlaps.shape[0]):
        i = contacts.part[p]
        dx, dy = roller.motion[0, X] - parts[i, X], roller.motion[0, Y] - parts[i, Y]
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        hit = touch(shape, dx, dy, outline(shape, i, frame), circle, guess)
        stiffness[p] = either(local_stiffness(hit[7], contacts.modulus), stiffness[p])
        overlaps[p] = hit[0]
    return overlaps, stiffness


@optional
def survey_walls(walls, world, radius, per, least, wn, wt, rows, worst):
    overlaps, stiffness = wall_overlaps(world.shape, world.parts, world.frame, walls)
    return survey_listed(walls, overlaps, stiffness, radius, per, least, wn, wt, rows, worst)


@optional
def survey_roller(roller, world, radius, per, least, wn, wt, rows, worst):
    overlaps, stiffness = roller_overlaps(world.shape, world.parts, world.frame, roller)
    return survey_listed(roller, overlaps, stiffness, radius, per, least, wn, wt, rows, worst)


@compiled(allocates=True)
def survey(world, parts, least):
    """Look at the whole bed.

    parts: dem.assembly.Constants; least (m): overlap that a pair in the lists counts with, at
    least, as to stiffness.

    Returns the number of touching pairs of parts, the greatest overlap over the smaller radius
    with the part it belongs to, and a bound on the squared greatest eigenfrequency (1/s2): each
    contact adds to the mass-weighted stiffness matrix a block of known norm, and no eigenvalue
    exceeds the largest sum of norms in a row (Gershgorin's theorem for blocks).
    """
    radius, per, wn, wt = parts.radius, parts.per, parts.wn, parts.wt
    rows = np.zeros(world.bodies.shape[0])
    touching, worst = survey_pairs(
        world.shape, world.parts, world.frame, world.pairs, world.tangent,
        radius, per, least, wn, wt, rows,
    )  # fmt: skip
    look = world, radius, per, least, wn, wt, rows
    worst = either(survey_walls(world.walls, *look, worst), worst)
    worst = either(survey_roller(world.roller, *look, worst), worst)
    return touching, worst[0], worst[1], rows.max()


@optional
def fall_squared(gravity, distance):
    """Square of the speed (m/s) that a fall over a distance (m) adds."""
    return 2.0 * distance * math.sqrt(gravity[0] ** 2 + gravity[1] ** 2)


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

    The critical step is 2 / omega_max without damping, bounded from below by the stiffness of all
    contacts; pairs that are near but do not touch count with the overlap of a collision at the
    greatest speed to be expected, and so does a granule that meets its like.
    """
    energy, fastest = kinetic(world.bodies, world.inverse_mass, world.inverse_inertia)
    speed = expected_speed(world.roller, world.gravity, parts.skin, fastest)
    radius, mass = 0.5 * parts.mean_radius, 0.5 * parts.mean_mass
    least = max(impact_overlap(mass, radius, parts.modulus, speed), 1e-8 * radius)
    touching, overlap, part, bound = survey(world, parts, least)
    alone = 4.0 * parts.modulus * math.sqrt(parts.radius.max() * least) * parts.wt.max() ** 2
    granules = world.bodies.shape[0]
    return Glance(
        energy, speed, 2.0 * touching / granules, overlap, part // parts.per,
        2.0 / math.sqrt(max(bound, alone)),
    )  # fmt: skip
