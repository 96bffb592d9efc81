"""`simulate`: from a state to a `Result`, in one call."""

import math
from typing import Any

import numpy as np

from dem.base.errors import InputError
from dem.base.validate import checked
from dem.dynamics.result import Result
from dem.dynamics.simulation import DURATION, LARGEST_OVERLAP, PIECES, STEP_FRACTION, Simulation
from dem.dynamics.skin import SKIN
from dem.scene import Scene, State

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
    skin: float = SKIN,
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
    skin : float
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
    kept = _history(frames, run)
    interval, shortest = duration / frames, math.inf
    for frame in range(1, frames + 1):
        shortest = min(shortest, run.advance(interval))
        pushed = run._collect()
        forces: dict[str, Any] = {
            "cylinder_force": pushed.on_cylinder.sum(axis=0), "cylinder_torque": pushed.twist,
            "wall_force": pushed.on_walls, "wall_tangential_force": pushed.shear,
            "held_force": pushed.on_held,
        }  # fmt: skip
        _keep(kept, frame, run, {name: each / interval for name, each in forces.items()})
    optional: dict[str, Any] = dict.fromkeys(("cylinder_position", "cylinder_torque", "held_force"))
    return Result(**optional | kept, state=run.state, time_step=shortest, scene=scene)


def _history(frames: int, run: Simulation) -> dict[str, np.ndarray]:
    """Arrays of a Result by name, with the start in them; raises InputError if they are too large."""
    n, walls = run.scene.granules, len(run._collect().on_walls)
    shapes = {
        "time": (), "position": (n, 2), "angle": (n,), "velocity": (n, 2), "angular_velocity": (n,),
        "cylinder_force": (2,), "wall_force": (walls,), "wall_tangential_force": (walls,),
        "wall_offset": (walls,),
    }  # fmt: skip
    if run.scene.held:
        shapes["held_force"] = len(run.scene.held), 2
    if run.scene.cylinder is not None:
        shapes |= {"cylinder_position": (2,), "cylinder_torque": ()}
    held = 8 * (frames + 1) * sum(map(math.prod, shapes.values()))
    if held > MOST_KEPT:
        raise InputError(
            f"frames is {frames}; of {n} granules they fill {held / 2**30:.3g} GiB, more than "
            f"{MOST_KEPT / 2**30:g}: keep fewer, or advance a Simulation and save what you need."
        )
    kept = {name: np.empty((frames + 1, *shape)) for name, shape in shapes.items()}
    for name, each in kept.items():
        if name.endswith(("force", "torque")):
            each[0] = math.nan
    _keep(kept, 0, run, {})
    return kept


def _keep(kept: dict[str, np.ndarray], frame: int, run: Simulation, forces: dict[str, Any]) -> None:
    """Note the simulation as it is, and the mean forces (N) since the frame before."""
    world = run.world
    found = vars(run.state) | forces | {"time": run.time}
    if world.walls is not None:
        found["wall_offset"] = world.walls.planes[:, 2]
    if world.cylinder is not None:
        found["cylinder_position"] = world.cylinder.motion[0, :2]
    for name, values in found.items():
        if name in kept:
            kept[name][frame] = values
