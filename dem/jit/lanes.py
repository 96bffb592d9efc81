"""Where the kernel lays out a block of contacts side by side, so that vector units take them.

A lane is one contact of the block. `motion` holds the motion of both parts, four numbers of one
contact together (the processor copies such a group in one go and turns four groups over);
`values` holds one quantity of all contacts together. All indices are unsigned and all offsets
constants: the compiler then sees that nothing wraps around or overlaps, and makes vector code.
"""

from typing import NamedTuple

import numpy as np

from dem.jit.columns import rows

BLOCK = 64  # contacts; what they need fits well into the first-level cache
LINE = 8  # numbers between rows, so that they do not all fall on the same places of the cache


class Lanes(NamedTuple):
    """motion and values: rows of BLOCK lanes and a LINE of padding, see the offsets below.

    account (6,): three energies (J) summed over time (dem.dynamics.energy), and what they were before the
    last step; None where nobody asks.
    """

    motion: np.ndarray
    values: np.ndarray
    account: np.ndarray | None


def _offsets(count, step, group=1):
    return [np.uint64(r // group * step + r % group) for r in range(count)]


# motion[offset + 4 k]: position and velocity of parts 1 and 2, spin and changes of both
(X1, Y1, VX1, VY1, X2, Y2, VX2, VY2,
 W1, DVX1, DVY1, DW1, W2, DVX2, DVY2, DW2) = _offsets(16, 4 * BLOCK + LINE, group=4)  # fmt: skip
ZERO, ONE, TWO, THREE, FOUR, EIGHT = map(np.uint64, (0, 1, 2, 3, 4, 8))

# values[offset + k]: outlines (up to four numbers each), the contact, the forces
(OWN, _, _, _, OTHER, _, _, _, OVERLAP, NX, NY, N1, T1, N2, T2, RADIUS, DOUBT,
 ALONG, ACROSS, D_ALONG, D_ACROSS, PUSH_X, PUSH_Y, TWIST1, TWIST2,
 DAMPED, SLID) = _offsets(27, BLOCK + LINE)  # fmt: skip
ROW = np.uint64(BLOCK + LINE)  # from one number of an outline to the next


# account: energy (J) lost in dashpots, by sliding; work of the cylinder on the granules
LOST_DAMPED, LOST_SLID, WORK, ACCOUNTS = 0, 1, 2, 3


def make_lanes(accounted: bool = False) -> Lanes:
    account = rows(1, 2 * ACCOUNTS)[0] if accounted else None
    return Lanes(rows(1, 16 * (BLOCK + LINE))[0], rows(1, 27 * (BLOCK + LINE))[0], account)
