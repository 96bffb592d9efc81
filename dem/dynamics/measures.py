"""What a bed is measured by between steps, beside its contacts: energies, speeds, accelerations.

Python and kernels call these functions.
"""

import math

import numpy as np

from dem.contacts.layout import DVX, FX, FY, TAU, VX, VY, W
from dem.dynamics.motion import greater, restoring_load
from dem.dynamics.world import INVERSE_MASS, LOAD
from dem.jit.intrinsics import noinline
from dem.laws.protocol import impact_overlap


def velocity_later(world, full, i, c, later):
    """Component c of the velocity of granule i after kicks of a time `later` (s); full: whether
    rows of motion have velocities of full steps."""
    granules = world.granules
    velocity = granules.motion[i, VX + c]
    if full:
        velocity = velocity - granules.motion[i, DVX + c]
    push = granules.inverse_mass[i] * granules.force[i, FX + c]
    return velocity + later * push + later * world.gravity[c]


def kinetic(world, full, later, frame):
    """Kinetic energy (J) of the granules that are free, and greatest speed (m/s) of all; NaN wins.

    later (s): kicks that velocities lack; frame: velocity (m/s) that is added to all for the
    energy.
    """
    noinline()
    total, fastest, granules = 0.0, 0.0, world.granules
    for i in range(granules.angle.shape[0]):
        vx = velocity_later(world, full, i, 0, later)
        vy = velocity_later(world, full, i, 1, later)
        if granules.inverse_mass[i] > 0.0:
            squared = (vx + frame[0]) ** 2 + (vy + frame[1]) ** 2
            total += 0.5 * squared / granules.inverse_mass[i]
            inverse = granules.inverse_inertia[i]
            if inverse > 0.0:
                spin = granules.motion[i, W] + later * inverse * granules.force[i, TAU]
                total += 0.5 * spin * spin / inverse
        fastest = greater(fastest, vx * vx + vy * vy)
    return total, math.sqrt(fastest)


def fastest(boundaries):
    """Square of the greatest speed (m/s) that a surface has now, or will have on its path."""
    noinline()
    motion, waypoints, squared = boundaries.motion, boundaries.waypoints, 0.0
    for b in range(motion.shape[0]):
        along, spin = motion[b, VX] ** 2 + motion[b, VY] ** 2, abs(motion[b, W])
        last = boundaries.first_waypoint[b + 1] - 1
        for q in range(boundaries.first_waypoint[b], last + 1):
            if q == last or waypoints[q + 1, 0] > boundaries.time[0]:
                vx, vy = waypoints[q, 1], waypoints[q, 2]
                along = greater(along, vx * vx + vy * vy)
                spin = greater(spin, abs(waypoints[q, 3]))
        if b < boundaries.reach.shape[0] and boundaries.reach[b] > 0.0:
            along = (math.sqrt(along) + boundaries.reach[b] * spin) ** 2
        squared = greater(squared, along)
    return squared


def driven_acceleration(boundaries):
    """Greatest acceleration (m/s2) of driven surfaces, without their damping, by the forces of now and
    the loads of now or later."""
    drive, force, waypoints, greatest = (
        boundaries.drive,
        boundaries.force,
        boundaries.waypoints,
        0.0,
    )
    for b in range(force.shape[0]):
        fx = restoring_load(boundaries, b, 0) + force[b, FX]
        fy = restoring_load(boundaries, b, 1) + force[b, FY]
        last = boundaries.first_waypoint[b + 1] - 1
        for q in range(boundaries.first_waypoint[b], last + 1):
            if q == last or waypoints[q + 1, 0] > boundaries.time[0]:
                ax = drive[b, INVERSE_MASS] * (waypoints[q, 1 + LOAD] + fx)
                ay = drive[b, INVERSE_MASS + 1] * (waypoints[q, 2 + LOAD] + fy)
                acceleration = math.sqrt(ax * ax + ay * ay)
                if b < boundaries.reach.shape[0]:
                    torque = (
                        waypoints[q, 3 + LOAD] + restoring_load(boundaries, b, 2) + force[b, TAU]
                    )
                    acceleration += boundaries.reach[b] * drive[b, INVERSE_MASS + 2] * abs(torque)
                greatest = greater(greatest, acceleration)
    return greatest


def greatest_acceleration(world, bed):
    """Of any constituent (m/s2), from the forces on its granule; gravity not counted."""
    granules, greatest = world.granules, 0.0
    force = granules.force
    for i in range(granules.angle.shape[0]):
        push = math.sqrt(force[i, FX] ** 2 + force[i, FY] ** 2) * granules.inverse_mass[i]
        push += abs(force[i, TAU]) * granules.inverse_inertia[i] * bed.arm[i]
        greatest = greater(greatest, push)
    return greatest


def expected_speed(world, skin, speed_bound):
    """Greatest speed (m/s) before the lists are rebuilt: of granules, boundaries that may be
    driven, and a fall."""
    squared, gravity = greater(fastest(world.boundaries), speed_bound * speed_bound), world.gravity
    squared += 2.0 * skin * driven_acceleration(world.boundaries)
    squared += 2.0 * skin * math.sqrt(gravity[0] ** 2 + gravity[1] ** 2)
    return math.sqrt(squared)


def usual_overlap(law, bed, speed):
    """Overlap (m) of a collision of two mean granules at a speed (m/s), which is not too small."""
    radius, mass = 0.5 * bed.mean_radius, 0.5 * bed.mean_mass
    return max(impact_overlap(law, bed.modulus, radius, mass, speed), 1e-8 * radius)


def over(values, inverse):
    """Values (n,) divided by an inverse mass or inertia, zero where that is."""
    return np.divide(values, inverse, out=np.zeros_like(values), where=inverse > 0.0)
