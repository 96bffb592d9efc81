"""The picture at the top of README: beds of three shapes, and the drag in them."""

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from dem.figures import bed, style
from dem.figures.snapshots import bed_of
from dem.shapes import outlines

NAME, FILES = "beds", ("snapshots", "drag")
CASES = {"c1": "Discs", "d1": "Dumbbells", "e3": "Ellipses 1.375:1"}
SNAPSHOT = -1  # the end of the stroke


@style.styled
def draw(snapshots: Path, drag: Path, folder: Path) -> list[Path]:
    """Draw the beds of the first seed, and the mean drag of all runs with its interval."""
    figure = Figure(figsize=(12.0, 3.7))
    *beds, curves = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.35))
    with xr.open_dataset(snapshots) as dataset:
        for axes, (case, title) in zip(beds, CASES.items(), strict=True):
            _bed(axes, bed_of(dataset, case), dataset.sel(case=case))
            axes.set_title(title)
        stroke = 1e3 * float(dataset["snapshot_displacement"].max())
    beds[1].set_xlabel(f"Layers as they were at the start, after {stroke:.0f} mm")
    with xr.open_dataset(drag) as dataset:
        for case, title in CASES.items():
            one = dataset.sel(case=case)
            look, x, (mean, half) = style.look(one), style.displacement(one), style.smoothed(one)
            curves.plot(x, mean, color=look.color, linestyle=look.line, label=title)
            style.band(curves, x, mean, half, color=look.color)
        curves.set(xlim=(0.0, x[-1]), ylim=(0.0, None), xlabel="Displacement of the cylinder (mm)")
    curves.set_ylabel("Drag (N)")
    curves.set_title("Mean of five runs, 95 % intervals")
    curves.legend(loc="upper left")
    return style.save(figure, folder / NAME)


def _bed(axes, found, case: xr.Dataset) -> None:
    rings = outlines(str(case["kind"].values), found.diameters, float(case["aspect_ratio"]))
    height = found.height[SNAPSHOT]
    view = bed.box_view(found.width, height)
    drawn = bed.Drawing(axes, rings, view, [bed.circle(found.cylinder)], found.periods)
    walls = bed.box_walls(found.width, height, found.periods)
    drawn.move(found.position[SNAPSHOT], found.angle[SNAPSHOT], walls, [found.axis[SNAPSHOT]])
    drawn.paint(bed.layer_colors(found.position[0], found.height[0]))
    x, y = 1e3 * found.axis[SNAPSHOT]
    arrow = {"arrowstyle": "-|>", "linewidth": 2.0, "color": "black"}
    axes.annotate("", (x, y + 1.4e3 * found.cylinder), (x, y), arrowprops=arrow)
    words = {"ha": "center", "va": "top", "fontsize": "small"}
    axes.annotate("cylinder", (x, y - 0.5e3 * found.cylinder), **words)
