"""The packing fraction at which a bed jams, and those at which shapes are equally far from it.

Granules grow in the box of the run, around the cylinder; above jamming the pressure of a Hertzian
bed goes as the distance to the power of 3/2 (O'Hern et al. 2003, Phys. Rev. E 68, 011306), so the
line of pressure^(2/3) against packing fraction meets zero where the bed jams.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem import drag
from dem.compaction import START, Press
from dem.config import Replicate, height_of_box
from dem.errors import InputError
from dem.shapes import SHAPES

STEP = 0.005  # of the packing fraction
STEPS = 50  # at most
NOISE = 5e-8  # m: pressure over E* below which a bed may be at rest without being jammed
ENOUGH = 1.2e-6  # m: pressure over E* at which the line is long enough


class Path(NamedTuple):
    """fraction (k,) and pressure (k,) over E* (m, unit thickness) along the growth of one bed;
    jamming: fraction where it jams; slope: of pressure^(2/3) against fraction (m^(2/3))."""

    fraction: np.ndarray
    pressure: np.ndarray
    jamming: float
    slope: float


def compress(replicate: Replicate, friction: float) -> Path:
    """Grow the granules of a run until the bed is well above jamming."""
    sizes, sweep = drag.diameters(replicate), replicate.sweep
    height = height_of_box(sweep, sizes)
    shape = SHAPES[replicate.shape.kind][0].of_size(sizes, replicate.shape.ratio)
    cylinder = drag.cylinder(replicate, height)
    press = Press(shape, sweep.box_width, height, cylinder, replicate.seed, friction)
    fractions, pressures = [], []
    for fraction in START + STEP * np.arange(STEPS):
        fractions.append(fraction)
        pressures.append(press.press(fraction))
        if pressures[-1] > ENOUGH:
            break
    return line(np.array(fractions), np.array(pressures))


def line(fraction: np.ndarray, pressure: np.ndarray) -> Path:
    """The Path through these points; NaN where fewer than three stand above the noise."""
    above = np.flatnonzero(pressure <= NOISE)
    start = above[-1] + 1 if len(above) else 0
    if len(fraction) - start < 3:
        return Path(fraction, pressure, np.nan, np.nan)
    slope, height = np.polyfit(fraction[start:], pressure[start:] ** (2.0 / 3.0), 1)
    return Path(fraction, pressure, -height / slope, slope)


def measure(replicates: dict[str, list[Replicate]], frictions, progress=lambda done: None) -> dict:
    """Variables over `jam` by the names of layout.py: beds by label, at each friction."""
    jobs = [(label, r, mu) for label, some in replicates.items() for r in some for mu in frictions]
    paths = []
    for done, (_, replicate, friction) in enumerate(jobs):
        paths.append(compress(replicate, friction))
        progress((done + 1) / len(jobs))
    curve = np.full((len(jobs), STEPS), np.nan)
    for row, path in zip(curve, paths, strict=True):
        row[: len(path.pressure)] = path.pressure
    return {
        "jam_shape": np.array([label for label, _, _ in jobs]),
        "jam_ratio": np.array([float(r.shape.ratio) for _, r, _ in jobs]),
        "jam_seed": np.array([r.seed for _, r, _ in jobs]),
        "jam_friction": np.array([mu for _, _, mu in jobs]),
        "jam_fraction": np.array([path.jamming for path in paths]),
        "jam_slope": np.array([path.slope for path in paths]),
        "jam_pressure": curve,
        "jam_at": START + STEP * np.arange(STEPS),
    }


class Jamming:
    """Jamming fractions of all shapes, from the variables of `measure`."""

    def __init__(self, dataset: xr.Dataset):
        self._dataset = dataset

    def beds(self, shape: str, friction: float = 0.0) -> xr.Dataset:
        """Rows of a shape packed with a friction; raises InputError if there are none."""
        data = self._dataset
        here = (data["jam_shape"] == shape) & np.isclose(data["jam_friction"], friction)
        if not here.any():
            raise InputError(f"shape {shape!r} at friction {friction:g} is in none of the files of jamming.")  # fmt: skip
        return data.isel(jam=np.flatnonzero(here.values))

    def fraction(self, shape: str, friction: float = 0.0) -> float:
        """Mean jamming fraction of a shape."""
        return float(self.beds(shape, friction)["jam_fraction"].mean())

    def at_distance(self, shape: str, other: str, fraction: float, friction: float = 0.0) -> float:
        """Where a shape is as far from jamming as another is at a packing fraction."""
        return self.fraction(shape, friction) + fraction - self.fraction(other, friction)

    def at_pressure(self, shape: str, other: str, fraction: float) -> float:
        """Where a shape has the pressure that another has at a packing fraction.

        At no pressure, below jamming, distances are all there is to compare.
        """
        distance = fraction - self.fraction(other)
        slopes = [float(self.beds(label)["jam_slope"].mean()) for label in (other, shape)]
        factor = slopes[0] / slopes[1] if distance > 0.0 else 1.0
        return self.fraction(shape) + distance * factor
