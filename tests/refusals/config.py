"""Values of a configuration that cannot be, and values that exclude each other."""

import datetime
import math
from functools import partial

from project import CONFIG

import dem
from dem.experiment.config import SECTIONS
from dem.experiment.kinds import EXPERIMENTS

ROLLING = {"granule": 0.1, "wall": 0.1, "cylinder": 0.1}
MIXED = {"granules": 100, "mixture": {"c1": 0.5, "d1": 0.5}}
DISCS = {"discs": [[0, 0, 1]]}
CLUMP = {"kind": "clump", "diameter": 1e-3, "granules": 100}
SECOND = {"diameter": 2e-3, "gap": 20e-3}
LONG = 300 * "n"
SHEAR = {"inertial_number": 0.1, "pressure": 1e5, "settle": 1, "strain": 1, "samples": 9}
GROUPS = {"shear": SHEAR}  # of sections that the paper has not
PRESSED = {"packing.fraction": None, "packing.pressure": 3e7}
SETTLED = {"packing.preparation": "settled", "packing.fraction": 0.6, "gravity": 9.81}
SETTLE = "granules settle on a floor, give gravity, and let periodic be none or x"
FRICTIONLESS = "a bed that is packed under a pressure is relaxed without friction, leave both out"

SINGLE = [
    ("colour", "red", "colour is not a known key; there are experiment, box_width,"),
    ("seeds", 5, "seeds is not a known key; the nearest is sweep."),
    ("box_width", "20 mm", "box_width is '20 mm'; it must be a number, in m."),
    ("gravity", True, "gravity is true; it must be a number, in m s-2."),
    ("gravity", math.nan, "gravity is nan; it must be finite, at most 1e+20 in size, in m s-2."),
    ("gravity", -1, "gravity is -1; it must be at least 0, in m s-2."),
    ("friction.granule", [0.1, 0.3], "friction.granule is [0.1, 0.3]; it must be a number."),
    ("friction", 0.3, "friction is 0.3; it must be a group of keys; its keys are granule, wall,"),
    ("material.young_modulus", 5e-324, "is 5e-324; it must be positive, at least 1e-20, in Pa."),
    ("material.restitution", 0.0, "material.restitution is 0.0; it must be at least 0.001."),
    ("packing.fraction", 84, "packing.fraction is 84; it must be below 1."),
    ("record.window", [1e-3], "record.window.1 is missing"),
    ("record.window", [0, 10**400], "it must be finite, at most 1e+20 in size, in m."),
    ("record.observables", "drag", "record.observables is 'drag'; it must be a list."),
    ("record.observables", ["drags"], "is 'drags'; it must be 'alignment', 'drag'"),
    ("shapes.e1.aspect_ratio", 0.8, "shapes.e1.aspect_ratio is 0.8; it must be at least 1."),
    ("shapes.c1.kind", "disk", "is 'disk'; it must be 'clump', 'disc', 'dumbbell', 'ellipse' or"),
    ("cylinder.outline", "star", "cylinder.outline is 'star'; it must be"),
    ("cylinder.spin", "fast", "cylinder.spin is 'fast'; it must be an angular velocity or free"),
    ("ellipse.contact", "geometric", "it must be 'common_normal' or 'geometric_potential'."),
    ("experiment", "darg", "experiment is 'darg'; it must be 'drag'"),
    ("results", "results/../..", "it must be results or a folder below it, such as results/mine"),
    ("results", "results/store", "but not that of the store"),
    ("extends", "config/papr.yaml", "config/papr.yaml: cannot read it"),
    ("cases", {"c1": 3}, "cases.c1 is 3; it must be a group of keys; its keys are shape, density."),
    ("cases.c1.shape", "C1", "is 'C1', which is not one of shapes; the nearest is c1"),
    ("extends", f"config/{LONG}.yaml", "nnn.yaml"),  # too long for a file
    ("experiment", f"{LONG}.py", "nnn.py"),
    ("shapes.c1.kind", f"{LONG}.Own", "nnn.Own"),
    ("title", datetime.date(2020, 1, 1), "title is 2020-01-01; it must be text."),
    ("friction", {1: 1}, "friction.1 is not a known key; there are granule, wall, cylinder, stif"),
    ("shapes", {False: {}}, "shapes.false is false; it must be a label: a letter from A to Z"),
    # what does not fit into its box
    ("shapes.c1.diameter", 0.03, "shapes.c1.diameter is 0.03"),
    ("cylinder.stroke", 0.05, "cylinder.stroke is 0.05"),
    ("cylinder.start", 0.02, "cylinder.start is 0.02"),
    ("cylinder.start", 0.99, "asks for an impossible run: cylinder.start is 0.99: with shapes.c1"),
    ("cylinder.diameter", 0.021, "cylinder.diameter is 0.021"),
    ("second", SECOND, "second.gap is 0.02 m: with shapes.c1"),
    # what another value excludes
    ("record.window", [1e-3, 7e-3], "record.window ends at 0.007 m, beyond cylinder.stroke"),
    ("record.window", [5e-3, 1e-3], "window [0.005, 0.001] must run from less to more"),
    ("record.window", [1e-3, 1.001e-3], "record.window [0.001, 0.001001] holds no bin"),
    ("record.snapshots", 8, "record.snapshots - 1, which is 7"),
    ("numerics.step_fraction", 1.5, "is 1.5; it must be at most 1, or allow_unstable be true."),
    ("packing.pressure", 3e7, "one follows from the other, make one of them null"),
    ("packing.fraction", None, "fraction is missing; give it, or a pressure in its place"),
    ("shapes.e1.aspect_ratio", None, "shapes.e1: aspect_ratio is missing; kind ellipse needs one"),
    ("shapes.d1.aspect_ratio", 1.5, "aspect_ratio is 1.5; a dumbbell always has 2"),
    ("shapes.c1.discs", DISCS["discs"], "shapes.c1: discs is given; kind disc takes none"),
    ("shapes.m", CLUMP, "shapes.m: discs is missing; kind clump needs one"),
    ("shapes.m", CLUMP | DISCS | {"aspect_ratio": 2}, "aspect_ratio is given; kind clump takes no"),
    ("shapes.m", MIXED, "has the kinds disc and dumbbell; its shapes must be of one kind"),
    ("shapes.m", MIXED | {"kind": "disc"}, "kind is given; a mixture takes none"),
    ("shapes.m", MIXED | {"mixture": {"c1": 0.5, "c2": 0.4}}, "sum to 0.9; they must sum to 1"),
    ("shapes.m", MIXED | {"mixture": {"c1": 0.5, "c3": 0.5}}, "'c3', which is not one of shapes"),
    ("shapes.m", MIXED | {"mixture": {"c1": 0.5, "m": 0.5}}, "has m, a mixture itself"),
    ("rolling", ROLLING, "rolling is for discs, and shapes.d1.kind is dumbbell; make the"),
]
FILES = {f"{key}: {words}": ({key: value}, words) for key, value, words in SINGLE}

WEDGE = {"cylinder.outline": "wedge", "cylinder.aspect_ratio": 2}
TOGETHER = [
    (WEDGE, "is 2 and outline wedge; leave it out, or let outline be ellipse or plate"),
    (PRESSED | {"periodic": "y"}, "a pressure needs a top wall, let periodic be none or x"),
    (PRESSED | {"packing.friction": 0.3}, FRICTIONLESS),
    (PRESSED | {"packing.preparation": "grown"}, FRICTIONLESS),
    (SETTLED | {"packing.fraction": 0.8}, "the room above the bed, let it be at most 0.75"),
    (SETTLED | {"gravity": 0.0}, SETTLE),
    (SETTLED | {"periodic": "xy"}, SETTLE),
    ({"contact.law": "line", "contact.stiffness": 1e6}, "and law line; leave it out, or let law"),
    ({"cylinder.direction": 0.0, "cylinder.stroke": 9e-3}, "would leave it during its stroke; at"),
    ({"cylinder": None, "experiment": "onset", "second": SECOND}, "give cylinder too"),
]
FILES |= {f"{changes} {words}": (changes, words) for changes, words in TOGETHER}
for name, header in EXPERIMENTS.items():
    for section in SECTIONS:
        needed, change = header["SECTIONS"].get(section), {"experiment": name}
        if needed is None and section in GROUPS:
            words = f"{section} is no section of the experiment {name}; leave it out"
            FILES[f"{name}: {words}"] = change | {section: GROUPS[section]}, words
        elif needed:
            words = f"{section} is missing; the experiment {name} needs it"
            others = {other: None for other in SECTIONS if header["SECTIONS"].get(other) is None}
            FILES[f"{name}: {words}"] = change | others | {section: None}, words
    if header.get("BED_ALONE") and "packing.preparation" not in header["ASKS"]:
        words = f"the experiment {name} compresses its bed, let it be relaxed or grown"
        FILES[words] = SETTLED | {"experiment": name}, words
for preparation in ("grown", "settled"):
    words = f"packing.preparation is {preparation}; the experiment onset needs relaxed, because"
    FILES[words] = SETTLED | {"experiment": "onset", "packing.preparation": preparation}, words
OF_FILE = {"extends": CONFIG / "smoke.yaml"}
WRONG = OF_FILE | {"shape": "c1", "friction": {"granule": -1}}
CALLS = {
    "a run without a shape": (partial(dem.run_experiment, OF_FILE), "shape is missing"),
    "a run with a wrong value": (
        partial(dem.run_experiment, WRONG),
        "values: friction.granule is -1; it must be at least 0.",
    ),
}
