"""What users plausibly hand over to the library by mistake: the sentence ends in what to write instead."""

import numpy as np

import dem

PLACES = [[2e-3, 2e-3], [5e-3, 2e-3]]
DISCS = dem.Disc([1e-3, 1e-3])


def scene(**changes):
    defaults = {"shape": DISCS, "friction": dem.Friction(), "walls": dem.box(1e-2, 1e-2)}
    return dem.Scene(**defaults | {"solids": dem.Cylinder(1e-3, (8e-3, 8e-3))} | changes)


def simulate(**changes):
    default = {"scene": scene(), "state": dem.State(PLACES), "duration": 1e-9}
    return dem.simulate(**default | changes)


FLOOR, SIDE = [0, -1, 0], [1, 0, 1]
CALLS = {
    "Friction.granule is -0.1; it must be at least 0.": lambda: dem.Friction(-0.1),
    "poisson_ratio is 0.6; it must be at most 0.5.": lambda: dem.Material(poisson_ratio=0.6),
    "Material.density is True; it must be a number, in kg m-3.": lambda: dem.Material(True),
    "Scene.friction is 0.3; it must be an instance of Friction.": lambda: scene(friction=0.3),
    "is (0.01, 0.01); it must have shape (n, 3), not (2,).": lambda: scene(walls=(1e-2, 1e-2)),
    "walls[2] is where walls[0] is, so that": lambda: scene(
        walls=[FLOOR, SIDE, dem.Wall([0, -1, 1e-9], friction=0.1)]
    ),
    "the normal (nx, ny) of row 1 must have length 1": lambda: scene(walls=[SIDE, [1, 1, 0]]),
    "is 9.81; it must be two finite numbers (x, y), in m s-2.": lambda: scene(gravity=9.81),
    "is 0.001; it must hold real numbers in a list or an array.": lambda: dem.Disc(1e-3),
    "all must be from 1e-20 to 1e+20, and -1 is at [1].": lambda: dem.Disc([1.0, -1.0]),
    "it must have 2, as position.": lambda: dem.State(PLACES, velocity=[[0, 0]] * 3),
    "state has 1 granules; it must have 2, as scene.": lambda: simulate(state=dem.State([[0, 0]])),
    "and nan is at [0, 0].": lambda: dem.State([[np.nan, 0.0]]),
    "velocity is not a number where position is one": lambda: dem.State(
        PLACES, np.full((2, 2), np.nan)
    ),
    "state must leave at least one granule there": lambda: simulate(
        state=dem.State([[np.nan] * 2] * 2)
    ),
    "it must be 'common_normal' or 'geometric_potential', or a": lambda: dem.Ellipse(
        [1.0], [1.0], contact="chord"
    ),
    "frames is 1.5; it must be a whole number.": lambda: simulate(frames=1.5),
    "does not fit into the box": lambda: dem.pack(
        DISCS, 8e-3, 8e-3, dem.Cylinder(2e-3, (0.5e-3, 4e-3)), 1
    ),
}
