"""Beds with a free surface: granules fall under gravity until they are at rest.

They start apart, as dem.packing.random leaves them far below jamming, and move by the dynamics of a
run (dem.dynamics.simulation) with their own masses and stiffness. The box is higher than the bed.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from dem.base.errors import OverlapError, PackingError, StateError
from dem.dynamics.assembly import modulus
from dem.dynamics.simulation import Simulation
from dem.material import Friction
from dem.packing.minimise import minimise
from dem.packing.random import finished, relaxed

PIECE = 3.0  # sqrt(diameter / gravity) between two looks
PIECES = 200  # at most
STILL = 1e-6  # of weight times diameter: mean kinetic energy of granules at rest


def come_to_rest(
    run: Simulation,
    gravity: float,
    still: float = STILL,
    save: Callable[[], None] = lambda: None,
    advance: Callable[[float], object] | None = None,
) -> tuple[float, float]:
    """Go on until the granules are at rest under gravity (m/s2), for a limited time.

    still: of weight times diameter, mean kinetic energy at rest; save: called while they are not;
    advance: what goes on by a time (s), `run.advance` if None.
    Returns their kinetic energy (J), and what it is at most at rest.
    """
    diameter = 2.0 * float(run.scene.shape.constituent_radius.mean())
    for _ in range(PIECES):
        (advance or run.advance)(PIECE * math.sqrt(diameter / gravity))
        enough = still * float(run.scene.mass[run.state.present].sum()) * gravity * diameter
        if (energy := run.diagnose().kinetic_energy) <= enough:
            break
        save()
    return energy, enough


def settle(shape, room, materials, friction, gravity, thickness, job):
    """A bed at rest under gravity (m/s2), with Coulomb's coefficient at all contacts while it settles.

    materials: those that Room.species numbers; thickness (m): of the granules out of the plane. Raises PackingError where they do not come to
    rest.
    """
    rough = Friction(friction, friction, friction)
    real = {"material": materials, "gravity": (0.0, -gravity), "thickness": thickness}
    real["law"] = room.law
    scene = replace(room.scene(shape, friction=rough), **real)
    diameter = 2.0 * float(shape.constituent_radius.mean())
    state = relaxed(shape, room, job).state
    try:
        run = Simulation(scene, state, threads=job.threads)
        kinetic_energy, enough = come_to_rest(run, gravity)
        if not kinetic_energy <= enough:
            raise PackingError(
                f"{room.name(shape)} is not at rest after {run.time:.3g} s under gravity: its kinetic "
                f"energy is {kinetic_energy:.2g} J, asked for {enough:.2g} J."
            )
    except (OverlapError, StateError) as error:
        raise PackingError(
            f"{room.name(shape)} cannot be made: while it settled, {error}"
        ) from None
    stiffness = max(modulus(scene, material, material) for material in materials)
    unit = scene.law.scale(stiffness, 0.5 * diameter) * 0.5 * diameter
    net_force = run.world.force[:, :2] + scene.gravity / run.world.granules.inverse_mass[:, None]
    net_force = float(np.hypot(*net_force.T).max() / unit)
    return finished(shape, room, minimise(room.scene(shape), run.state, 0), net_force)
