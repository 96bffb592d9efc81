"""How a frame of a bed is drawn: true outlines, walls and solids, to scale."""

from itertools import product

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from dem.dynamics.stress import clipped
from dem.periodic import wrapped

STEEL = {"facecolor": "white", "edgecolor": "black", "hatch": "xxxx", "zorder": 3}
BEHIND = {"facecolor": "0.93", "edgecolor": "0.6", "hatch": "////", "linewidth": 0.0}  # walls
SPACE = {"facecolor": "white", "edgecolor": "black", "linewidth": 1.4, "zorder": 0}
RIM = [withStroke(linewidth=5.0, foreground="white")]  # of a mark, on the hatch of a solid
MARGIN = 0.05  # of a view, around what it shows
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
    return np.concatenate([part[:, neck : points - neck + 1] for part in parts], axis=1)


def placed(rings, position, angle) -> np.ndarray:
    """Outlines (n, points, 2) in m of granules at positions (n, 2) in m, angles (n,)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.moveaxis(np.array([[cosine, sine], [-sine, cosine]]), -1, 0)  # transposed
    return rings @ turn + position[:, None]


def free_space(planes, view) -> np.ndarray:
    """Corners (c, 2) in m, anticlockwise, of the space within a view that walls leave to granules.

    planes (w, 3): rows (nx, ny, offset), solid where n.x > offset; view: lower left and upper right
    corner (m).
    """
    (left, low), (right, high) = view
    space = np.array([[left, low], [right, low], [right, high], [left, high]], float)
    for plane in planes:
        space = clipped(space, plane[:2], plane[2])
    return space


def shifts(periodic) -> np.ndarray:
    """Where a body of a periodic box is seen: displacements (k, 2) in m, (0, 0) alone without
    periods."""
    turns = ([-side, 0.0, side] if side else [0.0] for side in periodic or (None, None))
    return np.array(list(product(*turns)))


def view_of(frames) -> np.ndarray:
    """View (2, 2) in m, lower left and upper right corner, that holds granules and solids of all
    frames, and the corners of walls that are near, but nothing behind walls; a period is shown once."""
    reach = np.linalg.norm(frames.rings, axis=-1).max(axis=-1)[:, None]
    radius = np.array([solid.radius for solid in frames.solids])[:, None]
    low, high = _corners(
        frames.position - reach,
        frames.position + reach,
        frames.place - radius,
        frames.place + radius,
    )
    periods = np.array(frames.periodic or (None, None), float)  # NaN: none
    once = [0.0 * periods, periods]
    low, high = np.where(np.isfinite(periods), once, [low, high])
    size = (high - low).max()
    near = np.array([low - size, high + size])
    corners = np.concatenate([free_space(planes, near) for planes in frames.walls])
    inside = ((corners > near[0] + 1e-6 * size) & (corners < near[1] - 1e-6 * size)).all(axis=1)
    if len(corners):  # a solid may go where no granule can
        low, high = np.clip([low, high], *_corners(corners))
    low, high = _corners(low, high, corners[inside])
    edge = MARGIN * (high - low).max()
    return np.where(np.isfinite(periods), once, [low - edge, high + edge])


def _corners(*places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner of what holds some places (..., 2)."""
    every = np.concatenate([place.reshape(-1, 2) for place in places])
    return np.nanmin(every, axis=0), np.nanmax(every, axis=0)  # NaN: places of removed solids


def draw(axes, frames, frame: int, view, contacts=None, strongest=1.0, **look) -> None:
    """Draw a frame of dem.figures.frames.Frames on axes in mm, in place of what they show.

    What is solid is hatched; a line marks the angle of each round solid that turns. contacts: drawn
    as lines, if any; of the strongest force (N) they are 4 points wide. look: colours of granules,
    as of a PolyCollection.
    """
    periodic = frames.periodic
    position = wrapped(frames.position[frame], periodic)
    granules = placed(frames.rings, position, frames.angle[frame])
    places = wrapped(frames.place[frame], periodic)
    rings, marks = [], []
    for solid, place, turns in zip(frames.solids, places, frames.turn.T, strict=True):
        rings.append(solid.placed(place, turns[frame]))
        if solid.is_round and len(np.unique(turns[np.isfinite(turns)])) > 1:
            marks.append(np.array([place, rings[-1][0]]))
    chains, widths = (), None
    if contacts is not None:
        start = position[contacts.granule]
        chains = np.stack([start, start + contacts.branch], axis=1)
        widths = 4.0 * contacts.force / strongest
    axes.clear()
    axes.patch.set(**BEHIND)
    beyond = view + np.subtract(*view) * [[1.0], [-1.0]]  # no view shows its edges
    axes.add_patch(Polygon(1e3 * free_space(frames.walls[frame], beyond), **SPACE))
    for shift in shifts(periodic):
        shown = [
            [1e3 * (line + shift) for line in lines] for lines in (granules, chains, rings, marks)
        ]
        for collection in (
            PolyCollection(shown[0], edgecolors="0.25", linewidths=0.5, **look),
            LineCollection(
                shown[1], linewidths=widths, colors="#b34700", capstyle="round", zorder=2
            ),
            PolyCollection(shown[2], **STEEL),
            LineCollection(shown[3], linewidths=2.0, colors="black", zorder=4, path_effects=RIM),
        ):
            axes.add_collection(collection, autolim=False)
    xlim, ylim = 1e3 * view.T
    axes.set(xlabel="x (mm)", ylabel="y (mm)", xlim=xlim, ylim=ylim, aspect="equal")
    axes.grid(visible=False)
