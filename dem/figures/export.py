"""Snapshots of one replicate for ParaView: one VTK file each, and a .pvd file that lists them."""

from pathlib import Path

import meshio
import numpy as np

from dem.base.files import atomic
from dem.dynamics.contact_list import CYLINDER
from dem.experiment.motion import Motion
from dem.figures.bed import placed
from dem.figures.frames import mean_velocity
from dem.periodic import wrapped

PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1"><Collection>
{lines}
</Collection></VTKFile>
"""


def export(motion: Motion, path: Path, progress=lambda done: None) -> None:
    """Write the snapshots beside a .pvd file, the one to open, with its name and a number.

    Granules are polygons with their true outline, a dumbbell two; data of each: number, volume
    diameter (m), angle (rad), velocity (m/s), the mean since the snapshot before, and the sum of
    its normal forces (N). The cylinder is one polygon more, number -1. Contacts are lines from
    centre to centre, number -2, with their normal force. Lengths in m; time is the displacement.
    What has left through a periodic side is put back into the box.
    """
    lines = []
    for snapshot, displacement in enumerate(motion.displacement):
        name = f"{path.stem}{snapshot:04d}.vtu"
        with atomic(path.with_name(name)) as part:
            meshio.write(part, _mesh(motion, snapshot), file_format="vtu")
        lines.append(f'<DataSet timestep="{displacement:.9g}" file="{name}"/>')
        progress((snapshot + 1) / len(motion.displacement))
    with atomic(path) as part:
        part.write_text(PVD.format(lines="\n".join(lines)))


def _mesh(motion: Motion, snapshot: int) -> meshio.Mesh:
    rings = motion.outlines[:, :, :-1]  # the last point is the first
    count, parts, corners, _ = rings.shape
    place = wrapped(motion.position[snapshot], motion.periodic)
    configuration = motion.replicate.configuration
    turn = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    circle = 0.5 * configuration.cylinder.diameter * np.column_stack([np.cos(turn), np.sin(turn)])
    axis = np.array([0.5 * configuration.box_width, motion.cylinder_y[snapshot]])
    circle += wrapped(axis, motion.periodic)
    outlines = 1e-3 * placed(rings, place, motion.angle[snapshot])
    polygons = np.concatenate([outlines.reshape(-1, corners, 2), circle[None]])
    contacts = motion.contacts(snapshot)
    first = place[contacts.granule]
    points = np.concatenate([polygons.reshape(-1, 2), first, first + contacts.branch])
    cells = np.arange(polygons.size // 2).reshape(len(polygons), corners)
    ends = polygons.size // 2 + np.arange(2 * len(first)).reshape(2, -1).T
    force, bodies = np.zeros(count + 1), contacts.partner >= CYLINDER  # the last polygon
    np.add.at(force, contacts.granule, contacts.force)
    np.add.at(force, contacts.partner[bodies], contacts.force[bodies])
    velocity = np.vstack([mean_velocity(motion, snapshot), [0.0, configuration.cylinder.velocity]])
    of_bodies = {
        "granule": np.append(np.arange(count), -1),
        "diameter": np.append(motion.diameters, configuration.cylinder.diameter),
        "angle": np.append(motion.angle[snapshot], 0.0),
        "velocity": np.pad(velocity, ((0, 0), (0, 1))),
        "force": force,
    }
    body = np.append(np.repeat(np.arange(count), parts), count)  # of each polygon
    gaps = {"granule": np.full(len(first), -2), "force": contacts.force}
    data = {
        name: [values[body], gaps.get(name, np.full((len(first), *values.shape[1:]), np.nan))]
        for name, values in of_bodies.items()
    }
    points = np.pad(points, ((0, 0), (0, 1)))
    return meshio.Mesh(points, [("polygon", cells), ("line", ends)], cell_data=data)
