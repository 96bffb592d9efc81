"""Values of a configuration that cannot be, and values that exclude each other."""

import datetime
import math
from functools import partial

from project import CONFIG

import dem

MIXED = {"granules": 100, "mixture": {"c1": 0.5, "d1": 0.5}}
SECOND = {"diameter": 2e-3, "gap": 20e-3}
LONG = 300 * "n"  # too long for a file
PRESSED = {"packing.fraction": None, "packing.pressure": 3e7}
COHESIVE = {"law": "cohesive", "pull_off": 1e-3, "range": 1e-6}
SETTLED = {"packing.preparation": "settled", "packing.fraction": 0.6, "gravity": 9.81}
ONSET = SETTLED | {"experiment": "onset"}

FILES = {
    "colour is not a known key; there are experiment, box_width,": {"colour": "red"},
    "seeds is not a known key; the nearest is sweep.": {"seeds": 5},
    "gravity is nan; it must be finite, at most 1e+20 in size, in m s-2.": {"gravity": math.nan},
    "its keys are granule, wall,": {"friction": 0.3},
    "is 5e-324; it must be positive, at least 1e-20, in Pa.": {"material.young_modulus": 5e-324},
    "packing.fraction is 84; it must be below 1.": {"packing.fraction": 84},
    "is 1e-13; it must be at least 1e-12, in m.": {"cylinder.diameter": 1e-13},
    "record.window.1 is missing": {"record.window": [1e-3]},
    "record.observables is 'drag'; it must be a list.": {"record.observables": "drag"},
    "is 'drags'; it must be 'alignment', 'drag'": {"record.observables": ["drags"]},
    "spin is 'fast'; it must be an angular velocity or free": {"cylinder.spin": "fast"},
    "experiment is 'darg'; it must be 'drag'": {"experiment": "darg"},
    "it must be results or a folder below it, such as results/mine": {"results": "results/../.."},
    "but not that of the store": {"results": "results/store"},
    "config/papr.yaml: cannot read it": {"extends": "config/papr.yaml"},
    "is 'C1', which is not one of shapes; the nearest is c1": {"cases.c1.shape": "C1"},
    "nnn.yaml": {"extends": f"config/{LONG}.yaml"},
    "nnn.py": {"experiment": f"{LONG}.py"},
    "nnn.Own": {"shapes.c1.kind": f"{LONG}.Own"},
    "title is 2020-01-01; it must be text.": {"title": datetime.date(2020, 1, 1)},
    "friction.1 is not a known key; there are granule, wall, cylinder,": {"friction": {1: 1}},
    "shapes.false is false; it must be a label: a letter from A to Z": {"shapes": {False: {}}},
    # what does not fit into its box
    "shapes.c1.diameter is 0.03": {"shapes.c1.diameter": 0.03},
    "cylinder.start is 0.02": {"cylinder.start": 0.02},
    "impossible run: cylinder.start is 0.99: with shapes.c1": {"cylinder.start": 0.99},
    "cylinder.diameter is 0.021": {"cylinder.diameter": 0.021},
    "second.gap is 0.02 m: with shapes.c1": {"second": SECOND},
    "cylinder.stroke is 0.05": {"cylinder.stroke": 0.05},
    "cylinder.stroke is 0.009": {"cylinder.direction": 0.0, "cylinder.stroke": 9e-3},
    # what another value excludes
    "record.window ends at 0.007 m, beyond cylinder.stroke": {"record.window": [1e-3, 7e-3]},
    "window [0.005, 0.001] must run from less to more": {"record.window": [5e-3, 1e-3]},
    "record.window [0.001, 0.001001] holds no bin": {"record.window": [1e-3, 1.001e-3]},
    "record.snapshots - 1, which is 7": {"record.snapshots": 8},
    "is 1.5; it must be at most 1, or allow_unstable be true.": {"numerics.step_fraction": 1.5},
    "one follows from the other, make one of them null": {"packing.pressure": 3e7},
    "give it, or a pressure in its place": {"packing.fraction": None},
    "aspect_ratio is missing; kind ellipse needs one": {"shapes.e1.aspect_ratio": None},
    "aspect_ratio is 1.5; a dumbbell always has 2": {"shapes.d1.aspect_ratio": 1.5},
    "aspect_ratio is given; kind clump takes no": {
        "shapes.e1.kind": "clump",
        "shapes.e1.discs": [[0, 0, 1]],
    },
    "has the kinds disc and dumbbell; its shapes must be of one kind": {"shapes.m": MIXED},
    "kind is given; a mixture takes none": {"shapes.m": MIXED | {"kind": "disc"}},
    "run: shapes.c1.granules is missing; only a part of": {"shapes.c1.granules": None},
    "sum to 0.9; they must": {"shapes.m": MIXED | {"mixture": {"c1": 0.5, "d1": 0.4}}},
    "'c3', which is not one of shapes": {"shapes.m": MIXED | {"mixture": {"c1": 0.5, "c3": 0.5}}},
    "has m, a mixture itself": {"shapes.m": MIXED | {"mixture": {"c1": 0.5, "m": 0.5}}},
    "rolling is for discs, and shapes.d1.kind is dumbbell; make the": {
        "rolling": {"granule": 0.1, "wall": 0.1, "cylinder": 0.1}
    },
    "is 2 and outline wedge; leave it out, or let outline be ellipse or plate": {
        "cylinder.outline": "wedge",
        "cylinder.aspect_ratio": 2,
    },
    "a pressure needs a top wall, let periodic be none or x": PRESSED | {"periodic": "y"},
    "friction is 0.3 and preparation relaxed; a bed that is packed under a pressure is": PRESSED
    | {"packing.friction": 0.3},
    "the room above the bed, let it be at most 0.75": SETTLED | {"packing.fraction": 0.8},
    "settled, gravity 0 and periodic none; granules settle on": SETTLED | {"gravity": 0.0},
    "settled, gravity 9.81 and periodic xy; granules settle on": SETTLED | {"periodic": "xy"},
    "and law line; leave it out, or let law": {"contact.law": "line", "contact.stiffness": 1e6},
    "law is cohesive; give pull_off too": {"contact": {"law": "cohesive", "range": 1e-6}},
    "beds are packed without attraction": {"contact": COHESIVE, "experiment": "jamming"},
    "give cylinder too": {"cylinder": None, "experiment": "onset", "second": SECOND},
    "the experiment jamming compresses its bed, let it be relaxed or grown": SETTLED
    | {"experiment": "jamming"},
    "preparation is settled; the experiment onset needs relaxed, because": ONSET,
}
OF_FILE = {"extends": CONFIG / "smoke.yaml"}
CALLS = {
    "shape is missing": partial(dem.run_experiment, OF_FILE),
    "values: friction.granule is -1; it must be at least 0.": partial(
        dem.run_experiment, OF_FILE | {"shape": "c1", "friction": {"granule": -1}}
    ),
}
