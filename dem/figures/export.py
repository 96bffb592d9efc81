"""Snapshots of one replicate for ParaView: one VTK file each, and a .pvd file that lists them."""

from pathlib import Path

import meshio
import numpy as np

from dem.base.files import atomic, write_bytes
from dem.experiment.snapshots import Snapshots
from dem.figures.bed import placed
from dem.figures.frames import mean_velocity, sums_of_forces
from dem.periodic import wrapped

PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1"><Collection>
{}
</Collection></VTKFile>
"""


def export(motion: Snapshots, path: Path, progress=lambda done: None) -> None:
    """Write the snapshots beside a .pvd file, the one to open, with its name and a number.

    Granules are polygons with their true outline, a dumbbell two; data of each: number, volume
    diameter (m), angle (rad), velocity (m/s), the mean since the snapshot before, and the sum of
    its normal forces (N). Solids are polygons too, with the numbers -1, -2 and so on. Contacts are
    lines from centre to centre, with the next number and their normal force. Lengths in m; time is
    the displacement of a cylinder (m), or the time of a scene (s). Granules that have left through
    a periodic side are put back into the box.
    """
    lines = []
    for snapshot, mark in enumerate(motion.marks):
        name = f"{path.stem}{snapshot:04d}.vtu"
        with atomic(path.with_name(name)) as part:
            meshio.write(part, _mesh(motion, snapshot), file_format="vtu")
        lines.append(f'<DataSet timestep="{mark:.9g}" file="{name}"/>')
        progress((snapshot + 1) / len(motion.marks))
    write_bytes(path, PVD.format("\n".join(lines)).encode())


def _mesh(motion: Snapshots, snapshot: int) -> meshio.Mesh:
    there = np.flatnonzero(~np.isnan(motion.angle[snapshot]))
    rings = motion.outlines[there, :, :-1]  # the last point is the first
    count, parts, corners, _ = rings.shape
    place, angle = (
        wrapped(motion.position[snapshot], motion.periodic),
        motion.angle[snapshot, there],
    )
    solids, contacts = motion.solids(snapshot), motion.contacts(snapshot)
    start = place[contacts.granule]
    blocks = [placed(rings.reshape(count, -1, 2), place[there], angle).reshape(-1, corners, 2)]
    for solid in solids:
        centre = wrapped(np.array(solid.position), motion.periodic)
        blocks.append(solid.placed(centre, solid.angle)[None, :-1])
    blocks.append(np.stack([start, start + contacts.branch], axis=1))
    points = np.concatenate([block.reshape(-1, 2) for block in blocks])
    ends = np.cumsum([block[..., 0].size for block in blocks])
    cells = [
        ("line" if block is blocks[-1] else "polygon", numbers.reshape(block.shape[:2]))
        for block, numbers in zip(blocks, np.split(np.arange(len(points)), ends), strict=False)
    ]
    numbers = np.flatnonzero(~np.isnan(motion.turn[snapshot]))  # of solids that are there
    granules, total = len(place), len(motion.drawn)
    rows = [*there, *(granules + numbers)]
    places = np.concatenate([motion.position, motion.place], axis=1)
    velocity = mean_velocity(places, motion.time, motion.age)[snapshot, rows]
    bodies = {
        "granule": np.append(there, -1 - numbers),
        "diameter": np.append(motion.diameters[there], [2.0 * solid.radius for solid in solids]),
        "angle": np.append(angle, [solid.angle for solid in solids]),
        "velocity": np.pad(velocity, ((0, 0), (0, 1))),
        "force": sums_of_forces(contacts, granules, total)[rows],
    }
    lines = {"granule": np.full(len(start), -1 - total), "force": contacts.force}
    data = {
        name: [
            np.repeat(values[:count], parts, axis=0),
            *values[count:, None],
            lines.get(name, np.full((len(start), *values.shape[1:]), np.nan)),
        ]
        for name, values in bodies.items()
    }
    return meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), cells, cell_data=data)
