"""`simulate`: from a state to a `Result`, in one call."""

import math
from typing import Any

import numpy as np

from dem.base.errors import InputError
from dem.base.validate import checked
from dem.dynamics.result import Result
from dem.dynamics.simulation import DURATION, LARGEST_OVERLAP, PIECES, STEP_FRACTION, Simulation
from dem.scene import ARRAYS, Scene, State

MOST_KEPT = 2**30  # bytes of the frames of a result


@checked(duration=DURATION, frames=PIECES)
def simulate(
    scene: Scene,
    state: State,
    duration: float,
    time_step: float | None = None,
    frames: int = 1,
    *,
    step_fraction: float = STEP_FRACTION,
    max_overlap: float = LARGEST_OVERLAP,
    skin: float | None = None,
    threads: int = 1,
    allow_unstable: bool = False,
) -> Result:
    """Simulate a scene from a state and return arrays.

    Parameters
    ----------
    scene : Scene
        What is simulated: n granules, walls, cylinder.
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
        scene, state, time_step, step_fraction, max_overlap, skin, threads,
        allow_unstable=allow_unstable,
    )  # fmt: skip
    run.check_duration(duration)
    interval, shortest, first = duration / frames, math.inf, _seen(run, math.nan)
    size = 8 * (frames + 1) * sum(map(np.size, first.values()))
    if size > MOST_KEPT:
        raise InputError(
            f"frames is {frames}; of {scene.granules} granules they fill {size / 2**30:.3g} GiB, more than "
            f"{MOST_KEPT / 2**30:g}: keep fewer, or advance a Simulation and save what you need."
        )
    kept = {name: np.empty((frames + 1, *np.shape(each))) for name, each in first.items()}
    for frame in range(frames + 1):
        if frame:  # the last one ends at the duration itself, however many there are
            end = duration * (frame / frames)
            shortest = min(shortest, run._run_steps("duration", end, 0.0, 1))
        for name, values in (_seen(run, interval) if frame else first).items():
            kept[name][frame] = values
    optional: dict[str, Any] = dict.fromkeys(("cylinder_position", "cylinder_torque", "held_force"))
    return Result(**optional | kept, state=run.state, time_step=shortest, scene=scene)


def _seen(run: Simulation, interval: float) -> dict[str, Any]:
    """The simulation as it is, and the mean forces (N) since the frame before, an interval (s) ago."""
    world, state, (walls, cylinder, held) = run.world, run.state, run._collect()
    found = {name: getattr(state, name) for name in ARRAYS} | {
        "time": run.time,
        "cylinder_force": (cylinder[:2] + cylinder[2:4]) / interval,
        "wall_force": walls[:, 0] / interval,
        "wall_tangential_force": walls[:, 3] / interval,
        "wall_offset": np.empty(0) if world.walls is None else world.walls.planes[:, 2],
    }
    if world.cylinder is not None:
        found["cylinder_position"] = world.boundaries.motion[world.cylinder.first, :2]
        found["cylinder_torque"] = cylinder[4] / interval
    if world.held is not None:
        found["held_force"] = held[:, :2] / interval
    return found
