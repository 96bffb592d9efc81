"""How boundaries move, at rest, on a path or pushed (dem.motion), and what they do to held granules."""

import math

from dem.dynamics.forces import greater
from dem.dynamics.world import DAMPING, EXTERNAL_FORCE, INVERSE_MASS
from dem.jit.block_memory import WORK
from dem.jit.columns import DVX, DVY, FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.shapes.rotation import rotate


@inlined
def waypoint_after(waypoints, first, last, time):
    """The first waypoint of a path that is later than a time (s), `last` if none is."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if waypoints[middle, 0] <= time:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def on_path(waypoints, first, last, after, time, c):
    """Velocity of component c at a time (s) before waypoint `after` of a path."""
    low, high = max(after - 1, first), min(after, last - 1)
    span = waypoints[high, 0] - waypoints[low, 0]
    change = waypoints[high, 1 + c] - waypoints[low, 1 + c]
    return waypoints[low, 1 + c] + (
        change * ((time - waypoints[low, 0]) / span) if span > 0.0 else 0.0
    )


@inlined
def follow_path(boundaries, b, dt):
    """Velocity of boundary b on its path: the mean over the step, and the change to its end.

    Corners and jumps within the step count from their time on. What is driven stays as it is.
    """
    motion, waypoints, time = boundaries.motion, boundaries.waypoints, boundaries.time[0]
    first, last = boundaries.first_waypoint[b], boundaries.first_waypoint[b + 1]
    after, end, left = waypoint_after(waypoints, first, last, time), time + dt, 1.0
    axes = 2 if boundaries.drive[b, INVERSE_MASS + 2] > 0.0 else 3
    for c in range(axes):
        motion[b, VX + c] = 0.0
    while True:
        ends = after == last or not waypoints[after, 0] < end
        stop = end if ends else waypoints[after, 0]
        share = left if ends else (stop - time) / dt
        for c in range(axes):
            middle = on_path(waypoints, first, last, after, 0.5 * (time + stop), c)
            motion[b, VX + c] += share * middle
        if ends:
            break
        time, after, left = stop, after + 1, left - share
    for c in range(axes):
        motion[b, DVX + c] = on_path(waypoints, first, last, after, end, c) - motion[b, VX + c]


@inlined
def kick_driven(boundaries, b, kick, dt):
    """Velocity and spin of boundary b where it is driven, after a kick (s): as of a granule, with
    damping at its mean."""
    motion, drive = boundaries.motion, boundaries.drive
    previous_acceleration = boundaries.previous_acceleration
    for c in range(3):
        inverse_mass = drive[b, INVERSE_MASS + c]
        if inverse_mass > 0.0:
            drag, before = drive[b, DAMPING + c] * inverse_mass, motion[b, VX + c]
            pushed = inverse_mass * (drive[b, EXTERNAL_FORCE + c] + boundaries.force[b, FX + c])
            after = (before * (1.0 - 0.5 * kick * drag) + kick * pushed) / (1.0 + 0.5 * kick * drag)
            motion[b, VX + c] = after
            now = pushed - 0.5 * drag * (before + after)
            motion[b, DVX + c] = 0.5 * dt * (2.0 * now - previous_acceleration[b, c])
            previous_acceleration[b, c] = now


@compiled
def move_boundaries(world, kick, dt):
    """Kick all boundaries over the time `kick` (s) and move them over dt (s).

    Velocities are those of half steps as in dem.dynamics.integration. `move_held` then moves held
    granules. Impulses take up what kicks: with the momentum of the granules, they are exact.
    """
    boundaries, planes = world.boundaries, world.walls.planes
    motion, first = boundaries.motion, boundaries.first_waypoint
    contact_forces, impulses = boundaries.contact_forces, boundaries.impulses
    force, account = boundaries.force, world.lanes.account
    for b in range(motion.shape[0]):
        before = motion[b, VX], motion[b, VY], motion[b, W]
        for c in range(impulses.shape[1]):
            impulses[b, c] += kick * contact_forces[b, c]
        if first[b] < first[b + 1]:
            follow_path(boundaries, b, dt)
        kick_driven(boundaries, b, kick, dt)
        if account is not None:  # at the mean velocity, as the kick changes kinetic energies
            twice = force[b, FX] * (before[0] + motion[b, VX])
            twice += force[b, FY] * (before[1] + motion[b, VY])
            twice += contact_forces[b, 4] * (before[2] + motion[b, W])
            account[WORK] -= 0.5 * kick * twice
        motion[b, X] += dt * motion[b, VX]
        motion[b, Y] += dt * motion[b, VY]
        boundaries.angle[b] += dt * motion[b, W]
        rotate(boundaries.orientation, b, boundaries.angle[b], dt * motion[b, W])
    boundaries.time[0] += dt
    for k in range(planes.shape[0]):
        planes[k, 2] += dt * (motion[k, VX] * planes[k, 0] + motion[k, VY] * planes[k, 1])


@inlined
def surface_moved(surface, boundaries):
    """Largest squared displacement (m2) of the boundaries of a surface since the lists were
    made."""
    farthest = 0.0
    if surface is not None:
        planes, motion, reference = surface.planes, boundaries.motion, boundaries.reference
        for q in range(surface.boundary.shape[0]):
            b = surface.boundary[q]
            dx, dy = motion[b, X] - reference[b, 0], motion[b, Y] - reference[b, 1]
            if planes is not None:  # only the motion along the normal counts
                squared = (dx * planes[b, 0] + dy * planes[b, 1]) ** 2
            else:
                turn = boundaries.reach[b] * abs(boundaries.angle[b] - reference[b, 2])
                squared = (math.sqrt(dx * dx + dy * dy) + turn) ** 2
            farthest = greater(farthest, squared)
    return farthest


@inlined
def boundaries_moved(world):
    """Largest squared displacement (m2) of walls, and of solids, since the lists were made."""
    boundaries = world.boundaries
    solids = surface_moved(world.circles, boundaries)
    solids = greater(solids, surface_moved(world.outlines, boundaries))
    solids = greater(solids, surface_moved(world.polygons, boundaries))
    return surface_moved(world.walls, boundaries), solids


@inlined
def move_held(held, world, full, kick, low, high):
    """Move the held among granules low to high along with their groups, after a kick (s).

    full: dem.dynamics.world.at_full_steps.
    """
    if held is not None:
        bodies, motion, member, start = (
            world.bodies,
            world.boundaries.motion,
            held.member,
            held.start,
        )
        account, force = world.lanes.account, world.force
        q, end = 0, member.shape[0]
        while q < end:  # the first member of the patch
            middle = (q + end) // 2
            if member[middle] < low:
                q = middle + 1
            else:
                end = middle
        while q < member.shape[0] and member[q] < high:
            i = member[q]
            b = held.group[i]
            bodies[i, X] = start[q, 0] + motion[b, X]
            bodies[i, Y] = start[q, 1] + motion[b, Y]
            bodies[i, VX], bodies[i, VY] = motion[b, VX], motion[b, VY]
            if full is not None:
                bodies[i, VX] += motion[b, DVX]
                bodies[i, VY] += motion[b, DVY]
            bodies[i, DVX] = motion[b, DVX]
            bodies[i, DVY] = motion[b, DVY]
            if account is not None:  # work of its spin
                account[WORK] -= kick * force[i, TAU] * bodies[i, W]
            q += 1


# For the bounds of speed and time step


@inlined
def fastest(boundaries):
    """Square of the greatest speed (m/s) that a surface has now, or will have on its path."""
    motion, waypoints, squared = boundaries.motion, boundaries.waypoints, 0.0
    for b in range(motion.shape[0]):
        along, spin = motion[b, VX] ** 2 + motion[b, VY] ** 2, abs(motion[b, W])
        last, reach = boundaries.first_waypoint[b + 1] - 1, boundaries.reach[b]
        for q in range(boundaries.first_waypoint[b], last + 1):
            if q == last or waypoints[q + 1, 0] > boundaries.time[0]:
                vx, vy = waypoints[q, 1], waypoints[q, 2]
                along = greater(along, vx * vx + vy * vy)
                spin = greater(spin, abs(waypoints[q, 3]))
        if reach > 0.0:
            along = (math.sqrt(along) + reach * spin) ** 2
        squared = greater(squared, along)
    return squared


@inlined
def driven_acceleration(boundaries):
    """Greatest acceleration (m/s2) of driven surfaces, without their damping."""
    drive, force, greatest = boundaries.drive, boundaries.force, 0.0
    for b in range(force.shape[0]):
        ax = drive[b, INVERSE_MASS] * (drive[b, EXTERNAL_FORCE] + force[b, FX])
        ay = drive[b, INVERSE_MASS + 1] * (drive[b, EXTERNAL_FORCE + 1] + force[b, FY])
        acceleration = math.sqrt(ax * ax + ay * ay)
        torque = drive[b, EXTERNAL_FORCE + 2] + force[b, TAU]
        acceleration += boundaries.reach[b] * drive[b, INVERSE_MASS + 2] * abs(torque)
        greatest = greater(greatest, acceleration)
    return greatest
