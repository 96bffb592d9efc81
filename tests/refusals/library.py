"""What users plausibly hand over to the library by mistake: the sentence ends in what to write instead."""

import numpy as np
from project import CONFIG

import dem

PLACES = [[2e-3, 2e-3], [5e-3, 2e-3]]
DISCS = dem.Disc([1e-3, 1e-3])


def scene(**changes):
    defaults = {"shape": DISCS, "friction": dem.Friction(), "walls": dem.box(1e-2, 1e-2)}
    return dem.Scene(**defaults | {"solids": dem.Cylinder(1e-3, (8e-3, 8e-3))} | changes)


def simulate(**changes):
    default = {"scene": scene(), "state": dem.State(PLACES), "duration": 1e-9}
    return dem.simulate(**default | changes)


def pack(**changes):
    default = {"shape": DISCS, "width": 1e-2, "height": 1e-2, "solids": None, "seed": 1}
    return dem.pack(**default | changes)


MISSPELT = {"extends": f"{CONFIG}/smoke.yaml", "shape": "c1", "frction": {"granule": 0.1}}
FLOOR, SIDE, AGAIN = [0, -1, 0], [1, 0, 1], "walls[2] is where walls[0] is, so that"
MISTAKES = [  # what is called, with what: a part of the sentence
    (dem.Friction, {"granule": -0.1}, "Friction.granule is -0.1; it must be at least 0."),
    (dem.Friction, {"stiffness": 0}, "stiffness is 0; it must be positive, at least 1e-20."),
    (dem.Material, {"poisson_ratio": 0.6}, "poisson_ratio is 0.6; it must be at most 0.5."),
    (dem.Material, {"density": True}, "Material.density is True; it must be a number, in kg m-3."),
    (dem.Material, {"young_modulus": "70 GPa"}, "is '70 GPa'; it must be a number, in Pa."),
    (scene, {"friction": 0.3}, "Scene.friction is 0.3; it must be an instance of Friction."),
    (scene, {"walls": (1e-2, 1e-2)}, "is (0.01, 0.01); it must have shape (n, 3), not (2,)."),
    (scene, {"walls": [FLOOR, SIDE, [0, -1, 1e-9]]}, AGAIN),
    (scene, {"walls": [FLOOR, SIDE, dem.Wall(FLOOR, friction=0.1)]}, AGAIN),
    (scene, {"walls": [SIDE, [1, 1, 0]]}, "the normal (nx, ny) of row 1 must have length 1"),
    (scene, {"gravity": 9.81}, "is 9.81; it must be two finite numbers (x, y), in m s-2."),
    (dem.Disc, {"radius": 1e-3}, "is 0.001; it must hold real numbers in a list or an array."),
    (dem.Disc, {"radius": [1.0, -1.0]}, "all must be from 1e-20 to 1e+20, and -1 is at [1]."),
    (dem.State, {"position": PLACES, "velocity": [[0, 0]] * 3}, "it must have 2, as position."),
    (simulate, {"state": dem.State([[0, 0]])}, "state has 1 granules; it must have 2, as scene."),
    (dem.State, {"position": [[np.nan, 0.0]] * 2}, "and nan is at [0, 0]."),
    (
        dem.Ellipse,
        {"semi_major": [1.0], "semi_minor": [1.0], "contact": "chord"},
        "it must be 'common_normal' or 'geometric_potential', or a",
    ),
    (simulate, {"frames": 1.5}, "frames is 1.5; it must be a whole number."),
    (pack, {"periodic": "yx"}, "periodic is 'yx'; it must be 'none', 'x', 'y' or 'xy'."),
    (dem.run_experiment, {"values": MISSPELT}, "the nearest is friction"),
]
CALLS = {
    f"{call.__qualname__}({values})": (lambda call=call, values=values: call(**values), words)
    for call, values, words in MISTAKES
}
