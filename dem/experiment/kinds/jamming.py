"""The packing fraction at which a bed jams: its granules grow in the box, around the cylinder.

Above jamming the pressure of a Hertzian bed goes as the distance to the power of 3/2 (O'Hern et al.
2003, Phys. Rev. E 68, 011306), so the line of pressure^(2/3) against packing fraction meets zero
where the bed jams. Pressure is taken as load: force on the walls per length, the stress of two
dimensions. Friction while the granules grow is packing.friction.
"""

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


def line(fraction: np.ndarray, load: np.ndarray) -> tuple[float, float]:
    """Packing fraction where a bed jams, and slope of load^(2/3) there; NaN where fewer than three
    points are above the noise."""
    quiet = np.flatnonzero(load <= NOISE)
    start = quiet[-1] + 1 if len(quiet) else 0
    if len(fraction) - start < 3:
        return np.nan, np.nan
    slope, height = np.polyfit(fraction[start:], load[start:] ** (2.0 / 3.0), 1)
    return -height / slope, slope


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    return {"jam_at": START + STEP * np.arange(STEPS)}


def run(replicate: Replicate, bed=None, progress=lambda done: None) -> dict:
    """Grow the granules of a run until the bed is well above jamming; returns the variables of a run by
    name, NaN where no bed is found."""
    packing, loads = replicate.configuration.packing, []
    fractions = START + STEP * np.arange(STEPS)
    try:
        press = Press(*room_of(replicate), packing.friction, PREPARATIONS[packing.preparation])
        while len(loads) < STEPS and (not loads or loads[-1] <= ENOUGH):
            loads.append(press.press(fractions[len(loads)]) / replicate.shape.diameter)
        jamming, slope = line(fractions[: len(loads)], np.array(loads))
    except PackingError:
        jamming = slope = np.nan
    return {
        "jam_fraction": jamming,
        "jam_slope": slope,
        "jam_load": loads,
        "jam_friction": packing.friction,
    }
