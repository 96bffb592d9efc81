"""This code as one of those that are timed, and the machine code of a scene."""

import importlib.metadata
import time

import numba
from llvmlite.binding.object_file import ObjectFileRef

from dem.dynamics.simulation import Simulation
from dem.dynamics.step import STEPS
from dem.dynamics.system import NONE
from dem.jit.kernel import OPTIONS
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from dem.shapes.dumbbell import Dumbbell
from dem.shapes.ellipse import Ellipse

NAME, SHAPES = "dem", (Disc, Dumbbell, Ellipse)
WIDEST = {"zmm": 512, "ymm": 256}  # bits of the registers of x86


def available() -> None:
    """Always: the beds are made by it."""


def version() -> str:
    """Release of the package."""
    return importlib.metadata.version("granular-drag")


def seconds(scene: Scene, state: State, time_step: float, warm: int, steps: int) -> float:
    """Processor time (s) that a number of steps takes after `warm` others."""
    simulation = Simulation(scene, state, time_step)
    simulation.advance(warm * time_step)
    before, started = simulation.steps, time.process_time()
    simulation.advance(steps * time_step)
    spent = time.process_time() - started
    return spent * steps / (simulation.steps - before)  # rounding may make it one step more


def machine_code(scene: Scene, state: State, time_step: float) -> tuple[int, int]:
    """Size (bytes) of the machine code of the steps of a scene, with all they call, and width (bits)
    of the widest vector registers that it names.

    The size is that of the text section of the object file, with the few hundred bytes that call it
    from Python. It is compiled again, because Numba does not keep object files that it reads from
    disk.
    """
    system = Simulation(scene, state, time_step).engine.system
    kernel, given = system.kernels.work, (system.world, STEPS, 0.5, 1.0, 1, 1.0, NONE, system.place)
    fresh = numba.njit(**OPTIONS)(kernel.binding.copy(kernel.function))
    signature = tuple(map(numba.typeof, given))
    fresh.compile(signature)
    code = fresh.overloads[signature].library._compiled_object
    sections = ObjectFileRef.from_data(code).sections()
    assembly = fresh.inspect_asm(signature)
    width = next((bits for name, bits in WIDEST.items() if name in assembly), 128)
    return sum(section.size() for section in sections if section.is_text()), width
