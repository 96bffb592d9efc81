"""Where the kernel lays out a block of contacts side by side, so that vector units take them.

A lane is one contact of the block. `motion` holds the motion of both constituents, four numbers of
one contact together, because the processor copies and transposes such groups fast. `values` holds
one quantity of all contacts together. All indices are unsigned and all offsets constants: the
compiler then sees that nothing wraps around or overlaps, and makes vector code.
"""

from typing import NamedTuple

import numpy as np
from numba.core.errors import TypingError
from numba.extending import overload

from dem.jit.columns import rows
from dem.jit.compilation import INLINED

BLOCK = 64  # contacts; what they need fits well into the first-level cache
LINE = 8  # numbers between rows, so that they do not all fall on the same places of the cache
OUTLINE_SIZE = 8  # numbers of an outline, at most


class Lanes(NamedTuple):
    """Scratch memory of one thread.

    Attributes
    ----------
    motion, values : ndarray
        Rows of BLOCK lanes and a LINE of padding, see the offsets below.
    account : ndarray of shape (9,) or None
        Energy ledger: three powers (W) now, the energies (J) that they have made with the kicks so
        far, the work (J) of the boundaries and that of gravity, and the greatest sum of both so far
        (dem.dynamics.energy).
    """

    motion: np.ndarray
    values: np.ndarray
    account: np.ndarray | None


def _offsets(count, step, group=1):
    return [np.uint64(r // group * step + r % group) for r in range(count)]


# motion[offset + 4 k]: position and velocity of 1 and 2; spin of both, with the changes after it
# fmt: off
(X1, Y1, VX1, VY1, X2, Y2, VX2, VY2,
 W1, _, _, _, W2, _, _, _) = _offsets(16, 4 * BLOCK + LINE, group=4)
# fmt: on
ZERO, ONE, TWO, THREE, FOUR, FIVE, SIX, EIGHT = map(np.uint64, (0, 1, 2, 3, 4, 5, 6, 8))

# values[offset + k]: geometry, velocities and spins of 2 relative to 1 and their changes, root of
# the law, forces, powers, outlines
# fmt: off
(OVERLAP, NX, NY, N1, T1, N2, T2, RADIUS, UNCONVERGED,
 V_NORMAL, V_TANGENT, DV_NORMAL, DV_TANGENT, MEAN_ROOT, FORCE_X, FORCE_Y, TORQUE_1, TORQUE_2,
 DAMPED, SLID, SPIN, D_SPIN, ROLLED, OUTLINE_1) = _offsets(24, BLOCK + LINE)
# fmt: on
ROW = np.uint64(BLOCK + LINE)  # from one number of an outline to the next
OUTLINE_2 = np.uint64(OUTLINE_1 + OUTLINE_SIZE * ROW)
VALUES = int(OUTLINE_2 + OUTLINE_SIZE * ROW)  # numbers in all

# account: power (W) that dashpots take, tangential springs, and rolling springs; their energies;
# work on the granules, of boundaries and of gravity; its greatest sum in size
POWER_DAMPED, POWER_SPRINGS, POWER_ROLLING, ACCOUNTS, WORK, FALL, PEAK = 0, 1, 2, 3, 6, 7, 8


def make_lanes(accounted: bool = False) -> Lanes:
    """Scratch memory for one thread; accounted: keep the energies of the ledger."""
    account = rows(1, PEAK + 1)[0] if accounted else None
    return Lanes(rows(1, 16 * (BLOCK + LINE))[0], rows(1, VALUES)[0], account)


def store_outline(outline, values, at):
    """Write an outline (a tuple of floats) to values[at], values[at + ROW] ..."""


@overload(store_outline, jit_options=INLINED)
def _store_outline(outline, values, at):
    if len(outline) > OUTLINE_SIZE:
        raise TypingError(f"an outline has {len(outline)} numbers; it may have {OUTLINE_SIZE}")
    if len(outline) == 0:
        return lambda outline, values, at: None

    def store(outline, values, at):
        values[at] = outline[0]
        store_outline(outline[1:], values, at + ROW)

    return store


def pick(rows, p):
    """Number p of each row."""


@overload(pick, jit_options=INLINED)
def _pick(rows, p):
    if len(rows) == 0:
        return lambda rows, p: ()
    return lambda rows, p: (rows[0][p],) + pick(rows[1:], p)


def load_outline(like, values, at, step=ROW):
    """The outline that store_outline wrote; like: an outline of as many numbers. Or as many rows of
    a table from `at` on, a step apart."""


@overload(load_outline, jit_options=INLINED)
def _load_outline(like, values, at, step=ROW):
    if len(like) == 0:
        return lambda like, values, at, step=ROW: ()
    return lambda like, values, at, step=ROW: (
        (values[at],) + load_outline(like[1:], values, at + step, step)
    )
