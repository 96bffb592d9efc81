"""Promises over all values of a configuration, by the schema, so that a value is tested on the day it comes.

In scenes that together read every value, each value is changed by itself, and each experiment is asked.
"""

import pickle
import re
import typing
from functools import cache

import numpy as np
import pytest
from sweeps import smoke

import dem
from dem.experiment.bed import make_bed, room_of
from dem.experiment.config import EXPERIMENTS
from dem.experiment.scene import make_scene
from dem.laws import LAWS
from dem.shapes import KINDS

pytestmark = pytest.mark.quick

SOFT = {"young_modulus": 5e9, "poisson_ratio": 0.3, "restitution": 0.7}
DISC = {"kind": "disc", "diameter": 8e-4, "granules": 20}
ROLLING = {"granule": 0.1, "wall": 0.1, "cylinder": 0.1}
SECOND = {"diameter": 8e-4, "gap": 2e-4, "spin": 40.0, "friction": 0.1}
WALLS = {side: {"friction": 0.2, "material": SOFT} for side in ("left", "right", "bottom", "top")}
CELL = {"inertial_number": 0.1, "pressure": 1e7, "settle": 4.0, "strain": 0.01, "samples": 2}
SOLIDS = {"plate": {"outline": "plate", "diameter": 2e-3, "thickness": 3e-4, "x": 2e-3, "y": 2e-3, "angle": 0.1, "pivot_x": 1.8e-3, "pivot_y": 2.1e-3,
                    "velocity": 0.1, "direction": 0.2, "spin": 5.0, "friction": 0.2, "material": SOFT},
          "club": {"x": 1.2e-3, "y": 9e-3, "velocity": 0.1, "direction": 0.2, "spin": 5.0, "friction": 0.2, "material": SOFT, "parts": {
              "bar": {"outline": "plate", "diameter": 8e-4, "thickness": 3e-4, "x": 1e-4, "y": 1e-4, "angle": 0.2},
              "arm": {"outline": "plate", "diameter": 1.4e-3, "thickness": 3e-4, "x": 3e-4}}}}  # fmt: skip
PISTON = {"outline": "circle", "diameter": 8e-4, "x": 3e-3, "y": 5e-4, "force_y": 0.1, "mass": 1e-5, "torque": 1e-6, "weight": True, "spring_x": 10.0,
          "velocity": 0.1, "direction": 0.4}  # fmt: skip
SMALL = {"box_width": 4e-3, "packing.fraction": 0.74, "cylinder.diameter": 1e-3, "cylinder.stroke": 2e-5,
         "cylinder.start": 0.4, "record.bins": 6, "record.window": [0.0, 2e-5], "record.snapshots": 2,
         "numerics.step_fraction": 0.05, "record.observables": ["drag", "snapshots", "solids"], "shapes": {"x": DISC}}  # fmt: skip
PLATE = {"cylinder.outline": "plate", "cylinder.aspect_ratio": 4.0, "cylinder.angle": 0.2, "cylinder.diameter": 1.6e-3}  # fmt: skip
# The plate and the linear law are in beds alone, and a pressure is on discs: as in beds that other tests pack.
SCENES = {
    "discs": {"cylinder.material": SOFT, "cylinder.spin": 50.0, "cylinder.direction": 0.3, "second": SECOND,
              "gravity": 9.81, "walls": WALLS, "rolling": ROLLING, "packing.fraction": 0.77, "packing.friction": 0.2},
    "pressed": {"packing.fraction": None, "packing.pressure": 3e7, "periodic": "x"},
    "settled": {"packing.preparation": "settled", "packing.fraction": 0.5, "packing.friction": 0.2, "gravity": 1e3, "material.young_modulus": 2e9,
                "contact": {"law": "cohesive", "pull_off": 1e-3, "range": 1e-6}},
    "ellipses": {"shapes": {"x": DISC | {"kind": "ellipse", "aspect_ratio": 1.4}}},
    "materials": {"shapes": {"x": {"granules": 20, "mixture": {"y": 0.5, "z": 0.5}}, "z": DISC | {"diameter": 7e-4},
                             "y": DISC | {"material": SOFT | {"density": 5e3}}}},
    "jamming": {"experiment": "jamming", "cylinder": None, "periodic": "x", "contact": {"law": "linear", "stiffness": 1e6}},
    "onset": PLATE | {"experiment": "onset"},
    "scene": {"experiment": "scene", "cylinder": None, "gravity": 1e3, "packing.fraction": None, "packing.height": 12e-3,
              "packing.preparation": "lattice", "packing.region": [0.0, 1e-3, 4e-3, 12e-3], "material.young_modulus": 1e8,
              "record": {"bins": 4, "snapshots": 3, "cells": 9, "region": [0.0, 0.0, 2e-3, 6e-3]}, "solids": SOLIDS,
              "sinks": {"floor": {"region": [None, None, None, 2.2e-3], "to": "rain"}}, "exchange_interval": 1e-4,
              "sources": {"rain": {"region": [5e-4, 8e-3, 3.5e-3, 11.5e-3], "count": 9, "rate": 1.5e4, "velocity_x": 0.1, "velocity_y": -0.2}},
              "phases": {"fall": {"time": 4e-4}, "move": {"time": 2e-4, "motion": {"plate": {"velocity": -0.5, "direction": 0.1, "spin": 9.0}}}}},
    "shear": {"experiment": "shear", "cylinder": None, "record": None, "shear": CELL, "periodic": "x",
              "packing.fraction": 0.83, "numerics.step_fraction": 0.3, "material.young_modulus": 2e10, "shapes": {"x": DISC | {"granules": 40}}},
}  # fmt: skip
FILE = ["x,y,angle", *(f"{1e-3 * (k % 3 + 1)},{1e-3 * (k // 3 + 4)},{k}" for k in range(20))]
SCENES["file"] = SCENES["scene"] | {"packing.preparation": "file", "packing.region": None, "packing.file": FILE, "periodic": "x", "solids": {"piston": PISTON}}  # fmt: skip
SCENES["file"] |= {
    "sinks": {},
    "sources": {},
    "exchange_interval": None,
    "phases": {
        "fall": {"time": 4e-4},
        "move": {
            "time": 2e-4,
            "motion": {"piston": {"force_x": 0.1, "torque": -1e-6}},
        },
    },
}
LYING = {"friction": 0.3, "solid": 0.2, "gravity": 1e3, "slope": 0.2, "slip": 0.01}
SCENES["flat"] = SCENES["file"] | {"gravity": 0.0, "solids": {"piston": PISTON | {"weight": False}}, "base_plate": LYING}  # fmt: skip
NAMES = {
    "experiment": [*EXPERIMENTS][::-1],
    "law": LAWS,
    "kind": KINDS,
}  # that the schema leaves to folders
# numbers that are tried in turn where there is none, by their units
ABSENT = {"1": (0.37, 2.0), "m": (1e-3,), "s": (1e-9,), "Pa": (3e7,), "rad": (0.3,), "rad s-1": (40.0,),
          "kg m-3": (5e3,), "N": (1e-3,), "N m": (1e-6,), "kg": (1e-6,), "m s-1": (0.2,), "N m-1": (1e6,), "m s-2": (9.81,)}  # fmt: skip
# values by which granules move while they are packed, and the scenes whose kernels others have for that
MOVED = "packing.friction", "packing.preparation"
IN_MOTION = "discs", "settled"
# values that need not change what a run gives
SILENT = {
    "numerics.max_overlap": "a run that reaches it ends",
    "numerics.allow_unstable": "the steps are not beyond the critical one",
}


@cache
def first(scene):
    """The run of a scene, its bed and what it gives."""
    values = smoke().changed(SMALL | SCENES[scene], "c1")
    replicate = values.replicate("x", 3900.0, 3)
    bed = make_bed(replicate.bed_description)
    return replicate, bed, given(replicate, bed)


def given(replicate, bed):
    """What a run gives, but for times."""
    values = replicate.configuration.module.run(replicate, bed)
    values.pop("run_time", None)
    return values


def texts(annotation):
    """The texts that a type names."""
    if typing.get_origin(annotation) is typing.Literal:
        return typing.get_args(annotation)
    return sum(map(texts, typing.get_args(annotation)), ())


def options(entry, value):
    """Other values to try at a path."""
    known = NAMES.get(entry.path.rpartition(".")[2]) or texts(entry.field.annotation)
    if isinstance(value, bool):
        return [not value]
    if known and not isinstance(value, float):
        return [t for t in known if t != value and f"none: {t}" not in entry.about]
    if isinstance(value, tuple):
        return [tuple(side and part * side for side in value) for part in (0.5, 0.8, 0.97)]
    if not value:
        return ABSENT[entry.units]
    return [2 * value, value + 1] if isinstance(value, int) else [1.1 * value, 0.5 * value]


def changed(scene, density=3900.0, seed=3, **values):
    """The run of a scene with other values, by path; the density and the seed are values too."""
    return first(scene)[0].configuration.changed(values, "x").replicate("x", density, seed)


@cache
def others(scene):
    """Another value, and the run with it, by path. Where none is taken, the sentence names the path."""
    values, taken = first(scene)[0].configuration, {}
    tried = {"density": [4e3], "seed": [4]}
    for path, entry in values.entries.items():
        section = path.rpartition(".")[0]
        if not section or values.at(section) is not None:
            tried[path] = options(entry, values.at(path))
    for path, some in tried.items():
        for value in some:
            try:
                taken[path] = value, changed(scene, **{path: value})
                break
            except dem.InputError as error:
                words = str(error)
        else:
            assert path.rpartition(".")[2] in words
    return taken


def alike(one, two):
    """Whether arrays or numbers are the same to the last bit."""
    return all(np.array_equal(*pair, equal_nan=True) for pair in zip(one, two, strict=True))


def parts(replicate, bed):
    """What is packed and what is simulated, as bytes."""
    return pickle.dumps(room_of(replicate.bed_description)), pickle.dumps(
        make_scene(replicate, bed)
    )


def is_free(path):
    """Whether only other runs read a value: of ellipses, or how many granules there are of a part of a mixture."""
    return path.startswith("ellipse.") or path in ("shapes.y.granules", "shapes.z.granules")


@pytest.mark.parametrize("scene", SCENES)
def test_a_bed_and_a_run_are_known_by_all_that_they_read(scene):
    """All values that one is not known by are changed together: none of its numbers differs by a bit."""
    replicate, bed, values = first(scene)
    taken = others(scene).items()
    shared = {path: value for path, (value, run) in taken if run.bed_id == replicate.bed_id}
    same = changed(scene, **shared)
    assert same.bed_id == replicate.bed_id and alike(bed[:2], make_bed(same.bed_description)[:2])
    unread = {path: value for path, (value, run) in taken if run.id == replicate.id}
    assert all(map(is_free, unread)) or replicate.configuration.module.constants.get("BED_ALONE")
    same = changed(scene, **unread)
    assert same.id == replicate.id and alike(values.values(), given(same, bed).values())


@pytest.mark.parametrize("scene", SCENES)
def test_each_value_changes_what_a_run_gives_or_is_refused(scene):
    """No run is made where other granules are packed, or another scene is simulated."""
    replicate, bed, values = first(scene)
    packed, simulated = parts(replicate, bed)
    silent, needless = set(), set()
    for path, (_, other) in others(scene).items():
        if path in MOVED and scene not in IN_MOTION:
            continue
        granules, scene_of_other = parts(other, bed)
        bed_of_other = bed
        if other.bed_id != replicate.bed_id and granules == packed:
            bed_of_other = make_bed(other.bed_description)
            if alike(bed[:2], bed_of_other[:2]):
                needless.add(f"{scene}: {path}")
        if other.id != replicate.id and (granules, scene_of_other) == (packed, simulated):
            results = given(other, bed_of_other)
            if results.keys() == values.keys() and alike(values.values(), results.values()):
                silent.add(path)
    assert silent <= SILENT.keys() and not needless


def test_every_value_is_taken_in_some_scene():
    def paths(tables):
        return {
            re.sub(r"(shapes|solids|motion|sinks|sources)\.\w+", r"\1.x", path)
            for table in tables
            for path in table
        }

    known = paths(first(scene)[0].configuration.entries for scene in SCENES)
    assert known - {"experiment"} <= paths(map(others, SCENES))
