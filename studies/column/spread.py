"""How far granules have spread from the left wall, and how high they are, at the snapshots.

The ends of granules are those of the circles that hold them.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

S = ("snapshot",)
VARIABLES = {
    "height": (S, "m", "top of the highest granule of the heap"),
    "middle_y": (S, "m", "height of the centre of mass"),
    "front": (S, "m", "right end of the farthest granule of the heap"),
    "front_all": (S, "m", "right end of the farthest granule"),
    "front_99": (S, "m", "distance from the left wall within which 99 % of the mass is"),
    "heap_mass": (S, "1", "share of the mass that is in the heap"),
    "unrest": (S, "1", "kinetic energy over that of a fall of all granules by the mean diameter"),
}


def look(simulation) -> dict:
    """Values of VARIABLES by name. The heap: the most granules that contacts connect."""
    (x, y), scene = simulation.state.position.T, simulation.scene
    mass, radius = scene.mass, scene.shape.bounding_radius
    contacts = simulation.contacts()
    pairs = contacts.partner >= 0
    joined = contacts.granule[pairs], contacts.partner[pairs]
    graph = coo_array((np.ones(pairs.sum()), joined), (len(x), len(x)))
    _, part = connected_components(graph, directed=False)
    heap, order = part == np.bincount(part).argmax(), np.argsort(x)
    fall = mass.sum() * np.hypot(*scene.gravity) * 2.0 * radius.mean()
    return {
        "height": (y + radius)[heap].max(),
        "middle_y": mass @ y / mass.sum(),
        "front": (x + radius)[heap].max(),
        "front_all": (x + radius).max(),
        "front_99": x[order][np.searchsorted(mass[order].cumsum(), 0.99 * mass.sum())],
        "heap_mass": mass[heap].sum() / mass.sum(),
        "unrest": simulation.diagnose().kinetic_energy / fall,
    }
