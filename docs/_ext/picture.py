"""The picture at the top of README: beds of three shapes, and the drag in them."""

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from dem.figures import bed, style
from dem.figures.snapshots import frames_of_case, motion_of

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
            _bed(axes, motion_of(dataset, case))
            axes.set_title(title)
        stroke = 1e3 * float(dataset["snapshot_displacement"].max())
    beds[1].set_xlabel(f"Layers as they were at the start, after {stroke:.0f} mm")
    with xr.open_dataset(drag) as dataset:
        for case, title in CASES.items():
            one = dataset.sel(case=case)
            look, x, (mean, half) = (
                style.look(one),
                1e3 * one["displacement"].values,
                style.smoothed(one),
            )
            curves.plot(x, mean, color=look.color, linestyle=look.line, label=title)
            style.band(curves, x, mean, half, color=look.color)
        curves.set(xlim=(0.0, x[-1]), ylim=(0.0, None), xlabel="Displacement of the cylinder (mm)")
    curves.set_ylabel("Drag (N)")
    curves.set_title("Mean of five runs, 95 % intervals")
    curves.legend(loc="upper left")
    return style.save(figure, folder / NAME)


def _bed(axes, motion) -> None:
    frames, cylinder = frames_of_case(motion), motion.replicate.configuration.cylinder.diameter
    view = bed.view_of(frames)
    bed.draw(axes, frames, SNAPSHOT, view, facecolors=frames.paints["layer"])
    axes.set_axis_off()
    x, y = 1e3 * frames.place[SNAPSHOT, 0]
    arrow = {"arrowstyle": "-|>", "linewidth": 2.0, "color": "black"}
    axes.annotate("", (x, y + 1.4e3 * cylinder), (x, y), arrowprops=arrow)
    words = {"ha": "center", "va": "top", "fontsize": "small"}
    axes.annotate("cylinder", (x, y - 0.5e3 * cylinder), **words)
