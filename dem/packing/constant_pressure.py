"""Beds at a prescribed pressure: the top wall of a loose bed comes down until it bears that.

The granules keep their size, so the height of the box is a result. After every step down the
elastic energy is minimised without friction, as in dem.packing.random. Above jamming the pressure
to the power of 2/3 is nearly linear in the height under Hertz's law (see
dem.experiment.kinds.jamming), so a secant finds the height.
"""

import numpy as np

from dem.base.errors import PackingError
from dem.dynamics.world import PATCH
from dem.packing.cost import LONGEST
from dem.packing.minimise import minimise
from dem.packing.random import finished, relaxed
from dem.scene import State

STEP = 0.01  # of the height, at most, between two rests
STEPS = 100  # at most
FAR = 1e-3  # of the height: less tells no slope
NEAR = 1e-3  # of the pressure: how near it is met
PATIENCE = 20_000  # iterations between two steps
# of the force of the pressure on a granule: enough between two steps, and in beds of several patches
RESTING, RESTING_OF_LARGE = 1e-4, 3e-3


def pack_under(shape, room, pressure, job):
    """A bed at rest whose top wall bears a pressure, to one part in a thousand.

    The room has the height at which the bed is loose, before its top wall comes down; pressure:
    the force on the top wall over width and Room.modulus. Solids stay where they
    are; otherwise as dem.pack. Raises PackingError as dem.pack does, and where no height is found.
    """
    power = 1.0 / room.law.power
    resting = RESTING if len(shape.area) <= PATCH else RESTING_OF_LARGE
    near = resting * pressure * room.modulus * 2.0 * shape.constituent_radius.mean()
    seen, met = [], False  # heights (m), pressure over what is asked, to the power
    if "height" in job.stage:  # of a bed that was stopped; the job has the places of its granules
        seen, met = [(h, p) for h, p in job.stage["seen"]], bool(job.stage["met"])
        room = room._replace(height=float(job.stage["height"]))
        state = State(np.zeros((len(shape.area), 2)))
    else:
        state = relaxed(shape, room, job).state
    while len(seen) < STEPS:
        job.stage |= {"height": room.height, "met": met, "seen": np.array(seen).reshape(-1, 2)}
        iterations, enough = (LONGEST, None) if met else (PATIENCE, near)
        bed = minimise(room.scene(shape), state, iterations, enough, job)
        borne = float(
            bed.world.boundaries.contact_forces[len(bed.world.boundaries.planes) - 1, 0]
        ) / (room.modulus * room.width * pressure)
        polished, met = met, abs(borne - 1.0) < NEAR
        if polished and met:
            if not bed.net_force <= bed.enough:
                break
            return finished(shape, room, bed)
        seen.append((room.height, borne**power))
        # once more, until it is at rest as any other bed
        lower = room.height if met else _next(seen)
        state = bed.state
        state.position[:, 1] *= lower / room.height
        room = room._replace(height=lower)
    raise PackingError(
        f"no height of a box of {room.width:.3g} m was found in which the bed (seed {room.seed}) "
        f"is at rest under its pressure; at {room.height:.4g} m it bears {borne:.3g} of it."
    )


def _next(seen):
    """Height (m) to look at next, by a secant, at most STEP from the last one.

    The other point of the secant is the last point of opposite sign, which brackets the height.
    Without one it is the last point that is far enough away for a slope.
    """
    height, borne = seen[-1]
    across = [at for at in seen if (at[1] - 1.0) * (borne - 1.0) < 0.0]
    apart = [at for at in seen if abs(at[0] / height - 1.0) > FAR]
    before, less = (across or apart or [seen[-1]])[-1]
    change = -STEP if borne < 1.0 else STEP
    if (height - before) * (borne - less) < 0.0:
        slope = (borne - less) / (height - before)
        change = float(np.clip((1.0 - borne) / slope / height, -STEP, STEP))
    return height * (1.0 + change)
