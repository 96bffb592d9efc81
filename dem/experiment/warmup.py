"""Compile the kernels that a run needs before many processes need them at once."""

from dem.dynamics.simulation import Simulation
from dem.experiment.bed import cylinder, diameters
from dem.experiment.config import Replicate
from dem.experiment.scene import make_scene
from dem.packing.random import pack
from dem.shapes import KINDS


def compile_kernels(replicate: Replicate) -> None:
    """Pack three granules of this run's shape loosely and run them for an instant, as it would."""
    own, label = replicate.configuration, replicate.label
    few = replicate.shape.model_copy(update={"granules": 3})
    own = own.model_copy(update={"shapes": {label: few}})
    replicate = Replicate(own, label, replicate.density, replicate.seed)
    if drawn := own.cylinder:
        height = 4.0 * (drawn.diameter + few.diameter) / min(drawn.start, 1.0 - drawn.start)
    else:
        height = own.box_width
    shape = KINDS[few.kind].shape.of_size(diameters(replicate), few.ratio)
    bed = pack(shape, own.box_width, height, cylinder(replicate, height), 0, own.periodic)
    if drawn is None:  # the bed is packed, and no more
        return
    ledger = "ledger" in own.record.observables
    run = Simulation(make_scene(replicate, bed), bed.state, ledger=ledger)
    run.check_duration(1e-9)
    run.record(1e-9, 1)
    if ledger:
        run.ledger()
    if "snapshots" in own.record.observables:
        run.contacts()  # of snapshots, which the measures of flow ask for
