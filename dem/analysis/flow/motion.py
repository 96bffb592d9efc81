"""The snapshots of one replicate, with all that is needed to draw and to measure them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base.errors import InputError
from dem.dynamics.simulation import Simulation
from dem.dynamics.touching import Touching
from dem.experiment import drag
from dem.experiment.config import Replicate, parse
from dem.io.dataset import content_of, read
from dem.packing.random import Bed
from dem.shapes import KINDS

READ = (
    "snapshot_displacement", "cylinder_y", "granule_x", "granule_y", "granule_angle",
    "granule_diameter", "box_height", "shape", "density", "seed", "displacement", "drag",
)  # fmt: skip


class Motion(NamedTuple):
    """Snapshots s of granules n. SI units.

    displacement, cylinder_y (s,); position (s, n, 2); angle (s, n); diameters (n,); drag (bins,)
    at drag_displacement (bins,).
    """

    replicate: Replicate
    height: float
    displacement: np.ndarray
    cylinder_y: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    diameters: np.ndarray
    drag_displacement: np.ndarray
    drag: np.ndarray

    @property
    def outlines(self) -> np.ndarray:
        """Outlines (n, rings, points, 2) in m about the centre at angle zero."""
        kind = KINDS[self.replicate.shape.kind].shape
        return kind.of_size(self.diameters, self.replicate.shape.ratio).polygons(33)

    def nearest(self, displacement: float) -> int:
        """The snapshot nearest to a displacement of the cylinder (m)."""
        return int(np.abs(self.displacement - displacement).argmin())

    def contacts(self, snapshot: int) -> Touching:
        """Contacts at a snapshot."""
        replicate, place = self.replicate, self.position[snapshot]
        bed = Bed(
            place, self.angle[snapshot], replicate.sweep.box_width, self.height, *(np.nan,) * 4
        )
        scene = drag.make_scene(replicate, bed)
        axis = scene.cylinder.position[0], float(self.cylinder_y[snapshot])
        scene = replace(scene, cylinder=replace(scene.cylinder, position=axis))
        return Simulation(scene, bed.state).contacts()


def read_motion(path: Path) -> Motion:
    """The snapshots in the file of a replicate; raises InputError for any other file."""
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file.")
    values, attrs = read(path, READ)
    if "configuration" not in attrs:
        raise InputError(f"{path}: it has no attribute configuration; is it another file?")
    moved = values["snapshot_displacement"]
    if not (len(moved) > 1 and np.isfinite(moved).all() and (np.diff(moved) > 0.0).all()):
        raise InputError(f"{path}: its snapshots do not follow each other; is it another file?")
    with content_of(path):
        try:
            sweep = parse(json.loads(attrs["configuration"]))
        except InputError:
            raise InputError(
                f"{path}: its configuration is none of a run; is it another file?"
            ) from None
        density, seed = float(values["density"]), int(values["seed"])
        return Motion(
            sweep.replicate(str(values["shape"]), density, seed),
            float(values["box_height"]),
            moved,
            values["cylinder_y"],
            np.stack([values["granule_x"], values["granule_y"]], axis=-1),
            values["granule_angle"],
            values["granule_diameter"],
            values["displacement"],
            values["drag"],
        )
