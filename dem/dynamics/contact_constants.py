"""Constants of all contacts of a list, by the law, the materials, the sizes and the masses."""

import math

import numpy as np

from dem.contacts.effective import effective_radius
from dem.contacts.layout import BLOCK, NUMBERS, PARTNER, TARGET
from dem.contacts.response import rolling_stiffness
from dem.dynamics.world import (
    ALPHA,
    COULOMB,
    INVERSE_MASS,
    MODULUS,
    PAIR_CONSTANTS,
    PAIRS,
    SECTIONS,
    SHARE,
    WALLS,
    friction_of,
)
from dem.jit.intrinsics import noinline
from dem.laws.protocol import length, stiffness


def put(table, p, column, value):
    """Write a column of contact p, unless the scene lacks it."""
    if column >= 0:
        table[p + column] = value


def inverse_masses_driven(boundaries, b):
    """Inverse mass (1/kg) of boundary b along x and y, and inverse inertia (1/(kg m2)) unless round."""
    drive, turns = boundaries.drive, 0.0
    if b < boundaries.reach.shape[0] and boundaries.reach[b] > 0.0:
        turns = drive[b, INVERSE_MASS + 2]
    return drive[b, INVERSE_MASS], drive[b, INVERSE_MASS + 1], turns


def inverse_masses_of(world, g):
    """Inverse mass (1/kg) of granule g along x and y, and zero: its turning does not count in m*. If
    it is held, the values of its group."""
    b = world.held.group[g]
    if b >= 0:
        return inverse_masses_driven(world.boundaries, b)
    inverse = world.granules.inverse_mass[g]
    return inverse, inverse, 0.0


def effective_mass(held, mass, i, j):
    """Effective mass (kg) of a pair: a held one is infinitely heavy."""
    if held[i]:
        return mass[j]
    if held[j]:
        return mass[i]
    return mass[i] * mass[j] / (mass[i] + mass[j])


def set_friction(friction, at, row):
    """Constants of friction of a contact from its row of GranuleTable.pair_constants."""
    for c in range(PAIR_CONSTANTS - COULOMB):
        friction[at + c * BLOCK] = row[COULOMB + c]


def set_constants(law, layout, table, p, row, radii, mass, inverse_masses):
    """Constants of contact p from its row of GranuleTable.pair_constants, the radii of both bodies (m; zero of
    a flat one) and its effective mass m* (kg).

    inverse_masses: of both bodies, along x and y (1/kg), and inverse inertia (1/(kg m2)).
    """
    one, two = radii
    radius = effective_radius(one, two)
    constant = stiffness(law, row[MODULUS], radius)
    other = two if two > 0.0 else one
    put(table, p, layout.stiffness, row[MODULUS] if layout.local else constant)
    put(table, p, layout.length, length(law, row[SHARE], one, other, radius))
    reduced = mass if layout.local else mass * constant
    put(table, p, layout.dashpot, row[ALPHA] * math.sqrt(reduced))
    first, second = inverse_masses
    put(table, p, layout.mass_turn, mass * second[2])
    # where neither body yields or turns, the mass is m* itself
    both = first[0] + second[0]
    put(table, p, layout.mass_x, mass * both if both + second[2] > 0.0 else 1.0)
    both = first[1] + second[1]
    put(table, p, layout.mass_y, mass * both if both + second[2] > 0.0 else 1.0)


def set_rolling(law, layout, table, p, coefficient, ratio, radii, square):
    """Rolling resistance of contact p: its coefficient, the damping ratio, both radii (m).

    square: mass times radius squared (kg m2), of both bodies as of two springs in a row; 3/2 of it
    is I_r, about the contact.
    """
    arm = coefficient * effective_radius(radii[0], radii[1])
    table[p + layout.arm] = arm
    constant = rolling_stiffness(law, arm, table[p + layout.stiffness])
    table[p + layout.rolling_dashpot] = 2.0 * ratio * math.sqrt(1.5 * square * constant)


def fill_constants(world, bed, layout):
    """Constants of all contacts of the list of a bed (dem.dynamics.assembly.GranuleTable)."""
    noinline()
    contacts, owner, law = world.contacts, world.constituents.owner, world.law
    numbers, table, radius, mass = contacts.numbers, contacts.table, bed.radius, bed.mass
    friction = contacts.friction
    inverse_mass = world.granules.inverse_mass
    if friction.shape[0] > 0 and contacts.alike:
        for lane in range(BLOCK):
            set_friction(friction, lane, bed.pair_constants[0, 0])
    for section in range(PAIRS, SECTIONS):
        for block in range(contacts.first[section], contacts.first[section + 1]):
            at, base = NUMBERS * np.uint64(block), layout.stride * block
            friction_at = np.int64(friction_of(contacts, block))
            for lane in range(contacts.count[block]):
                k = np.uint64(lane)
                p, i = base + lane, np.int64(numbers[at + k])
                g = owner[i]
                first = inverse_masses_of(world, g)
                if section == PAIRS:
                    j = np.int64(numbers[at + PARTNER + k])
                    h = owner[j]
                    second, radii = inverse_masses_of(world, h), (radius[i], radius[j])
                    m = effective_mass(bed.held, mass, i, j)
                    row = bed.pair_constants[bed.species[h], bed.species[g]]
                    turned = inverse_mass[g] / radius[i] ** 2 + inverse_mass[h] / radius[j] ** 2
                    square, kind = 1.0 / turned if turned > 0.0 else 0.0, 0
                else:
                    b = world.faces.boundary[np.int64(numbers[at + TARGET + k])]
                    second, m = inverse_masses_driven(world.boundaries, b), mass[i]
                    radii, kind = (radius[i], bed.solid_radius[b]), 1 if section == WALLS else 2
                    row = bed.pair_constants[bed.pair_constants.shape[1] + b, bed.species[g]]
                    square = mass[i] * radius[i] ** 2
                inverse_masses = first, second
                set_constants(law, layout, table, p, row, radii, m, inverse_masses)
                if friction.shape[0] > 0 and friction_at > 0:
                    set_friction(friction, friction_at + lane, row)
                if layout.arm >= 0:
                    coefficient, ratio = bed.rolling[kind], bed.rolling[3]
                    set_rolling(law, layout, table, p, coefficient, ratio, radii, square)
