"""Small packed beds that several tests share."""

from functools import cache
from typing import NamedTuple

import numpy as np
from project import CONFIG

import dem
from dem import shapes
from dem.experiment.sections import ShapeSection
from dem.sweep.config import load

KINDS = sorted(shapes.KINDS, key=len, reverse=True)  # "superellipse" before "ellipse"


# packing fractions at which beds are stiff
STIFF = [(kind, 0.88 if "ellipse" in kind else 0.84) for kind in shapes.KINDS]


ROD = [(-0.8, 0.0, 0.8), (0.0, 0.0, 1.0), (0.8, 0.0, 0.8)]  # x, y, radius of the discs of clumps


def section_of(kind):
    """The granules of the small beds, as in config/smoke.yaml."""
    ratio = None if shapes.KINDS[kind].aspect_ratio else 1.375
    form = {"discs": ROD} if kind == "clump" else {"aspect_ratio": ratio}
    return ShapeSection(kind=kind, diameter=1092e-6, granules=60, **form)


class Small(NamedTuple):
    """A packed bed of 60 granules, with the sizes (m) and the shape that it was made from."""

    diameters: np.ndarray
    shape: tuple
    cylinder: dem.Solid
    bed: dem.Bed

    def scene(self, **changes):
        """Scene with friction, damping, walls and the cylinder: one compilation a kind of granule."""
        defaults = {
            "friction": dem.Friction(),
            "walls": self.bed.walls,
            "solids": self.cylinder,
            "thickness": 1e-3,
        }
        return dem.Scene(self.shape, **defaults | changes)

    @property
    def state(self):
        return dem.State(self.bed.position.copy(), angle=self.bed.angle.copy())


@cache
def small_bed(kind, fraction=0.84):
    """A packed bed of a kind of granule."""
    sweep = load(CONFIG / "smoke.yaml").changed({"packing.fraction": fraction}, "c1")
    section = section_of(kind)
    discs = sweep.replicate("c1", 3900.0, 1).bed_description  # as many, of the same sizes
    diameters, height = discs.diameters, discs.height(discs.diameters)
    shape = shapes.KINDS[kind].shape.of_size(diameters, section.form)
    axis = 0.5 * sweep.box_width, sweep.cylinder.start * height
    cylinder = dem.Cylinder(sweep.cylinder.diameter, axis, (0.0, sweep.cylinder.velocity))
    return Small(diameters, shape, cylinder, dem.pack(shape, 8e-3, height, cylinder, 1))


PRESSURE, HIGH = 60e6, 150e6  # Pa


def replicate(pressure=PRESSURE, **changes):
    """A run of the small bed of discs under a pressure."""
    values = {
        "packing.fraction": None,
        "packing.pressure": pressure,
        "periodic": "x",
        "record.observables": ["drag", "snapshots", "top"],
    }
    sweep = load(CONFIG / "smoke.yaml")
    return sweep.changed(values | changes, "c1").replicate("c1", 3900.0, 1)


def area_of(run):
    """Area (m2) of the top wall."""
    return run.configuration.box_width * run.shape.diameter
