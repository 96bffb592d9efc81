"""Random beds of granules that swell in motion to a prescribed packing fraction.

Granules start as in dem.packing.random. They grow in the same steps, but after each step they move
by the dynamics of a run (dem.dynamics.simulation), without friction and with inelastic collisions.
At full size they move on until they are at rest. A bed below jamming then has granules apart from
each other, as shaking leaves them. A minimiser stops as soon as an overlap is gone, so it leaves
them just touching.
"""

import math
from typing import Any

import numpy as np

from dem.base.errors import OverlapError, PackingError, StateError
from dem.base.types import Length, checked
from dem.dynamics.numerics import OneOrMore
from dem.dynamics.simulation import Simulation
from dem.dynamics.world import World
from dem.material import Material
from dem.packing.job import Job
from dem.packing.random import (
    GROWTH,
    HERTZ,
    SETTLED,
    Bed,
    BedSeed,
    Room,
    at_rest,
    dilute_start,
)
from dem.periodic import Sides
from dem.scene import ContactLaw, Granules, State
from dem.solids import Solids

DAMPED = Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=0.5)
COARSE_STEP = 0.9  # of the bound on the critical time step: the motion need not be accurate
STAGE = 300.0  # sqrt(m / (E* R)): motion after each step of growth
KEPT = 0.5  # of all velocities, after a stage
STAGES = 100  # at full size, at most; what is jammed then moves little and is minimised


@checked
def grow(
    shape: Granules,
    width: Length,
    height: Length,
    solids: Solids,
    seed: BedSeed,
    periodic: Sides = "none",
    law: ContactLaw = HERTZ,
    threads: OneOrMore = 1,
    checkpoint: Any = None,
) -> Bed:
    """Pack granules at random into a box by growth in motion.

    Takes what `pack` takes. Beds above jamming are at rest by the same measure. Below jamming the
    granules of this bed are apart from each other. Those in beds of `pack` just touch and resist a
    solid sooner.

    Parameters
    ----------
    shape : Disc, Dumbbell, Ellipse, Superellipse, Clump or a shape of your own
        Granules, n in all, with their sizes (m).
    width : float
        Width of the box (m).
    height : float
        Height of the box (m).
    solids : Solid, sequence of Solid or None
        Solids that the granules leave room for. Their motion, friction and material are ignored.
    seed : int
        Seed of the random places and angles, without unit, zero or positive.
    periodic : str
        Along which sides the box repeats itself: "none", "x", "y" or "xy". There are no walls
        across these.
    law : Hertz, Linear, Line or a class of your own
        Law of contacts, as `Scene` takes it.
    threads : int
        Number of threads, as of `pack` (without unit).
    checkpoint : path, optional
        File that keeps the last minimisation, as of `pack`.

    Returns
    -------
    Bed
        The bed, with the net force and the pressure that remain in it.

    Raises
    ------
    PackingError
        If no bed at rest is found, usually because the packing fraction is too high.
    InputError
        If a value cannot be used, for instance if a solid does not fit into the box.

    See Also
    --------
    pack : Make a bed by minimising its energy, which is faster.

    Notes
    -----
    The granules start small and apart, and grow in steps of 2 %. After each step they move for
    300 sqrt(m / (E* R)) without friction, at a restitution of 0.5, and all velocities are halved.
    At full size they move on until no granule feels a net force above 1e-5 E* R^2. What is left of
    it is minimised as by `pack`, to 1e-9 E* R^2.

    Examples
    --------
    >>> import dem
    >>> import numpy as np
    >>> shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
    >>> cylinder = dem.Cylinder(diameter=2e-3, position=(4e-3, 3.6e-3))
    >>> room = dict(width=8e-3, height=7.6e-3, solids=cylinder, seed=1)
    >>> bed = dem.grow(shape, **room)
    >>> bool(bed.coordination_number < dem.pack(shape, **room).coordination_number)
    True
    """
    room, job = Room(width, height, solids, seed, periodic, law), Job(threads, checkpoint)
    job.begin("grow", shape, room)
    return grown(shape, room, job)


def grown(shape: Any, room: Room, job: Job) -> Bed:
    """`grow` in a room."""
    factor, state = dilute_start(shape, room)
    if "factor" in job.stage:
        return at_rest(shape, room, state, job)
    unit = room.unit(shape)
    try:
        while factor < 1.0:
            state, _ = _moved(room, shape.scaled(factor), state, job.threads)
            factor = min(factor * GROWTH, 1.0)
        for _ in range(STAGES):
            state, net_force = _moved(room, shape, state, job.threads)
            if net_force <= SETTLED * unit:
                break
    except (OverlapError, StateError) as error:
        raise PackingError(f"{room.name(shape)} cannot be made: while it grew, {error}") from None
    return at_rest(shape, room, State(state.position, angle=state.angle), job)


def greatest_force(world: World) -> float:
    """Largest net force (N) on a granule."""
    return float(np.linalg.norm(world.force[:, :2], axis=1).max())


def _moved(room: Room, shape: Any, state: State, threads: int) -> tuple[State, float]:
    """The State after one stage, with velocities reduced, and the largest net force (N)."""
    scene = room.scene(shape, DAMPED)
    run = Simulation(scene, state, step_fraction=COARSE_STEP, threads=threads)
    stiffness = room.law.scale(room.modulus, shape.constituent_radius.mean())  # as if SOFT
    run.advance(STAGE * math.sqrt(scene.mass.mean() / stiffness))
    end = run.state
    slower = State(end.position, KEPT * end.velocity, end.angle, KEPT * end.angular_velocity)
    return slower, greatest_force(run.world)
