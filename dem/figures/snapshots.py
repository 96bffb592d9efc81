"""Figures 9 to 12: beds at equal displacements of the cylinder, one row per case."""

import json

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.statistics import find
from dem.base.errors import InputError
from dem.experiment.observables.flow import LAYERS
from dem.figures import bed, style
from dem.periodic import periods_of, wrapped
from dem.shapes import outlines

SHARES = (0.0, 0.5, 1.0)  # of the stroke: displacements that are shown


@style.styled
def beds(dataset: xr.Dataset, shapes: tuple[str, ...], colors: str, title: str) -> Figure:
    """One row per shape, one column per displacement; colors: "cluster" or "layers".

    Raises InputError when there is none of the shapes at the density of the first case.
    """
    dataset = dataset.isel(seed=0)
    there = [case for shape in shapes if (case := find(dataset, shape)) and is_known(dataset, case)]
    if not there:
        raise InputError(f"there is none of the shapes {', '.join(shapes)} in the data.")
    shown = [dataset["snapshot_displacement"].values[-1] * share for share in SHARES]
    snapshots = [int(np.abs(dataset["snapshot_displacement"].values - x).argmin()) for x in shown]
    figure = Figure(figsize=(style.WIDTH, 0.9 + 3.05 * len(there)))
    grid = figure.subplots(len(there), len(snapshots), squeeze=False)
    for row, case in zip(grid, there, strict=True):
        one = dataset.sel(case=case)
        _row(row, one, snapshots, colors, json.loads(dataset.attrs["configuration"]))
        row[0].annotate(
            f"{case}: {style.describe(one)}{style.drawn(one)}", (-0.04, 0.5), rotation=90,
            xycoords="axes fraction", ha="right", va="center", fontsize=11,
        )  # fmt: skip
    for axes, snapshot in zip(grid[0], snapshots, strict=True):
        moved = style.millimetres(dataset["snapshot_displacement"].values[snapshot])
        axes.set_title(f"after {moved:.1f} mm" if moved else "at the start")
    figure.suptitle(title)
    return figure


def is_known(dataset: xr.Dataset, case: str) -> bool:
    """Whether the run of a case did not fail."""
    return bool(dataset["granule_diameter"].sel(case=case).notnull().any())


def heights(bed: xr.Dataset) -> np.ndarray:
    """Height (snapshot,) in m of the box of one run."""
    if "top_y" in bed:
        return bed["top_y"].values
    return np.full(bed.sizes["snapshot"], float(bed["box_height"]))


def _row(row, here, snapshots, colors, configuration) -> None:
    """One case at several displacements."""
    known = np.isfinite(here["granule_diameter"].values)
    sizes, height = here["granule_diameter"].values[known], heights(here)
    rings = outlines(str(here["kind"].values), sizes, float(here["aspect_ratio"]))
    width, diameter = configuration["box_width"], configuration["cylinder"]["diameter"]
    periods = periods_of(width, height[0], configuration["periodic"])
    place = np.stack([here["granule_x"].values, here["granule_y"].values], axis=-1)[:, known]
    place = wrapped(place, periods)
    axis = wrapped(np.array([0.5 * width, float(here["cylinder_y"][0])]), periods)
    paint = (
        bed.cluster_colors(place[0], axis, diameter) if colors == "cluster"
        else bed.layer_colors(place[0], height[0], LAYERS)
    )  # fmt: skip
    for axes, snapshot in zip(row, snapshots, strict=True):
        drawn = bed.Drawing(axes, rings, bed.box_view(width, height.max()), diameter, periods)
        drawn.joints.set_visible(False)  # panels are too small for them
        angle = here["granule_angle"].values[snapshot, known]
        axis = 0.5 * width, float(here["cylinder_y"][snapshot])
        walls = bed.box_walls(width, height[snapshot], periods)
        drawn.move(place[snapshot], angle, axis, walls)
        drawn.paint(paint)
