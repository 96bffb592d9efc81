"""Which friction and packing fraction has a sheared bed of discs?

Second-hand: mu = 0.25 + 1.1 I and phi = 0.81 - 0.3 I are attributed to da Cruz, Emam, Prochnow, Roux
and Chevoir (2005, Phys. Rev. E 72, 021309), whose paper we could not obtain, for a friction of 0.4
between discs and inertial numbers I of about 0.01 to 0.1. Nothing runs here: the flows are those of studies/shear/shear.nc, with their restitution
(0.1), spread of diameters (20 %) and definition of I, measured in the middle half of the height.
Ours are smaller (12 by 17 diameters) and have Hertzian contacts.

Tolerances. Half of a 95 % interval over runs, by Student's t, and the last digits of what is
published: 0.005 + 0.05 I of either. The mean excess over the three numbers averages errors of its
own: a third of the root of their squares, and the mean of the last digits.
"""

import numpy as np
import xarray as xr

from dem.analysis.shear import rheology
from studies import HERE
from studies.verification.row import Row

TITLE = "Friction and packing fraction in shear"
SOURCE = "attributed to da Cruz and others 2005, second-hand"

FILE = HERE / "shear/shear.nc"
FRICTION = ("0.4",)  # between granules
LOW, HIGH = 0.009, 0.1  # of I, where the straight lines are said to hold
MU, PHI = "friction of the bed", "packing fraction"


def measure() -> list[Row]:
    with xr.open_dataset(FILE) as dataset:
        flow = rheology(dataset.load())[FRICTION]
    rows = []
    for at in np.flatnonzero((flow.number > LOW) & (flow.number < HIGH)):
        number = flow.number[at]
        for name, interval, expected in (
            (MU, flow.middle[at], 0.25 + 1.1 * number),
            (PHI, flow.fraction[at], 0.81 - 0.3 * number),
        ):
            tolerance = interval[2] - interval[0] + _digits(number)
            rows.append(Row(name, "1", interval[0], expected, tolerance, number))
    for name in (MU, PHI):
        of = [row for row in rows if row.name == name]
        digits = np.array([_digits(row.x) for row in of])
        errors = np.array([row.tolerance for row in of]) - digits
        excess = np.mean([row.value - row.expected for row in of])
        tolerance = np.sqrt((errors**2).sum()) / len(of) + digits.mean()
        rows.append(Row(f"mean excess of the {name}", "1", excess, 0.0, tolerance))
    return rows


def _digits(number: float) -> float:
    """What the published coefficients leave open."""
    return 0.005 + 0.05 * number
