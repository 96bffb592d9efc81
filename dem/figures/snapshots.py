"""Figures 9 to 12: beds at equal displacements of the cylinder, one row per case."""

import json
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import find
from dem.base.errors import InputError
from dem.figures import bed, style
from dem.periodic import Periods, periods_of, wrapped
from dem.shapes import outlines

SHARES = (0.0, 0.5, 1.0)  # of the stroke: displacements that are shown
PANEL, AROUND = 2.5, 1.2  # inches: width of a bed; height of the words around all beds
SCALE = 5.0  # mm, of the bar


class Bed(NamedTuple):
    """Snapshots s of n granules in a box, of the first seed of a case. SI units.

    diameters (n,):      volume diameters
    position (s, n, 2):  centres, within the box
    angle (s, n):        anticlockwise
    axis (s, 2):         of the cylinder
    height (s,):         of the box
    width, cylinder:     of the box; diameter of the cylinder
    periods:             of the box, as of dem.Scene
    """

    diameters: np.ndarray
    position: np.ndarray
    angle: np.ndarray
    axis: np.ndarray
    height: np.ndarray
    width: float
    cylinder: float
    periods: Periods


def bed_of(dataset: xr.Dataset, case: str) -> Bed | None:
    """The bed of a case of snapshots.nc; None where its run failed."""
    own, one = json.loads(dataset.attrs["configuration"]), dataset.isel(seed=0).sel(case=case)
    known = np.isfinite(one["granule_diameter"].values)  # other cases may have more granules
    if not known.any():
        return None
    width, count = own["box_width"], one.sizes["snapshot"]
    height = one["top_y"].values if "top_y" in one else np.full(count, float(one["box_height"]))
    periods = periods_of(width, height[0], own["periodic"])
    position = np.stack([one["granule_x"].values, one["granule_y"].values], axis=-1)[:, known]
    axis = np.column_stack([np.full(count, 0.5 * width), one["cylinder_y"].values])
    return Bed(
        one["granule_diameter"].values[known],
        wrapped(position, periods),
        one["granule_angle"].values[:, known],
        wrapped(axis, periods),
        height,
        width,
        own["cylinder"]["diameter"],
        periods,
    )


@style.styled
def beds(dataset: xr.Dataset, shapes: tuple[str, ...], colors: str, title: str) -> Figure:
    """One row per shape, one column per displacement; colors: "cluster" or "layers".

    Raises InputError when there is none of the shapes at the density of the first case.
    """
    cases = [case for case in (find(dataset, shape) for shape in shapes) if case]
    there = {case: found for case in cases if (found := bed_of(dataset, case))}
    if not there:
        raise InputError(f"there is none of the shapes {', '.join(shapes)} in the data.")
    moved = dataset["snapshot_displacement"].values
    snapshots = [int(np.abs(moved - moved[-1] * share).argmin()) for share in SHARES]
    tall = sum(found.height.max() / found.width for found in there.values())
    figure = Figure(figsize=(style.WIDTH, AROUND + PANEL * tall))
    grid = figure.subplots(len(there), len(snapshots), squeeze=False)
    for row, (case, found) in zip(grid, there.items(), strict=True):
        one = dataset.sel(case=case)
        _row(row, found, one, snapshots, colors)
        width, height = 1e3 * found.width, 1e3 * found.height[0]
        row[0].annotate(
            f"{case}: {style.describe(one)}{style.drawn(one)}\nbox {width:.3g} mm \N{MULTIPLICATION SIGN} {height:.3g} mm",
            (-0.04, 0.5),
            rotation=90,
            xycoords="axes fraction",
            ha="right",
            va="center",
        )
    for axes, snapshot in zip(grid[0], snapshots, strict=True):
        shown = style.millimetres(moved[snapshot])
        axes.set_title(f"after {shown:.1f} mm" if shown else "at the start")
    look = {"color": "black", "linewidth": 3.0, "solid_capstyle": "butt", "clip_on": False}
    grid[-1, 0].plot([0.0, SCALE], [-1.2, -1.2], **look)
    grid[-1, 0].text(1.2 * SCALE, -1.2, f"{SCALE:g} mm", va="center")
    figure.suptitle(f"{title}\n(one run each, seed {int(dataset['seed'][0])})")
    return figure


def _row(row, found: Bed, one: xr.Dataset, snapshots: list[int], colors: str) -> None:
    """One case at several displacements."""
    rings = outlines(str(one["kind"].values), found.diameters, float(one["aspect_ratio"]))
    view, start = bed.box_view(found.width, found.height.max()), found.position[0]
    if colors == "cluster":
        paint = bed.cluster_colors(start, found.axis[0], found.cylinder)
    else:
        paint = bed.layer_colors(start, found.height[0])
    for axes, snapshot in zip(row, snapshots, strict=True):
        drawn = bed.Drawing(axes, rings, view, [bed.circle(found.cylinder)], found.periods)
        walls = bed.box_walls(found.width, found.height[snapshot], found.periods)
        place = found.axis[snapshot]
        drawn.move(found.position[snapshot], found.angle[snapshot], walls, [place])
        drawn.paint(paint)
