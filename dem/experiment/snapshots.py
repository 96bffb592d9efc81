"""The snapshots of one run, with all that is needed to draw and to measure them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dem.dynamics.contact_list import ContactList
from dem.dynamics.simulation import Simulation
from dem.experiment.bed import periods, shaped, solids
from dem.experiment.box import ahead_of
from dem.experiment.run import Replicate
from dem.experiment.scene import make_scene
from dem.packing.random import Bed
from dem.periodic import Periods
from dem.solids import Solid

ORIENTATIONS = "cylinder_orientation", "second_orientation"  # variables of a run


class Snapshots(NamedTuple):
    """Snapshots s of granules n. SI units.

    height (s,): of the box, up to its top wall; displacement, cylinder_y (s,); position (s, n, 2),
    not wrapped at periodic sides; angle (s, n); diameters (n,); drag (bins,) at drag_displacement
    (bins,), None where it is not asked for; orientation: angles (s,) of each solid, None for one that
    does not turn.
    """

    replicate: Replicate
    height: np.ndarray
    displacement: np.ndarray
    cylinder_y: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    diameters: np.ndarray
    drag_displacement: np.ndarray | None = None
    drag: np.ndarray | None = None
    orientation: Sequence[np.ndarray | None] = (None, None)

    @property
    def periodic(self) -> Periods:
        """Periods (m) of the box."""
        return periods(self.replicate, self.height[0])

    @property
    def outlines(self) -> np.ndarray:
        """Outlines (n, rings, points, 2) in m about the centre at angle zero."""
        return shaped(self.replicate, self.diameters).polygons(33)

    def nearest(self, displacement: float) -> int:
        """The snapshot nearest to a displacement of the cylinder (m)."""
        return int(np.abs(self.displacement - displacement).argmin())

    def contacts(self, snapshot: int) -> ContactList:
        """Contacts at a snapshot."""
        replicate, place = self.replicate, self.position[snapshot]
        bed = Bed(
            place,
            self.angle[snapshot],
            replicate.configuration.box_width,
            float(self.height[snapshot]),
            *(np.nan,) * 4,
            self.periodic,
        )
        scene = replace(make_scene(replicate, bed), solids=self.solids(snapshot))
        return Simulation(scene, bed.state).contacts()

    def solids(self, snapshot: int) -> tuple[Solid, ...]:
        """The cylinder, and a second one, where they are at a snapshot."""
        first, *others = solids(self.replicate, self.height[0])
        way = self.displacement[snapshot] * np.array(
            ahead_of(self.replicate.configuration.cylinder)
        )
        place = first.position[0] + way[0], float(self.cylinder_y[snapshot])
        moved = (
            replace(first, position=place),
            *(replace(solid, position=solid.position + way) for solid in others),
        )
        return tuple(
            solid if angle is None else replace(solid, angle=angle[snapshot])
            for solid, angle in zip(moved, self.orientation, strict=False)
        )
