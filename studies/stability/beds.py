"""Experiments on the paper's bed, one function each.

Each takes the sweep, the label of a shape and studies.stability.catalogue.Changes, and returns
some of QUANTITIES by name.
"""

from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import STEP_FRACTION, Simulation
from dem.experiment.scene import make_scene
from dem.shapes.disc import Disc
from dem.shapes.ellipse import Ellipse
from studies.stability.catalogue import Changes
from studies.stability.scenes import bed_of, changed, start
from studies.stability.watching import LOOKS, watch

STROKE = 0.5e-3  # m, of the cylinder where a case does not say


def draw(sweep, shape, change) -> dict:
    """The paper's experiment over a short stroke."""
    replicate = changed(sweep, shape, change)
    stroke = change.displacement or STROKE
    return watch(start(replicate), stroke / replicate.configuration.cylinder.velocity / LOOKS)


def rest(sweep, shape, change) -> dict:
    """The cylinder rests for many steps."""
    replicate = changed(sweep, shape, change)
    simulation, fraction = (
        start(replicate, still=True),
        replicate.configuration.numerics.step_fraction,
    )
    step = fraction * simulation.diagnose().critical_time_step
    quantities = watch(simulation, step * (change.steps or 1000) / LOOKS)
    moving = 0.5 * simulation.scene.mass.sum() * sweep.cylinder.velocity**2
    return quantities | {"kinetic": quantities["kinetic"] / moving}


def accelerate(sweep, shape, change) -> dict:
    """The cylinder goes from rest to its velocity in equal stages."""
    replicate = changed(sweep, shape, change)
    simulation, velocity = start(replicate, still=True), replicate.configuration.cylinder.velocity

    def faster(look):
        simulation.set_motion(0, (0.0, velocity * (look + 1) / LOOKS))

    return watch(simulation, 2.0 * (change.displacement or STROKE) / velocity / LOOKS, faster)


def follow(sweep, shape, change) -> dict:
    """Does the critical time step follow the mass: as its square root, at the start?"""
    usual, other = (
        start(changed(sweep, shape, c)).diagnose().critical_time_step for c in (Changes(), change)
    )
    return {"scaling": abs(other / usual / np.sqrt(change.density / change.stiffness) - 1.0)}


def restart(sweep, shape, change) -> dict:
    """A run continued from a saved state against one without interruption."""
    replicate = changed(sweep, shape, change)
    half = (change.displacement or STROKE) / 2.0 / replicate.configuration.cylinder.velocity
    whole, second = start(replicate), start(replicate)
    whole.advance(half)
    second.restore(whole.checkpoint())
    whole.advance(half)
    second.advance(half)
    apart = np.abs(whole.state.position - second.state.position).max()
    size = float(whole.scene.shape.bounding_radius.mean())
    return {"difference": apart / size, "residual": second.ledger().residual}


def round_off(sweep, shape, change) -> dict:
    """Ellipses of a given aspect ratio, nearly 1, against discs, on one bed before chaos."""
    replicate = changed(sweep, shape, change.model_copy(update={"aspect_ratio": None}))
    bed, sizes = bed_of(replicate), replicate.diameters
    scene = make_scene(replicate, bed)
    shapes = Disc.of_size(sizes), Ellipse.of_size(sizes, change.aspect_ratio)
    scenes = [replace(scene, shape=shape) for shape in shapes]
    step = STEP_FRACTION * Simulation(scenes[0], bed.state).diagnose().critical_time_step
    discs, ellipses = (Simulation(scene, bed.state, step, ledger=True) for scene in scenes)
    for run in (discs, ellipses):
        run.advance((change.steps or 500) * step)
    apart = np.abs(discs.state.position - ellipses.state.position).max()
    residual = max(run.ledger().residual for run in (discs, ellipses))
    return {"difference": apart / float(sizes.mean()), "residual": residual}
