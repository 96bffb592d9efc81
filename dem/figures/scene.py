"""A scene at three times of its recorded phase, and force and torque on its solids against time."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.one_run import run_at
from dem.base.errors import InputError
from dem.base.statistics import half_interval
from dem.experiment.snapshots import snapshots_of
from dem.figures import style
from dem.figures.bed import draw, view_of
from dem.figures.snapshots import frames_of_case
from dem.figures.sweep import at_place

FILE = "scene"
CAPTION = "A scene at three times, and the force and torque on each solid that is there"
VARIABLES = ("granule_x", "solid_x")
SHARES = 0.0, 0.5, 1.0  # of the recorded phase


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """The first seed of the first point of all axes above; means of its seeds below. Raises InputError
    where all of these failed."""
    if "configuration" not in dataset.attrs:
        raise InputError(
            "it holds single runs; dem draw shows them, and the figure the file of a sweep."
        )
    beside = {dim: 0 for dim in dataset["run_id"].dims if dim != "seed"}
    runs = dataset.isel(beside)
    if "seed" not in runs.dims:
        runs = runs.expand_dims("seed")
    whole = np.flatnonzero(np.isfinite(runs["box_height"]))
    if not len(whole):
        raise InputError("all runs of the first point of this file failed; there is none to draw.")
    frames = frames_of_case(snapshots_of(*run_at(dataset, runs.isel(seed=whole[0]))))
    time = runs["snapshot_time"].values
    view = view_of(frames)
    width, height = view[1] - view[0]
    tall = style.WIDTH / len(SHARES) * height / width
    there = np.flatnonzero(np.isfinite(frames.turn).any(axis=0))  # others were removed before
    heights = (tall + 0.6, 3.6)[: 1 + bool(len(there))]
    figure = Figure(figsize=(style.WIDTH, sum(heights)))
    beds, *below = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False).flat
    for axes, share in zip(beds.subplots(1, len(SHARES)), SHARES, strict=True):
        snapshot = int(np.abs(time - share * time[-1]).argmin())
        draw(axes, frames, snapshot, view, facecolors=frames.paints["layer"])
        axes.set_axis_off()
        axes.set_title(f"{time[snapshot]:.3g} s")
    coords = [dim for dim in beside if dim in dataset.coords]
    point = ", ".join(
        at_place(dataset, dim, dataset[dim].values[0]).replace(": ", " ") for dim in coords
    )
    words = "one run"
    for curves in below:
        draw_curves(curves, runs.isel(solid=there), len(whole) > 1)
        style.legend(figure, curves.axes[0], ncols=4)
        if len(whole) > 1:
            words = f"one run above; below mean of {len(whole)} seeds, 95 % intervals"
    figure.suptitle(f"{dataset.attrs['title']}: {point}\n({words})")
    return figure


def draw_curves(figure, runs: xr.Dataset, bands: bool) -> None:
    """Force and torque on each solid, the mean of all seeds; bands: with its interval."""
    force = np.hypot(runs["solid_force_x"], runs["solid_force_y"])
    panels = (force, "Force on the solid (N)"), (runs["solid_torque"], "Torque on it (N m)")
    for axes, (values, words) in zip(figure.subplots(1, 2), panels, strict=True):
        for k, name in enumerate(runs["solid"].values):
            on = values.isel(solid=k)
            look = {"color": style.CASES[k % len(style.CASES)]}
            line = {"linestyle": style.LINES[k % len(style.LINES)], "label": str(name)}
            axes.plot(runs["time"], on.mean("seed"), **look, **line)
            if bands:
                style.band(axes, runs["time"], on.mean("seed"), half_interval(on), **look)
        axes.set(xlabel="Time (s)", ylabel=words)
