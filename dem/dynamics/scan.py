"""What a bed is asked for between steps: constants of its contacts, their energies, the critical time step."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.layout import (
    NUMBERS,
    PARTNER,
    TARGET,
    X,
    Y,
)
from dem.contacts.response import rolling_stiffness
from dem.contacts.springs import TINY as LEAST
from dem.dynamics.contact_constants import fill_constants
from dem.dynamics.critical_step import (
    add_contact,
    add_springs,
    body_of,
    boundary_of,
    constant_of,
    friction_ratios,
    shortest_steps,
    value_at,
)
from dem.dynamics.measures import (
    driven_acceleration,
    expected_speed,
    greatest_acceleration,
    kinetic,
    usual_overlap,
)
from dem.dynamics.motion import greater
from dem.dynamics.world import (
    PAIRS,
    SECTIONS,
    WALLS,
)
from dem.jit.intrinsics import noinline
from dem.laws.protocol import (
    attraction,
    attraction_energy,
    energy,
    force,
    measure,
)

# Rows of dem.contacts.layout that a scan reads
(
    ROW_OVERLAP,
    ROW_NX,
    ROW_NY,
    ROW_N1,
    ROW_T1,
    ROW_N2,
    ROW_T2,
    ROW_RADIUS,
    ROW_FORCE_X,
    ROW_FORCE_Y,
    ROW_ELASTIC,
    ROWS,
) = range(12)
# Of the result of a scan: pairs that touch, greatest overlap over the smaller radius, its
# constituent, critical time step (s) and the one to take, kinetic energy (J), bounds of speed (m/s)
# and of acceleration (m/s2), smallest overlap (m) that a stiffness is computed for
(TOUCHING, DEEPEST, DEEP_CONSTITUENT, CRITICAL, CHOSEN, KINETIC, SPEED, PUSH, LEAST_OVERLAP,
 RESULT) = range(10)  # fmt: skip


def scan_blocks(world, bed, layout, begin, geometry, bounds, result):
    """Add what the contacts of blocks from `begin` on do to the rows of bounds, where there are any, and
    to a result: how many pairs touch, the greatest overlap over the smaller radius, and its
    constituent.

    geometry: from dem.dynamics.forces.contact_forces. NaN is the greatest overlap.
    """
    noinline()
    contacts, motion, radius = world.contacts, world.constituents.motion, bed.radius
    numbers, table, limits = contacts.numbers, contacts.table, (result[LEAST_OVERLAP], bed.bulk)
    section = PAIRS
    for block in range(begin, begin + geometry.shape[0]):
        while block >= contacts.first[section + 1]:
            section += 1
        at, base = NUMBERS * np.uint64(block), layout.stride * block
        for lane in range(contacts.count[block]):
            k = np.uint64(lane)
            p, i, j = base + lane, np.int64(numbers[at + k]), np.int64(numbers[at + PARTNER + k])
            row = geometry[block - begin]
            overlap, nx, ny = row[ROW_OVERLAP, lane], row[ROW_NX, lane], row[ROW_NY, lane]
            if not overlap <= 0.0:
                smaller = min(radius[i], radius[j]) if section == PAIRS else radius[i]
                if section == PAIRS:
                    result[TOUCHING] += 1.0
                relative = overlap / smaller
                if not (relative <= result[DEEPEST] or result[DEEPEST] != result[DEEPEST]):
                    result[DEEPEST], result[DEEP_CONSTITUENT] = relative, i
            if bounds.shape[0] == 0:
                continue
            # the points are on the surfaces of both bodies, not in the middle of a gap
            outside = 0.5 * min(overlap, 0.0)
            n1, n2, t1 = row[ROW_N1, lane] + outside, row[ROW_N2, lane] + outside, row[ROW_T1, lane]
            one = body_of(world, bed, i, nx, ny, n1, t1)
            if section == PAIRS:
                two = body_of(world, bed, j, nx, ny, -n2, row[ROW_T2, lane])
            else:
                normal_arm, tangent_arm = 0.0, 0.0
                if section != WALLS:
                    dx, dy = motion[j, X] - motion[i, X], motion[j, Y] - motion[i, Y]
                    dx += value_at(table, p, layout.shift_x)
                    dy += value_at(table, p, layout.shift_y)
                    x, y = n1 * nx - t1 * ny - dx, n1 * ny + t1 * nx - dy
                    normal_arm, tangent_arm = x * ny - y * nx, x * nx + y * ny
                b = world.faces.boundary[np.int64(numbers[at + TARGET + k])]
                two = boundary_of(world, bed, b, normal_arm, tangent_arm)
            contact = overlap, nx, ny, row[ROW_RADIUS, lane]
            ratios = friction_ratios(contacts, block, lane)
            add_contact(world.law, layout, table, p, ratios, bounds, limits, contact, (one, two))


def add_energies(world, layout, begin, geometry, result):
    """Add normal, tangential and rolling elastic energies (J) of blocks from `begin` on to a result,
    and write the normal forces (N) of the law to a row of the geometry.

    A spring stores T^2 / (2 k_t).
    """
    contacts, table, law = world.contacts, world.contacts.table, world.law
    for k in range(geometry.shape[0]):
        base, block = layout.stride * (begin + k), geometry[k]
        for lane in range(contacts.count[begin + k]):
            p, gap = base + lane, block[ROW_OVERLAP, lane]
            overlap, second = max(gap, 0.0), value_at(table, p, layout.length)
            constant = constant_of(law, layout, table, p, block[ROW_RADIUS, lane])
            measured = measure(law, overlap, second)
            push = force(law, constant, overlap, measured)
            block[ROW_ELASTIC, lane] = push - attraction(law, gap, second)
            result[0] += energy(law, constant, overlap, measured)
            result[0] += attraction_energy(law, gap, second)
            last = value_at(table, p, layout.measure)
            stiff = friction_ratios(contacts, begin + k, lane)[0] * constant * last
            spring = value_at(table, p, layout.tangential_force)
            result[1] += 0.5 * spring**2 / max(stiff, LEAST)
            stiff = rolling_stiffness(law, value_at(table, p, layout.arm), constant) * last
            result[2] += 0.5 * value_at(table, p, layout.rolling_moment) ** 2 / max(stiff, LEAST)


CONSTANTS, SCAN, ENERGIES = range(3)  # what `scan` does


class Moment(NamedTuple):
    """When a bed is scanned.

    Attributes
    ----------
    later : float
        Kicks that velocities lack (s).
    frame : tuple of float
        Velocity (m/s) that is added to all for the energy.
    skin : float
        Skin of the lists (m).
    """

    later: float = 0.0
    frame: tuple[float, float] = (0.0, 0.0)
    skin: float = 0.0


def scan(world, bed, layout, task, moment, begin, geometry, bounds, result):
    """What is asked of the contacts of a list between steps, in one kernel for all scenes of a law.

    CONSTANTS: see dem.dynamics.contact_constants. SCAN, of blocks from `begin` on: see `scan_blocks`; with the
    first block also the measures of dem.dynamics.measures, at a Moment, and with the last one the
    critical step (s) and the one to take. ENERGIES: see `add_energies`.
    """
    if task == CONSTANTS:
        fill_constants(world, bed, layout)
        return
    if task == ENERGIES:
        add_energies(world, layout, begin, geometry, result)
        return
    skin, end = moment.skin, begin + geometry.shape[0]
    if begin == 0:
        energy, fastest = kinetic(world, layout.full, moment.later, moment.frame)
        speed = expected_speed(world, skin, fastest)
        push = greater(driven_acceleration(world.boundaries), greatest_acceleration(world, bed))
        result[KINETIC], result[PUSH] = energy, push
        result[SPEED] = math.sqrt(speed * speed + 2.0 * skin * push)
        if result[LEAST_OVERLAP] == 0.0:
            result[LEAST_OVERLAP] = usual_overlap(world.law, bed, speed)
    scan_blocks(world, bed, layout, begin, geometry, bounds, result)
    if bounds.shape[0] > 0 and end == world.contacts.first[SECTIONS]:
        add_springs(world.boundaries, world.granules.angle.shape[0], bounds)
        result[CRITICAL], result[CHOSEN] = shortest_steps(bounds, bed.fraction)
