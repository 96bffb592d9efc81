"""Any scene: granules around solids that have names and move in phases. The last phase is recorded.

A phase takes a time, or lasts until the granules are at rest; solids that it does not name move on.
"""

from itertools import pairwise

import numpy as np

from dem.base.errors import RunError
from dem.contacts.layout import X, Y
from dem.dynamics.simulation import Simulation
from dem.experiment.bed import make_bed
from dem.experiment.config import Configuration
from dem.experiment.intruders import towards
from dem.experiment.run import Replicate
from dem.experiment.scene import start
from dem.jit.kernel import computing
from dem.packing.random import Bed
from dem.packing.settling import come_to_rest
from dem.periodic import Periods, wrapped

ON = "solid", "time"
AT = "snapshot", "solid"
N = ("time",)
S = ("snapshot",)
VARIABLES = {
    "solid_force_x": (ON, "N", "force of the granules on the solid along x, mean of the bin"),
    "solid_force_y": (ON, "N", "force of the granules on the solid along y, mean of the bin"),
    "solid_torque": (ON, "N m", "torque of the granules about its position, mean of the bin"),
    "solid_x": (AT, "m", "position of the solid along x"),
    "solid_y": (AT, "m", "position of the solid along y"),
    "solid_angle": (AT, "rad", "angle of the solid, anticlockwise"),
    "kinetic_energy": (N, "J", "kinetic energy of the granules, end of the bin"),
    "coordination_number": (N, "1", "contacts of a granule with others, end of the bin"),
    "max_overlap": (N, "1", "greatest overlap over the smaller radius, end of the bin"),
    "granule_x": (("snapshot", "granule"), "m", "centres of the granules along x, not wrapped"),
    "granule_y": (("snapshot", "granule"), "m", "centres of the granules along y, not wrapped"),
    "granule_angle": (("snapshot", "granule"), "rad", "angles of the granules"),
    "granule_diameter": (("granule",), "m", "volume diameters of the granules"),
    "surface_height": (
        ("snapshot", "cell"),
        "m",
        "height of the highest granule over the cell, by the circles that hold granules",
    ),
    "region_granules": (S, "1", "granules whose centre is in record.region"),
    "region_mass": (S, "kg", "mass of the granules whose centre is in record.region"),
    "run_time": ((), "s", "processor time of the run, without compiling"),
    "steps": ((), "1", "number of time steps of the run"),
    "box_height": ((), "m", "height of the box"),
}
AXIS = {
    "time": (N, "s", "time since the last phase began, middle of the bin"),
    "snapshot_time": (S, "s", "time since the last phase began at the snapshot"),
    "solid": (("solid",), None, "name of the solid"),
    "cell": (("cell",), "1", "middle of the cell along x over the width of the box"),
}
STILL = 1e-5  # of weight times diameter: mean kinetic energy at rest, while some granules rock
SIZES = {
    "time": "record.bins",
    "snapshot": "record.snapshots",
    "solid": "solid_count",
    "cell": "record.cells",
}
NEEDED = {"region_granules": "record.region", "region_mass": "record.region"}
SECTIONS = {"solids": True, "phases": True, "record": True}


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    record, duration = configuration.record, configuration.duration
    return {
        "time": duration * (np.arange(record.bins) + 0.5) / record.bins,
        "snapshot_time": np.linspace(0.0, duration, record.snapshots),
        "solid": np.array(configuration.solid_names),
        "cell": (np.arange(record.cells) + 0.5) / record.cells,
    }


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates, but for what it takes to come to rest."""
    return sum(phase.time or 0.0 for phase in replicate.configuration.phases.values())


def run(replicate: Replicate, bed: Bed | None = None, progress=lambda done: None) -> dict:
    """Make one run; returns its variables by name. Raises RunError where it fails."""
    c = replicate.configuration
    bed = bed or make_bed(replicate.bed_description)
    simulation, started = start(replicate, bed, threads=c.threads), computing()
    moving = [[solid.velocity or 0.0, solid.direction] for solid in c.solids.values()]
    for name, phase in c.phases.items():
        for solid, motion in phase.motion.items():
            k = c.solid_names.index(solid)
            for part, value in enumerate((motion.velocity, motion.direction)):
                moving[k][part] = moving[k][part] if value is None else value
            speed, direction = moving[k]
            velocity = tuple(speed * part for part in towards(direction))
            simulation.set_velocity(velocity, k, motion.spin)
        if phase.until:
            _rest(replicate, simulation, name)
        elif name != [*c.phases][-1]:
            simulation.check_duration(phase.time)
            simulation.advance(phase.time)
    every = c.record.bins // (c.record.snapshots - 1)
    simulation.check_duration(c.duration)
    records, looks = [], [_look(replicate, simulation)]
    for done in range(0, c.record.bins, every):
        records.append(simulation.record(c.duration / c.record.bins, every))
        looks.append(_look(replicate, simulation))
        progress((done + every) / c.record.bins)
    columns = zip(*records, strict=True)
    record = type(records[0])(*map(np.concatenate, columns))
    force = (record.normal_force + record.tangential_force).transpose(2, 1, 0)
    return {name: [look[name] for look in looks] for name in looks[0]} | {
        "run_time": computing() - started,
        "steps": simulation.steps,
        "box_height": bed.height,
        "solid_force_x": force[0],
        "solid_force_y": force[1],
        "solid_torque": record.torque.T,
        "kinetic_energy": record.kinetic_energy,
        "coordination_number": record.coordination_number,
        "max_overlap": record.max_overlap,
        "granule_diameter": replicate.diameters,
    }


def _rest(replicate: Replicate, simulation: Simulation, phase: str) -> None:
    """Go on until the granules are at rest."""
    energy, enough = come_to_rest(simulation, replicate.configuration.gravity, STILL)
    if energy > enough:
        raise RunError(
            f"phases.{phase}: the granules are not at rest after {simulation.time:.3g} s: their kinetic "
            f"energy is {energy:.2g} J, asked for {enough:.2g} J."
        )


def _look(replicate: Replicate, simulation: Simulation) -> dict:
    """What snapshots hold."""
    record, state = replicate.configuration.record, simulation.state
    scene, seen = simulation.scene, simulation.world.boundaries
    x, y = state.position.T
    look = {"granule_x": x, "granule_y": y, "granule_angle": state.angle}
    look |= dict(
        zip(("solid_x", "solid_y"), seen.motion[len(scene.walls) :, [X, Y]].T, strict=True)
    )
    look["solid_angle"] = seen.angle[len(scene.walls) :]
    width, radius = replicate.configuration.box_width, scene.shape.bounding_radius
    given = state.position, radius, width, record.cells, scene.periodic
    look["surface_height"] = surface(*given)
    if record.region:
        within = inside(state.position, record.region, scene.periodic)
        look |= {"region_granules": within.sum(), "region_mass": scene.mass[within].sum()}
    return look


def inside(position: np.ndarray, region: tuple, periodic: Periods = None) -> np.ndarray:
    """Which centres (n, 2) in m are in a region: left, bottom, right, top (m) of the box."""
    x, y = wrapped(position, periodic).T
    left, bottom, right, top = region
    return (x >= left) & (x <= right) & (y >= bottom) & (y <= top)


def surface(
    position: np.ndarray, radius: np.ndarray, width: float, cells: int, periodic: Periods = None
) -> np.ndarray:
    """Height (cells,) in m of the highest granule over each cell, by the circles that hold granules, 0
    without one.

    position (n, 2), radius (n,): of the granules (m); width: of the box (m), the cells side by side.
    """
    x, y = wrapped(position, periodic).T
    images = (0.0, -width, width) if periodic and periodic[0] else (0.0,)
    x = np.concatenate([x + shift for shift in images])
    y, radius = np.tile(y, len(images)), np.tile(radius, len(images))
    heights, edges = np.zeros(cells), np.linspace(0.0, width, cells + 1)
    for cell, (low, high) in enumerate(pairwise(edges)):
        nearest = np.clip(0.0, low - x, high - x)
        over = np.abs(nearest) < radius
        tops = y[over] + np.sqrt(radius[over] ** 2 - nearest[over] ** 2)
        heights[cell] = tops.max(initial=0.0)
    return heights
