"""One call that simulates a scene, and returns its frames."""

import math
from typing import Any

import numpy as np
from pydantic import InstanceOf

from dem.base.errors import InputError
from dem.base.types import Time, checked
from dem.dynamics.numerics import (
    MAX_OVERLAP,
    STEP_FRACTION,
    Intervals,
    MaxOverlap,
    Skin,
    StepFraction,
    ThreadCount,
)
from dem.dynamics.result import Result, shares
from dem.dynamics.simulation import Simulation
from dem.dynamics.stepping import Schedule
from dem.jit.columns import X, Y
from dem.scene import ARRAYS, Scene, State

MOST_BYTES = 2**30  # of all frames


@checked
def simulate(
    scene: InstanceOf[Scene],
    state: InstanceOf[State],
    duration: Time,
    time_step: Time | None = None,
    frames: Intervals = 1,
    *,
    step_fraction: StepFraction = STEP_FRACTION,
    max_overlap: MaxOverlap = MAX_OVERLAP,
    skin: Skin | None = None,
    threads: ThreadCount = 1,
    allow_unstable: bool = False,
) -> Result:
    """Simulate a scene from a state and return arrays.

    Parameters
    ----------
    scene : Scene
        What is simulated: n granules, walls, solids.
    state : State
        Where the granules start, and how they move.
    duration : float
        Time to simulate (s).
    time_step : float, optional
        Time step (s); None, which is recommended, chooses it from the stiffness of the contacts.
    frames : int
        Number of equal intervals after each of which the state is kept (without unit). All frames
        together must fit into a gibibyte.
    step_fraction : float
        As in Simulation (without unit).
    max_overlap : float
        As in Simulation (without unit).
    skin : float, optional
        As in Simulation (without unit).
    threads : int
        As in Simulation (without unit).
    allow_unstable : bool
        As in Simulation.

    Returns
    -------
    Result
        The start and a frame per interval, frames + 1 in all.

    Raises
    ------
    InputError
        If a value cannot be used.
    RunError
        If the run fails: StateError or OverlapError.

    Examples
    --------
    Two discs collide in empty space and part at half their speed:

    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), dem.Material(restitution=0.5))
    >>> state = dem.State([[0, 0], [2.1e-3, 0]], velocity=[[1, 0], [-1, 0]])
    >>> result = dem.simulate(scene, state, duration=1e-4)
    >>> result.velocity[-1, :, 0].round(1)
    array([-0.5,  0.5])
    """
    run = Simulation(
        scene,
        state,
        time_step,
        step_fraction,
        max_overlap,
        skin,
        threads,
        allow_unstable=allow_unstable,
    )
    run.check_duration(duration)
    interval, shortest, first = duration / frames, math.inf, frame_of(run, math.nan)
    size = 8 * (frames + 1) * sum(map(np.size, first.values()))
    if size > MOST_BYTES:
        raise InputError(
            f"frames is {frames}; of {scene.granules} granules they fill {size / 2**30:.3g} GiB, "
            f"more than {MOST_BYTES / 2**30:g}: keep fewer, or advance a Simulation and save "
            "what you need."
        )
    series = {name: np.empty((frames + 1, *np.shape(value))) for name, value in first.items()}
    for frame in range(frames + 1):
        if frame:  # the last one ends at the duration itself, however many there are
            shortest = min(
                shortest,
                run.engine.advance(
                    "duration", Schedule(begin=duration * (frame / frames), intervals=1)
                ),
            )
        for name, value in (frame_of(run, interval) if frame else first).items():
            series[name][frame] = value
    optional: dict[str, Any] = {"held_force": None}
    return Result(**optional | series, state=run.state, time_step=shortest, scene=scene)


def frame_of(run: Simulation, interval: float) -> dict[str, Any]:
    """The simulation as it is, and the mean forces (N) since the frame before, an interval (s)
    ago."""
    world, state, scene = run.world, run.state, run.scene
    walls, solids, held = shares(scene, run.engine.take_impulses())
    _, place, _ = shares(scene, world.boundaries.motion)
    frame = {name: getattr(state, name) for name in ARRAYS} | {
        "time": run.time,
        "solid_force": (solids[:, :2] + solids[:, 2:4]) / interval,
        "solid_torque": solids[:, 4] / interval,
        "solid_position": place[:, [X, Y]],
        "solid_angle": world.boundaries.angle[len(walls) : len(walls) + len(solids)],
        "wall_force": walls[:, 0] / interval,
        "wall_tangential_force": walls[:, 3] / interval,
        "wall_offset": world.walls.planes[:, 2],
    }
    if world.held is not None:
        frame["held_force"] = held[:, :2] / interval
    return frame
