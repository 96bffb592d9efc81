"""The packing fraction at which a bed jams: its granules grow in the box, around the cylinder.

Above jamming the pressure of a Hertzian bed goes as the distance to the power of 3/2 (O'Hern et al.
2003, Phys. Rev. E 68, 011306), so the line of pressure^(2/3) against packing fraction meets zero
where the bed jams; of a linear one as the distance itself. Pressure is taken as load: force on the
walls per length, the stress of two dimensions. Friction while the granules grow is packing.friction.
"""

import numpy as np

from dem.base.errors import PackingError
from dem.experiment.bed import PREPARATIONS, room_of
from dem.experiment.config import Configuration
from dem.experiment.run import Replicate
from dem.packing.compaction import START, Press

VARIABLES = {
    "jam_fraction": ((), "1", "packing fraction at which the bed jams"),
    "jam_slope": (
        (),
        "1",
        "slope of load^(1/n) against packing fraction, n = 3/2 under Hertz's law",
    ),
    "jam_load": (
        ("jam_at",),
        "1",
        "load: mean normal force on the walls per length, over E* and the mean diameter, or over K",
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
FRACTIONS = START + STEP * np.arange(STEPS)
# load: mean normal force on the walls per length, over E* and the mean diameter
NOISE = 5e-5  # a bed under less load may be at rest without being jammed
ENOUGH = 1.1e-3  # here a line through the points above the noise is long enough


def line(fraction: np.ndarray, load: np.ndarray, power: float = 1.5) -> tuple[float, float]:
    """Packing fraction where a bed jams, and slope of load^(1/power) there; NaN where fewer than three
    points are above the noise."""
    quiet = np.flatnonzero(load <= NOISE)
    start = quiet[-1] + 1 if len(quiet) else 0
    if len(fraction) - start < 3:
        return np.nan, np.nan
    slope, height = np.polyfit(fraction[start:], load[start:] ** (1.0 / power), 1)
    return -height / slope, slope


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    return {"jam_at": FRACTIONS}


def run(replicate: Replicate, bed=None, progress=lambda done: None) -> dict:
    """Grow the granules of a run until the bed is well above jamming; returns the variables of a run by
    name, NaN where no bed is found."""
    packing, law, loads = replicate.configuration.packing, replicate.law, []
    unit = law.scale(1.0, replicate.shape.diameter)
    try:
        room = room_of(replicate.bed_description)
        press = Press(*room, packing.friction, PREPARATIONS[packing.preparation])
        for fraction in FRACTIONS:
            loads.append(press.press(fraction) / unit)
            if sum(load > NOISE for load in loads) > 2 and loads[-1] > ENOUGH:
                break
        jamming, slope = line(FRACTIONS[: len(loads)], np.array(loads), law.power)
    except PackingError:
        jamming = slope = np.nan
    return {
        "jam_fraction": jamming,
        "jam_slope": slope,
        "jam_load": loads,
        "jam_friction": packing.friction,
    }
