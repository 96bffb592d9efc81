"""Bring a frictionless bed to rest: minimise its elastic energy by FIRE.

FIRE (Bitzek et al. 2006, Phys. Rev. Lett. 97, 170201, with the corrections of Guenole et al. 2020,
Comput. Mater. Sci. 175, 109584) is mechanics with a bias: velocities turn towards the forces, and
the bed stops whenever it moves uphill. The forces are as in a run without friction and damping.
The radius of gyration puts torques and spins on the scale of forces and speeds.

An iteration goes over the bed twice, patch by patch as a run does (dem.dynamics.step): forces
and kicks, then moves. A kick does not wait for the sum that tells whether the bed moves uphill. If it
does, which is rare, the kick is taken back.
"""

import math
from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from dem.base.errors import PackingError
from dem.contacts.layout import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, aligned
from dem.dynamics.assembly import assemble, order_of
from dem.dynamics.checkpoint import restored
from dem.dynamics.contact_output import list_contacts
from dem.dynamics.forces import (
    FORCES,
    RESPOND,
    SHOW,
    add_forces_across_patches,
    clear_boundaries,
    clear_patch,
    contact_forces,
    knows_forces,
    sum_held_forces,
)
from dem.dynamics.motion import collect, farthest_of, greater, is_beyond, place, rotate
from dem.dynamics.scan import CRITICAL, DEEP_CONSTITUENT, DEEPEST, TOUCHING
from dem.dynamics.skin import SKIN_OF_PACKING, bounded_skin
from dem.dynamics.step import STEPS, Place, Threads, share_of
from dem.dynamics.system import System
from dem.dynamics.world import PATCH, SECTIONS, WALLS, World, granules_of, number_of_patches
from dem.jit.interrupts import signals_deferred
from dem.jit.intrinsics import barrier, noinline, widest_vectors
from dem.laws.protocol import stiffest
from dem.packing.job import Job
from dem.scene import State

# What a kernel has: dem.dynamics.kinds
TURNS = ROTATES = COMPOSED = True

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


def gyration(granules, i):
    """Inertia over mass (m2), which puts torques and spins on the scale of forces and speeds; 0 if
    granule i does not turn."""
    if TURNS and granules.inverse_inertia[i] > 0.0:
        return granules.inverse_mass[i] / granules.inverse_inertia[i]
    return 0.0


def kick(granules, dt, patch, sums):
    """Change the velocities of a patch by the forces over dt (s), and sum up.

    The velocities before are kept in the columns of which only dashpots take notice.
    """
    noinline()
    widest_vectors()
    force, motion = granules.force, granules.motion
    inverse_mass, inverse_inertia = granules.inverse_mass, granules.inverse_inertia
    low, high = granules_of(granules.angle.shape[0], patch)
    power, push, largest, speed = 0.0, 0.0, 0.0, 0.0
    for number in range(low, high):
        i = np.uint64(number)
        g2 = gyration(granules, i)
        fx, fy, torque = force[i, FX], force[i, FY], force[i, TAU]
        vx, vy, w = motion[i, VX], motion[i, VY], motion[i, W]
        power += fx * vx + fy * vy + torque * w
        f2 = fx * fx + fy * fy
        push += f2
        if g2 > 0.0:
            push += torque * torque / g2
            f2 = max(f2, torque * torque / g2)
        largest = greater(largest, f2)  # NaN is not at rest
        motion[i, DVX], motion[i, DVY], motion[i, DW] = vx, vy, w
        vx += dt * fx * inverse_mass[i]
        vy += dt * fy * inverse_mass[i]
        if TURNS:
            w += dt * torque * inverse_inertia[i]
        motion[i, VX], motion[i, VY], motion[i, W] = vx, vy, w
        speed += vx * vx + vy * vy + g2 * w * w
    sums[patch, POWER], sums[patch, PUSH], sums[patch, LARGEST] = power, push, largest
    sums[patch, SPEED] = speed


def halt(granules, orientation, back, patch):
    """Move a patch over `back` (s) with its velocities before the kick, and take all off it."""
    noinline()
    motion, angle = granules.motion, granules.angle
    low, high = granules_of(angle.shape[0], patch)
    for i in range(low, high):
        for c in range(2):
            motion[i, X + c] += back * motion[i, DVX + c]
            motion[i, VX + c] = 0.0
        motion[i, W] = 0.0
        if gyration(granules, i) > 0.0:
            angle[i] += back * motion[i, DW]
            if ROTATES:
                rotate(orientation, i, angle[i], back * motion[i, DW])


def move(granules, constituents, alpha, factor, dt, limit, patch):
    """Turn the velocities of a patch towards the forces, v = (1 - alpha) v + factor F, and move it
    over dt (s). Returns how many constituents are `is_beyond` a limit."""
    noinline()
    widest_vectors()
    force, motion, angle = granules.force, granules.motion, granules.angle
    orientation, reference, beyond = constituents.orientation, constituents.reference, 0
    low, high = granules_of(angle.shape[0], patch)
    for number in range(low, high):
        i = np.uint64(number)
        g2 = gyration(granules, i)
        for c in range(2):
            motion[i, VX + c] = (1.0 - alpha) * motion[i, VX + c] + factor * force[i, FX + c]
            motion[i, X + c] += dt * motion[i, VX + c]
        if g2 > 0.0:
            motion[i, W] = (1.0 - alpha) * motion[i, W] + factor * force[i, TAU] / g2
            angle[i] += dt * motion[i, W]
            if ROTATES:
                rotate(orientation, i, angle[i], dt * motion[i, W])
        if not COMPOSED:
            beyond += is_beyond(motion, reference, i, limit)
    if COMPOSED:
        beyond = place(motion, constituents, low, high, limit)
    return beyond


def total(sums, column):
    """The sum over all patches, in one order for any number of threads."""
    result = 0.0
    for patch in range(sums.shape[0]):
        result += sums[patch, column]
    return result


def greatest_of(sums, column):
    """The greatest of all patches, NaN if one is."""
    largest = 0.0
    for patch in range(sums.shape[0]):
        largest = greater(largest, sums[patch, column])
    return largest


def collect_patch(granules, constituents, patch):
    """Forces on the granules of a patch from those on their constituents."""
    if COMPOSED:
        low, high = granules_of(granules.angle.shape[0], patch)
        collect(granules.force, constituents, low, high)


def fire(world, task, enough, dt, steps, list_range, rows, descent):
    """As dem.dynamics.step.advance, where STEPS minimise the elastic energy until no net force exceeds
    `enough` (N), and nothing drifts.

    descent: see Descent, which has the step too. Returns iterations done, and the largest displacement
    (m; 0 up to list_range, beyond it the lists are too old).
    """
    granules, constituents, patches = world.granules, world.constituents, world.patches
    lowest, blocks, n = patches.lowest, world.contacts.first, granules.angle.shape[0]
    thread, memory, sums = descent.place, descent.memory, descent.sums
    lanes, arrivals, size = thread.lanes, thread.arrivals, thread.size
    begin, end = share_of(thread, lowest.shape[0])
    if task in (SHOW, RESPOND):
        contact_forces(world, task, steps, steps + rows.shape[0], 0.0, lanes, rows)
        return 0, 0.0
    dt, alpha, downhill, longest = memory[0], memory[1], memory[2], memory[3]
    done, moved, largest = 0, 0.0, math.inf
    limit = list_range * list_range
    while True:
        if task == STEPS:
            # Kick the patches that waited for forces of others, all of them at first
            ahead = min(1.1 * dt, longest) if downhill + 1.0 > N_MIN else dt
            for patch in range(begin, end):
                if done == 0 or not knows_forces(lowest, patch, begin):
                    kick(granules, ahead, patch, sums)
            barrier(arrivals, size)
            # Sums that all threads have; none is written before the next barrier
            power, push, speed = total(sums, POWER), total(sums, PUSH), total(sums, SPEED)
            largest = math.sqrt(greatest_of(sums, LARGEST))
            if largest <= enough:
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
                barrier(arrivals, size)  # now all threads have the sums
                for patch in range(begin, end):
                    halt(granules, constituents.orientation, back, patch)
                    kick(granules, dt, patch, sums)
                barrier(arrivals, size)
                speed = total(sums, SPEED)
            factor = alpha * math.sqrt(speed / push) if push > 0.0 else 0.0
            for patch in range(begin, end):
                beyond = move(granules, constituents, alpha, factor, dt, limit, patch)
                sums[patch, MOVED] = farthest_of(constituents, patch) if beyond > 0 else 0.0
            barrier(arrivals, size)
            moved = greatest_of(sums, MOVED)
        elif COMPOSED:
            place(granules.motion, constituents, 0, n, 0.0)
        done += 1
        last = done >= steps or not moved <= limit
        # Forces, and the next kick of patches that know all of theirs
        ahead = min(1.1 * dt, longest) if downhill + 1.0 > N_MIN else dt
        for patch in range(begin, end):
            low, high = world.contacts.of_patch[patch], world.contacts.of_patch[patch + 1]
            clear_patch(constituents, patch)
            contact_forces(world, FORCES, low, high, 0.0, lanes, rows)
            if knows_forces(lowest, patch, begin):
                add_forces_across_patches(constituents, patches, patch)
                collect_patch(granules, constituents, patch)
                if not last:
                    kick(granules, ahead, patch, sums)
        barrier(arrivals, size)
        for patch in range(begin, end):
            if not knows_forces(lowest, patch, begin):
                add_forces_across_patches(constituents, patches, patch)
        barrier(arrivals, size)
        if thread.number == 0:
            clear_boundaries(world.boundaries)
            contact_forces(world, FORCES, blocks[WALLS], blocks[SECTIONS], 0.0, lanes, rows)
            sum_held_forces(constituents, world.held, world.boundaries)
        barrier(arrivals, size)
        for patch in range(begin, end):
            if not knows_forces(lowest, patch, begin):
                collect_patch(granules, constituents, patch)
        if last:
            break
    if thread.number == 0 and task == STEPS:
        memory[0], memory[1], memory[2], memory[4] = dt, alpha, downhill, largest
    return done, math.sqrt(moved)


class Descent(NamedTuple):
    """A thread that minimises.

    Attributes
    ----------
    place : Place
        Which one it is, with its scratch memory.
    memory : ndarray of shape (5,)
        Time step (s), alpha, number of steps downhill, the largest time step (s), and the largest
        net force (N) that was seen last.
    sums : ndarray of shape (patches, SUMS)
        Of each patch.
    """

    place: Place
    memory: np.ndarray
    sums: np.ndarray


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


class Minimiser:
    """A bed on its way to rest.

    Attributes
    ----------
    system : System
        Its arrays and kernels.
    goal : Goal
        When it is at rest.
    memory : ndarray of shape (5,)
        See Descent, zeros at first.
    left : int
        Iterations that are left.
    """

    def __init__(self, system: System, skin: float, goal: Goal, left: int, threads: int):
        self.system, self.skin, self.goal, self.left = system, skin, goal, left
        self.memory = np.zeros(5)
        patches = number_of_patches(len(system.world.granules.angle))
        self.sums, self.threads = aligned(patches, SUMS), min(threads, patches)
        system.place = self.descent(system.place)

    def descent(self, place) -> Descent:
        """The place of a thread, with what all share."""
        return Descent(place, self.memory, self.sums)

    def begin(self) -> None:
        """Lists and forces at the start."""
        self.system.rebuild(self.skin)
        if self.left > 0:
            self.system.forces(0.0)
            self.memory[:2] = math.inf, ALPHA_START

    def piece(self, threads: Threads | None) -> float:
        """At most PIECE of the iterations that are left; returns the greatest net force (N)."""
        goal, memory, begins = self.goal, self.memory, self.memory[0] == 0.0
        if begins:
            self.begin()
        if self.left > 0 and (begins or goal.fraction > STEP):  # a longer step is guarded each time
            memory[3] = min(goal.fraction * self.critical_step(), goal.alone)
            memory[0] = min(memory[0], 0.1 * memory[3] if begins else memory[3])
        pause, largest = max(self.left - PIECE, 0), math.inf
        while self.left > pause and not largest <= goal.enough:
            given = goal.enough, 0.0, self.left - pause, goal.list_range
            done, moved = self.system.advance(*given, threads)
            largest = float(memory[4])
            self.left -= max(done, 1)
            if not moved <= goal.list_range:
                if not math.isfinite(moved):
                    self.left = 0
                    break
                self.system.rebuild(self.skin)
        return largest

    def critical_step(self) -> float:
        """Critical time step (s) of the contacts; near pairs count with an overlap."""
        return float(self.system.scan(least=self.goal.least)[CRITICAL])


class Minimum(NamedTuple):
    """A bed after its minimisation.

    Attributes
    ----------
    system : System
        Its arrays, with the forces on walls and solids; granules in the order of memory.
    order : ndarray of shape (n,)
        Number of each granule of the world.
    net_force : float
        Greatest net force on a granule (N); infinite if no iteration was allowed.
    enough : float
        Net force (N) below which a bed is at rest.
    touching : int
        Number of pairs of constituents that touch.
    max_overlap : float
        Greatest overlap over the smaller radius, without unit.
    deepest : int
        A granule that has it.
    """

    system: System
    order: np.ndarray
    net_force: float
    enough: float
    touching: int
    max_overlap: float
    deepest: int

    @property
    def world(self) -> World:
        """The arrays."""
        return self.system.world

    @property
    def state(self) -> State:
        """Places and angles of granules, at rest."""
        back = np.argsort(self.order)
        return State(self.world.bodies[back, :2], angle=self.world.granules.angle[back])


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
    system = assemble(scene, state, order, work=fire)
    table = system.table
    skin = bounded_skin(scene, table, SKIN_OF_PACKING)
    radius, modulus = table.radius.mean(), table.modulus
    law = system.world.law
    unit, large = scene.law.scale(modulus, radius) * radius, scene.granules > PATCH
    least = 0.02 * radius
    light = np.max(1.0 / scene.mass + scene.shape.normal_lever**2 / scene.inertia)
    squared_rate = 4.0 * stiffest(law, modulus, radius, least) * light
    fraction = LONGER_STEP if large else STEP
    goal = Goal(
        enough=REST * unit if enough is None else enough,
        list_range=0.45 * skin,
        least=least,
        fraction=fraction,
        alone=fraction / STEP / math.sqrt(squared_rate),
    )
    minimiser = Minimiser(system, skin, goal, iterations, job.threads)
    if stopped:
        system.world = restored(system, stopped)
        minimiser.memory[:], minimiser.left = stopped["memory"], int(stopped["left"])
    try:
        with nullcontext() if minimiser.threads == 1 else Threads(minimiser.threads) as threads:
            if threads is not None:
                threads.places = [*map(minimiser.descent, threads.places)]
            while True:
                if large and enough is None and minimiser.memory[0] > 0.0:
                    force = list_contacts(minimiser.system, order).force
                    share = SHARE_OF_CONTACT * force.mean() if len(force) else 0.0
                    most = np.clip(share, REST * unit, MOST_REST * unit)
                    minimiser.goal = goal = goal._replace(enough=float(most))
                before = minimiser.left
                with signals_deferred():
                    net_force = minimiser.piece(threads)
                world = minimiser.system.world
                if not np.isfinite(world.bodies).all():
                    raise PackingError("a position became infinite while the bed was relaxed.")
                kept = {"world": world, "order": order}
                kept |= {"memory": minimiser.memory, "left": minimiser.left}
                job.reached(before - minimiser.left, net_force / unit, **kept)
                if minimiser.left == 0 or net_force <= goal.enough:
                    break
    except KeyboardInterrupt:
        job.save()
        raise
    system = minimiser.system
    result = system.scan(steps=False)
    system.forces(0.0)
    return Minimum(
        system=system,
        order=order,
        net_force=net_force,
        enough=goal.enough,
        touching=int(result[TOUCHING]),
        max_overlap=float(result[DEEPEST]),
        deepest=int(order[system.world.constituents.owner[int(result[DEEP_CONSTITUENT])]]),
    )
