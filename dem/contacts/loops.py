"""The only loops over contacts: forces on granules, walls and cylinder."""

import numpy as np

from dem.contacts.blocks import (
    gather,
    gather_circle,
    gather_pairs,
    gather_planes,
    inspect,
    inspect_again,
    inspect_planes,
    push,
    reaction,
    scatter,
    settle_account,
)  # fmt: skip
from dem.jit.columns import FX, FY, TAU, VX, VY, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.lanes import ACCOUNTS, BLOCK, EIGHT, FOUR, ONE, TWO, WORK, ZERO
from dem.jit.optional import optional
from dem.jit.prefetch import prefetch
from dem.shapes.geometry import collect, place
from dem.dynamics.synchronise import wait
from dem.dynamics.world import granules_of, number_of_chunks


@optional
def fetch(numbers, p):
    prefetch(numbers, p)


@optional
def fetch_ahead(chunks, rows, contacts, start, end):
    """Ask for what the block after the next needs, and for the motion of parts in the next."""
    far = start + 2 * BLOCK
    for p in range(far, min(far + BLOCK, end), 8):
        prefetch(contacts.part, p)
        prefetch(contacts.other, p)
        prefetch(contacts.slot, p)
        prefetch(contacts.stiffness, p)
        fetch(contacts.damping, p)
        fetch(contacts.spring, p)
        fetch(contacts.root, p)
        fetch(contacts.normal_x, p)
        fetch(contacts.normal_y, p)
    near = start + BLOCK
    for p in range(near, min(near + BLOCK, end)):
        prefetch(rows, EIGHT * contacts.other[p])


@compiled
def pair_contacts(
    shape, parts, frame, contacts, tangent, turns, force, dt, lanes, chunks, begin, end
):
    """Rows begin to end of the list."""
    rows, pushes = parts.reshape(-1), force.reshape(-1)
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        fetch_ahead(chunks, rows, contacts, start, end)
        gather(rows, rows, contacts, start, stop, lanes)
        gather_pairs(shape, frame, contacts, start, stop, lanes.values)
        inspect(shape, contacts, start, stop, lanes)
        inspect_again(contacts.normal_x, shape, contacts, start, stop, lanes)
        push(shape, contacts, tangent, start, stop, dt, lanes)
        settle_account(lanes.account, contacts.damping, tangent, start, stop, lanes.values)
        scatter(contacts, start, stop, lanes.values, turns, pushes)


@compiled
def wall_contacts(shape, parts, frame, walls, turns, force, dt, lanes):
    if walls is None:
        return
    contacts = walls.contacts
    rows, pushes, still = parts.reshape(-1), force.reshape(-1), walls.motion.reshape(-1)
    count = contacts.part.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(rows, still, contacts, start, stop, lanes)
        gather_planes(shape, walls.planes, frame, contacts, start, stop, lanes.values)
        inspect_planes(shape, contacts, start, stop, lanes)
        push(shape, contacts, walls.tangent, start, stop, dt, lanes)
        settle_account(lanes.account, contacts.damping, walls.tangent, start, stop, lanes.values)
        for p in range(start, stop):
            k = np.uint64(p - start)
            wall, normal, _ = reaction(contacts, p, k, lanes.values, turns, pushes)
            walls.impulse[wall] += normal * dt


@compiled
def roller_contacts(shape, parts, frame, roller, turns, force, dt, lanes):
    if roller is None:
        return
    contacts = roller.contacts
    rows, pushes, axis = parts.reshape(-1), force.reshape(-1), roller.motion.reshape(-1)
    count = contacts.part.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(rows, axis, contacts, start, stop, lanes)
        gather_circle(shape, roller.radius, frame, contacts, start, stop, lanes.values)
        inspect(shape, contacts, start, stop, lanes)
        inspect_again(contacts.normal_x, shape, contacts, start, stop, lanes)
        push(shape, contacts, roller.tangent, start, stop, dt, lanes)
        settle_account(lanes.account, contacts.damping, roller.tangent, start, stop, lanes.values)
        for p in range(start, stop):
            k = np.uint64(p - start)
            _, _, shares = reaction(contacts, p, k, lanes.values, turns, pushes)
            for c in range(4):
                roller.impulse[c] += shares[c] * dt
            put_work(lanes.account, roller.motion, shares, dt)


@optional
def turn_page(account):
    """Keep what the account holds before a step."""
    for kind in range(ACCOUNTS):
        account[ACCOUNTS + kind] = account[kind]


@optional
def put_work(account, motion, shares, dt):
    """Work (J) of the cylinder on a granule: shares (N), see dem.contacts.blocks.reaction, act on it."""
    fx, fy = shares[0] + shares[2], shares[1] + shares[3]
    account[WORK] -= (fx * motion[0, VX] + fy * motion[0, VY]) * dt


@optional
def deliver(chunks, pushes, parts, chunk):
    """Add to the parts of a chunk what pairs of other chunks have left for them."""
    for q in range(chunks.first[chunk], chunks.first[chunk + 1]):
        slot, at = FOUR * (parts + chunks.inbox[q]), FOUR * chunks.target[chunks.inbox[q]]
        for c in (ZERO, ONE, TWO):
            pushes[at + c] += pushes[slot + c]
            pushes[slot + c] = 0.0


@inlined
def clear(force, low, high):
    """No forces on parts low to high."""
    for i in range(low, high):
        force[i, FX] = 0.0
        force[i, FY] = 0.0
        force[i, TAU] = 0.0


@inlined
def greater(a, b):
    """The greater of two numbers, NaN if either is."""
    return b if (b > a or b != b) and a == a else a


@inlined
def farthest(parts, reference, low, high):
    """Largest squared displacement (m2) of parts low to high since the lists were made."""
    largest = 0.0
    for i in range(low, high):
        dx = parts[i, X] - reference[i, 0]
        dy = parts[i, Y] - reference[i, 1]
        largest = greater(largest, dx * dx + dy * dy)
    return largest


@compiled
def add_forces(world, dt, begin, end, leads, team):
    """Forces on the parts: of pairs in chunks begin to end; of walls and cylinder if this thread leads.

    Returns the largest squared displacement (m2) of these parts since the lists were made. To
    look at that and to clear the forces goes straight through the memory of a chunk: it is in the
    cache when the pairs want it.
    """
    shape, parts, frame, force = world.shape, world.parts, world.frame, world.part_force
    turns, lanes, pairs = world.inverse_inertia, world.lanes, world.pairs
    granules = world.bodies.shape[0]
    per, moved = parts.shape[0] // granules, 0.0
    turn_page(lanes.account)
    for chunk in range(begin, end):
        low, high = granules_of(world.chunks, granules, chunk)
        low, high = per * low, per * high
        clear(force, low, high)
        moved = greater(moved, farthest(parts, world.reference, low, high))
        pair_contacts(
            shape, parts, frame, pairs, world.tangent, turns, force, dt, lanes, world.chunks,
            np.int64(pairs.first[low]), np.int64(pairs.first[high]),
        )  # fmt: skip
    wait(team)
    for chunk in range(begin, end):
        deliver(world.chunks, force.reshape(-1), np.uint64(parts.shape[0]), chunk)
    wait(team)
    if leads:
        wall_contacts(shape, parts, frame, world.walls, turns, force, dt, lanes)
        roller_contacts(shape, parts, frame, world.roller, turns, force, dt, lanes)
    return moved


@compiled
def forces(world, dt):
    """Fill world.force (N, N m) for the present positions, at the end of a step of dt (s).

    Returns the largest squared displacement (m2) since the lists were made.
    """
    granules = world.bodies.shape[0]
    place(world.shape, world.bodies, world.frame, world.parts, 0, granules)
    chunks = number_of_chunks(world.chunks, granules)
    begin = np.int64(0)  # of the type that advance has: else all is compiled twice
    moved = add_forces(world, dt, begin, chunks, begin == 0, None)
    collect(world.shape, world.part_force, world.frame, world.force, 0, granules)
    return moved
