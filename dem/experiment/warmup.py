"""Compile the kernels that a run needs before many processes need them at once."""

from dem.dynamics.simulation import Simulation
from dem.experiment.bed import PREPARATIONS, cylinder, diameters
from dem.experiment.config import Replicate
from dem.experiment.scene import make_scene
from dem.shapes import KINDS


def compile_kernels(replicate: Replicate) -> None:
    """Pack three granules of this run's shape loosely and run them for an instant, as it would."""
    own, label = replicate.configuration, replicate.label
    few = replicate.shape.model_copy(update={"granules": 3})
    own = own.model_copy(update={"shapes": {label: few}})
    replicate = Replicate(own, label, replicate.density, replicate.seed)
    start = own.cylinder.start
    height = 4.0 * (own.cylinder.diameter + few.diameter) / min(start, 1.0 - start)
    shape = KINDS[few.kind].shape.of_size(diameters(replicate), few.ratio)
    prepare = PREPARATIONS[own.packing.preparation]
    bed = prepare(shape, own.box_width, height, cylinder(replicate, height), 0, own.periodic)
    ledger = "ledger" in own.record.observables
    run = Simulation(make_scene(replicate, bed), bed.state, ledger=ledger)
    run.check_duration(1e-9)
    run.record(1e-9, 1)
    if ledger:
        run.ledger()
    if "snapshots" in own.record.observables:
        run.contacts()  # of snapshots, which the measures of flow ask for
