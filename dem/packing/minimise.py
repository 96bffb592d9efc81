"""Bring a frictionless bed to rest: minimise its elastic energy by FIRE.

FIRE (Bitzek et al. 2006, Phys. Rev. Lett. 97, 170201, with the corrections of Guenole et al. 2020,
Comput. Mater. Sci. 175, 109584) is mechanics with a bias: velocities turn towards the forces, and
the bed stops whenever it moves uphill. The forces are those of a run without friction and damping.
The radius of gyration puts torques and spins on the scale of forces and speeds.

An iteration goes over the bed twice, patch by patch as a run does (dem.dynamics.integration): forces
and kicks, then moves. A kick does not wait for the sum that tells whether the bed moves uphill. If it
does, which is rare, the kick is taken back.
"""

import math
from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from dem.base.errors import PackingError
from dem.dynamics.assembly import SKIN_OF_PACKING, assemble, granule_table, order_of, ordered
from dem.dynamics.checkpoint import replaced
from dem.dynamics.contact_output import contact_summary, list_contacts
from dem.dynamics.diagnostics import critical_step
from dem.dynamics.forces import (
    add_forces_across_patches,
    boundary_forces,
    farthest_of,
    forces,
    greater,
    knows_forces,
    pair_forces,
)
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.dynamics.threads import Threads, barrier, leads, share_of
from dem.dynamics.world import PATCH, World, granules_of, number_of_patches
from dem.jit.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, rows
from dem.jit.compilation import compiled, inlined
from dem.jit.interrupts import signals_deferred
from dem.laws.protocol import stiffest
from dem.packing.job import Job
from dem.scene import State
from dem.shapes.protocol import collect, place
from dem.shapes.rotation import rotate

ALPHA_START = 0.25  # share of the turn towards the forces, at first
N_MIN = 20.0  # steps downhill before the time step grows
PIECE = 1000  # iterations in one call, between which Python answers Ctrl-C
STEP, LONGER_STEP = 0.5, 0.75  # of the bound on the critical step; in beds of several patches
# E* R^2, or under a law with a thickness K R: a bed is at rest when no granule feels a greater net force
REST = 1e-9
# of the mean contact force: at rest too, in beds of several patches, up to MOST_REST (E* R^2)
SHARE_OF_CONTACT, MOST_REST = 5e-3, 1e-6

# Sums over a patch, a cache line for each: F.v, F.F, greatest F.F of a granule, v.v after the kick,
# greatest squared displacement. Rotation counts by the radius of gyration.
POWER, PUSH, LARGEST, SPEED, MOVED, SUMS = 0, 1, 2, 3, 4, 8


@inlined
def gyration(world, i):
    """Inertia over mass (m2), which puts torques and spins on the scale of forces and speeds; 0 if
    granule i does not turn."""
    inverse_inertia = world.inverse_inertia
    if inverse_inertia is not None and inverse_inertia[i] > 0.0:
        return world.inverse_mass[i] / inverse_inertia[i]
    return 0.0


@compiled
def kick(world, dt, patch, sums):
    """Change the velocities of a patch by the forces over dt (s), and sum up.

    The velocities before are kept in the columns of which only dashpots take notice.
    """
    force, bodies = world.force, world.bodies
    inverse_mass, inverse_inertia = world.inverse_mass, world.inverse_inertia
    low, high = granules_of(bodies.shape[0], patch)
    power, push, largest, speed = 0.0, 0.0, 0.0, 0.0
    for i in range(low, high):
        g2 = gyration(world, i)
        fx, fy, torque = force[i, FX], force[i, FY], force[i, TAU]
        vx, vy, w = bodies[i, VX], bodies[i, VY], bodies[i, W]
        power += fx * vx + fy * vy + torque * w
        f2 = fx * fx + fy * fy
        push += f2
        if g2 > 0.0:
            push += torque * torque / g2
            f2 = max(f2, torque * torque / g2)
        largest = greater(largest, f2)  # NaN is not at rest
        bodies[i, DVX], bodies[i, DVY], bodies[i, DW] = vx, vy, w
        vx += dt * fx * inverse_mass[i]
        vy += dt * fy * inverse_mass[i]
        if inverse_inertia is not None:
            w += dt * torque * inverse_inertia[i]
        bodies[i, VX], bodies[i, VY], bodies[i, W] = vx, vy, w
        speed += vx * vx + vy * vy + g2 * w * w
    sums[patch, POWER], sums[patch, PUSH], sums[patch, LARGEST] = power, push, largest
    sums[patch, SPEED] = speed


@compiled
def halt(world, back, patch):
    """Move a patch over `back` (s) with its velocities before the kick, and take all off it."""
    bodies, angle, orientation = world.bodies, world.angle, world.orientation
    low, high = granules_of(bodies.shape[0], patch)
    for i in range(low, high):
        for c in range(2):
            bodies[i, X + c] += back * bodies[i, DVX + c]
            bodies[i, VX + c] = 0.0
        bodies[i, W] = 0.0
        if gyration(world, i) > 0.0:
            angle[i] += back * bodies[i, DW]
            rotate(orientation, i, angle[i], back * bodies[i, DW])


@compiled
def move(world, alpha, factor, dt, patch):
    """Turn the velocities of a patch towards the forces, v = (1 - alpha) v + factor F, and move it
    over dt (s)."""
    force, bodies, angle = world.force, world.bodies, world.angle
    orientation = world.orientation
    low, high = granules_of(bodies.shape[0], patch)
    for i in range(low, high):
        g2 = gyration(world, i)
        for c in range(2):
            bodies[i, VX + c] = (1.0 - alpha) * bodies[i, VX + c] + factor * force[i, FX + c]
            bodies[i, X + c] += dt * bodies[i, VX + c]
        if g2 > 0.0:
            bodies[i, W] = (1.0 - alpha) * bodies[i, W] + factor * force[i, TAU] / g2
            angle[i] += dt * bodies[i, W]
            rotate(orientation, i, angle[i], dt * bodies[i, W])
    place(world.shape, bodies, orientation, world.constituents, low, high)


@inlined
def total(sums, column):
    """The sum over all patches, in one order for any number of threads."""
    result = 0.0
    for patch in range(sums.shape[0]):
        result += sums[patch, column]
    return result


@inlined
def greatest_of(sums, column):
    """The greatest of all patches, NaN if one is."""
    largest = 0.0
    for patch in range(sums.shape[0]):
        largest = greater(largest, sums[patch, column])
    return largest


@inlined
def collect_patch(world, patch):
    """Forces on the granules of a patch from those on their constituents."""
    low, high = granules_of(world.bodies.shape[0], patch)
    collect(world.shape, world.constituent_force, world.orientation, world.force, low, high)


@compiled
def fire(world, memory, steps, goal, sums, thread):
    """Minimise the elastic energy until no net force exceeds goal.enough (N).

    memory: time step (s), alpha, number of steps downhill, all carried between calls, and
    the largest time step (s); sums: of each patch (patches, SUMS); thread: a
    dem.dynamics.threads.Place, or None. Returns iterations done, the largest displacement (m; 0 up
    to goal.list_range, beyond it the lists are too old) and the largest net force (N).
    """
    patches, count = world.patches, number_of_patches(world.bodies.shape[0])
    begin, end = share_of(thread, count)
    dt, alpha, downhill, longest = memory[0], memory[1], memory[2], memory[3]
    done, moved, largest = 0, 0.0, math.inf
    limit = goal.list_range * goal.list_range
    while True:
        # Kick the patches that waited for forces of others, all of them at first
        ahead = min(1.1 * dt, longest) if downhill + 1.0 > N_MIN else dt
        for patch in range(begin, end):
            if done == 0 or not knows_forces(patches, patch, begin):
                kick(world, ahead, patch, sums)
        barrier(thread)
        # Sums that all threads have; none is written before the next barrier
        power, push, speed = total(sums, POWER), total(sums, PUSH), total(sums, SPEED)
        largest = math.sqrt(greatest_of(sums, LARGEST))
        if largest <= goal.enough:
            break
        if power > 0.0:
            downhill += 1.0
            if downhill > N_MIN:
                dt = ahead
                alpha *= 0.99
        else:
            back = -0.5 * dt
            downhill, alpha = 0.0, ALPHA_START
            dt = max(0.5 * dt, 0.02 * longest)
            barrier(thread)  # now all threads have the sums
            for patch in range(begin, end):
                halt(world, back, patch)
                kick(world, dt, patch, sums)
            barrier(thread)
            speed = total(sums, SPEED)
        factor = alpha * math.sqrt(speed / push) if push > 0.0 else 0.0
        for patch in range(begin, end):
            move(world, alpha, factor, dt, patch)
            sums[patch, MOVED] = farthest_of(world, patch, limit)
        barrier(thread)
        moved = greatest_of(sums, MOVED)
        done += 1
        last = done == steps or not moved <= limit
        # Forces, and the next kick of patches that know all of theirs
        ahead = min(1.1 * dt, longest) if downhill + 1.0 > N_MIN else dt
        for patch in range(begin, end):
            pair_forces(world, 0.0, patch)
            if knows_forces(patches, patch, begin):
                add_forces_across_patches(world, patch)
                collect_patch(world, patch)
                if not last:
                    kick(world, ahead, patch, sums)
        barrier(thread)
        for patch in range(begin, end):
            if not knows_forces(patches, patch, begin):
                add_forces_across_patches(world, patch)
        barrier(thread)
        if leads(thread):
            boundary_forces(world, 0.0)
        barrier(thread)
        for patch in range(begin, end):
            if not knows_forces(patches, patch, begin):
                collect_patch(world, patch)
        if last:
            break
    if leads(thread):
        memory[0], memory[1], memory[2] = dt, alpha, downhill
    return done, math.sqrt(moved), largest


class Goal(NamedTuple):
    """When a bed is at rest, and how it gets there.

    Attributes
    ----------
    enough : float
        Greatest net force (N) on a granule at rest.
    list_range : float
        Displacement (m) after which lists are made again.
    least : float
        Smallest overlap (m) that the stiffness of a contact is computed for.
    fraction : float
        Largest time step over the bound on the critical one, without unit.
    alone : float
        Largest time step (s) of a granule that has one contact of that overlap.
    """

    enough: float
    list_range: float
    least: float
    fraction: float
    alone: float


@compiled(allocates=True)
def settle(world, table, goal, memory, left, sums, threads):
    """Minimise, with lists kept up to date; at most PIECE of the iterations that are `left`.

    memory: that of `fire`, zeros at first. threads: None, or dem.dynamics.threads.Threads; this
    function then runs as it is written, uncompiled. Returns the world, the iterations still left,
    the greatest net force (N), the number of pairs of constituents that touch, the greatest overlap
    over the smaller radius and a constituent that has it. Once the bed is at rest or no iteration
    is left, the forces on walls and solids are those of now, and contacts are counted.
    """
    begins = memory[0] == 0.0
    if begins:
        world = rebuild_neighbor_list(world, table)
        if left > 0:
            forces(world, 0.0, math.inf)
            memory[0], memory[1] = math.inf, ALPHA_START
    if left > 0 and (begins or goal.fraction > STEP):  # a longer step is guarded in every call
        memory[3] = min(goal.fraction * critical_step(world, table, goal.least), goal.alone)
        memory[0] = min(memory[0], 0.1 * memory[3] if begins else memory[3])
    pause = max(left - PIECE, 0)
    largest = math.inf
    while left > pause and not largest <= goal.enough:
        if threads is None:
            done, moved, largest = fire(world, memory, left - pause, goal, sums, None)
        else:
            done, moved, largest = threads.together(fire, world, memory, left - pause, goal, sums)
        left -= max(done, 1)
        if not moved <= goal.list_range:
            if not math.isfinite(moved):
                left = 0
                break
            world = rebuild_neighbor_list(world, table)
    touching, overlap, deepest = 0, 0.0, 0
    if left == 0 or largest <= goal.enough:
        touching, overlap, deepest = contact_summary(world, table)
        forces(world, 0.0, math.inf)
    return world, left, largest, touching, overlap, deepest


class Minimum(NamedTuple):
    """A bed after its minimisation.

    Attributes
    ----------
    world : World
        Its arrays, with the forces on walls and solids; granules in the order of memory.
    order : ndarray of shape (n,)
        Number of each granule of the world.
    net_force : float
        Greatest net force on a granule (N); infinite if no iteration was allowed.
    enough : float
        That of a bed at rest (N).
    touching : int
        Number of pairs of constituents that touch.
    max_overlap : float
        Greatest overlap over the smaller radius, without unit.
    deepest : int
        A granule that has it.
    """

    world: World
    order: np.ndarray
    net_force: float
    enough: float
    touching: int
    max_overlap: float
    deepest: int

    @property
    def state(self) -> State:
        """Places and angles of granules, at rest."""
        back = np.argsort(self.order)
        return State(self.world.bodies[back, :2], angle=self.world.angle[back])


def minimise(scene, state, iterations, enough=None, job=None):
    """Minimise until no net force exceeds `enough` (N), or in so many iterations.

    Without `enough`, until the bed is at rest: REST, in a bed of several patches SHARE_OF_CONTACT
    of the mean contact force if that is more. The time step is stable at overlaps of 2 % of the
    radius; in a bed of several patches it is longer, and bounded by the overlaps of every PIECE of
    iterations. Raises PackingError if a position becomes infinite.
    """
    job = job or Job()
    stopped, state = job.stopped(), state.checked(scene.granules)
    order = stopped["order"] if stopped else order_of(scene, state)
    scene, state = ordered(scene, state, order)
    table = granule_table(scene, SKIN_OF_PACKING)
    world, memory, left = assemble(scene, state, table), np.zeros(4), iterations
    if stopped:
        world, memory = replaced(world, stopped, "world"), stopped["memory"]
        left = int(stopped["left"])
        if table.alone:  # a granule is its own only constituent: one array for both
            world = world._replace(constituents=world.bodies, force=world.constituent_force)
    radius, modulus = table.radius.mean(), table.modulus
    unit, large = scene.law.scale(modulus, radius) * radius, scene.granules > PATCH
    least = 0.02 * radius
    light = np.max(1.0 / scene.mass + scene.shape.normal_lever**2 / scene.inertia)
    squared_rate = 4.0 * stiffest(table.law, modulus, radius, least) * light
    fraction = LONGER_STEP if large else STEP
    goal = Goal(
        enough=REST * unit if enough is None else enough,
        list_range=0.45 * table.skin,
        least=least,
        fraction=fraction,
        alone=fraction / STEP / math.sqrt(squared_rate),
    )
    patches = number_of_patches(scene.granules)
    sums, size = rows(patches, SUMS), min(job.threads, patches)
    run = settle if size == 1 else settle.py_func
    try:
        with nullcontext() if size == 1 else Threads(size) as threads:
            while True:
                if large and enough is None and memory[0] > 0.0:
                    force = list_contacts(world, order).force
                    share = SHARE_OF_CONTACT * force.mean() if len(force) else 0.0
                    bound = np.clip(share, REST * unit, MOST_REST * unit)
                    goal = goal._replace(enough=float(bound))
                before = left
                with signals_deferred():
                    world, left, *rest = run(world, table, goal, memory, left, sums, threads)
                if not np.isfinite(world.bodies).all():
                    raise PackingError("a position became infinite while the bed was relaxed.")
                kept = {"world": world, "order": order, "memory": memory, "left": left}
                job.reached(before - left, rest[0] / unit, **kept)
                if left == 0 or rest[0] <= goal.enough:
                    break
    except KeyboardInterrupt:
        job.save()
        raise
    net_force, touching, overlap, deepest = rest
    deepest = int(order[world.shape.owner[deepest]])
    return Minimum(world, order, net_force, goal.enough, touching, overlap, deepest)
