"""Drag over that of the first shape against the width of the box, at equal pressure and
fraction."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.values import places_beside
from dem.figures import style
from dem.figures.sweep import heading
from studies.common.shapes import name
from studies.pressure.widths import Widths

FILE = "drag"
CAPTION = (
    "Drag of shapes against the width of the box, at equal pressure and at equal packing fraction"
)
AXES = {"box": 3, "shape": 2, "seed": 2}
APART = 0.03  # between shapes, of a width
BEYOND = 2.0  # times the widest box: place of infinite width


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Drags above and ratios below against width, one column per place on the other axes."""
    columns = places_beside(dataset, *AXES)
    figure, grid = style.panels(2 * len(columns), len(columns), 0.4, 3.5, sharex=True)
    found = []
    for above, below, place in zip(grid, grid[len(columns) :], columns, strict=False):
        widths = Widths(dataset.sel(place))
        base = widths.line(widths.shapes[0])
        for number, shape in enumerate(widths.shapes):
            look = style.numbered(number) | {"label": name(shape)}
            shift = 1.0 + APART * (number - 0.5 * (len(widths.shapes) - 1))
            line = widths.line(shape)
            drags = [widths.drag(shape, box) for box in widths.series]
            _points(above, widths, shift, drags, widths.drag_limit(shape), line.drag, look)
            if number:
                ratios = [widths.ratio(shape, box) for box in widths.series]
                _points(below, widths, shift, ratios, widths.limit(shape), _over(line, base), look)
        found.append(f"{widths.ratio(shape, widths.series[-1]).value:.2g}")
        equal = heading(dataset, place, len(columns)) or "all runs"
        above.set_title(f"Equal {equal}" if len(columns) > 1 else equal)
        style.logarithmic(below, "x")
        places = np.unique(widths.width[widths.along])
        ticks = [f"{width:g}" for width in places]
        below.set_xticks([*places, BEYOND * places[-1]], [*ticks, "\N{INFINITY}"])
        below.axhline(1.0, **style.REFERENCE)
        below.set_xlabel("Width of the box / that of the first")
        for axes in (above, below):
            style.logarithmic(axes)
    grid[0].set_ylabel(f"Mean drag from\n{style.window_text(dataset)} (N)")
    grid[len(columns)].set_ylabel(f"Drag over that of {name(widths.shapes[0])}")
    style.legend(figure, grid[0], ncols=3)
    figure.suptitle(
        f"The drag of {name(shape)} in the widest box is {' or '.join(found)} times that of {name(widths.shapes[0])}\n"
        "(95 % intervals; open: extrapolated to infinite width, where possible)"
    )
    return figure


def _over(line, base):
    """Ratio of two lines by width."""
    return lambda width: line.drag(width) / base.drag(width)


def _points(axes, widths, shift, values, limit, curve, look):
    """Means in the boxes that differ in width alone; the line through them and its limit, if the
    drag has one."""
    x = widths.width[widths.along]
    style.intervals(axes, x * shift, values, **look)
    if 0.0 < limit.low <= limit.high < np.inf:
        end = BEYOND * x.max()
        style.intervals(
            axes, [end * shift], limit, markerfacecolor="white", **look | {"label": None}
        )
        along = np.geomspace(x.min(), x.max(), 50)
        y = [curve(width)[0] for width in along]
        axes.plot(along * shift, y, color=look["color"], linewidth=1.2)
