"""Snapshots of one replicate for ParaView: one VTK file each, and a .pvd file that lists them."""

from pathlib import Path

import meshio
import numpy as np

from dem.base.files import atomic
from dem.experiment.motion import Motion
from dem.figures.bed import placed
from dem.periodic import wrapped

PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1"><Collection>
{lines}
</Collection></VTKFile>
"""


def export(motion: Motion, path: Path, progress=lambda done: None) -> None:
    """Write the snapshots beside a .pvd file, the one to open, with its name and a number.

    Granules are polygons with their true outline; data of each: number, volume diameter (m) and
    angle (rad). The cylinder is one polygon more, number -1. Lengths in m; time is the
    displacement. What has left through a periodic side is put back into the box.
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
    place = wrapped(motion.position[snapshot], motion.periodic)
    outlines = 1e-3 * placed(rings, place, motion.angle[snapshot])
    own, count = motion.replicate.configuration, rings.shape[2]
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    circle = 0.5 * own.cylinder.diameter * np.column_stack([np.cos(turn), np.sin(turn)])
    axis = np.array([0.5 * own.box_width, motion.cylinder_y[snapshot]])
    circle += wrapped(axis, motion.periodic)
    polygons = np.concatenate([outlines, circle[None]])
    points = np.concatenate([polygons.reshape(-1, 2), np.zeros((polygons.size // 2, 1))], axis=1)
    corners = np.arange(len(points)).reshape(len(polygons), count)
    owner = np.append(np.repeat(np.arange(len(rings)), rings.shape[1]), -1)
    inside = owner >= 0
    data = {
        "granule": owner,
        "diameter": np.where(inside, motion.diameters[owner], own.cylinder.diameter),
        "angle": np.where(inside, motion.angle[snapshot][owner], 0.0),
    }
    return meshio.Mesh(points, [("polygon", corners)], cell_data={k: [v] for k, v in data.items()})
