"""The packing fraction at which a bed jams, and those at which shapes are equally far from it.

Granules grow in the box of the run, around the cylinder; above jamming the pressure of a Hertzian
bed goes as the distance to the power of 3/2 (O'Hern et al. 2003, Phys. Rev. E 68, 011306), so the
line of pressure^(2/3) against packing fraction meets zero where the bed jams. Pressure is taken as
load: force on the walls per length, the stress of two dimensions.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.base.errors import InputError, PackingError
from dem.experiment import drag
from dem.experiment.config import Replicate
from dem.experiment.fit import height_of_box
from dem.packing.pressed import START, Press
from dem.shapes import KINDS

STEP = 0.005  # of the packing fraction
STEPS = 50  # at most
# load: mean normal force on the walls per length, over E* and the mean diameter
NOISE = 5e-5  # a bed under less load may be at rest without being jammed
ENOUGH = 1.1e-3  # here the line is long enough


class Path(NamedTuple):
    """fraction (k,) and load (k,), over E* and the mean diameter, along the growth of one bed;
    jamming: fraction where it jams; slope: of load^(2/3) against fraction."""

    fraction: np.ndarray
    load: np.ndarray
    jamming: float
    slope: float


def compress(replicate: Replicate, friction: float) -> Path:
    """Grow the granules of a run until the bed is well above jamming; NaN where no bed is found."""
    sizes, sweep = drag.diameters(replicate), replicate.sweep
    height = height_of_box(sweep, sizes)
    shape = KINDS[replicate.shape.kind].shape.of_size(sizes, replicate.shape.ratio)
    room = shape, sweep.box_width, height, drag.cylinder(replicate, height)
    fractions, loads = [], []
    try:
        press = Press(*room, replicate.seed, friction)
        for fraction in START + STEP * np.arange(STEPS):
            loads.append(press.press(fraction) / replicate.shape.diameter)
            fractions.append(fraction)
            if loads[-1] > ENOUGH:
                break
    except PackingError:
        return Path(np.array(fractions), np.array(loads), np.nan, np.nan)
    return line(np.array(fractions), np.array(loads))


def line(fraction: np.ndarray, load: np.ndarray) -> Path:
    """The Path through these points; NaN where fewer than three are above the noise."""
    quiet = np.flatnonzero(load <= NOISE)
    start = quiet[-1] + 1 if len(quiet) else 0
    if len(fraction) - start < 3:
        return Path(fraction, load, np.nan, np.nan)
    slope, height = np.polyfit(fraction[start:], load[start:] ** (2.0 / 3.0), 1)
    return Path(fraction, load, -height / slope, slope)


def measure(replicates: dict[str, list[Replicate]], frictions, progress=lambda done: None) -> dict:
    """Variables over `jam` by the names of layout.py: beds by label, at each friction."""
    jobs = [(label, r, mu) for label, some in replicates.items() for r in some for mu in frictions]
    paths = []
    for done, (_, replicate, friction) in enumerate(jobs):
        paths.append(compress(replicate, friction))
        progress((done + 1) / len(jobs))
    curve = np.full((len(jobs), STEPS), np.nan)
    for row, path in zip(curve, paths, strict=True):
        row[: len(path.load)] = path.load
    return {
        "jam_shape": np.array([label for label, _, _ in jobs]),
        "jam_ratio": np.array([float(r.shape.ratio) for _, r, _ in jobs]),
        "jam_diameter": np.array([r.shape.diameter for _, r, _ in jobs]),
        "jam_seed": np.array([r.seed for _, r, _ in jobs]),
        "jam_friction": np.array([mu for _, _, mu in jobs]),
        "jam_fraction": np.array([path.jamming for path in paths]),
        "jam_slope": np.array([path.slope for path in paths]),
        "jam_load": curve,
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

    def at_load(self, shape: str, other: str, fraction: float) -> float:
        """Where a shape has the load on the walls that another has at a packing fraction.

        Where that one bears none, below jamming, distances are all there is to compare.
        """
        distance = fraction - self.fraction(other)
        if distance <= 0.0:
            return self.fraction(shape) + distance
        slopes, sizes = zip(*(self._line(label) for label in (other, shape)), strict=True)
        return self.fraction(shape) + distance * slopes[0] / slopes[1] * (sizes[0] / sizes[1]) ** (
            2 / 3
        )

    def _line(self, shape):
        """Mean slope of load^(2/3), and the diameter (m) that the load is measured by."""
        beds = self.beds(shape)
        return float(beds["jam_slope"].mean()), float(beds["jam_diameter"][0])
