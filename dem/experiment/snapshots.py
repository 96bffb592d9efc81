"""The snapshots of one run, with all that is needed to draw and to measure them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dem.dynamics.contact_output import ContactList
from dem.dynamics.simulation import Simulation
from dem.experiment.bed import shaped
from dem.experiment.run import Replicate
from dem.experiment.scene import make_scene, solids
from dem.packing.random import Bed
from dem.periodic import Periods, periods_of
from dem.solids import Solid

ORIENTATIONS = "cylinder_orientation", "second_orientation"  # variables of a run


class Snapshots(NamedTuple):
    """Snapshots s of granules n. SI units.

    height (s,): of the box, up to its top wall; displacement (s,); position (s, n, 2), not wrapped at
    periodic sides; angle (s, n); diameters (n,); drag (bins,) at drag_displacement (bins,), None where
    it is not asked for; orientation: angles (s,) of each solid, None for one that does not turn.
    """

    replicate: Replicate
    height: np.ndarray
    displacement: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    diameters: np.ndarray
    drag_displacement: np.ndarray | None = None
    drag: np.ndarray | None = None
    orientation: Sequence[np.ndarray | None] = (None, None)

    @property
    def periodic(self) -> Periods:
        """Periods (m) of the box."""
        c = self.replicate.configuration
        return periods_of(c.box_width, self.height[0], c.periodic)

    @property
    def outlines(self) -> np.ndarray:
        """Outlines (n, rings, points, 2) in m about the centre at angle zero."""
        return shaped(self.replicate.bed_description, self.diameters).polygons(33)

    def nearest(self, displacement: float) -> int:
        """The snapshot nearest to a displacement of the cylinder (m)."""
        return int(np.abs(self.displacement - displacement).argmin())

    def contacts(self, snapshot: int) -> ContactList:
        """Contacts at a snapshot."""
        bed = Bed(
            self.position[snapshot],
            self.angle[snapshot],
            self.replicate.configuration.box_width,
            float(self.height[snapshot]),
            *(np.nan,) * 4,
            self.periodic,
        )
        scene = replace(make_scene(self.replicate, bed), solids=self.solids(snapshot))
        return Simulation(scene, bed.state).contacts()

    def solids(self, snapshot: int) -> tuple[Solid, ...]:
        """The cylinder, and a second one, where they are at a snapshot."""
        ahead = np.array(self.replicate.configuration.cylinder.ahead)
        moved = (
            replace(solid, position=tuple(solid.position + self.displacement[snapshot] * ahead))
            for solid in solids(self.replicate, self.height[0])
        )
        return tuple(
            solid if angle is None else replace(solid, angle=angle[snapshot])
            for solid, angle in zip(moved, self.orientation, strict=False)
        )


def snapshots_of(replicate: Replicate, values: dict) -> Snapshots:
    """The snapshots of a run from its variables by name."""
    displacement = values["snapshot_displacement"]
    return Snapshots(
        replicate,
        values.get("top_y", np.full(len(displacement), float(values["box_height"]))),
        displacement,
        np.stack([values["granule_x"], values["granule_y"]], axis=-1),
        values["granule_angle"],
        values["granule_diameter"],
        values.get("displacement"),
        values.get("drag"),
        [values.get(name) for name in ORIENTATIONS],
    )


def variables_of(run) -> dict:
    """These variables, from what a run recorded (dem.experiment.kinds.drag.RunData)."""
    c, height = run.replicate.configuration, run.bed.height
    drawn = solids(run.replicate, height)
    x, y = np.stack([state.position for state in run.states]).transpose(2, 0, 1)
    displacement = np.linspace(0.0, c.cylinder.stroke, c.record.snapshots)
    values = {
        "cylinder_y": drawn[0].position[1] + c.cylinder.ahead[1] * displacement,
        "granule_x": x,
        "granule_y": y,
        "granule_angle": np.stack([state.angle for state in run.states]),
        "granule_diameter": run.replicate.diameters,
    }
    every = c.record.bins // (c.record.snapshots - 1)
    if c.packing.pressure is not None:
        values["top_y"] = np.append(height, run.record.wall_offset[every - 1 :: every, -1])
    for k, (solid, section) in enumerate(zip(drawn, (c.cylinder, c.second), strict=False)):
        if section.spin is not None:
            angle = run.record.solid_angle[every - 1 :: every, k]
            values[ORIENTATIONS[k]] = np.append(solid.angle, angle)
    return values
