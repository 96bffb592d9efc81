"""Scenes that cannot be: solids, phases and places."""

from project import CONFIG

from dem.sweep.config import load

PATH = CONFIG / "scenes/hopper.yaml"


def scene(**changes):
    values = {path.replace("__", "."): value for path, value in changes.items()}
    return lambda: load(PATH).changed(values, "disc").replicate("disc", 2500.0, 1)


def solid(**changes):
    return scene(**{f"solids__gate__{name}": value for name, value in changes.items()})


def fed(by="above", **changes):
    """A hopper whose granules come again above."""
    source = {"region": [0.002, 0.045, 0.018, 0.058]} | changes.pop("source", {})
    sink = {"region": [None, None, None, 0.004], "to": by} | changes.pop("sink", {})
    return scene(sinks={"below": sink}, sources={"above": source}, **changes)


def of_file(**changes):
    granules = {"packing__file": ["x,y", "0.01,0.03"], "packing__region": None}
    return scene(**{"packing__preparation": "file"} | granules | changes)


BALL = {"outline": "circle", "diameter": 2e-3, "x": 3e-3}
PART = {"kind": "disc", "diameter": 1e-3}
MIXED = {"disc": {"granules": 1, "mixture": {"a": 0.5, "b": 0.5}}, "a": PART, "b": PART}

ANGULAR = {"disc": {"kind": "superellipse", "aspect_ratio": 1.2, "diameter": 1e-3, "granules": 60}}
CALLS = {
    "settle on no floor, let it be relaxed or grown": scene(gravity=0.0, base_plate={"friction": 0.3}, packing__preparation="settled", packing__region=None),
    "gravity is 9.81, in the plane of the bed, and base_plate is given": scene(base_plate={"friction": 0.3}),
    "sinks.below.to is 'abov', which is not one of sources; the nearest is above": fed("abov"),
    "sources.above.count is missing; no sink gives it granules": fed(None, source={"rate": 9.0}),
    "exchange_interval is missing; without gravity": fed(gravity=0.0, phases={"open": {"time": 0.1}}),
    "exchange_interval is 0.001 s; there are no sinks and no sources": scene(exchange_interval=1e-3),
    "sinks.below.region is [None, 0.01, None, 0.004]; it must be left, bottom, right, top": fed(sink={"region": [None, 0.01, None, 0.004]}),
    "sources.above.region is [0.002, 0.045, 0.022, 0.058]: with shapes.disc": fed(source={"region": [0.002, 0.045, 0.022, 0.058]}),
    "sources.above.region is [0.002, 0.045, 0.018, 0.046]; it must be wider": fed(source={"region": [0.002, 0.045, 0.018, 0.046]}),
    "sources.above.region is [0.008, 0.0158, 0.012, 0.0172]; solids leave no place": fed(source={"region": [0.008, 0.0158, 0.012, 0.0172]}),
    "motion has 'gte', which is not one of solids; the nearest is gate": scene(phases__open__motion={"gte": {"spin": 1.0}}),
    "phases.open.motion.gate.spin is 'fre'": scene(phases__open__motion={"gate": {"spin": "fre"}}),
    "motion has gate, which phases.fill removed": scene(phases__fill__motion={"gate": {"removed": True}}, phases__open__motion={"gate": {"spin": 1.0}}),
    "removed is true and spin given": scene(phases__open__motion={"gate": {"removed": True, "spin": 1.0}}),
    "torque is given and spin free": solid(torque=1.0, spin="free"),
    "direction is 1 and velocity missing": solid(direction=1.0, force_x=1.0),
    "solids.gate.mass is 1 and no force moves it": solid(mass=1.0),
    "solids.gate has a force, and the solid a pivot": solid(force_y=1.0, pivot_x=0.0),
    "phases.open.motion.gate has one of velocity and direction": scene(phases__fill__motion={"gate": {"force_x": 1.0}}, phases__open__motion={"gate": {"velocity": 1.0}}),
    "record.observables has flow, which needs a cylinder": scene(record__observables=["scene", "flow"]),
    "solids.gate.material.young_modulus cannot vary; there is no material, give that first": solid(material__young_modulus=1e9),
    "path and spin are given": solid(path=[[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0]], spin=1.0),
    "path and direction are given": solid(path=[[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0]], spring_x=1.0, direction=0.0),
    "path has a spin, and it is that of the point to which": solid(path=[[0.0, 0.0, 0.0, 0.0], [1.0, 0.0, 1.0, 2.0]], spring_x=1.0),
    "solids.gate.force_x is [[1.0, 0.0], [1.0, 2.0]]; it must be a force, or rows [time, force] whose times rise": solid(force_x=[[1.0, 0.0], [1.0, 2.0]]),
    "solids.gate.weight is true and no force moves it along y": solid(weight=True, force_x=1.0),
    "solids.gate.weight is true and gravity 0": scene(solids__gate__weight=True, solids__gate__force_y=0.0, gravity=0.0, phases__fill={"time": 1.0, "until": None}),
    "outline is missing; give it, or parts": solid(outline=None),
    "outline and parts are given; parts have theirs": solid(parts={"a": BALL}),
    "solids.gate.parts have their centre at [0.003, 0]; a body that forces move": solid(outline=None, diameter=None, thickness=None, parts={"a": BALL}, force_y=0.0, spin="free"),
    "rows [time, velocity along x, along y, spin] whose times rise": solid(path=[[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 1.0, 0.0]]),
    "a time or until, and both are given": scene(phases__fill__time=1.0),
    "a time or until, and neither is given": scene(phases__fill__until=None),
    "phases.open is the last and has until": scene(phases__open={"until": "rest"}),
    "without gravity nothing comes to rest": scene(gravity=0.0),
    "to rest, give gravity, a base_plate with friction or a time": scene(gravity=0.0, base_plate={"friction": 0.0}),
    "phases is missing; the experiment scene needs it": scene(phases={}),
    "outline is circle, which turns about its middle": solid(outline="circle", thickness=None, pivot_x=0.0),
    "thickness is 0.0006 and outline square; leave it out": solid(outline="square"),
    "thickness is 0.01 m; it must be less than diameter, 0.008 m": solid(thickness=0.01),
    "it must be left, bottom, right, top, in this order": scene(record__region=[0.02, 0.0, 0.01, 0.03]),
    "height is missing; granules in a lattice fill no box": scene(packing__height=None, packing__fraction=0.5),
    "fraction is 0.5 and height 0.06; one follows": scene(packing__fraction=0.5),
    "friction is 0.3 and preparation lattice; nothing is packed": scene(packing__friction=0.3),
    "region is given; only a lattice has one": scene(packing__preparation="settled"),
    "solids.gate is 0.004 m inside the left wall; put": solid(x=0.0),
    "m inside solids.gate; put them beside": solid(y=0.0185),
    "record.window is given; the experiment scene has none": scene(record__window=[0.0, 1.0]),
    "packing.region is [0.0, 0.0, 0.03, 0.05]: with shapes.disc the box is": scene(packing__region=[0.0, 0.0, 0.03, 0.05]),
    "shapes.disc.granules is 500: with shapes.disc the box is 0.02 m by 0.06 m, and its rows between x": scene(shapes__disc__granules=500),
    "base_plate.solid is 0.2 and no force moves a solid": scene(gravity=0.0, base_plate={"friction": 0.3, "solid": 0.2}),
    "file is missing and preparation file; give one": of_file(packing__file=None),
    "file is given and preparation lattice; leave it out": of_file(packing__preparation="lattice"),
    "height is missing; granules of a file fill no box": of_file(packing__height=None, packing__fraction=0.5),
    "friction is 0.3 and preparation file; nothing is packed": of_file(packing__friction=0.3),
    "shapes.disc.granules is 200; packing.file has 1 granules": of_file(),
    "shapes.disc is a mixture; a file of granules does not say": of_file(shapes=MIXED),
    "solids.gate has the outline Ellipse; among granules of Superellipse it must": scene(solids__gate__outline="ellipse", shapes=ANGULAR),
    "another; name it among solids": scene(second={"diameter": 1e-3, "gap": 1e-3}),
    "record.bins is 61; it must be a multiple": scene(record__bins=61),
}  # fmt: skip
FILES = {
    "sinks is no section of the experiment drag": {"sinks": {"a": {"region": [None] * 4}}},
    "solids is no section of the experiment drag": {
        "solids": {"a": {"outline": "circle", "diameter": 1e-3, "x": 0.0, "y": 0.0}}
    },
    "preparation is lattice; such granules have still to fall": {
        "packing.preparation": "lattice",
        "packing.height": 0.02,
        "packing.fraction": None,
    },
    "preparation is file; such granules have still to fall": {
        "packing.preparation": "file",
        "packing.file": ["x,y", "0.01,0.01"],
        "packing.height": 0.02,
        "packing.fraction": None,
    },
    "packing.file is 'none.csv'; it cannot be read (": {"packing.file": "none.csv"},
    "packing.file is 3; it must be a file, or a list of its lines": {"packing.file": 3},
    "sweep: packing.file is not a value that can vary": {"sweep.packing/file": ["a.csv"]},
    "record.cells is given; the experiment drag has none": {"record.cells": 9},
    "record.window is missing; give the displacements": {"record.window": None},
}
