"""What a scene shows: forces on solids and where they are, granules, their surface, those in a region."""

from itertools import pairwise

import numpy as np

from dem.dynamics.paths import shown
from dem.experiment.scene import make_scene
from dem.experiment.sinks_and_sources import inside
from dem.motion import Drive
from dem.periodic import Periods, wrapped

ON = "solid", "time"
AT = "snapshot", "solid"
N = ("time",)
S = ("snapshot",)
INTO = "sink", "time"
FROM = "source", "time"
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
    "top_y": (S, "m", "height of the top wall above the floor, where it holds a pressure"),
    "region_granules": (S, "1", "granules whose centre is in record.region"),
    "region_mass": (S, "kg", "mass of the granules whose centre is in record.region"),
    "granule_age": (
        ("snapshot", "granule"),
        "s",
        "time since the granule came from a source, NaN where it never did or is not there",
    ),
    "sink_granules": (INTO, "1", "granules that went into the sink in the bin"),
    "sink_mass": (INTO, "kg", "mass of the granules that went into the sink in the bin"),
    "source_granules": (FROM, "1", "granules that came from the source in the bin"),
    "source_mass": (FROM, "kg", "mass of the granules that came from the source in the bin"),
}
AXIS = {
    "solid": (("solid",), None, "name of the solid"),
    "sink": (("sink",), None, "name of the sink"),
    "source": (("source",), None, "name of the source"),
    "cell": (("cell",), "1", "middle of the cell along x over the width of the box"),
}
SIZES = {
    "solid": "solid_count",
    "cell": "record.cells",
    "sink": "sink_count",
    "source": "source_count",
}
NEEDED = {
    "top_y": "packing.pressure",
    "region_granules": "record.region",
    "region_mass": "record.region",
    "sink_granules": "sink_count",
    "sink_mass": "sink_count",
    "granule_age": "source_count",
    "source_granules": "source_count",
    "source_mass": "source_count",
}


def axes(configuration) -> dict:
    """Names of the solids, sinks and sources, and where the cells are."""
    cells = configuration.record.cells
    return {
        "solid": np.array(configuration.solid_names),
        "sink": np.array([*configuration.sinks]),
        "source": np.array([*configuration.sources]),
        "cell": (np.arange(cells) + 0.5) / cells,
    }


def look(simulation) -> dict:
    """Where the solids are, at one snapshot, NaN of those that were removed, and a top wall that is
    pressed."""
    seen, walls = simulation.world.boundaries, simulation.scene.walls
    x, y, angle = shown(seen)[len(walls) :].T
    pressed = bool(walls) and isinstance(walls[-1].motion, Drive)
    top = {"top_y": seen.planes[-1, 2]} if pressed else {}
    return {"solid_x": x, "solid_y": y, "solid_angle": angle} | top


def measure(run) -> dict:
    """All other values of VARIABLES by name."""
    record, c = run.record, run.replicate.configuration
    scene, position = make_scene(run.replicate, run.bed), [state.position for state in run.states]
    force = (record.normal_force + record.tangential_force).transpose(2, 1, 0)
    given = scene.shape.bounding_radius, c.box_width, c.record.cells, scene.periodic
    values = {
        "solid_force_x": force[0],
        "solid_force_y": force[1],
        "solid_torque": record.torque.T,
        "kinetic_energy": record.kinetic_energy,
        "coordination_number": record.coordination_number,
        "max_overlap": record.max_overlap,
        "granule_x": [places[:, 0] for places in position],
        "granule_y": [places[:, 1] for places in position],
        "granule_angle": [state.angle for state in run.states],
        "granule_diameter": run.replicate.diameters,
        "surface_height": [surface(places, *given) for places in position],
    }
    if c.record.region:
        within = [inside(places, c.record.region, scene.periodic) for places in position]
        values["region_granules"] = [counted.sum() for counted in within]
        values["region_mass"] = [scene.mass[counted].sum() for counted in within]
    if c.sources:
        values["granule_age"] = run.ages
    for name, moved in (
        ("sink", run.exchanged[: len(c.sinks)]),
        ("source", run.exchanged[len(c.sinks) :]),
    ):
        if len(moved):
            values[f"{name}_granules"], values[f"{name}_mass"] = moved[:, 0], moved[:, 1]
    return values


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
