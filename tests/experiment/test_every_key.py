"""Promises over all values of a configuration, by the schema, so that a value is tested on the day it comes.

In scenes that together read every value, each value is changed by itself, and each experiment is asked.
"""

import pickle
import re
import typing
from functools import cache

import numpy as np
import pytest
from project import CONFIG

from dem.base.errors import InputError
from dem.experiment.bed import make_bed, room_of
from dem.experiment.config import EXPERIMENTS
from dem.experiment.scene import make_scene
from dem.laws import LAWS
from dem.shapes import KINDS
from dem.sweep.config import load

pytestmark = pytest.mark.quick

SOFT = {"young_modulus": 5e9, "poisson_ratio": 0.3, "restitution": 0.7}
DISC = {"kind": "disc", "diameter": 8e-4, "granules": 20}
ROLLING = {"granule": 0.1, "wall": 0.1, "cylinder": 0.1}
SECOND = {"diameter": 8e-4, "gap": 2e-4, "spin": 40.0, "friction": 0.1}
WALLS = {side: {"friction": 0.2, "material": SOFT} for side in ("left", "right", "bottom", "top")}
CELL = {"inertial_number": 0.1, "pressure": 1e7, "settle": 4.0, "strain": 0.01, "samples": 2}
SMALL = {"box_width": 4e-3, "packing.fraction": 0.74, "cylinder.diameter": 1e-3, "cylinder.stroke": 2e-5,
         "cylinder.start": 0.4, "record.bins": 4, "record.window": [0.0, 2e-5], "record.snapshots": 2,
         "numerics.step_fraction": 0.05, "record.observables": ["drag", "snapshots", "solids"], "shapes": {"x": DISC}}  # fmt: skip
PLATE = {
    "cylinder.outline": "plate",
    "cylinder.aspect_ratio": 4.0,
    "cylinder.angle": 0.2,
    "cylinder.diameter": 1.6e-3,
}
ALONE = {"cylinder": None, "packing.friction": 0.2}
SCENES = {
    "discs": {"cylinder.material": SOFT, "cylinder.spin": 50.0, "gravity": 9.81, "walls": WALLS},
    "rolling": {"rolling": ROLLING},
    "linear": {"contact": {"law": "linear", "stiffness": 1e6}},
    "two cylinders": {"second": SECOND, "cylinder.direction": 0.3},
    "plate": PLATE,
    "square": {"cylinder.outline": "square", "cylinder.diameter": 1.6e-3, "packing.fraction": 0.7},
    "pressure": {"packing.fraction": None, "packing.pressure": 3e7, "periodic": "x"},
    "friction": {"packing.fraction": 0.8, "packing.friction": 0.2},
    "settled": {"packing.preparation": "settled", "packing.fraction": 0.5, "gravity": 1e3, "material.young_modulus": 2e9},
    "ellipses": {"shapes": {"x": DISC | {"kind": "ellipse", "aspect_ratio": 1.4}}},
    "materials": {"shapes": {"x": {"granules": 20, "mixture": {"y": 0.5, "z": 0.5}}, "z": DISC | {"diameter": 7e-4},
                             "y": DISC | {"material": SOFT | {"density": 5e3}}}},
    "jamming": {"experiment": "jamming", **ALONE},
    "onset": {"experiment": "onset", "cylinder": None},
    "shear": {"experiment": "shear", "cylinder": None, "record": None, "shear": CELL, "periodic": "x",
              "packing.fraction": 0.83, "numerics.step_fraction": 0.3, "material.young_modulus": 2e10, "shapes": {"x": DISC | {"granules": 40}}},
}  # fmt: skip
NAMES = {"experiment": EXPERIMENTS, "law": LAWS, "kind": KINDS}  # that the schema leaves to folders
# numbers that are tried in turn where there is none, by their units
ABSENT = {"1": (0.37, 2.0), "m": (1e-3,), "s": (1e-9,), "Pa": (3e7,), "rad": (0.3,), "rad s-1": (40.0,),
          "kg m-3": (5e3,), "N m-1": (1e6,), "m s-2": (9.81,)}  # fmt: skip
# values by which granules move while they are packed, and the scenes whose kernels others have for that
MOVED = "packing.friction", "packing.preparation"
IN_MOTION = "discs", "friction", "settled", "onset"
# values, of a scene or of all, that need not change what a run gives
SILENT = {
    "numerics.max_overlap": "a run that reaches it ends",
    "numerics.allow_unstable": "the steps are not beyond the critical one",
    "onset: packing.preparation": "it is ignored, and should be refused",
}
# values that beds are known by without need: they are packed twice
NEEDLESS = {
    "materials: material.thickness": "without a stiffness of contacts, no bed depends on it",
    "materials: shapes.y.material.restitution": "all of a shape is taken",
    "materials: shapes.y.material.density": "all of a shape is taken",
}


@cache
def configuration(scene):
    return load(CONFIG / "smoke.yaml").changed(SMALL | SCENES[scene], "c1")


def run(values, label="x", density=3900.0, seed=3):
    return values.replicate(label, density, seed)


@cache
def first(scene):
    """The run of a scene, its bed and what it gives."""
    replicate = run(configuration(scene))
    bed = make_bed(replicate)
    return replicate, bed, given(replicate, bed)


def given(replicate, bed):
    """What a run gives, but for times."""
    experiment = replicate.configuration.module
    values = experiment.run(replicate, bed)
    return {name: value for name, value in values.items() if name != "run_time"}


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
    if not value:
        return ABSENT[entry.units]
    return (
        [2 * value, value + 1] if isinstance(value, int) else [1.1 * value, 0.5 * value, 2 * value]
    )


@cache
def others(scene):
    """The run with another value, by path; and by path the sentence where none is taken."""
    values, runs, refused = configuration(scene), {}, {}
    for path, entry in values.entries.items():
        if values.at(path.rpartition(".")[0]) is None and "." in path:
            continue  # a section that is not there
        for value in options(entry, values.at(path)):
            try:
                runs[path] = value, run(values.changed({path: value}, "x"))
                break
            except InputError as error:
                refused[path] = str(error)
    coordinates = {"density": {"density": 4e3}, "seed": {"seed": 4}}
    runs |= {name: (None, run(values, **change)) for name, change in coordinates.items()}
    return runs, {path: words for path, words in refused.items() if path not in runs}


def together(scene, paths):
    """The run with other values at several paths at once."""
    values, runs = configuration(scene), others(scene)[0]
    changes = {path: runs[path][0] for path in paths if path in values.entries}
    coordinates = {
        name: getattr(runs[name][1], name) for name in ("density", "seed") if name in paths
    }
    return run(values.changed(changes, "x"), **coordinates)


def alike(one, two):
    """Whether arrays or numbers are the same to the last bit."""
    return all(np.array_equal(*pair, equal_nan=True) for pair in zip(one, two, strict=True))


def parts(replicate, bed):
    """What is packed and what is simulated, as bytes."""
    return pickle.dumps(room_of(replicate)), pickle.dumps(make_scene(replicate, bed))


def is_free(path):
    """Whether only other runs read a value: of ellipses, or how many granules there are of a part of a mixture."""
    return path.startswith("ellipse.") or path in ("shapes.y.granules", "shapes.z.granules")


@pytest.mark.parametrize("scene", SCENES)
def test_runs_share_a_bed_where_it_has_the_same_bits(scene):
    """All values that the bed is not known by are changed together."""
    replicate, bed, _ = first(scene)
    runs = others(scene)[0].items()
    other = together(scene, [path for path, (_, run) in runs if run.bed_id == replicate.bed_id])
    assert other.bed_id == replicate.bed_id
    assert alike(bed[:2], make_bed(other)[:2])


@pytest.mark.parametrize("scene", SCENES)
def test_a_run_is_known_by_all_that_it_reads(scene):
    """All values that it is not known by are changed together: no result differs by a bit."""
    replicate, bed, values = first(scene)
    unread = [path for path, (_, run) in others(scene)[0].items() if run.id == replicate.id]
    assert all(map(is_free, unread)) or replicate.configuration.module.constants.get("BED_ALONE")
    other = together(scene, unread)
    assert other.id == replicate.id and alike(values.values(), given(other, bed).values())


@pytest.mark.parametrize("scene", SCENES)
def test_each_value_changes_what_a_run_gives_or_is_refused(scene):
    """No run is made where other granules are packed, or another scene is simulated."""
    replicate, bed, values = first(scene)
    packed, simulated = parts(replicate, bed)
    silent, needless = set(), set()
    runs, refused = others(scene)
    for path, (_, other) in runs.items():
        if path in MOVED and scene not in IN_MOTION:
            continue
        granules, scene_of_other = parts(other, bed)
        bed_of_other = bed
        if other.bed_id != replicate.bed_id and granules == packed:
            bed_of_other = make_bed(other)
            if alike(bed[:2], bed_of_other[:2]):
                needless.add(path)
        if other.id != replicate.id and (granules, scene_of_other) == (packed, simulated):
            results = given(other, bed_of_other)
            if results.keys() == values.keys() and alike(values.values(), results.values()):
                silent.add(path)
    assert not [path for path in silent if not {path, f"{scene}: {path}"} & SILENT.keys()]
    assert {f"{scene}: {path}" for path in needless} <= NEEDLESS.keys()
    assert all(path.rpartition(".")[2] in words for path, words in refused.items())


def test_every_value_is_taken_in_some_scene():
    labels = re.compile(r"shapes\.\w+")
    known, taken = (
        {labels.sub("shapes.x", path) for scene in SCENES for path in table(scene)}
        for table in (lambda scene: configuration(scene).entries, lambda scene: others(scene)[0])
    )
    assert known - {"experiment"} <= taken
