"""How beds are drawn: true outlines, walls and cylinder to scale, coloured by what is asked for."""

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Circle, Rectangle

from dem.experiment.flow_measures import layers_of
from dem.figures import style
from dem.shapes import KINDS

PLAIN, SHADED = "#dfe7ee", style.CURVE
EDGE = {"edgecolors": style.OUTLINE, "linewidths": 0.35}
STEEL = {"facecolor": style.STEEL, "edgecolor": "black", "linewidth": 0.8, "zorder": 3}
AHEAD = 1.5  # diameters of the cylinder: height of the cluster that is shaded


def outlines(kind: str, diameters, ratio: float) -> np.ndarray:
    """Outlines (n, rings, points, 2) in m about the centre at angle zero."""
    return KINDS[kind].shape.of_size(diameters, ratio).polygons(33)


def placed(rings, position, angle) -> np.ndarray:
    """Outlines (n rings, points, 2) in mm of granules at positions (n, 2) in m, angles (n,)."""
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    x, y = rings[..., 0], rings[..., 1]
    turned = np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
    moved = turned + np.asarray(position)[:, None, None, :]
    return 1e3 * moved.reshape(-1, *rings.shape[2:])


class Bed:
    """One bed on axes; lengths in m. What is drawn can be moved, for films."""

    def __init__(self, axes, rings, width: float, height: float, cylinder: float):
        self.rings, self.per = rings, rings.shape[1]
        self.granules = PolyCollection([], **EDGE, zorder=1)
        self.cylinder = Circle((0.5e3 * width, 0.0), 0.5e3 * cylinder, **STEEL)
        self.forces = LineCollection([], colors="#b34700", capstyle="round", zorder=2)
        axes.add_collection(self.granules, autolim=False)
        axes.add_collection(self.forces, autolim=False)
        axes.add_patch(self.cylinder)
        axes.add_patch(Rectangle((0.0, 0.0), 1e3 * width, 1e3 * height, fill=False, linewidth=1.4))
        edge = 0.01e3 * width
        axes.set(
            xlim=(-edge, 1e3 * width + edge), ylim=(-edge, 1e3 * height + edge), aspect="equal"
        )
        axes.grid(visible=False)
        axes.set_axis_off()

    def move(self, position, angle, cylinder_y: float) -> None:
        """Granules to positions (n, 2) in m and angles (n,) in rad; the cylinder to its height."""
        self.granules.set_verts(placed(self.rings, position, angle))
        self.cylinder.center = self.cylinder.center[0], 1e3 * cylinder_y

    def paint(self, colors) -> None:
        """Colours (n, ...), one a granule."""
        self.granules.set_facecolor(np.repeat(np.asarray(colors), self.per, axis=0))

    def push(self, segments, forces, largest: float) -> None:
        """Lines (m, 2, 2) in m with the width of the force (m,) in N; the largest is 4 points wide."""
        self.forces.set_segments(1e3 * np.asarray(segments))
        self.forces.set_linewidths(4.0 * np.minimum(np.asarray(forces) / largest, 1.5))


def cluster(start, axis, diameter: float):
    """Which granules (n,) begin in front of the cylinder: as wide as it is, AHEAD of it."""
    above = start[:, 1] - axis[1]
    return (np.abs(start[:, 0] - axis[0]) < 0.5 * diameter) & (
        (above > 0.0) & (above < (0.5 + AHEAD) * diameter)
    )


def cluster_colors(start, axis, diameter: float) -> np.ndarray:
    """Colours (n,) that shade the cluster in front of the cylinder."""
    return np.where(cluster(start, axis, diameter), SHADED, PLAIN)


def layer_colors(start, height: float, layers: int) -> np.ndarray:
    """Colours (n,) of horizontal layers in turn, by where granules begin."""
    return np.array(style.LAYERS)[layers_of(start, height, layers) % len(style.LAYERS)]
