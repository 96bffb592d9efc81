"""Files of runs that say too little, and tables that cannot be written."""

from pathlib import Path

import numpy as np
from synthetic import VELOCITY, drags, drawn, jammed, sheared

from dem.analysis.means import means, write_means
from dem.analysis.onset import limits
from dem.analysis.shear import rheology
from dem.analysis.velocity import rates

FILE = Path(__file__).parents[2] / "docs/data/drag.nc"


def fitted(velocities, beds):
    return lambda: rates(drawn(np.ones((1, velocities, beds)), VELOCITY[:velocities]))


CALLS = {
    "means of another format": (
        lambda: write_means(means(FILE, "drag"), Path("means.txt")),
        "of a file that ends in .csv or .nc",
    ),
    "means of what is not there": (lambda: means(FILE, "lift"), "it has no lift; it has "),
    "a law of three velocities": (fitted(3, 5), "it has 3 velocities"),
    "a law of two beds": (
        fitted(7, 2),
        "2 beds that were drawn at all of them; a fit takes 4 and 3",
    ),
    "a law of one velocity": (
        lambda: rates(drawn([drags(1.0, 1.0, 1.0)]).isel(cylinder_velocity=0)),
        "do not differ in cylinder.velocity",
    ),
    "a curve of one inertial number": (
        lambda: rheology(sheared([[0.3, 0.4]]).isel(shear_inertial_number=0)),
        "do not differ in shear.inertial_number",
    ),
    "a line of two sizes": (lambda: limits(jammed((50, 100))), "it has 2 and 4"),
    "a line of two beds": (lambda: limits(jammed(beds=2)), "it has 3 and 2"),
}
COMMANDS = {
    "means docs/data/drag.nc --of lift": "it has no lift; it has ",
    "means docs/data/drag.nc docs/data/precise.nc --of lift": "it has no lift; it has ",
}
