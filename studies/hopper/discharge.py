"""Mass that falls through an orifice, and Beverloo's law in two dimensions."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.values import value_of

G = 9.81  # m/s2
BULK = 16e-3, 30e-3  # m, heights between which the packing fraction of the moving bed is measured


def free_fall() -> float:
    """Flow over sqrt(g) D^1.5 from a half circle over the orifice, without dilation."""
    x = np.linspace(-1.0, 1.0, 200_001)
    return float(np.sqrt(2.0 * np.sqrt(1.0 - x**2)).mean() * 2.0 / 2.0**1.5)


class Discharge(NamedTuple):
    """What a sweep measured: `width` (o,) of the orifice over the diameter; `flow` (case, orifice,
    seed): solid area per time, over the bulk packing fraction and sqrt(g d^3), without unit;
    `fraction`: of the bulk."""

    width: np.ndarray
    flow: xr.DataArray
    fraction: xr.DataArray


def discharge(dataset: xr.Dataset) -> Discharge:
    """From the file of a sweep of hoppers."""
    runs = dataset.squeeze("sink") if "sink" in dataset.dims else dataset
    diameter, width = float(runs["diameter"].max()), float(value_of(runs, "box_width"))
    duration = float(runs["snapshot_time"][-1])
    area = runs["sink_mass"].sum("time") / duration / runs["density"] / diameter  # of thickness d
    low, high = BULK
    inside = (runs["granule_y"] > low) & (runs["granule_y"] < high)
    covered = (inside * np.pi / 4.0 * runs["granule_diameter"] ** 2).sum("granule")
    fraction = (covered / width / (high - low)).mean("snapshot")
    flow = area / fraction / np.sqrt(G * diameter**3)
    failed = ~np.isfinite(runs["box_height"])
    return Discharge(runs["orifice"].values.astype(float) * 1e-3 / diameter, flow.where(~failed), fraction)


def beverloo(found: Discharge, case: str) -> np.ndarray:
    """Rows (seed, 2) of C and k of ``flow = C (D / d - k)^1.5``, by a line through flow^(2/3)."""
    rows = found.flow.sel(case=case).transpose("seed", "orifice").values ** (2.0 / 3.0)
    lines = [np.polyfit(found.width, row, 1) for row in rows]
    return np.array([(slope**1.5, -base / slope) for slope, base in lines])
