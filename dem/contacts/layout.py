"""Where the numbers of contacts are: those of one block side by side, so that vector units take
them.

A list of contacts has blocks of BLOCK, and each block has columns: constants of its contacts, and
what they remember. The lanes are scratch memory of one thread for the block that it works on.
`pair` holds the motion of both bodies, four numbers of one contact together, because the processor
copies and transposes such groups fast. `lanes` holds one quantity of all contacts together. All
indices are unsigned and all offsets constants: the compiler then sees that nothing wraps around or
overlaps, and makes vector code.

Rows of motion: position of the centre (m), velocity (m/s) and angular velocity (rad/s) at half
steps, and the change of each over the coming half step, by which a dashpot sees the velocity at
full steps. Where nothing turns and contacts have dashpots, rows have the velocity of the full step:
only dashpots see it, and a contact copies half a row. Rows of force: force (N) and torque about the
centre (N m).
"""

import numpy as np

BLOCK = 64  # contacts; what they need fits well into the first-level cache
LINE = 8  # numbers between rows, so that they do not all fall on the same places of the cache

ZERO, ONE, TWO, THREE, FOUR, FIVE, SIX, EIGHT = map(np.uint64, (0, 1, 2, 3, 4, 5, 6, 8))
X, Y, VX, VY, W, DVX, DVY, DW = range(8)
FX, FY, TAU = range(3)

# pair[offset + 4 k]: position and velocity of 1 and 2; spin of both, with the changes after it
_GROUP = 4 * BLOCK + LINE
# fmt: off
(X1, Y1, VX1, VY1, X2, Y2, VX2, VY2, W1, _, _, _, W2) = (
    np.uint64(k // 4 * _GROUP + k % 4) for k in range(13)
)
# fmt: on
PAIR = 4 * _GROUP  # numbers in all

# lanes[offset + k]: geometry and force (the first SEEN rows are handed out, see dem.dynamics.system),
# whether the last normal was near enough, velocities and spins of 2 relative to 1 and their
# changes, root of the law, torques, powers, cosine and sine of both angles
# fmt: off
(OVERLAP, NX, NY, N1, T1, N2, T2, RADIUS, FORCE_X, FORCE_Y,
 UNCONVERGED, V_NORMAL, V_TANGENT, SPIN, DV_NORMAL, DV_TANGENT, D_SPIN, MEAN_ROOT,
 TORQUE_1, TORQUE_2, DAMPED, SLID, ROLLED, C1, S1, C2, S2) = (
    np.uint64(k * (BLOCK + LINE)) for k in range(27)
)
# fmt: on
LANES = 27 * (BLOCK + LINE)
SEEN = 10

# numbers[offset + k] of a block: constituent 1, body 2 as a row of motion, and where forces on it go
CONSTITUENT, PARTNER, TARGET = (np.uint64(k * BLOCK) for k in range(3))
NUMBERS = np.uint64(3 * BLOCK)

COLUMN = np.uint64(BLOCK)  # from one column of a list to the next

# account: power (W) that dashpots take, tangential springs, and rolling springs; their energies;
# work on the granules, of boundaries and of gravity; its greatest sum in size
POWER_DAMPED, POWER_SPRINGS, POWER_ROLLING, ACCOUNTS, WORK, FALL, PEAK = 0, 1, 2, 3, 6, 7, 8


def columns(flags: dict[str, bool], sizes: int) -> dict[str, np.uint64]:
    """Where each column of a block begins, by the name that kernels have for it.

    flags: what a scene has (dem.dynamics.kinds); sizes: numbers of the outline of one body. What a
    scene lacks has no column. History comes last.

    * STIFFNESS: the constant K of the law; the modulus that K follows from where R* is found at the
      contact
    * LENGTH: second constant (m) of the law
    * DASHPOT: alpha sqrt(m* K); alpha sqrt(m*) where R* is that at the contact
    * COEFFICIENT, FRICTION_STIFFNESS, FRICTION_DASHPOT: Coulomb's mu; tangential stiffness over K times
      the measure of the law; tangential over normal damping, sqrt(k_t / k_n)
    * ARM, ROLLING_DASHPOT: mu_r R_r (m), and the constant of its dashpot over the root of the
      law
    * MASS_X, MASS_Y, MASS_TURN: m/m* for a normal along x and along y, where a driven boundary
      yields, and what a squared lever (m2) about one that turns adds to it; the dashpot is then that
      of the mass m
    * SHIFT_X, SHIFT_Y: whole periods (m) from body 2 to its image beside body 1
    * SIZES: outlines of both bodies without cosine and sine
    * TANGENTIAL_FORCE (N), MEASURE, ROLLING_MOMENT (N m): springs, and the measure of the law in the
      last step
    * NORMAL_X, NORMAL_Y: normal in the last step, of bodies that are not round
    """
    present = {"STIFFNESS": 1, "LENGTH": flags["LONG"], "DASHPOT": flags["DAMPING"]}
    for name in ("COEFFICIENT", "FRICTION_STIFFNESS", "FRICTION_DASHPOT"):
        present[name] = flags["FRICTION"]
    present |= dict.fromkeys(("ARM", "ROLLING_DASHPOT"), flags["ROLLING"])
    present |= dict.fromkeys(("MASS_X", "MASS_Y", "MASS_TURN"), flags["YIELDS"])
    present |= dict.fromkeys(("SHIFT_X", "SHIFT_Y"), flags["PERIODIC"])
    present |= {"SIZES": 2 * sizes, "HISTORY": 0}
    present |= dict.fromkeys(("TANGENTIAL_FORCE", "MEASURE"), flags["FRICTION"])
    present |= {"ROLLING_MOMENT": flags["ROLLING"]}
    present |= dict.fromkeys(("NORMAL_X", "NORMAL_Y"), flags["GUESSES"])
    names, at = {}, 0
    for name, count in present.items():
        names[name] = np.uint64(at * BLOCK)
        at += int(count)
    return names | {"COLUMNS": np.uint64(at * BLOCK), "SECOND": np.uint64(sizes * BLOCK)}


def aligned(*shape: int) -> np.ndarray:
    """Zeros that begin on a cache line: a row of eight numbers then never straddles two."""
    size = int(np.prod(shape))
    room = np.zeros(size + 8)
    start = -room.ctypes.data % 64 // 8
    return room[start : start + size].reshape(shape)


# The outline of one body in a column of sizes, by how many numbers it has


def one_size(table, at):
    return (table[at],)


def two_sizes(table, at):
    return table[at], table[at + COLUMN]


def three_sizes(table, at):
    return table[at], table[at + COLUMN], table[at + TWO * COLUMN]


def four_sizes(table, at):
    return table[at], table[at + COLUMN], table[at + TWO * COLUMN], table[at + THREE * COLUMN]


def five_sizes(table, at):
    return four_sizes(table, at) + (table[at + FOUR * COLUMN],)


def six_sizes(table, at):
    return four_sizes(table, at) + (table[at + FOUR * COLUMN], table[at + FIVE * COLUMN])


SIZES_AT = {1: one_size, 2: two_sizes, 3: three_sizes, 4: four_sizes, 5: five_sizes, 6: six_sizes}
