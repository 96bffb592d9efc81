"""A scene at three times of its recorded phase, and the force and torque on each solid against time."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.one_run import replicate_at
from dem.base.errors import InputError
from dem.base.statistics import half_interval
from dem.experiment.snapshots import snapshots_of
from dem.figures import style
from dem.figures.bed import draw, view_of
from dem.figures.frames import Frames
from dem.figures.snapshots import frames_of_case

FILE = "scene"
CAPTION = "A scene at three times, and the force and torque on each of its solids"
VARIABLES = ("granule_x", "solid_x")
SHARES = 0.0, 0.5, 1.0  # of the recorded phase


def frames_of_point(dataset: xr.Dataset, one: xr.Dataset) -> Frames:
    """Frames of one run: its granules, walls and solids at the snapshots."""
    variables = {str(name): variable.values for name, variable in one.variables.items()}
    return frames_of_case(snapshots_of(replicate_at(dataset, one), variables))


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
    one = runs.isel(seed=whole[0]).dropna("granule", subset=["granule_diameter"])
    frames, time = frames_of_point(dataset, one), runs["snapshot_time"].values
    view = view_of(frames)
    width, height = view[1] - view[0]
    tall = style.WIDTH / len(SHARES) * height / width
    figure = Figure(figsize=(style.WIDTH, 4.2 + tall))
    beds, curves = figure.subfigures(2, 1, height_ratios=(tall + 0.6, 3.6))
    for axes, share in zip(beds.subplots(1, len(SHARES)), SHARES, strict=True):
        snapshot = int(np.abs(time - share * time[-1]).argmin())
        draw(axes, frames, snapshot, view, facecolors=frames.paints["layer"])
        axes.set_axis_off()
        axes.set_title(f"{time[snapshot]:.3g} s")
    force = np.hypot(runs["solid_force_x"], runs["solid_force_y"])
    panels = (force, "Force on the solid (N)"), (runs["solid_torque"], "Torque on it (N m)")
    for axes, (values, words) in zip(curves.subplots(1, 2), panels, strict=True):
        for k, name in enumerate(runs["solid"].values):
            on = values.isel(solid=k)
            look = {"color": style.CASES[k % len(style.CASES)]}
            line = {"linestyle": style.LINES[k % len(style.LINES)], "label": str(name)}
            axes.plot(runs["time"], on.mean("seed"), **look, **line)
            if len(whole) > 1:
                style.band(axes, runs["time"], on.mean("seed"), half_interval(on), **look)
        axes.set(xlabel="Time (s)", ylabel=words)
    style.legend(figure, axes, ncols=4)
    point = ", ".join(f"{dim} {runs[dim].item()}" for dim in beside if dim in runs.coords)
    several = f"; below mean of {len(whole)} seeds, 95 % intervals"
    words = f"(one run{' above' + several if len(whole) > 1 else ''})"
    figure.suptitle(f"{dataset.attrs['title']}: {point}\n{words}")
    return figure
