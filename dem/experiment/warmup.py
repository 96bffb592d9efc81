"""Compile the kernels of one kind of granule before many processes need them at once."""

from dem.dynamics.simulation import Simulation
from dem.experiment.config import Replicate, Sweep
from dem.experiment.drag import cylinder, diameters, make_scene
from dem.packing.random import pack
from dem.shapes import KINDS


def compile_kernels(sweep: Sweep, label: str) -> None:
    """Pack three granules of this shape loosely and run them for an instant, as the sweep would."""
    few = sweep.shapes[label].model_copy(update={"granules": 3})
    sweep = sweep.model_copy(update={"shapes": {label: few}})
    replicate = Replicate.model_construct(sweep=sweep, label=label, density=1e3, seed=0)
    start = sweep.cylinder.start
    height = 4.0 * (sweep.cylinder.diameter + few.diameter) / min(start, 1.0 - start)
    shape = KINDS[few.kind].shape.of_size(diameters(replicate), few.ratio)
    bed = pack(shape, sweep.box_width, height, cylinder(replicate, height), seed=0)
    scene = make_scene(replicate, bed)
    Simulation(scene, bed.state).advance(1e-9)
