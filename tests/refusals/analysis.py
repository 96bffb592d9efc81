"""Files of runs that say too little, and tables that cannot be written."""

from pathlib import Path

import numpy as np
from project import ROOT
from synthetic import VELOCITY, drags, drawn, jammed, sheared

from dem.analysis.means import means, write_means
from dem.analysis.onset import limits
from dem.analysis.shear import rheology
from dem.analysis.velocity import rates

FILE = ROOT / "docs/data/drag.nc"


def fit(velocities, beds):
    rates(drawn(np.ones((1, velocities, beds)), VELOCITY[:velocities]))


CALLS = {
    "of a file that ends in .csv or .nc": lambda: write_means(means(FILE, "drag"), Path("m.txt")),
    "it has 3 velocities": lambda: fit(3, 5),
    "2 beds that were drawn at all of them; a fit takes 4 and 3": lambda: fit(7, 2),
    "do not differ in cylinder.velocity": lambda: rates(
        drawn([drags(1.0, 1.0, 1.0)]).isel(cylinder_velocity=0)
    ),
    "do not differ in shear.inertial_number": lambda: rheology(
        sheared([[0.3, 0.4]]).isel(shear_inertial_number=0)
    ),
    "it has 2 and 4": lambda: limits(jammed((50, 100))),
    "it has 3 and 2": lambda: limits(jammed(beds=2)),
}
COMMANDS = {"means docs/data/drag.nc --of lift": "it has no lift; it has "}
