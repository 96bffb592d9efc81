"""The packing fraction at which a bed jams: its granules grow in the box, around the cylinder.

Above jamming the pressure of a Hertzian bed goes as the distance to the power of 3/2 (O'Hern et al.
2003, Phys. Rev. E 68, 011306), so the line of pressure^(2/3) against packing fraction meets zero
where the bed jams. Pressure is taken as load: force on the walls per length, the stress of two
dimensions. Friction while the granules grow is packing.friction.
"""

from typing import NamedTuple

import numpy as np

from dem.base.errors import PackingError
from dem.experiment.bed import PREPARATIONS, room_of
from dem.experiment.config import Configuration, Replicate
from dem.packing.compaction import START, Press

VARIABLES = {
    "jam_fraction": ((), "1", "packing fraction at which the bed jams"),
    "jam_slope": ((), "1", "slope of load^(2/3) against packing fraction"),
    "jam_load": (
        ("jam_at",),
        "1",
        "load: mean normal force on the walls per length, over E* and the mean diameter",
    ),
    "jam_friction": ((), "1", "coefficient of friction while the granules grow"),
}
SECTIONS = {"cylinder": False, "record": True}
ASKS = {"packing.pressure": (None, "the bed is compressed")}
BED_ALONE = True
AXIS = {"jam_at": (("jam_at",), "1", "packing fraction")}
STEP = 0.005  # of the packing fraction
STEPS = 50  # at most
SIZES = {"jam_at": STEPS}
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


def compress(replicate: Replicate) -> Path:
    """Grow the granules of a run until the bed is well above jamming; NaN where no bed is found."""
    own = replicate.configuration
    prepare = PREPARATIONS[own.packing.preparation]
    fractions, loads = [], []
    try:
        press = Press(*room_of(replicate), own.packing.friction, prepare)
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


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    return {"jam_at": START + STEP * np.arange(STEPS)}


def run(replicate: Replicate, bed=None, progress=lambda done: None) -> dict:
    """Grow the bed of a run until it jams; returns the variables of a run by name."""
    path = compress(replicate)
    load = np.full(STEPS, np.nan)
    load[: len(path.load)] = path.load
    return {
        "jam_fraction": path.jamming,
        "jam_slope": path.slope,
        "jam_load": load,
        "jam_friction": replicate.configuration.packing.friction,
    }
