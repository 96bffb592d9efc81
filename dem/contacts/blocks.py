"""Forces of a block of contacts, stage by stage, in the lanes of dem.jit.block_memory.

    gather           motion and outlines of both bodies, side by side
    find_contacts    geometry: overlap, normal, moment arms, velocity at the contact
    refine_contacts  geometry again, where the last normal was too far off
    contact_forces   force law
    accumulate       forces and torques on the constituents

find_contacts and contact_forces do nearly all arithmetic. They have no branches and become vector
code: a change of their form, also one that computes the same, may make them slower.
"""

import numpy as np

from dem.contacts.response import NO_MEAN, entry, relative_velocity, respond
from dem.jit import block_memory as lane
from dem.jit.block_memory import (
    EIGHT,
    FIVE,
    FOUR,
    ONE,
    SIX,
    THREE,
    TWO,
    load_outline,
    store_outline,
)
from dem.jit.compilation import inlined
from dem.jit.instructions import add_four, subtract_four
from dem.jit.optional import (
    either,
    given,
    minus,
    optional,
    plus,
    rolled_without_first,
    times,
)
from dem.laws.protocol import mean_root
from dem.shapes.polygon import polygon_contact
from dem.shapes.protocol import (
    ContactGeometry,
    circle,
    find_contact,
    local_radius,
    outline,
    outline_among,
    refine_normal,
    support,
    tangential_lever,
)

# Gather: motion and outlines


@inlined
def copy_four(source, i, target, k):
    """Four numbers from source[i] on to target[k]: the compiler makes it one move."""
    a, b, c, d = source[i], source[i + ONE], source[i + TWO], source[i + THREE]
    target[k] = a
    target[k + ONE] = b
    target[k + TWO] = c
    target[k + THREE] = d


@inlined
def gather(turns, one, two, contacts, start, stop, lanes):
    """Motion of both bodies of each contact, from rows of dem.jit.columns one after the other.

    turns: inverse_inertia of a World, None where nothing turns.
    """
    motion = lanes.motion
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        at = FOUR * k
        i, j = EIGHT * contacts.constituent[p], EIGHT * contacts.partner[p]
        copy_four(one, i, motion, at + lane.X1)
        copy_four(two, j, motion, at + lane.X2)
        # body 2 to that image of it which is beside body 1
        if contacts.shift_x is not None:
            motion[at + lane.X2] += contacts.shift_x[p]
        if contacts.shift_y is not None:
            motion[at + lane.Y2] += contacts.shift_y[p]
        if turns is not None:
            if contacts.damping is not None or contacts.tangential_force is not None:
                copy_four(one, i + FOUR, motion, at + lane.W1)
                copy_four(two, j + FOUR, motion, at + lane.W2)
        elif contacts.first is None and contacts.damping is not None:
            # rows of granules have the velocity of the full step; those of boundaries have that of
            # the half step and its change
            motion[at + lane.VX2] += two[j + FIVE]
            motion[at + lane.VY2] += two[j + SIX]


@inlined
def sizes_of(outline):
    """The numbers of an outline after cosine and sine; where Shape.lists_sizes, they never
    change."""
    return outline[2:]


@optional
def turning(sizes, outline):
    """Cosine and sine of an outline of which the list has the sizes."""
    return outline[:2]


@inlined
def gather_pairs(shape, orientation, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        one = outline(shape, contacts.constituent[p], orientation)
        two = outline(shape, contacts.partner[p], orientation)
        store_outline(either(turning(contacts.sizes, one), one), values, lane.OUTLINE_1 + k)
        store_outline(either(turning(contacts.sizes, two), two), values, lane.OUTLINE_2 + k)


@optional
def find_circle_contacts(radius, shape, orientation, turns, contacts, start, stop, lanes):
    """Outlines and geometry of contacts with round solids."""
    values = lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        store_outline(
            outline(shape, contacts.constituent[p], orientation), values, lane.OUTLINE_1 + k
        )
        store_outline(circle(shape, radius[contacts.partner[p]]), values, lane.OUTLINE_2 + k)
    find_contacts(shape, turns, contacts, start, stop, lanes)


@optional
def find_outline_contacts(outlines, world, contacts, start, stop):
    """Outlines and geometry of contacts with solids that have the outline of a granule."""
    shape, orientation, frames = world.shape, world.orientation, world.boundaries.orientation
    values = world.lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        one = outline_among(outlines, shape, contacts.constituent[p], orientation)
        store_outline(one, values, lane.OUTLINE_1 + k)
        store_outline(outline(outlines, contacts.partner[p], frames), values, lane.OUTLINE_2 + k)
    find_contacts(outlines, world.inverse_inertia, contacts, start, stop, world.lanes)


@optional
def find_polygon_contacts(faces, world, contacts, start, stop):
    """Geometry of contacts with polygons, one by one."""
    shape, orientation, frames = world.shape, world.orientation, world.boundaries.orientation
    turns, lanes = world.inverse_inertia, world.lanes
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        one, b = outline(shape, contacts.constituent[p], orientation), contacts.partner[p]
        dx, dy = spacing(lanes.motion, k)
        guess = last_normal(contacts, p)
        geometry = polygon_contact(faces, b, frames, shape, one, dx, dy, guess)
        store_geometry(turns, geometry, contacts, p, lanes, k)


@optional
def find_wall_contacts(planes, shape, orientation, turns, contacts, start, stop, lanes):
    """Outlines and geometry of contacts with walls."""
    motion, values = lanes.motion, lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        wall = contacts.partner[p]
        store_outline(
            outline(shape, contacts.constituent[p], orientation), values, lane.OUTLINE_1 + k
        )
        values[lane.NX + k], values[lane.NY + k] = planes[wall, 0], planes[wall, 1]
        values[lane.OUTLINE_2 + k] = planes[wall, 2]
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        nx, ny = values[lane.NX + k], values[lane.NY + k]
        one = load_outline(circle(shape, 0.0), values, lane.OUTLINE_1 + k)
        reach, t1, radius = support(shape, one, nx, ny)
        at = FOUR * k
        height = motion[at + lane.X1] * nx + motion[at + lane.Y1] * ny
        overlap = reach + height - values[lane.OUTLINE_2 + k]
        n1 = reach - 0.5 * overlap
        geometry = ContactGeometry(overlap, nx, ny, n1, t1, None, None, radius)
        store_geometry(turns, geometry, contacts, p, lanes, k)


# Geometry of contacts


@inlined
def shifted(contacts, p, dx, dy):
    """The place dx, dy (m) of body 2 of contact p from body 1, of that image which is beside it."""
    x, y = contacts.shift_x, contacts.shift_y
    return plus(dx, entry(x, p)), plus(dy, entry(y, p))


@inlined
def spacing(motion, k):
    """Position (m) of body 2 of lane k from body 1."""
    at = FOUR * k
    return motion[at + lane.X2] - motion[at + lane.X1], motion[at + lane.Y2] - motion[at + lane.Y1]


@optional
def size_rows(sizes, shape):
    """The rows of Contacts.sizes: for both bodies."""
    part = sizes_of(circle(shape, 0.0))
    return load_outline(part, sizes, 0, 1), load_outline(part, sizes, len(part), 1)


@optional
def joined(sizes, like, values, k, p):
    """Outlines of lane k, with the sizes of contact p."""
    orientation = turning(sizes, like)
    one = load_outline(orientation, values, lane.OUTLINE_1 + k) + lane.pick(sizes[0], p)
    return one, load_outline(orientation, values, lane.OUTLINE_2 + k) + lane.pick(sizes[1], p)


@inlined
def outlines(shape, sizes, values, k, p):
    """Outlines of both bodies of contact p in lane k."""
    like = circle(shape, 0.0)
    whole = (
        load_outline(like, values, lane.OUTLINE_1 + k),
        load_outline(like, values, lane.OUTLINE_2 + k),
    )
    return either(joined(sizes, like, values, k, p), whole)


@optional
def put(number, array, k):
    array[k] = number


@inlined
def last_normal(contacts, p):
    """The normal that contact p had in the last step, None if it remembers none."""
    if contacts.normal_x is None:
        return None
    return contacts.normal_x[p], contacts.normal_y[p]


@inlined
def change_of(motion, at):
    """Changes of velocity and spin of a body."""
    return motion[at + ONE], motion[at + TWO], motion[at + THREE]


@optional
def change_between(turns, motion, at, geometry):
    """Change of the relative velocity to the full step; None where nothing turns: the velocity is
    then that of the full step, or nothing asks for it."""
    one, two = change_of(motion, at + lane.W1), change_of(motion, at + lane.W2)
    return relative_velocity(one, two, geometry)


@optional
def put_change(change, contacts, values, k):
    put(given(contacts.damping, change[0]), values, lane.DV_NORMAL + k)
    put(given(contacts.friction, change[1]), values, lane.DV_TANGENT + k)
    put(given(contacts.rolling, change[2]), values, lane.D_SPIN + k)


@optional
def change_of_lane(turns, rolling, values, k):
    spin = take(rolling, values, lane.D_SPIN + k)
    return values[lane.DV_NORMAL + k], values[lane.DV_TANGENT + k], spin


@inlined
def store_geometry(turns, geometry, contacts, p, lanes, k):
    """Write contact p to lane k: its geometry, and the velocity and its change at the contact."""
    motion, values = lanes.motion, lanes.values
    at = FOUR * k
    overlap, nx, ny, n1, t1, n2, t2, radius = geometry
    velocity = relative_velocity(
        (motion[at + lane.VX1], motion[at + lane.VY1], take(turns, motion, at + lane.W1)),
        (motion[at + lane.VX2], motion[at + lane.VY2], take(turns, motion, at + lane.W2)),
        geometry,
    )
    change = change_between(turns, motion, at, geometry)
    values[lane.OVERLAP + k], values[lane.NX + k], values[lane.NY + k] = overlap, nx, ny
    put(given(turns, n1), values, lane.N1 + k)
    put(given(turns, n2), values, lane.N2 + k)
    put(t1, values, lane.T1 + k)
    put(t2, values, lane.T2 + k)
    put(radius, values, lane.RADIUS + k)
    # only damping needs the rate, only friction the slip, only rolling resistance the spin
    put(given(contacts.damping, velocity[0]), values, lane.V_NORMAL + k)
    put(given(contacts.friction, velocity[1]), values, lane.V_TANGENT + k)
    put(given(contacts.rolling, velocity[2]), values, lane.SPIN + k)
    put_change(change, contacts, values, k)
    if contacts.normal_x is not None:
        contacts.normal_x[p], contacts.normal_y[p] = nx, ny


@inlined
def find_contacts(shape, turns, contacts, start, stop, lanes):
    motion, values, sizes = lanes.motion, lanes.values, size_rows(contacts.sizes, shape)
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        dx, dy = spacing(motion, k)
        one, two = outlines(shape, sizes, values, k, p)
        guess = last_normal(contacts, p)
        geometry, converged = find_contact(shape, dx, dy, one, two, guess)
        store_geometry(turns, geometry, contacts, p, lanes, k)
        put(unconverged(converged), values, lane.UNCONVERGED + k)
    refine_contacts(contacts.normal_x, shape, turns, contacts, start, stop, lanes)


@optional
def unconverged(converged):
    return 0.0 if converged else 1.0


@optional
def refine_contacts(normal_x, shape, turns, contacts, start, stop, lanes):
    motion, values, sizes = lanes.motion, lanes.values, size_rows(contacts.sizes, shape)
    count = 0
    for q in range(stop - start):  # nearly always none is, and vector code is fast to say so
        count += values[lane.UNCONVERGED + np.uint64(q)] != 0.0
    if count == 0:
        return
    for p in range(start, stop):
        k = np.uint64(p - start)
        if values[lane.UNCONVERGED + k] != 0.0:
            dx, dy = spacing(motion, k)
            one, two = outlines(shape, sizes, values, k, np.uint64(p))
            guess = refine_normal(shape, dx, dy, one, two, last_normal(contacts, p))
            geometry, _ = find_contact(shape, dx, dy, one, two, guess)
            store_geometry(turns, geometry, contacts, p, lanes, k)


# Forces

NEAR = 8.0  # halves of a step's change; beyond, the mean over the step differs by less than 5e-4


@optional
def average_roots(damping, contacts, start, stop, dt, values):
    """The mean over the step of the root of the law, for the dashpots of the few contacts that are
    near touch, one by one; NO_MEAN of all others."""
    near = 0
    for q in range(stop - start):
        k = np.uint64(q)
        overlap, change = values[lane.OVERLAP + k], 0.5 * dt * abs(values[lane.V_NORMAL + k])
        values[lane.MEAN_ROOT + k] = NO_MEAN
        near += -change < overlap < NEAR * change
    if near > 0:
        for q in range(stop - start):
            k, p = np.uint64(q), np.uint64(start + q)
            overlap, change = values[lane.OVERLAP + k], 0.5 * dt * abs(values[lane.V_NORMAL + k])
            if -change < overlap < NEAR * change:
                mean = mean_root(contacts.law, overlap, change, entry(contacts.length, p))
                values[lane.MEAN_ROOT + k] = mean


@rolled_without_first
def contact_forces(friction, shape, levers, turns, contacts, start, stop, dt, lanes):
    """Forces and torques of a block.

    levers: not None where normal forces may exert torques, although granules are discs.
    """
    values, levers = lanes.values, either(tangential_lever(shape), levers)
    average_roots(contacts.damping, contacts, start, stop, dt, values)
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        nx, ny = values[lane.NX + k], values[lane.NY + k]
        # n2 and t2 mean nothing for walls, and no lever does where nothing turns: none is asked for
        n1, t1 = values[lane.N1 + k], take(levers, values, lane.T1 + k)
        n2, t2 = values[lane.N2 + k], take(levers, values, lane.T2 + k)
        radius = take(local_radius(shape), values, lane.RADIUS + k)
        geometry = ContactGeometry(values[lane.OVERLAP + k], nx, ny, n1, t1, n2, t2, radius)
        spin = take(contacts.rolling, values, lane.SPIN + k)
        velocity = values[lane.V_NORMAL + k], values[lane.V_TANGENT + k], spin
        change = either(change_of_lane(turns, contacts.rolling, values, k), (None, None, None))
        mean = take(contacts.damping, values, lane.MEAN_ROOT + k)
        n, t, moment, damped, slid, rolled = respond(
            contacts, p, geometry, velocity, change, mean, dt, lanes.account
        )
        put(damped, values, lane.DAMPED + k)
        put(slid, values, lane.SLID + k)
        put(rolled, values, lane.ROLLED + k)
        values[lane.FORCE_X + k] = minus(n * nx, times(t, ny))
        values[lane.FORCE_Y + k] = plus(n * ny, times(t, nx))
        # zero where a list has none, because other lists of the same lanes have some
        none = given(turns, 0.0)
        one = minus(minus(times(t1, n), times(n1, t)), moment)
        put(either(one, none), values, lane.TORQUE_1 + k)
        two = plus(minus(minus(None, times(n2, t)), times(t2, n)), moment)
        put(either(two, none), values, lane.TORQUE_2 + k)


@optional
def add_losses(account, contacts, start, stop, values):
    """Add up what a block of contacts loses (W)."""
    for q in range(stop - start):
        k = np.uint64(q)
        if contacts.damping is not None or contacts.friction is not None:
            account[lane.POWER_DAMPED] += values[lane.DAMPED + k]
        if contacts.friction is not None:
            account[lane.POWER_SPRINGS] += values[lane.SLID + k]
        if contacts.rolling is not None:
            account[lane.POWER_ROLLING] += values[lane.ROLLED + k]


@optional
def take(present, array, k):
    return array[k]


# Sums over contacts


@inlined
def accumulate(contacts, start, stop, values, inverse_inertia, force):
    """Add the forces of a block to both constituents of each pair.

    force (4 constituents,): the rows of dem.jit.columns one after the other. To keep the sum of one
    constituent in registers from pair to pair takes longer: each pair must choose which sum it adds
    to.
    """
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        gx, gy = values[lane.FORCE_X + k], values[lane.FORCE_Y + k]
        one = either(take(inverse_inertia, values, lane.TORQUE_1 + k), 0.0)
        two = either(take(inverse_inertia, values, lane.TORQUE_2 + k), 0.0)
        add_four(force, FOUR * contacts.force_row[p], gx, gy, two, 0.0)
        subtract_four(force, FOUR * contacts.constituent[p], gx, gy, -one, 0.0)
