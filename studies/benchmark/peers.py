"""The codes that are timed, ours first; one that is not there is named and skipped."""

import importlib.metadata
import time
from collections.abc import Callable
from typing import NamedTuple

from dem.dynamics.simulation import Simulation
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from dem.shapes.dumbbell import Dumbbell
from dem.shapes.ellipse import Ellipse
from studies.common.peers import lammps, liggghts, yade


class Code(NamedTuple):
    """A program: the shapes it is timed with; available, None or one sentence that says why not.

    seconds(scene, state, time_step, warm, steps): time (s) of a number of steps, on one core, after
    `warm` others from the state; without reading, listing contacts for the first time and the like.
    """

    name: str
    shapes: tuple
    available: Callable[[], str | None]
    version: Callable[[], str]
    seconds: Callable


def our_seconds(scene: Scene, state: State, time_step: float, warm: int, steps: int) -> float:
    """See Code."""
    simulation = Simulation(scene, state, time_step)
    simulation.advance(warm * time_step)
    before, started = simulation.steps, time.perf_counter()
    simulation.advance(steps * time_step)
    spent = time.perf_counter() - started
    return spent * steps / (simulation.steps - before)  # rounding may make it one step more


CODES = (
    Code(
        "dem", (Disc, Dumbbell, Ellipse), lambda: None,
        lambda: importlib.metadata.version("granular-drag"), our_seconds,
    ),
    Code("LAMMPS", (Disc, Dumbbell), lammps.available, lammps.version, lammps.seconds),
    Code("LIGGGHTS", (Disc,), liggghts.available, liggghts.version, liggghts.seconds),
    Code("YADE", (Disc,), yade.available, yade.version, yade.seconds),
)  # fmt: skip
