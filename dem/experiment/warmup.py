"""Compile the kernels that a run needs before many processes need them at once."""

from dataclasses import replace

from dem.dynamics.simulation import Simulation
from dem.experiment.bed import diameters, packed, shaped, thickness
from dem.experiment.observables import module_of
from dem.experiment.run import Replicate
from dem.experiment.scene import make_scene
from dem.experiment.solids import solids_of
from dem.packing.random import Room


def compile_kernels(replicate: Replicate) -> None:
    """Pack three granules of this run's shape loosely and run them for an instant, as it would.

    This compiles for all runs of its `Replicate.variant`. A bed between
    rough walls is its own, for an instant too.
    """
    own, label = replicate.configuration, replicate.label
    if hasattr(own.module.code, "warm_up"):
        own.module.code.warm_up(replicate)
        return
    few = replicate.shape.model_copy(update={"granules": 3})
    own = own.model_copy(update={"shapes": own.shapes | {label: few}})
    replicate = Replicate(own, label, replicate.density, replicate.seed)
    shape = shaped(replicate, diameters(replicate))
    height, solids = own.box_width, ()
    if drawn := own.cylinder:  # in a box that is much too high for three granules
        size = drawn.diameter + few.diameter
        if own.second is not None:
            size += own.second.gap + own.second.diameter
        height = 4.0 * size / min(drawn.start, 1.0 - drawn.start)
        solids = solids_of(replicate, height, thickness(replicate))
    bed = packed(own, shape, Room(own.box_width, height, solids, 0, own.periodic, replicate.law))
    if not own.module.observed:  # the bed is packed, and no more
        return
    ledger = "ledger" in own.record.observables
    scene = replace(make_scene(replicate, bed), solids=solids)
    run = Simulation(scene, bed.state, ledger=ledger)
    run.check_duration(1e-9)
    run.record(1e-9, 1)
    for name in own.record.observables:
        if hasattr(module := module_of(name, own.beside), "look"):
            module.look(run)
    if "flow" in own.record.observables:
        run.contacts()
