"""One run: the phases of its scene, one after the other. The last is recorded, as observables say."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base.errors import RunError
from dem.base.plugins import load
from dem.contacts.layout import VX, VY, W
from dem.dynamics.record import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.bed import make_bed
from dem.experiment.box import check_stroke
from dem.experiment.config import Configuration
from dem.experiment.intruders import towards
from dem.experiment.replicate import Replicate
from dem.experiment.run_checkpoint import PartialRun, resumed
from dem.experiment.scene import motion_of, start
from dem.experiment.sinks_and_sources import Exchange
from dem.experiment.snapshots import Snapshots, snapshots_of, variables_of
from dem.packing.random import Bed
from dem.packing.settling import come_to_rest

PIECES = 20  # of a phase, between which a run saves itself
BINS_A_CALL = 20  # between two signs of progress
STILL = 1e-5  # of weight times diameter: mean kinetic energy at rest, while some granules rock


class RunData(NamedTuple):
    """What observables measure.

    record: of the bins of the last phase
    states: at the snapshots
    exchanged: number and mass (kg) of granules in the bins, (s, 2, bins): of each sink, then of each
    source
    ages: time (s) since granules came from a source, at the snapshots (f, n)
    """

    replicate: Replicate
    bed: Bed
    record: Record
    states: list
    exchanged: np.ndarray
    ages: list | tuple = ()

    @property
    def snapshots(self) -> Snapshots:
        """The states as arrays, with all that is needed to draw and to measure them."""
        if self.replicate.configuration.cylinder is None:
            raise RunError("run.snapshots is of runs with a cylinder; a scene has run.states.")
        axes = self.replicate.configuration.module.axes
        values = axes | {"box_height": self.bed.height} | variables_of(self)
        return snapshots_of(self.replicate, values)


def run(
    replicate: Replicate,
    bed: Bed | None = None,
    progress: Callable[[float], None] = lambda done: None,
    checkpoint: Path | None = None,
) -> dict:
    """Play the phases of a run in a bed at rest, packed here if None; returns the variables of the run by
    name. It is the `run` of an experiment that has none of its own.

    progress is called with the share of the last phase that is done. checkpoint: a file to which a
    long run saves itself every minute, and from which it goes on, bit for bit, if it was stopped; it
    is the caller's to remove once the result is on disk. Raises RunError where the run fails.
    """
    c, scene = replicate.configuration, replicate.configuration.scene
    bed = bed or make_bed(replicate.bed_description)
    check_stroke(replicate, bed)
    observables = [load(file) for file in c.module.files[1:]]
    ledger = any(getattr(module, "LEDGER", False) for module in observables)
    simulation = start(replicate, bed, ledger=ledger, threads=1 if ledger else c.threads)
    partial = (checkpoint and resumed(checkpoint, replicate, simulation)) or PartialRun()
    exchange = Exchange(replicate, simulation, partial.exchange)

    def save() -> None:
        if checkpoint is not None:
            partial.save(checkpoint, replicate, simulation)

    _play(replicate, exchange, partial, save)
    bins, every = c.record.bins, c.record.bins // (c.record.snapshots - 1)
    simulation.check_duration(scene.duration)
    while True:
        if partial.bins % every == 0 and len(partial.states) == partial.bins // every:
            partial.states.append(simulation.state)
            exchange.look()
            looks = (module.look for module in observables if hasattr(module, "look"))
            partial.looks.append({k: v for look in looks for k, v in look(simulation).items()})
        if partial.bins == bins:
            break
        count = min(every - partial.bins % every, BINS_A_CALL)
        partial.records.append(exchange.record(scene.duration / bins, count))
        progress(partial.bins / bins)
        save()
    data = RunData(
        replicate, bed, partial.record, partial.states, exchange.exchanged, exchange.kept["ages"]
    )
    values = {name: [look[name] for look in partial.looks] for name in partial.looks[0]}
    for module in observables:
        if hasattr(module, "measure"):
            values |= module.measure(data)
    return values | {
        "run_time": partial.spent,
        "steps": simulation.steps,
        "box_height": bed.height,
        "packing_pressure": bed.pressure * replicate.modulus / replicate.thickness,
        "packing_coordination_number": bed.coordination_number,
        "packing_net_force": bed.net_force,
        "packing_max_overlap": bed.max_overlap,
    }


def _play(replicate: Replicate, exchange: Exchange, partial: PartialRun, save) -> None:
    """All phases but the last, and how solids move in that."""
    scene, simulation = replicate.configuration.scene, exchange.simulation
    moving = {
        name: (solid.velocity or 0.0, solid.direction) for name, solid in scene.solids.items()
    }
    for number, (name, phase) in enumerate(scene.phases.items(), 1):
        begins = number > partial.phase
        for solid, section in phase.motion.items():
            given = section.velocity, section.direction
            moving[solid] = tuple(
                old if new is None else new for old, new in zip(moving[solid], given, strict=True)
            )
            if begins:
                _move(replicate, simulation, solid, section, *moving[solid])
        if begins:
            partial.phase, partial.began = number, simulation.time
        if number < partial.phase or number == len(scene.phases):
            continue
        if phase.until:
            _rest(scene, exchange, name, save)
            continue
        simulation.check_duration(phase.time)
        for end in partial.began + phase.time * np.arange(1, PIECES + 1) / PIECES:
            if end > simulation.time:  # and not before it was stopped
                exchange.advance(end - simulation.time)
                save()


def _move(
    replicate: Replicate, simulation: Simulation, name: str, section, speed, direction
) -> None:
    """Let a solid move as a section of a phase says; speed (m/s), direction (rad): its own now."""
    scene = replicate.configuration.scene
    k = scene.solid_names.index(name)
    if section.removed:
        simulation.remove(k)
        return
    boundaries, b = simulation.world.boundaries, len(simulation.scene.walls) + k
    *velocity, spin = boundaries.motion[b, [VX, VY, W]].tolist()
    anchor = tuple(speed * part for part in towards(direction))
    pulled = any(section.springs)
    if not pulled and (section.velocity is not None or section.forces == (None, None)):
        velocity = anchor
    given = scene.solids[name], simulation.scene.solids[k], tuple(velocity), anchor, spin
    simulation.set_motion(k, *motion_of(section, replicate, *given))


def _rest(scene: Configuration, exchange: Exchange, phase: str, save) -> None:
    """Go on until the granules are at rest, and no more come by their rate."""
    simulation, gravity = exchange.simulation, scene.gravity or scene.base_plate.gravity
    while True:
        energy, enough = come_to_rest(simulation, gravity, STILL, save, exchange.advance)
        if energy > enough or not exchange.is_feeding:
            break
    if energy > enough:
        raise RunError(
            f"phases.{phase}: the granules are not at rest after {simulation.time:.3g} s: their kinetic "
            f"energy is {energy:.2g} J, asked for {enough:.2g} J."
        )
