"""A block of contacts, stage by stage, in the lanes of dem.jit.lanes.

gather: copy what is needed side by side. inspect: find all contacts; inspect_again: those for
which the last normal was no good guess. push: all forces. scatter: give them to the parts.
inspect and push, which hold nearly all arithmetic, have no branches and become vector code.
"""

import numpy as np

from dem.jit import lanes as row
from dem.jit.compilation import inlined
from dem.jit.lanes import EIGHT, FOUR, ONE, THREE, TWO
from dem.jit.optional import either, minus, optional, plus, times
from dem.contacts.response import approach, respond
from dem.shapes.geometry import load, outline, probe, recall, round_outline, save, seek, support


@inlined
def copy_four(source, i, target, k):
    """Four numbers from source[i] on to target[k]: the compiler makes it one move."""
    a, b, c, d = source[i], source[i + ONE], source[i + TWO], source[i + THREE]
    target[k] = a
    target[k + ONE] = b
    target[k + TWO] = c
    target[k + THREE] = d


@optional
def copy_rates(needed, rows, i, motion, k):
    copy_four(rows, i + FOUR, motion, k)


@inlined
def gather(one, two, contacts, start, stop, lanes):
    """Motion of both bodies of each contact, from rows of dem.jit.columns one after the other."""
    motion = lanes.motion
    rates = either(contacts.damping, contacts.spring)
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        at = FOUR * k
        i, j = EIGHT * contacts.part[p], EIGHT * contacts.other[p]
        copy_four(one, i, motion, at + row.X1)
        copy_four(two, j, motion, at + row.X2)
        copy_rates(rates, one, i, motion, at + row.W1)
        copy_rates(rates, two, j, motion, at + row.W2)


@inlined
def gather_pairs(shape, frame, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        save(shape, outline(shape, contacts.part[p], frame), values, row.OWN + k)
        save(shape, outline(shape, contacts.other[p], frame), values, row.OTHER + k)


@inlined
def gather_circle(shape, radius, frame, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        save(shape, outline(shape, contacts.part[p], frame), values, row.OWN + k)
        save(shape, round_outline(shape, radius), values, row.OTHER + k)


@inlined
def gather_planes(shape, planes, frame, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        wall = contacts.other[p]
        save(shape, outline(shape, contacts.part[p], frame), values, row.OWN + k)
        values[row.NX + k], values[row.NY + k] = planes[wall, 0], planes[wall, 1]
        values[row.OTHER + k] = planes[wall, 2]


@inlined
def spacing(motion, k):
    """Position (m) of part 2 of lane k from part 1."""
    at = FOUR * k
    return motion[at + row.X2] - motion[at + row.X1], motion[at + row.Y2] - motion[at + row.Y1]


@optional
def put(number, array, k):
    array[k] = number


@optional
def put_for(needed, number, array, k):
    """Without friction nobody asks for the slip, without damping nobody for the rate."""
    array[k] = number


@optional
def remembered(normal_x, normal_y, p):
    """The normal that contact p had last."""
    return normal_x[p], normal_y[p]


@optional
def remember(normal_x, normal_y, p, nx, ny):
    normal_x[p] = nx
    normal_y[p] = ny


@inlined
def keep(hit, contacts, p, lanes, k):
    """Write contact p to lane k: the hit, and the velocity and its change at the contact."""
    motion, values = lanes.motion, lanes.values
    at = FOUR * k
    overlap, nx, ny, n1, t1, n2, t2, radius = hit
    velocity = approach(
        (motion[at + row.VX1], motion[at + row.VY1], motion[at + row.W1]),
        (motion[at + row.VX2], motion[at + row.VY2], motion[at + row.W2]), hit,
    )  # fmt: skip
    change = approach(
        (motion[at + row.DVX1], motion[at + row.DVY1], motion[at + row.DW1]),
        (motion[at + row.DVX2], motion[at + row.DVY2], motion[at + row.DW2]), hit,
    )  # fmt: skip
    values[row.OVERLAP + k], values[row.NX + k], values[row.NY + k] = overlap, nx, ny
    values[row.N1 + k] = n1
    put(n2, values, row.N2 + k)
    put(t1, values, row.T1 + k)
    put(t2, values, row.T2 + k)
    put(radius, values, row.RADIUS + k)
    put_for(contacts.damping, velocity[0], values, row.ALONG + k)
    put_for(contacts.spring, velocity[1], values, row.ACROSS + k)
    put_for(contacts.damping, change[0], values, row.D_ALONG + k)
    put_for(contacts.spring, change[1], values, row.D_ACROSS + k)
    remember(contacts.normal_x, contacts.normal_y, p, nx, ny)


@inlined
def inspect(shape, contacts, start, stop, lanes):
    motion, values = lanes.motion, lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        dx, dy = spacing(motion, k)
        own, other = load(shape, values, row.OWN + k), load(shape, values, row.OTHER + k)
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        hit, sure = probe(shape, dx, dy, own, other, guess)
        keep(hit, contacts, p, lanes, k)
        put(doubt(sure), values, row.DOUBT + k)


@inlined
def inspect_planes(shape, contacts, start, stop, lanes):
    motion, values = lanes.motion, lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        nx, ny = values[row.NX + k], values[row.NY + k]
        reach, t1, radius = support(shape, load(shape, values, row.OWN + k), nx, ny)
        at = FOUR * k
        here = motion[at + row.X1] * nx + motion[at + row.Y1] * ny
        overlap = reach + here - values[row.OTHER + k]
        hit = overlap, nx, ny, reach - 0.5 * overlap, t1, None, None, radius
        keep(hit, contacts, p, lanes, k)


@optional
def doubt(sure):
    return 0.0 if sure else 1.0


@optional
def inspect_again(normal_x, shape, contacts, start, stop, lanes):
    motion, values = lanes.motion, lanes.values
    for p in range(start, stop):
        k = np.uint64(p - start)
        if values[row.DOUBT + k] != 0.0:
            dx, dy = spacing(motion, k)
            own, other = load(shape, values, row.OWN + k), load(shape, values, row.OTHER + k)
            guess = seek(shape, dx, dy, own, other, (normal_x[p], contacts.normal_y[p]))
            keep(probe(shape, dx, dy, own, other, guess)[0], contacts, p, lanes, k)


@inlined
def push(shape, contacts, tangent, start, stop, dt, lanes):
    values = lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        hit = recall(shape, values, k)
        velocity = values[row.ALONG + k], values[row.ACROSS + k]
        change = values[row.D_ALONG + k], values[row.D_ACROSS + k]
        n, t, damped, slid = respond(contacts, tangent, p, hit, velocity, change, dt, lanes.account)
        put(damped, values, row.DAMPED + k)
        put(slid, values, row.SLID + k)
        _, nx, ny, n1, t1, n2, t2, _ = hit
        values[row.PUSH_X + k] = minus(n * nx, times(t, ny))
        values[row.PUSH_Y + k] = plus(n * ny, times(t, nx))
        put(minus(times(t1, n), times(n1, t)), values, row.TWIST1 + k)
        put(minus(minus(None, times(n2, t)), times(t2, n)), values, row.TWIST2 + k)


@optional
def settle_account(account, damping, tangent, start, stop, values):
    """Add up what a block of contacts has lost."""
    for q in range(stop - start):
        k = np.uint64(q)
        take_loss(either(damping, tangent), account, row.LOST_DAMPED, values, row.DAMPED + k)
        take_loss(tangent, account, row.LOST_SLID, values, row.SLID + k)


@optional
def take_loss(present, account, kind, values, k):
    account[kind] += values[k]


@optional
def add(number, array, k):
    array[k] += number


@optional
def take(present, array, k):
    return array[k]


@inlined
def scatter(contacts, start, stop, values, turns, force):
    """Add the forces of a block to both parts of each pair.

    force (4 parts,): the rows of dem.jit.columns one after the other. What part 1 has felt so far
    stays in registers from pair to pair: fetching it anew each time would wait for the last store.
    """
    last, fx, fy, torque = np.uint64(0), force[0], force[1], force[2]
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        i, j = FOUR * contacts.part[p], FOUR * contacts.slot[p]
        gx, gy = values[row.PUSH_X + k], values[row.PUSH_Y + k]
        force[j] += gx
        force[j + ONE] += gy
        add(take(turns, values, row.TWIST2 + k), force, j + TWO)
        same = i == last
        fx = (fx if same else force[i]) - gx
        fy = (fy if same else force[i + ONE]) - gy
        torque = plus(torque if same else force[i + TWO], take(turns, values, row.TWIST1 + k))
        force[i], force[i + ONE], force[i + TWO] = fx, fy, torque
        last = i


@inlined
def reaction(contacts, p, k, values, turns, force):
    """Give part p of a contact with a wall or the cylinder its share.

    Returns the wall and the forces on it: normal (x, y) and tangential (x, y), in N.
    """
    at = FOUR * contacts.part[p]
    gx, gy = values[row.PUSH_X + k], values[row.PUSH_Y + k]
    force[at] -= gx
    force[at + ONE] -= gy
    add(take(turns, values, row.TWIST1 + k), force, at + TWO)
    nx, ny = values[row.NX + k], values[row.NY + k]
    normal = gx * nx + gy * ny
    hx, hy = normal * nx, normal * ny
    return contacts.other[p], normal, (hx, hy, gx - hx, gy - hy)
