"""A bed near rest as a linear system, and the step at which its motions begin to grow.

The limit belongs to the scheme itself: velocity Verlet with a dashpot that sees the velocity at
full steps, by an acceleration extrapolated from the last two.
"""

import math

import numpy as np

from dem.dynamics.checkpoint import copied
from dem.dynamics.simulation import Simulation
from dem.experiment.replicate import Replicate
from dem.sweep.config import Sweep
from studies.stability.catalogue import Changes
from studies.stability.scenes import changed

NUDGE = 1e-9  # by which granules are moved, over the size of the bed
SLOW = 1e6  # s: a step over which such a move is so slow that dashpots do not count


def small(sweep: Sweep, shape: str, granules: int, change: Changes) -> Replicate:
    """The first replicate of a shape, changed, with fewer granules in a box as much smaller."""
    share = math.sqrt(granules / sweep.shapes[shape].granules)
    if share >= 1.0:
        return changed(sweep, shape, change)
    smaller = {
        f"shapes.{shape}.granules": granules,
        "box_width": share * sweep.box_width,
        "cylinder.diameter": share * sweep.cylinder.diameter,
        "cylinder.stroke": share * sweep.cylinder.stroke,
        "record.window": [share * end for end in sweep.record.window],
    }
    return changed(sweep, shape, change, smaller)


class Nudged:
    """Forces on a bed whose granules are moved a little or given velocities; contacts stick."""

    def __init__(self, simulation: Simulation):
        system, scene = simulation.engine.observe()[0], simulation.scene
        self.system = system.with_world(copied(system.world))
        self.world = world = self.system.world
        self.size = math.sqrt((scene.inertia / scene.mass).mean())  # m: makes turns lengths
        self.unit = NUDGE * world.bodies[:, :2].max()
        self._table = world.contacts.table.copy()
        self._place, self._angle = world.bodies.copy(), world.granules.angle.copy()

    def push(self, moved, velocity, dt):
        """Forces and torques (n, 3) on granules moved so far (m, rad), at such velocities."""
        world, bodies = self.world, self.world.bodies
        world.contacts.table[:] = self._table  # what contacts remember
        bodies[:] = self._place
        bodies[:, :2] += moved[:, :2]
        bodies[:, 2:5] = velocity
        turned = self._angle + moved[:, 2]
        orientation = world.constituents.orientation[: len(turned), :2]
        orientation[:] = np.column_stack([np.cos(turned), np.sin(turned)])
        self.system.forces(dt)
        return world.force[:, :3] / [1.0, 1.0, self.size]


def matrices(simulation: Simulation):
    """Mass-weighted stiffness (3n, 3n) in 1/s2 and damping (3n, 3n) in 1/s of a frictional bed.

    Each granule is moved and turned in turn; the slip of that motion is fed to the tangential
    springs as a velocity over a step of SLOW. Velocities that no step follows leave the springs as
    they are, and give the dashpots alone.
    """
    bed, scene = Nudged(simulation), simulation.scene
    n, h = scene.granules, bed.unit
    still, stiffness, damping = np.zeros((n, 3)), [], []
    for unit in np.eye(3 * n):
        d = h * unit.reshape(n, 3) / [1.0, 1.0, bed.size]
        moved = bed.push(-d, -d / SLOW, SLOW) - bed.push(d, d / SLOW, SLOW)
        fast = 1e3 * d
        slowed = bed.push(still, -fast, 0.0) - bed.push(still, fast, 0.0)
        stiffness.append(moved.ravel() / (2.0 * h))
        damping.append(slowed.ravel() / (2e3 * h))
    mass = np.column_stack([scene.mass] * 2 + [scene.inertia / bed.size**2]).ravel()
    weight = np.sqrt(np.outer(mass, mass))
    return np.array(stiffness).T / weight, np.array(damping).T / weight


def growth(stiffness, damping, dt: float) -> float:
    """Greatest factor by which a small motion grows in one step of dt (s)."""
    k, c = dt**2 * stiffness, dt * damping
    push = np.hstack([-k, -c, -c, 0.5 * c])  # of displacement, last step, last changes of step
    place, keep, last, _ = np.split(np.eye(4 * len(k)), 4)
    step = np.vstack([place + keep + push, keep + push, push, last])
    return float(np.abs(np.linalg.eigvals(step)).max())


def limit(stiffness, damping, start: float, grown: float) -> float:
    """The step (s), to 1 %, from which motions grow by more than `grown`; start: one where none
    does."""
    low, high = start, 2.0 * start
    while growth(stiffness, damping, high) <= grown:
        low, high = high, 2.0 * high
    while high > 1.01 * low:
        middle = math.sqrt(low * high)
        if growth(stiffness, damping, middle) <= grown:
            low = middle
        else:
            high = middle
    return low
