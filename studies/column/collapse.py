"""Run-out and height over the base of a column, of our runs and as published."""

import numpy as np
import xarray as xr

HALF = 0.5e-3  # m, of the thickness of the gate
DYNAMICS = np.array([(0.5, 0.94, 0.50), (1.42, 3.45, 0.74), (6.26, 12.3, 1.24)])  # see README.md
RATIO = np.geomspace(0.65, 8.0, 100)  # of the columns that the fits below are drawn for
RODS = np.where(RATIO < 1.5, 3.25 * RATIO**0.96, 3.8 * RATIO**0.73), RATIO ** (1 / 3) / 1.42
ROLLING = np.where(RATIO < 2.7, 1.67 * RATIO, 2.7 * RATIO ** (2 / 3))


def normalised(runs: xr.Dataset) -> xr.Dataset:
    """Of each run over its base: run-outs and height at the end, and at the start the aspect ratio, by twice
    the height of the centre of mass, which is the height of a rectangle."""
    base, runs = runs["solids_gate_x"] - HALF, runs.squeeze("density")
    first, last = (runs.isel(snapshot=at) for at in (0, -1))
    return last.assign(
        front=last["front"] / base - 1.0,
        front_99=last["front_99"] / base - 1.0,
        height=last["height"] / base,
        ratio=2.0 * first["middle_y"] / base,
        unrest=first["unrest"],
    )
