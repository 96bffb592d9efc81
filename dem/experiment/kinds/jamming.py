"""The packing fraction at which a bed jams: its granules grow in the box, around the cylinder.

Above jamming the pressure of a Hertzian bed goes as the distance to the power of 3/2 (O'Hern et al.
2003, Phys. Rev. E 68, 011306), so the line of pressure^(2/3) against packing fraction meets zero
where the bed jams; of a linear one as the distance itself. Pressure is taken as load: force on the
walls per length, the stress of two dimensions. Friction while the granules grow is packing.friction.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dem.base.errors import InputError, PackingError
from dem.experiment.bed import PREPARATIONS, room_of
from dem.experiment.config import Configuration
from dem.experiment.replicate import Replicate
from dem.packing.compaction import START, Press

if TYPE_CHECKING:  # a second to load, which runs need not wait for
    import pandas as pd

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
GROWN = {"friction": (0.0, "1", "coefficient of friction of the beds that were grown", {"ge": 0.0})}
PRESSED = None, "it compares beds of one packing.fraction, give that"
DERIVES = {
    "equal_distance": (GROWN, {"packing.pressure": PRESSED, "packing.height": PRESSED}),
    "equal_load": (
        GROWN,
        {
            "packing.pressure": PRESSED,
            "packing.height": PRESSED,
            "friction": (0.0, "it holds for beds without friction, leave friction out"),
            "contact.law": (
                "hertz",
                "loads of jamming compare under Hertz's law alone, derive equal_distance",
            ),
        },
    ),
}
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


class Jamming(NamedTuple):
    """Beds that were grown until they jam.

    beds: a table of kind (text), friction while they grow (1), fraction (1) at which they jam,
          slope of load^(2/3) against fraction, and diameter (m) that loads are measured by
    """

    beds: pd.DataFrame

    def of(self, kind: str, column: str, friction: float = 0.0) -> np.ndarray:
        """A column of the beds of a kind; raises InputError if there are none."""
        beds = self.beds[(self.beds.kind == kind) & np.isclose(self.beds.friction, friction)]
        if beds.empty:
            raise InputError(f"no bed {kind} at friction {friction:g} was grown until it jams.")
        return beds[column].to_numpy()

    def mean(self, kind: str, column: str, friction: float = 0.0) -> float:
        """The mean of a column, without beds that did not jam."""
        return float(np.nanmean(self.of(kind, column, friction)))

    def at_distance(self, kind: str, other: str, fraction: float, friction: float) -> float:
        """Where a kind is as far from jamming as another is at a packing fraction."""
        jams, other_jams = (self.mean(name, "fraction", friction) for name in (kind, other))
        return jams + fraction - other_jams

    def at_load(self, kind: str, other: str, fraction: float) -> float:
        """Where a kind has the load on the walls that another has at a packing fraction.

        Where that one bears none, below jamming, distances are all there is to compare.
        """
        distance = fraction - self.mean(other, "fraction")
        if distance > 0.0:
            size, other_size = (float(self.of(name, "diameter")[0]) for name in (kind, other))
            ratio = (other_size / size) ** (2 / 3)
            distance = distance * self.mean(other, "slope") / self.mean(kind, "slope") * ratio
        return self.mean(kind, "fraction") + distance


def derive(name: str, results, replicate: Replicate, other: Replicate, friction: float) -> float:
    """Packing fraction at which a bed is as far from jamming as another is at the same, or as loaded;
    raises InputError where beds of one of them are not in the results."""
    import pandas as pd

    columns = {
        "run_id": "run_id",
        "bed_family": "kind",
        "jam_friction": "friction",
        "jam_fraction": "fraction",
        "jam_slope": "slope",
        "diameter": "diameter",
    }
    tables = [dataset[[*columns]].to_dataframe()[[*columns]] for dataset in results]
    # a bed in two files counts once
    jamming = Jamming(pd.concat(tables).drop_duplicates("run_id").rename(columns=columns))
    kinds, fraction = (
        (replicate.bed_description.family, other.bed_description.family),
        replicate.configuration.packing.fraction,
    )
    try:
        if name == "equal_load":
            return jamming.at_load(*kinds, fraction)
        return jamming.at_distance(*kinds, fraction, friction)
    except InputError:
        raise InputError(
            f"{name} needs beds like those of {replicate.label} and {other.label} that were grown at "
            f"friction {friction:g} until they jam; they are not in these files."
        ) from None
