"""What no bed can be made of, and bins of a bed that are none."""

from functools import cache

import numpy as np

import dem


@cache
def bed():
    scene = dem.Scene(dem.Disc([1e-3]), friction=dem.Friction(), walls=dem.box(8e-3, 8e-3))
    return dem.Simulation(scene, dem.State([[4e-3, 4e-3]]))


def pack(**changes):
    values = {"width": 8e-3, "height": 8e-3, "solids": None, "seed": 1} | changes
    return dem.pack(dem.Disc([1e-3]), **values)


EDGES = "it must hold two or more edges of bins that rise, in m"
CALLS = {
    "bins along both axes": (
        lambda: bed().stress(x=[0.0, 1e-3], y=[0.0, 1e-3]),
        "x and y are both given; give edges along one of them",
    ),
    "one edge": (lambda: bed().stress(y=[0.0]), EDGES),
    "edges that fall": (lambda: bed().stress(y=[0.0, 2e-3, 1e-3]), EDGES),
    "an edge that is no number": (
        lambda: bed().stress(x=[0.0, np.nan]),
        f"x is [0.0, nan]; {EDGES}",
    ),
    "a number of bins": (lambda: bed().stress(x=10), f"x is 10; {EDGES}"),
    "solid beside its box": (
        lambda: pack(solids=dem.Cylinder(2e-3, (0.5e-3, 4e-3))),
        "does not fit into the box",
    ),
    "seed below zero": (lambda: pack(seed=-1), "seed is -1"),
    "sides that are none": (lambda: pack(periodic="z"), "periodic is 'z'"),
}
FILES = {
    "way of packing": (
        {"packing.preparation": "shaken"},
        "packing.preparation is 'shaken'; it must be 'relaxed', 'grown' or 'settled'",
    ),
    "settled bed without room above it": (
        {"packing.preparation": "settled", "gravity": 9.81},
        "fraction is 0.84 and preparation settled",
    ),
}
