"""The film and the picture at the top of pages: beds of three shapes, and their drag."""

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image

from dem.figures import bed, style
from dem.figures.snapshots import frames_of_case, motion_of, scale_bar

NAME, FILES = "beds", ("snapshots", "drag")
FILM, FILMED, FRAMES = "strokes", ("snapshots", "precise"), 17
CASES = {"c1": "Discs", "d1": "Dumbbells", "e3": "Ellipses 1.375:1"}
SNAPSHOT = -1  # the end of the stroke


@style.styled
def draw(snapshots: Path, drag: Path, folder: Path) -> list[Path]:
    """Draw the beds of the first seed, and the mean drag of all runs with its interval."""
    figure = Figure(figsize=(style.WIDTH, 6.6))
    above, below = figure.subfigures(2, 1, height_ratios=(1.25, 1.0))
    beds, curves = above.subplots(1, len(CASES), sharex=True, sharey=True), below.subplots()
    with xr.open_dataset(snapshots) as dataset:
        for axes, (case, title) in zip(beds, CASES.items(), strict=True):
            _bed(axes, frames_of_case(motion_of(dataset, case)), SNAPSHOT)
            axes.set_title(title)
        stroke = 1e3 * float(dataset["snapshot_displacement"].max())
    scale_bar(beds[0])
    names = "every second layer at the start", "layers between", f"cylinder, after {stroke:.0f} mm"
    looks = *({"facecolor": color, "edgecolor": "0.25"} for color in style.LAYERS[::-1]), bed.STEEL
    above.legend(
        handles=[Patch(label=name, **look) for name, look in zip(names, looks, strict=True)],
        loc="outside lower center",
        ncols=3,
    )
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
        ranked = sorted(CASES, key=lambda case: float(dataset["drag"].sel(case=case).mean()))
        count = dataset.sizes["seed"]
        curves.set(xlim=(0.0, stroke), ylim=(0.0, None), xlabel="Displacement of the cylinder (mm)")
    curves.set_ylabel("Drag (N)")
    curves.set_title(f"Mean of {count} runs, 95 % intervals")
    figure.suptitle(f"{CASES[ranked[-1]]} resist most, {CASES[ranked[0]].lower()} least")
    curves.legend(loc="upper left")
    return style.save(figure, folder / NAME)


def _bed(axes, frames, snapshot: int) -> None:
    bed.draw(axes, frames, snapshot, bed.view_of(frames), facecolors=frames.paints["layer"])
    axes.set_axis_off()
    x, y = 1e3 * frames.place[snapshot, 0]
    arrow = {"arrowstyle": "-|>", "linewidth": 2.0, "color": "black"}
    axes.annotate("", (x, y + 2.8e3 * frames.solids[0].radius), (x, y), arrowprops=arrow)


@style.styled
def film(snapshots: Path, precise: Path) -> list[Image.Image]:
    """Frames of the strokes through the beds of the first seed, with the drag of all beds."""
    figure, frames = Figure(figsize=(6.6, 2.5), dpi=200), []
    canvas, beds = FigureCanvasAgg(figure), figure.subplots(1, len(CASES), sharex=True, sharey=True)
    with xr.open_dataset(snapshots) as dataset:
        runs = [frames_of_case(motion_of(dataset, case)) for case in CASES]
        count = dataset.sizes["snapshot"]
    with xr.open_dataset(precise) as dataset:
        window = slice(dataset.attrs["window_start"], dataset.attrs["window_stop"])
        drag = dataset["drag"].sel(displacement=window).mean("displacement").mean("seed")
        times = (drag / drag.sel(case="c1")).sel(case=[*CASES]).values
    for shown in np.linspace(0, count - 1, FRAMES).astype(int):
        for axes, run, title, ratio in zip(beds, runs, CASES.values(), times, strict=True):
            axes.clear()
            _bed(axes, run, shown)
            axes.set_title(f"{title}\ndrag {ratio:.2g}", fontsize=9)
        canvas.draw()
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB"))
    return frames
