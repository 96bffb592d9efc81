"""At which packing fraction do frictionless discs and ellipses jam, and on how many contacts?

Published: discs jam between 0.84 (quenched fast) and 0.853 (slowly; Schreck, O'Hern and Silbert
2010, arXiv:1007.2162), on four contacts each, as many as they have degrees of freedom. Ellipses are
densest near an aspect ratio of 1.4, at 0.895 (known to 0.1 %: Rocks and Hoy 2023,
arXiv:2305.19990), and have fewer than six contacts (Donev and others 2007). Nothing runs here: the
beds are those of studies/onset/onset.nc, continued to infinitely many granules, rattlers left out,
of diameters within 29 % (those of the sources are of one or two sizes).

Tolerances. Twice the half of a 95 % interval, which is four standard errors. To that: half of the
range of the protocols, 0.0065, about its middle, 0.8465; of 0.895 its last digit and 0.1 %, 0.0014.
Fewer than six, and more than the four of discs, is 5 to 1.
"""

import xarray as xr

from dem.analysis.onset import limits
from studies import HERE
from studies.verification.row import Row

TITLE = "Onset of jamming"
SOURCE = "arXiv:1007.2162; arXiv:2305.19990; Donev and others 2007"

FILE = HERE / "onset/onset.nc"
DENSEST = 1.4  # aspect ratio


def measure() -> list[Row]:
    with xr.open_dataset(FILE) as dataset:
        onset = limits(dataset.load())
    ratio, fraction, contacts = onset.ratio.tolist(), onset.fraction, onset.coordination
    at = ratio.index(DENSEST)
    rows = [
        Row(
            "packing fraction of discs",
            "1",
            fraction[0].value,
            0.8465,
            0.0065 + _four(fraction[0]),
            ratio[0],
        ),
        Row(
            f"packing fraction of ellipses of {DENSEST}",
            "1",
            fraction[at].value,
            0.895,
            0.0014 + _four(fraction[at]),
            DENSEST,
        ),
        Row("contacts of discs", "1", contacts[0].value, 4.0, _four(contacts[0]), ratio[0]),
    ]
    return rows + [
        Row("contacts of ellipses", "1", contacts[k].value, 5.0, 1.0, ratio[k])
        for k in range(1, len(ratio))
    ]


def _four(estimate) -> float:
    """Four standard errors, of a 95 % interval."""
    return estimate.high - estimate.low
