"""Figures 9 to 12: beds at equal displacements of the cylinder, one row per case."""

import json

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import find
from dem.analysis.one_run import run_at
from dem.base.errors import InputError
from dem.experiment.snapshots import Snapshots, snapshots_of
from dem.figures import style
from dem.figures.bed import draw, view_of
from dem.figures.frames import Frames, of_motion
from dem.shapes import is_drawn, outlines

PANEL, AROUND = 2.5, 1.2  # inches: width of a bed; height of the words around all beds
SCALE = 5.0  # mm, of the bar


def motion_of(dataset: xr.Dataset, case: str) -> Snapshots | None:
    """The snapshots of the first seed of a case of snapshots.nc; None where its run failed."""
    run = run_at(dataset, dataset.isel(seed=0).sel(case=case))
    return run and snapshots_of(*run)


def frames_of_case(motion: Snapshots) -> Frames:
    """Frames of such snapshots, with discs in place of mixtures and of shapes in files of a user."""
    labels = motion.replicate.labels()
    return of_motion(motion, outlines(labels["kind"], motion.diameters, labels["aspect_ratio"]))


@style.styled
def beds(dataset: xr.Dataset, shapes: tuple[str, ...], colors: str, title: str) -> Figure:
    """One row per shape, one column per displacement; colors: "cluster" or "layer".

    Raises InputError when there is none of the shapes at the density of the first case.
    """
    motions = {
        case: motion
        for shape in shapes
        if (case := find(dataset, shape)) and (motion := motion_of(dataset, case))
    }
    if not motions:
        raise InputError(f"there is none of the shapes {', '.join(shapes)} in the data.")
    moved = dataset["snapshot_displacement"].values
    # at the start, halfway and at the end
    snapshots = [int(np.abs(moved - moved[-1] * share).argmin()) for share in (0.0, 0.5, 1.0)]
    width = json.loads(dataset.attrs["configuration"])["box_width"]
    tall = sum(motion.height.max() / width for motion in motions.values())
    figure = Figure(figsize=(style.WIDTH, AROUND + PANEL * tall))
    grid = figure.subplots(len(motions), len(snapshots), squeeze=False)
    for row, (case, motion) in zip(grid, motions.items(), strict=True):
        frames = frames_of_case(motion)
        view = view_of(frames)
        for axes, snapshot in zip(row, snapshots, strict=True):
            draw(axes, frames, snapshot, view, facecolors=frames.paints[colors])
            axes.set_axis_off()
        one, height = dataset.sel(case=case), motion.height[0]
        note = "" if is_drawn(one["kind"].item()) else ", drawn as discs of equal area"
        row[0].annotate(
            f"{case}: {style.describe(one)}{note}\nbox {1e3 * width:.3g} mm \N{MULTIPLICATION SIGN} {1e3 * height:.3g} mm",
            (-0.04, 0.5),
            rotation=90,
            xycoords="axes fraction",
            ha="right",
            va="center",
        )
    for axes, snapshot in zip(grid[0], snapshots, strict=True):
        shown = 1e3 * moved[snapshot]
        axes.set_title(f"after {shown:.1f} mm" if shown else "at the start")
    scale_bar(grid[-1, 0])
    figure.suptitle(f"{title}\n(one run each, seed {int(dataset['seed'][0])})")
    return figure


def scale_bar(axes) -> None:
    """Draw a bar of a round length below a bed, on axes in mm."""
    look = {"color": "black", "linewidth": 3.0, "solid_capstyle": "butt", "clip_on": False}
    axes.plot([0.0, SCALE], [-1.2, -1.2], **look)
    axes.text(1.2 * SCALE, -1.2, f"{SCALE:g} mm", va="center")
