"""How beds are drawn: true outlines, walls and solids to scale, coloured by what is asked for."""

from itertools import product

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke

from dem.experiment.observables.flow import layers_of
from dem.figures import style
from dem.periodic import wrapped
from dem.solids import walls_of

PLAIN, SHADED = "#eef2f6", style.LAYERS[1]
EDGE = {"edgecolors": style.OUTLINE, "linewidths": 0.5}
STEEL = {"facecolor": "white", "edgecolor": "black", "hatch": "xxxx", "zorder": 3}
SOLID = {"facecolor": "0.93", "edgecolor": "0.6", "hatch": "////", "linewidth": 0.0, "zorder": 0}
AHEAD = 1.5  # diameters of the cylinder: height of the cluster that is shaded
NECK = 11  # of the points of an outline, one in so many on each side: width where two parts meet


def joined(rings) -> np.ndarray:
    """Outlines (n, points, 2) in one piece; rings (n, rings, points, 2) of one part, or of the two
    that meet on the x axis, the right one first."""
    if rings.shape[1] == 1:
        return rings[:, 0]
    right, left = rings[:, 0, :-1], rings[:, 1, :-1]
    points = left.shape[1]
    neck = points // NECK
    parts = left, np.roll(right, -(points // 2), axis=1)  # each begins where they meet
    return np.concatenate([each[:, neck : points - neck + 1] for each in parts], axis=1)


def placed(rings, position, angle) -> np.ndarray:
    """Outlines (n, ..., 2) in mm of granules at positions (n, 2) in m, angles (n,)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.stack([cosine, sine, -sine, cosine], axis=-1).reshape(-1, 2, 2)  # transposed
    flat = rings.reshape(len(rings), -1, 2) @ turn + np.asarray(position)[:, None]
    return 1e3 * flat.reshape(rings.shape)


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


def shifts(periodic) -> np.ndarray:
    """Where a body of a periodic box is seen: displacements (k, 2) in m, (0, 0) alone without
    periods."""
    turns = ([0.0] if not each else [-each, 0.0, each] for each in periodic or (None, None))
    return np.array(list(product(*turns)))


class Drawing:
    """Granules, walls and solids of dem.figures.frames.Frames on axes, one frame at a time.

    Where the frames are boxed the box is drawn alone; else what is solid is hatched, and the axes
    have numbers in mm.
    """

    def __init__(self, axes, frames):
        self.frames, self.rings, self.periodic = frames, joined(frames.rings), frames.periodic
        self.shifts = shifts(frames.periodic)
        self.granules = PolyCollection([], **EDGE, zorder=1)
        self.forces = LineCollection([], colors="#b34700", capstyle="round", zorder=2)
        self.solids = PolyCollection([], **STEEL)
        rim = [withStroke(linewidth=5.0, foreground="white")]  # seen on the hatch of a solid
        self.marks = LineCollection([], colors="black", linewidths=2.0, zorder=4, path_effects=rim)
        self.walls = LineCollection(
            [], colors="black", linewidths=1.4, capstyle="projecting", zorder=1
        )
        for collection in (self.granules, self.forces, self.solids, self.marks, self.walls):
            axes.add_collection(collection, autolim=False)
        self.solid = PathPatch(Path(np.empty((0, 2))), **SOLID)
        if frames.boxed:
            axes.set_axis_off()
        else:
            axes.add_patch(self.solid)
            axes.set(xlabel="x (mm)", ylabel="y (mm)")
        xlim, ylim = 1e3 * frames.view.T
        axes.set(xlim=xlim, ylim=ylim, aspect="equal")
        axes.grid(visible=False)

    def move(self, frame: int) -> None:
        """Show a frame; a line marks the angle of each round solid that turns."""
        frames, periodic = self.frames, self.periodic
        lines, space = edges(frames.walls[frame], frames.view)
        self.walls.set_segments(1e3 * lines)
        (left, low), (right, high) = frames.view
        around = np.array([[left, low], [left, high], [right, high], [right, low]])  # clockwise
        rings = [1e3 * ring[[*range(len(ring)), 0]] for ring in (around, space)]
        self.solid.set_path(Path.make_compound_path(*map(Path, rings)))
        position = wrapped(frames.position[frame], periodic)
        self.granules.set_verts(self._images(placed(self.rings, position, frames.angle[frame])))
        rings, marks = [], []
        for k, outline in enumerate(frames.solids):
            place = wrapped(frames.place[frame, [k]], periodic)
            ring = placed(outline[None], place, frames.turn[frame, [k]])
            rings += [*self._images(ring)]
            if np.ptp(frames.turn[:, k]) and np.ptp(np.hypot(*outline.T)) < 1e-9:  # round
                marks += [*self._images(np.stack([1e3 * place[0], ring[0, 0]])[None])]
        self.solids.set_verts(rings)
        self.marks.set_segments(marks)

    def _images(self, lines) -> np.ndarray:
        """Lines (m, points, 2) in mm with their periodic images (k m, points, 2)."""
        return (lines + 1e3 * self.shifts[:, None, None]).reshape(-1, *lines.shape[1:])

    def paint(self, colors) -> None:
        """Colours (n,), one per granule."""
        self.granules.set_facecolor(np.tile(colors, len(self.shifts)))

    def shade(self, values) -> None:
        """Colours by numbers (n,), one per granule, on the scale of `granules`."""
        self.granules.set_array(np.tile(values, len(self.shifts)))

    def push(self, segments, forces, largest: float) -> None:
        """Lines (m, 2, 2) in m with the width of the force (m,) in N; the largest is 4 points
        wide."""
        middle = np.asarray(segments).mean(axis=1, keepdims=True)
        inside = segments - middle + wrapped(middle, self.periodic)
        self.forces.set_segments(self._images(1e3 * inside))
        self.forces.set_linewidths(
            np.tile(4.0 * np.minimum(forces / largest, 1.5), len(self.shifts))
        )


def box_walls(width: float, height: float, periodic) -> np.ndarray:
    """Walls (w, 3) of a box with such periods (m)."""
    walls = walls_of(width, height, periodic)
    return np.empty((0, 3)) if walls is None else walls


def box_view(width: float, height: float) -> np.ndarray:
    """Corners (2, 2) in m of the view of a box, that keeps its lines whole."""
    edge = 0.01 * width
    return np.array([[-edge, -edge], [width + edge, height + edge]])


def cluster_colors(start, axis, diameter: float) -> np.ndarray:
    """Colours (n,) that shade what begins in front of the cylinder: as wide as it is, AHEAD of
    it."""
    aside, above = np.moveaxis(start - np.asarray(axis), -1, 0)
    ahead = (above > 0.0) & (above < (0.5 + AHEAD) * diameter)
    return np.where(ahead & (np.abs(aside) < 0.5 * diameter), SHADED, PLAIN)


def layer_colors(start, height: float) -> np.ndarray:
    """Colours (n,) of horizontal layers in turn, by where granules begin."""
    return np.array(style.LAYERS)[layers_of(start, height) % len(style.LAYERS)]
