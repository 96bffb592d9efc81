"""Snapshots of one replicate for ParaView: one VTK file each, and a .pvd file that lists them."""

from pathlib import Path

import meshio
import numpy as np

from dem.base.files import atomic
from dem.dynamics.contact_list import CYLINDER
from dem.experiment.motion import Motion
from dem.figures.bed import placed
from dem.figures.frames import of_motion
from dem.periodic import wrapped

PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1"><Collection>
{lines}
</Collection></VTKFile>
"""


def export(motion: Motion, path: Path, progress=lambda done: None) -> None:
    """Write the snapshots beside a .pvd file, the one to open, with its name and a number.

    Granules are polygons with their true outline; data of each: number, volume diameter (m), angle (rad),
    velocity (m/s), the mean since the snapshot before, and the sum of its normal forces (N). The cylinder
    is one polygon more, number -1. Contacts are lines from centre to centre, number -2, with their normal
    force. Lengths in m; time is the displacement. What has left through a periodic side is put back
    into the box.
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
    rings = _joined(motion.outlines[:, :, :-1])  # the last point is the first
    place = wrapped(motion.position[snapshot], motion.periodic)
    outlines = 1e-3 * placed(rings[:, None], place, motion.angle[snapshot])
    own, count = motion.replicate.configuration, rings.shape[1]
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    circle = 0.5 * own.cylinder.diameter * np.column_stack([np.cos(turn), np.sin(turn)])
    axis = np.array([0.5 * own.box_width, motion.cylinder_y[snapshot]])
    circle += wrapped(axis, motion.periodic)
    polygons = np.concatenate([outlines, circle[None]])
    contacts = motion.contacts(snapshot)
    first = place[contacts.granule]
    points = np.concatenate([polygons.reshape(-1, 2), first, first + contacts.branch])
    points = np.pad(points, ((0, 0), (0, 1)))
    corners = np.arange(polygons.size // 2).reshape(len(polygons), count)
    ends = polygons.size // 2 + np.arange(2 * len(first)).reshape(2, -1).T
    felt, bodies = np.zeros(len(polygons)), contacts.partner >= CYLINDER  # the last polygon
    np.add.at(felt, contacts.granule, contacts.force)
    np.add.at(felt, contacts.partner[bodies], contacts.force[bodies])
    velocity = of_motion(motion).velocity(snapshot), [[0.0, own.cylinder.velocity]]
    gap = np.full(len(first), np.nan)
    data = {
        "granule": [np.append(np.arange(len(rings)), -1), np.full(len(first), -2)],
        "diameter": [np.append(motion.diameters, own.cylinder.diameter), gap],
        "angle": [np.append(motion.angle[snapshot], 0.0), gap],
        "velocity": [np.pad(np.concatenate(velocity), ((0, 0), (0, 1))), np.stack(3 * [gap], axis=1)],
        "force": [felt, contacts.force],
    }
    return meshio.Mesh(points, [("polygon", corners), ("line", ends)], cell_data=data)


def _joined(rings: np.ndarray) -> np.ndarray:
    """One outline a granule (n, q, 2) of rings (n, r, p, 2) that touch, through the points where they do."""
    found = rings[:, 0]
    for ring in np.moveaxis(rings[:, 1:], 1, 0):
        apart = np.linalg.norm(found[0, :, None] - ring[0], axis=-1)
        at, other = np.unravel_index(apart.argmin(), apart.shape)
        found = np.concatenate(
            [found[:, : at + 1], np.roll(ring, -other, axis=1)[:, 1:], found[:, at:]], axis=1
        )
    return found
