"""Simple shear of discs between rough walls: stress and packing fraction at a rate of shear.

The discs repeat themselves along x. Those next to floor and lid are held: the lower ones are at rest,
the upper ones move along x and are pressed down, so that the pressure is given and the height is not.
Everything is measured in the middle half of the height, away from the walls. The setup follows
da Cruz et al. (2005, Phys. Rev. E 72, 021309), with Hertzian contacts.
"""

from dataclasses import replace

import numpy as np

from dem.base.errors import RunError
from dem.dynamics.simulation import Simulation
from dem.experiment.bed import make_bed
from dem.experiment.config import Configuration
from dem.experiment.replicate import Replicate
from dem.experiment.scene import make_scene
from dem.jit.kernel import computing
from dem.motion import Drive, Held
from dem.packing.random import Bed
from dem.scene import Scene, State

S = ("shear_strain",)
VARIABLES = {
    "run_time": (
        (),
        "s",
        "processor time of the run, without compiling",
    ),
    "steps": ((), "1", "number of time steps of the run"),
    "shear_stress": (S, "Pa", "shear stress in the middle of the bed"),
    "normal_stress": (S, "Pa", "stress across the flow in the middle of the bed"),
    "shear_rate": (S, "s-1", "gradient of the velocity in the middle of the bed"),
    "shear_fraction": (S, "1", "packing fraction in the middle of the bed"),
    "lid_shear_stress": (
        S,
        "Pa",
        "shear stress on the lid, mean since the sample before",
    ),
    "lid_normal_stress": (
        S,
        "Pa",
        "normal stress on the lid, mean since the sample before",
    ),
    "shear_height": (S, "m", "distance between the mean heights of both walls"),
}
AXIS = {
    "shear_strain": (
        S,
        "1",
        "strain since the first sample, by the lid's velocity",
    ),
}
SIZES = {"shear_strain": "shear.samples"}
SECTIONS = {"shear": True}
ASKS = {
    "packing.pressure": (None, "the lid is pressed"),
    "periodic": ("x", "the bed is sheared along x"),
    "gravity": (0.0, "the pressure must be the same at all heights"),
    "shapes.*.kind": ("disc", "floor and lid are rows of discs"),
}
THICK = 1.25  # mean diameters from floor or lid to the farthest centres that are held
MIDDLE = 0.25  # of the height, on either side of the middle
# times that a bed takes to fall through its height under the pressure, before it is measured: a fast
# flow throws it up when it begins
FALLS = 3.0


def rate_of(replicate: Replicate) -> float:
    """Rate of shear (1/s) of the inertial number I = rate sqrt(m / (pressure thickness))."""
    shear = replicate.configuration.shear
    area = 0.25 * np.pi * replicate.shape.diameter**2  # of the mean granule; the thickness cancels
    return float(shear.inertial_number / np.sqrt(replicate.mean_density * area / shear.pressure))


def make_cell(replicate: Replicate, bed: Bed) -> tuple[Scene, State]:
    """The bed of a run between rough walls, the upper one pressed down and moved, and in it the flow that is
    asked for."""
    shear, diameter, rate = (
        replicate.configuration.shear,
        replicate.shape.diameter,
        rate_of(replicate),
    )
    scene, height = make_scene(replicate, bed), bed.position[:, 1]
    floor, lid = height < THICK * diameter, height > bed.height - THICK * diameter
    low, high = height[floor].max(), height[lid].min()
    speed = rate * (high - low)
    force = shear.pressure * (bed.width * scene.thickness)
    # yields to a wave of the bed, and keeps the pressure where the lid moves at much less than the shear
    damping = bed.width / diameter * np.sqrt(scene.mass.mean() * force / bed.width)
    drive = Drive((None, -force), float(scene.mass[lid].sum()), float(damping), (speed, 0.0))
    flow = np.clip(rate * (height - low), 0.0, speed)
    state = State(bed.position, np.column_stack([flow, np.zeros_like(flow)]), bed.angle)
    return replace(scene, walls=None, held=[Held(floor), Held(lid, drive)]), state


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates, but for what a fast flow takes to settle."""
    shear = replicate.configuration.shear
    return (shear.settle + shear.strain) / rate_of(replicate)


def run(replicate: Replicate, bed: Bed | None = None, progress=lambda done: None) -> dict:
    """Shear the bed of a run; returns the variables of a run by name. Raises RunError, also where a granule
    gets out between those that are held."""
    c, rate = replicate.configuration, rate_of(replicate)
    bed = bed or make_bed(replicate.bed_description)
    shear, (scene, state) = c.shear, make_cell(replicate, bed)
    force = shear.pressure * (bed.width * scene.thickness)
    fall = np.sqrt(2.0 * bed.height * scene.mass.sum() / force)
    settle = max(shear.settle / rate, FALLS * float(fall))
    simulation = Simulation(scene, state, **c.numerics.model_dump())
    simulation.check_duration(settle + shear.strain / rate)
    started = computing()
    simulation.advance(settle)
    interval = shear.strain / shear.samples / rate
    samples = [_sample(simulation, interval) for _ in range(shear.samples)]
    values = {name: np.array([sample[name] for sample in samples]) for name in samples[0]}
    return values | {"run_time": computing() - started, "steps": simulation.steps}


def _sample(simulation: Simulation, interval: float) -> dict[str, float]:
    """What is measured after an interval (s)."""
    scene = simulation.scene
    width = scene.periodic[0]
    on_lid = simulation.record(interval, 1).held_force[0, 1] / (width * scene.thickness)
    state = simulation.state
    height = state.position[:, 1]
    walls = [height[group.granules] for group in scene.held]
    beyond = np.flatnonzero((height < walls[0].min()) | (height > walls[1].max()))
    if len(beyond):
        raise RunError(
            f"granule {beyond[0]} got out through a gap in the rough walls; ask for a higher "
            "packing.fraction, at which they are closed."
        )
    floor, lid = (wall.mean() for wall in walls)
    middle, half = 0.5 * (floor + lid), MIDDLE * (lid - floor)
    edges = np.array([middle - half, middle + half])
    stress = simulation.stress(y=edges)
    both = (stress.contact + stress.kinetic)[0]
    inside = (height > edges[0]) & (height < edges[1])
    below = _below(edges[:, None], height, scene.shape.bounding_radius).sum(axis=1)
    return {
        "shear_stress": -both[0, 1],
        "normal_stress": both[1, 1],
        "shear_rate": np.polyfit(height[inside], state.velocity[inside, 0], 1)[0],
        "shear_fraction": np.diff(below)[0] / (2.0 * half * width),
        "lid_shear_stress": -on_lid[0],
        "lid_normal_stress": on_lid[1],
        "shear_height": lid - floor,
    }


def _below(line, height: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Areas (m2) of discs below a line."""
    over = np.clip((line - height) / radius, -1.0, 1.0)
    return radius**2 * (0.5 * np.pi + np.arcsin(over) + over * np.sqrt(1.0 - over**2))


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    shear = configuration.shear
    return {"shear_strain": shear.strain * np.arange(1, shear.samples + 1) / shear.samples}
