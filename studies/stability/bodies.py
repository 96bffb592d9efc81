"""Experiments on a few granules in a box, one function each; see studies.stability.beds."""

import math
from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import Simulation
from dem.material import Friction
from dem.scene import State
from dem.solids import Cylinder
from studies.stability.scenes import (
    free,
    granules,
    half_width,
    material_of,
    scattered,
    set_free,
)
from studies.stability.watching import LOOKS, contact_time, hertz, momenta, unlisted, watch

ROOM = 2.05  # spacing of granules at the start, over the greatest bounding radius
SMALL = 0.05  # size of small granules over large ones
BETWEEN = 20e-6  # s, from look to look


def gas(sweep, shape, change) -> dict:
    """Granules without friction fly about in a box until they have met so many times."""
    some = granules(sweep, shape, 100, change, spread=0.2)
    side = 10 * ROOM * some.bounding_radius.max()
    scene, state = free(sweep, some, change, side), scattered(some, side, 1.0)
    simulation = set_free(scene, state, change)
    meeting = contact_time(scene, 1.8)  # m/s: mean relative speed
    collisions, residuals = 0.0, []
    while collisions < (change.collisions or 1000):
        record = simulation.record(10.0 * meeting, 50)
        # pairs in contact at a moment, over the duration of a collision, are collisions a second
        pairs = 0.5 * scene.granules * record.coordination_number
        collisions += 10.0 * pairs.sum()
        residuals.append(simulation.ledger().residual)
    return {"residual": np.max(residuals)}


def cluster(sweep, shape, change) -> dict:
    """Granules collide with friction and damping far from any wall: no momentum is made or lost.

    Angular momentum is that of whole steps: within one, what is seen conserves it to second order
    only.
    """
    some = granules(sweep, shape, 49, change, spread=0.2)
    side = 7 * ROOM * some.bounding_radius.max()
    scene = replace(free(sweep, some, change, side, friction=True), walls=None)
    state = scattered(some, side, 1.0)
    state.position = state.position - 0.5 * side  # angular momentum about the middle
    steps = math.ceil(BETWEEN / set_free(scene, state, change).diagnose().longest_time_step)
    simulation = Simulation(scene, state, BETWEEN / steps, ledger=True)  # seen at whole steps
    before, turning, _ = momenta(simulation)
    residuals, changes = [], []
    for _ in range(LOOKS):
        simulation.advance(BETWEEN)
        now, spin, sizes = momenta(simulation)
        changes += [np.abs(now - before).max() / sizes[0], abs(spin - turning) / sizes[1]]
        residuals.append(simulation.ledger().residual)
    return {"residual": np.max(residuals), "momentum": np.max(changes)}


def sizes(sweep, shape, change) -> dict:
    """Granules of 1/20 of the size fly about among large ones; is every touching pair listed?"""
    large, many = granules(sweep, shape, 9, change), granules(sweep, shape, 91, change)
    both = zip(large, many.scaled(SMALL), strict=True)
    mixed = type(large)(
        *(np.concatenate(pair) if isinstance(pair[0], np.ndarray) else pair[0] for pair in both)
    )
    reach = large.bounding_radius.max()
    side = 3.6 * ROOM * reach
    simulation = set_free(free(sweep, mixed, change, side), _among(9, 91, side, reach), change)
    missed, residuals = 0, []
    for _ in range(LOOKS):
        simulation.advance(BETWEEN)
        missed += unlisted(simulation.world)
        residuals.append(simulation.ledger().residual)
    return {"residual": np.max(residuals), "missed": missed}


def _among(large: int, small: int, side: float, reach: float) -> State:
    """Large granules on a square grid in a box (m), small ones anywhere clear of them."""
    rng, across = np.random.default_rng(2), math.isqrt(large)
    grid = (np.stack(np.divmod(np.arange(large), across), axis=1) + 0.5) * side / across
    place = list(grid)
    while len(place) < large + small:
        new = rng.uniform(0.05 * side, 0.95 * side, 2)
        clear = np.full(len(place), 3.0 * SMALL * reach)
        clear[:large] = (1.1 + SMALL) * reach
        if (np.linalg.norm(place - new, axis=1) > clear).all():
            place.append(new)
    n = large + small
    return State(np.array(place), rng.normal(size=(n, 2)), rng.uniform(0.0, 2.0 * math.pi, n))


def _two(sweep, shape, change, friction=False):
    """Two equal granules, and a large box for them."""
    two = granules(sweep, shape, 2, change)
    side = 40.0 * two.bounding_radius.max()
    return two, side, free(sweep, two, change, side, friction)


def overlapped(sweep, shape, change) -> dict:
    """Two granules that begin in each other, at rest, fly apart."""
    two, side, scene = _two(sweep, shape, change)
    deep = change.overlap * two.constituent_radius[0]
    apart = 2.0 * two.polygons(721)[0, ..., 0].max() - deep
    place = [[0.5 * side, 0.5 * side], [0.5 * side + apart, 0.5 * side]]
    simulation = set_free(scene, State(place), change)
    freed = simulation.ledger().held
    quantities = watch(simulation, 1e-6)
    return quantities | {"gained": max(simulation.ledger().held / freed - 1.0, 0.0)}


def concentric(sweep, shape, change) -> dict:
    """Two granules that begin at one place."""
    _, side, scene = _two(sweep, shape, change)
    state = State(np.full((2, 2), 0.5 * side), angle=[0.0, 0.7])
    return watch(set_free(scene, state, change), 1e-6)


def impact(sweep, shape, change) -> dict:
    """A head-on impact in which an elastic pair reaches a given overlap over the radius."""
    two, side, scene = _two(sweep, shape, change)
    radius, mass = two.constituent_radius[0], 0.5 * scene.mass[0]
    deepest = change.overlap * radius
    speed = math.sqrt(0.8 * hertz(scene, 0.5 * radius) * deepest**2.5 / mass)
    reach = 1.01 * two.bounding_radius[0]
    place = [[0.5 * side - reach, 0.5 * side], [0.5 * side + reach, 0.5 * side]]
    velocity = [[0.5 * speed, 0.0], [-0.5 * speed, 0.0]]
    simulation = set_free(scene, State(place, velocity), change)
    return watch(simulation, 8.0 * (deepest + reach) / speed / LOOKS)


def pinch(sweep, shape, change) -> dict:
    """The cylinder presses a granule against the upper wall, by `overlap` of its half width
    each."""
    one, half = granules(sweep, shape, 1, change), 0.5 * sweep.cylinder.diameter
    across = half_width(one)
    side, speed = 4.0 * (half + across), sweep.cylinder.velocity
    top, gap = side - 2.0 * across, 1e-6
    cylinder = Cylinder(sweep.cylinder.diameter, (0.5 * side, top - half - gap), (0.0, speed))
    scene = replace(
        free(sweep, one, change, side),
        friction=Friction(),
        solids=cylinder,
        material=material_of(sweep, change),
    )
    # off the cylinder's axis, so that the granule is pressed aside and slides
    state = State([[0.5 * side + 0.02 * across, side - across]])
    simulation = set_free(scene, state, change)
    return watch(simulation, (gap + 2.0 * change.overlap * across) / speed / LOOKS)


def graze(sweep, shape, change) -> dict:
    """Two granules pass each other, by an overlap from 1e-3 down to 1e-12 of the half width."""
    residuals, gains = [], [0.0]
    for overlap in (1e-3, 1e-6, 1e-9, 1e-12):
        two, side, scene = _two(sweep, shape, change, friction=True)
        run = 1.2 * two.bounding_radius[0]
        gap = (2.0 - overlap) * half_width(two)
        place = [[0.5 * side - run, 0.5 * side], [0.5 * side + run, 0.5 * side + gap]]
        simulation = set_free(scene, State(place, [[1.0, 0.0], [-1.0, 0.0]]), change)
        before = simulation.ledger().held
        residuals.append(watch(simulation, 2.0 * run / LOOKS)["residual"])
        gains.append(simulation.ledger().held / before - 1.0)
    return {"residual": np.max(residuals), "gained": max(gains)}
