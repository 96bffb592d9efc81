"""Snapshots of one replicate for ParaView: one VTK file each, and a .pvd file that lists them."""

from pathlib import Path

import meshio
import numpy as np

from dem.base.files import atomic
from dem.experiment.box import ahead_of
from dem.experiment.snapshots import Snapshots
from dem.figures.bed import placed
from dem.figures.frames import mean_velocity
from dem.periodic import wrapped
from dem.solids import Solid

PVD = """<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1"><Collection>
{lines}
</Collection></VTKFile>
"""


def export(motion: Snapshots, path: Path, progress=lambda done: None) -> None:
    """Write the snapshots beside a .pvd file, the one to open, with its name and a number.

    Granules are polygons with their true outline, a dumbbell two; data of each: number, volume
    diameter (m), angle (rad), velocity (m/s), the mean since the snapshot before, and the sum of
    its normal forces (N). The cylinder is one polygon more, number -1, and a second one number
    -2. Contacts are lines from centre to centre, with the next number and their normal force. Lengths in m; time is the displacement.
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


def _ring(solid: Solid, corners: int, periodic) -> np.ndarray:
    """Outline (1, corners, 2) in m of a solid, by points of it, or all of them and some twice."""
    centre = wrapped(np.array(solid.position), periodic)
    ring = solid.placed(centre, solid.angle)
    ring = ring[np.linspace(0, len(ring) - 1, corners + 1).round().astype(int)[:-1]]
    return ring[None]


def _mesh(motion: Snapshots, snapshot: int) -> meshio.Mesh:
    rings = motion.outlines[:, :, :-1]  # the last point is the first
    count, parts, corners, _ = rings.shape
    place = wrapped(motion.position[snapshot], motion.periodic)
    solids, way = motion.solids(snapshot), motion.replicate.configuration.cylinder
    outlines = 1e-3 * placed(rings, place, motion.angle[snapshot])
    solid_rings = [_ring(solid, corners, motion.periodic) for solid in solids]
    polygons = np.concatenate([outlines.reshape(-1, corners, 2), *solid_rings])
    contacts = motion.contacts(snapshot)
    first = place[contacts.granule]
    points = np.concatenate([polygons.reshape(-1, 2), first, first + contacts.branch])
    cells = np.arange(polygons.size // 2).reshape(len(polygons), corners)
    ends = polygons.size // 2 + np.arange(2 * len(first)).reshape(2, -1).T
    more = len(solids)
    force, bodies = np.zeros(count + more), contacts.partner >= -more
    partner = np.where(contacts.partner < 0, count - 1 - contacts.partner, contacts.partner)
    np.add.at(force, contacts.granule, contacts.force)
    np.add.at(force, partner[bodies], contacts.force[bodies])
    drawn = np.multiply(ahead_of(way), way.velocity)
    velocity = np.vstack([mean_velocity(motion, snapshot), *[drawn] * more])
    of_bodies = {
        "granule": np.append(np.arange(count), -1 - np.arange(more)),
        "diameter": np.append(motion.diameters, [2.0 * solid.radius for solid in solids]),
        "angle": np.append(motion.angle[snapshot], [solid.angle for solid in solids]),
        "velocity": np.pad(velocity, ((0, 0), (0, 1))),
        "force": force,
    }
    body = np.append(np.repeat(np.arange(count), parts), count + np.arange(more))  # of polygons
    gaps = {"granule": np.full(len(first), -1 - more), "force": contacts.force}
    data = {
        name: [values[body], gaps.get(name, np.full((len(first), *values.shape[1:]), np.nan))]
        for name, values in of_bodies.items()
    }
    points = np.pad(points, ((0, 0), (0, 1)))
    return meshio.Mesh(points, [("polygon", cells), ("line", ends)], cell_data=data)
