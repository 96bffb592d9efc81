"""Flow of granules through an orifice, and Beverloo's law in two dimensions."""

import numpy as np
import xarray as xr

from dem.analysis.values import value_of

G = 9.81  # m/s2


def free_fall() -> float:
    """Flow over the square root of g D^3 if granules fall freely, and none apart from the next, from a half circle
    over an orifice of width D."""
    x = np.linspace(-1.0, 1.0, 200_001)
    return float(np.sqrt(2.0 * np.sqrt(1.0 - x**2)).mean() * 2.0 / 2.0**1.5)


def discharge(runs: xr.Dataset) -> xr.Dataset:
    """Of each run, without unit: `width` of the orifice over the diameter d; `fraction`, the packing fraction of the
    bed above; `flow`, area of granules per time over that fraction and the square root of g d^3; `share`, the same
    over the square root of g D^3 with the width D; `early`, the flow of the first half over that of all."""
    runs = runs.squeeze("sink")
    diameter, within = runs["diameter"], runs["region_mass"].mean("snapshot")
    left, bottom, right, top = value_of(runs, "record.region").values
    inside = (right - left) * (top - bottom)
    width = runs["orifice"].astype(float) * 1e-3 / diameter
    time, gone = float(runs["snapshot_time"][-1]), runs["sink_mass"]
    flow = gone.sum("time") / time * inside / within / np.sqrt(G * diameter**3)
    half = gone.isel(time=slice(None, gone.sizes["time"] // 2)).sum("time")
    return xr.Dataset(
        {
            "width": width,
            "fraction": within
            / (runs["density"] * diameter * inside),  # as thick as a disc is wide
            "flow": flow,
            "share": flow / width**1.5,
            "early": 2.0 * half / gone.sum("time"),
        }
    )


def beverloo(width: np.ndarray, flow: np.ndarray) -> tuple[float, float]:
    """C and k of ``flow = C (width - k)^1.5``, from a line through the powers 2/3."""
    slope, base = np.polyfit(width, flow ** (2.0 / 3.0), 1)
    return slope**1.5, -base / slope
