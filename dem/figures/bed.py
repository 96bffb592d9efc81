"""How beds are drawn: true outlines, walls and cylinder to scale, coloured by what is asked for."""

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path

from dem.experiment.observables.flow import layers_of
from dem.figures import style
from dem.periodic import wrapped
from dem.scene import walls_of

PLAIN, SHADED = "#dfe7ee", style.CURVE
EDGE = {"edgecolors": style.OUTLINE, "linewidths": 0.35}
STEEL = {"facecolor": style.STEEL, "edgecolor": "black", "linewidth": 0.8, "zorder": 3}
SOLID = {"facecolor": "0.93", "edgecolor": "0.6", "hatch": "////", "linewidth": 0.0, "zorder": 0}
AHEAD = 1.5  # diameters of the cylinder: height of the cluster that is shaded


def placed(rings, position, angle) -> np.ndarray:
    """Outlines (n rings, points, 2) in mm of granules at positions (n, 2) in m, angles (n,)."""
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    x, y = rings[..., 0], rings[..., 1]
    turned = np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
    moved = turned + np.asarray(position)[:, None, None, :]
    return 1e3 * moved.reshape(-1, *rings.shape[2:])


def edges(planes, view) -> tuple[np.ndarray, np.ndarray]:
    """Where walls end the space for granules: segments (k, 2, 2) in m, one per wall in view, and
    the corners (c, 2) of that space within the view, anticlockwise.

    planes (w, 3): rows (nx, ny, offset), solid where n.x > offset; view: lower left and upper right
    corner (m).
    """
    (left, low), (right, high) = view
    space = np.array([[left, low], [right, low], [right, high], [left, high]], float)
    for plane in planes:
        depth, kept = space @ plane[:2] - plane[2], []
        for at, here in enumerate(depth):
            before = depth[at - 1]
            if here * before < 0.0:
                kept.append(space[at] + here / (here - before) * (space[at - 1] - space[at]))
            if here <= 0.0:
                kept.append(space[at])
        space = np.array(kept).reshape(-1, 2)
    sides = np.stack([space, np.roll(space, -1, axis=0)], axis=1)
    off = np.abs(sides @ planes[:, :2].T - planes[:, 2]).max(axis=1)
    return sides[(off < 1e-9 * (right - left + high - low)).any(axis=1)], space


def images(place, reach, view, periodic):
    """Where bodies at places (n, 2) in m are seen in a view: (m, 2) in m, and whose each is (m,).

    Along a periodic side a body is seen once a period. reach (n,): radius (m) of the circle about
    it that holds it.
    """
    found, owner = wrapped(place, periodic), np.arange(len(place))
    for axis, period in enumerate(periodic or ()):
        if period is not None:
            turns = np.repeat([-period, 0.0, period], len(found))
            found, owner = np.tile(found, (3, 1)), np.tile(owner, 3)
            found[:, axis] += turns
            at, far = found[:, axis], reach[owner]
            seen = (at + far > view[0, axis]) & (at - far < view[1, axis])
            found, owner = found[seen], owner[seen]
    return found, owner


class Drawing:
    """Granules, walls and cylinder on axes; lengths in m. What is drawn can be moved, for films.

    rings: outlines; view: lower left and upper right corner; diameter: of the cylinder, None without
    one; periodic: periods as of dem.Scene; hatched: hatch what is solid, and number the axes in mm; else draw the
    box alone.
    """

    def __init__(self, axes, rings, view, diameter, periodic=None, hatched=False):
        self.axes, self.rings, self.per = axes, rings, rings.shape[1]
        self.view, self.periodic = np.asarray(view), periodic
        self.reach = np.hypot(rings[..., 0], rings[..., 1]).max(axis=(1, 2))
        self.granules = PolyCollection([], **EDGE, zorder=1)
        self.joints = LineCollection([], colors=style.OUTLINE, linewidths=1.1, zorder=1.5)
        self.forces = LineCollection([], colors="#b34700", capstyle="round", zorder=2)
        self.radius = 0.5 * (diameter or 0.0)
        most = 2 ** sum(period is not None for period in periodic or ())  # in view at once
        self.cylinders = [Circle((0.0, 0.0), 1e3 * self.radius, **STEEL) for _ in range(most)]
        self.walls = LineCollection(
            [], colors="black", linewidths=1.4, capstyle="projecting", zorder=1
        )
        self.parts = [self.granules, self.joints, self.forces, self.walls]
        for each in self.parts:
            axes.add_collection(each, autolim=False)
        self.solid = PathPatch(Path(np.empty((0, 2))), **SOLID)
        if hatched:
            self.parts += [axes.add_patch(self.solid), *axes.spines.values()]
            axes.set(xlabel="x (mm)", ylabel="y (mm)")
        else:
            axes.set_axis_off()
        if diameter is not None:
            self.parts += [axes.add_patch(each) for each in self.cylinders]
        axes.set(xlim=1e3 * self.view[:, 0], ylim=1e3 * self.view[:, 1], aspect="equal")
        axes.grid(visible=False)

    def move(self, position, angle, cylinder, walls) -> None:
        """Granules to positions (n, 2) in m and angles (n,) in rad; the cylinder to (x, y) in m; walls
        to planes (w, 3) as of dem.Scene."""
        lines, space = edges(walls, self.view)
        self.walls.set_segments(1e3 * lines)
        (left, low), (right, high) = self.view
        around = np.array([[left, low], [left, high], [right, high], [right, low]])  # clockwise
        rings = [1e3 * each[[*range(len(each)), 0]] for each in (around, space)]
        self.solid.set_path(Path.make_compound_path(*map(Path, rings)))
        place, self.owner = images(np.asarray(position), self.reach, self.view, self.periodic)
        placed_rings = placed(self.rings[self.owner], place, np.asarray(angle)[self.owner])
        self.granules.set_verts(placed_rings)
        if self.per > 1:  # a line from part to part tells which belong together
            self.joints.set_segments(placed_rings.mean(axis=1).reshape(-1, self.per, 2))
        if cylinder is not None:
            axis, reach = np.array([cylinder], float), np.array([self.radius])
            seen, _ = images(axis, reach, self.view, self.periodic)
            for number, each in enumerate(self.cylinders):
                each.set_visible(number < len(seen))
            for each, (x, y) in zip(self.cylinders, seen, strict=False):
                each.center = 1e3 * x, 1e3 * y

    def paint(self, colors) -> None:
        """Colours (n, ...), one per granule."""
        colors = np.asarray(colors)[self.owner]
        self.granules.set_facecolor(np.repeat(colors, self.per, axis=0))

    def push(self, segments, forces, largest: float) -> None:
        """Lines (m, 2, 2) in m with the width of the force (m,) in N; the largest is 4 points wide."""
        segments, forces = np.asarray(segments), np.asarray(forces)
        if self.periodic is not None:
            middle, ends = segments.mean(axis=1), segments[:, 1] - segments[:, 0]
            place, owner = images(middle, 0.5 * np.hypot(*ends.T), self.view, self.periodic)
            segments, forces = segments[owner] + (place - middle[owner])[:, None], forces[owner]
        self.forces.set_segments(1e3 * segments)
        self.forces.set_linewidths(4.0 * np.minimum(forces / largest, 1.5))


def box_walls(width: float, height: float, periodic) -> np.ndarray:
    """Walls (w, 3) of a box with such periods (m)."""
    walls = walls_of(width, height, periodic)
    return np.empty((0, 3)) if walls is None else walls


def box_view(width: float, height: float) -> np.ndarray:
    """Corners (2, 2) in m of the view of a box, that keeps its lines whole."""
    edge = 0.01 * width
    return np.array([[-edge, -edge], [width + edge, height + edge]])


def cluster_colors(start, axis, diameter: float) -> np.ndarray:
    """Colours (n,) that shade what begins in front of the cylinder: as wide as it is, AHEAD of it."""
    aside, above = np.moveaxis(start - np.asarray(axis), -1, 0)
    ahead = (above > 0.0) & (above < (0.5 + AHEAD) * diameter)
    return np.where(ahead & (np.abs(aside) < 0.5 * diameter), SHADED, PLAIN)


def layer_colors(start, height: float, layers: int) -> np.ndarray:
    """Colours (n,) of horizontal layers in turn, by where granules begin."""
    return np.array(style.LAYERS)[layers_of(start, height, layers) % len(style.LAYERS)]
