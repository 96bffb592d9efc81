"""A scene at three times of its recorded phase, and the force and torque on each solid against time."""

import json

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.base.statistics import half_interval
from dem.experiment.config import Configuration, of_results
from dem.experiment.run import Replicate
from dem.figures import style
from dem.figures.bed import MARGIN, draw, joined
from dem.figures.frames import Frames, layer_colours
from dem.periodic import periods_of, walled
from dem.shapes import outlines
from dem.solids import box
from dem.sweep.axis import RUN_KEYS, name_of

FILE = "scene"
CAPTION = "A scene at three times, and the force and torque on each of its solids"
VARIABLES = ("granule_x", "solid_x")
SHARES = 0.0, 0.5, 1.0  # of the recorded phase


def replicate_of(dataset: xr.Dataset, one: xr.Dataset) -> Replicate:
    """The run of one point of a file of scenes, with what varies there."""
    values = json.loads(dataset.attrs["configuration"])
    values = {name: values[name] for name in Configuration.read if name in values}
    values |= {name: one[name].item() for name in RUN_KEYS}
    run = of_results(values)
    for path in run.configuration.entries:
        if (name := name_of(path)) in one.variables:
            value = one[name].item()
            *groups, last = path.split(".")
            section = values
            for group in groups:
                section = section[group]
            section[last] = None if value == "null" else value
    return of_results(values)


def frames_of_point(dataset: xr.Dataset, one: xr.Dataset) -> Frames:
    """Frames of one run, without contacts: its granules, walls and solids at the snapshots."""
    run, count = replicate_of(dataset, one), one.sizes["snapshot"]
    height = float(one["box_height"])
    periods = periods_of(run.configuration.box_width, height, run.configuration.periodic)
    labels, diameters = run.labels(), one["granule_diameter"].values
    position = np.stack([one["granule_x"], one["granule_y"]], axis=-1)
    low, top = position[0, :, 1].min(), position[0, :, 1].max()
    solids = tuple(solid.solid(height) for solid in run.bed_description.solids)
    planes = box(run.configuration.box_width, height)[walled(periods)]
    return Frames(
        title=None,
        position=position,
        angle=one["granule_angle"].values,
        velocity=np.zeros_like(position),
        rings=joined(outlines(labels["kind"], diameters, labels["aspect_ratio"])),
        walls=np.broadcast_to(planes, (count, *planes.shape)),
        solids=solids,
        place=np.stack([one["solid_x"], one["solid_y"]], axis=-1),
        turn=one["solid_angle"].values,
        contacts=None,
        fastest=1.0,
        paints={"layer": layer_colours(position[0] - [0.0, low], top - low)},
        captions=[],
        record=None,
        marks=one["snapshot_time"].values,
        periodic=periods,
    )


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """The first seed of the first point of all axes above; means of its seeds below. Raises InputError
    where all of these failed."""
    beside = {dim: 0 for dim in dataset["run_id"].dims if dim != "seed"}
    runs = dataset.isel(beside)
    if "seed" not in runs.dims:
        runs = runs.expand_dims("seed")
    whole = np.flatnonzero(np.isfinite(runs["box_height"]))
    if not len(whole):
        raise InputError("all runs of the first point of this file failed; there is none to draw.")
    one = runs.isel(seed=whole[0]).dropna("granule", subset=["granule_diameter"])
    frames, time = frames_of_point(dataset, one), runs["snapshot_time"].values
    size = np.array([json.loads(dataset.attrs["configuration"])["box_width"], one["box_height"]])
    edge = (
        MARGIN * size.max() * np.array([side is None for side in frames.periodic or (None, None)])
    )
    view = np.array([-edge, size + edge])  # a solid may be drawn out of the box
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
