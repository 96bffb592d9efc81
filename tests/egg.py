"""A shape without any symmetry, in a file of its own: kernels of a class are kept where its code is known."""

from typing import NamedTuple

import numpy as np

from dem.shapes import smooth


def support(nx, ny, sizes):
    """Three bulges: h = r (1 + e cos 3 phi + c cos phi), without a centre of symmetry."""
    r, e, c = sizes
    cosine, sine = nx * (4.0 * nx * nx - 3.0), ny * (3.0 - 4.0 * ny * ny)
    return (
        r * (1.0 + e * cosine + c * nx),
        -r * (3.0 * e * sine + c * ny),
        r * (1.0 - 8.0 * e * cosine),
    )


@smooth.smooth(support)
class Egg(NamedTuple):
    """Granules that no half turn brings back; loaded: how far the outline is off the centre of mass, over r."""

    radius: np.ndarray
    bulge: float = 0.08
    loaded: float = 0.0

    @property
    def gyration_squared(self):
        return smooth.Smooth.gyration_squared.fget(self)
