"""Parts of granules and solids, for neighbour lists."""

from types import SimpleNamespace

import numpy as np
from hypothesis import strategies as st

from dem.dynamics.world import Faces
from dem.shapes.clump import Clump
from dem.shapes.disc import Disc
from dem.solids import Polygon


@st.composite
def parts(draw):
    """Rows of parts, bounding radii of a ratio up to 1:20 and a skin, at random places."""
    seed = draw(st.integers(0, 2**32 - 1))
    n = draw(st.integers(1, 60))
    spread = draw(st.sampled_from([0.0, 1.0, 10.0, 1e4]))
    skin = draw(st.sampled_from([0.0, 1e-3, 0.3, 5.0]))
    flat = draw(st.sampled_from([(1.0, 1.0), (1.0, 0.0), (1.0, 1e3)]))
    rng = np.random.default_rng(seed)
    rows = np.zeros((n, 8))
    rows[:, :2] = spread * rng.normal(size=(n, 2)) * flat + rng.normal(scale=100.0, size=2)
    return rows, rng.choice([0.05, 0.3, 1.0], n), skin


def owned(kind, n):
    """Granules of n parts, each its own or one, two or three in turn, and whose each part is."""
    if kind is Disc:
        return Disc(np.ones(n)), np.arange(n)
    owner = np.resize([0, 1, 1, 2, 2, 2], n) + np.arange(n) // 6 * 3
    first = np.searchsorted(owner, np.arange(owner[-1] + 2))
    return Clump(np.ones((n, 3)), owner, first, np.ones((owner[-1] + 1, 2))), owner


def solid(form, position, angle, size):
    """Surface and boundaries of one solid of a size: a circle, what is in one, or a polygon."""
    polygon = Polygon(size * np.array([[-0.5, -0.6], [1.0, -0.5], [0.2, 0.9]]), 0.3 * size)
    faces = Faces(np.array([0, 3]), polygon.faces, np.array([polygon.radius]))
    surface = SimpleNamespace(
        boundary=np.array([0]),
        planes=None,
        radius=np.array([size]) if form == "circle" else None,
        faces=faces if form == "polygon" else None,
    )
    motion, c, s = np.append(position, np.zeros(6)), np.cos(angle), np.sin(angle)
    boundaries = SimpleNamespace(
        motion=motion[None], orientation=np.array([[c, s]]), reach=np.array([size])
    )

    def gaps(offset):
        """From the solid to points relative to its place."""
        if form == "polygon":
            return beyond(offset @ [[c, -s], [s, c]], polygon.corners) - polygon.radius
        return np.hypot(*offset.T) - size

    return surface, boundaries, gaps


FORMS = "circle", "outline", "polygon"


def beyond(points, corners):
    """Distances (n,) from a convex polygon to points, zero inside."""
    edges = np.roll(corners, -1, axis=0) - corners
    offset = points[:, None] - corners
    along = (offset * edges).sum(axis=-1) / (edges**2).sum(axis=-1)
    distance = np.linalg.norm(offset - np.clip(along, 0.0, 1.0)[..., None] * edges, axis=-1)
    inside = (edges[:, 0] * offset[..., 1] > edges[:, 1] * offset[..., 0]).all(axis=1)
    return np.where(inside, 0.0, distance.min(axis=1))
