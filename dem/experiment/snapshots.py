"""The snapshots of one run, with all that is needed to draw and to measure them."""

from typing import NamedTuple

import numpy as np

from dem.dynamics.contact_output import ContactList
from dem.dynamics.result import contacts_of
from dem.experiment.replicate import Replicate
from dem.experiment.scene import granules, make_scene, solids
from dem.packing.random import Bed
from dem.periodic import Periods, periods_of
from dem.solids import Solid, moved

ORIENTATIONS = "cylinder_orientation", "second_orientation"  # variables of a run


class Snapshots(NamedTuple):
    """Snapshots s of granules n and solids k. SI units.

    height (s,): of the box, up to its top wall; time (s,) since the last phase began; position
    (s, n, 2), not wrapped at periodic sides; angle (s, n); diameters (n,); place (s, k, 2) and turn
    (s, k): of the solids; displacement (s,): of a cylinder, None in a scene; force (k, bins): on each
    solid against time, or (1, bins) the drag on a cylinder; None where it is not asked for; age (s, n):
    time since granules came from a source, None without any.
    """

    replicate: Replicate
    height: np.ndarray
    time: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    diameters: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    displacement: np.ndarray | None = None
    force: np.ndarray | None = None
    age: np.ndarray | None = None

    @property
    def periodic(self) -> Periods:
        """Periods (m) of the box."""
        c = self.replicate.configuration
        return periods_of(c.box_width, self.height[0], c.periodic)

    @property
    def outlines(self) -> np.ndarray:
        """Outlines (n, rings, points, 2) in m about the centre at angle zero."""
        return granules(self.replicate, self.diameters).polygons(33)

    @property
    def marks(self) -> np.ndarray:
        """Where the snapshots (s,) are: displacement of a cylinder (m), or time of a scene (s)."""
        return self.time if self.displacement is None else self.displacement

    def nearest(self, mark: float) -> int:
        """The snapshot nearest to a mark."""
        return int(np.abs(self.marks - mark).argmin())

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
        scene, place = make_scene(self.replicate, bed), self.place[snapshot]
        return contacts_of(scene, bed.state, place, self.turn[snapshot], scene.planes)

    @property
    def drawn(self) -> tuple[Solid, ...]:
        """All solids, where they are in a box of this height."""
        return solids(self.replicate, self.height[0])

    def solids(self, snapshot: int) -> tuple[Solid, ...]:
        """The solids where they are at a snapshot, but for those that were removed."""
        return moved(self.drawn, self.place[snapshot], self.turn[snapshot])


def snapshots_of(replicate: Replicate, values: dict) -> Snapshots:
    """The snapshots of a run from its variables by name."""
    time, c, displacement, force = values.get("snapshot_time"), replicate.configuration, None, None
    if time is None:
        displacement, ahead = values["snapshot_displacement"], np.array(c.cylinder.ahead)
        time = displacement / c.cylinder.velocity
        start = solids(replicate, float(values["box_height"]))
        place = [solid.position + displacement[:, None] * ahead for solid in start]
        turn = [
            values.get(name, np.full(len(time), solid.angle))
            for solid, name in zip(start, ORIENTATIONS, strict=False)
        ]
        place, turn = np.stack(place, axis=1), np.stack(turn, axis=1)
        force = values["drag"][None] if "drag" in values else None
    else:
        place, turn = (
            np.stack([values["solid_x"], values["solid_y"]], axis=-1),
            values["solid_angle"],
        )
        if "solid_force_x" in values:
            force = np.hypot(values["solid_force_x"], values["solid_force_y"])
    return Snapshots(
        replicate,
        values.get("top_y", np.full(len(time), float(values["box_height"]))),
        time,
        np.stack([values["granule_x"], values["granule_y"]], axis=-1),
        values["granule_angle"],
        values["granule_diameter"],
        place,
        turn,
        displacement,
        force,
        values.get("granule_age"),
    )


def variables_of(run) -> dict:
    """These variables, from what a run recorded (dem.experiment.phases.RunData)."""
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
