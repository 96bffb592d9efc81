"""Where the numbers of contacts are: side by side in each block, so that vector units take
them.

A list of contacts has blocks of BLOCK, and each block has columns: constants of its contacts, and
what they remember. The lanes are scratch memory of one thread for the block that it works on: each
row has one quantity of all contacts. In a step all indices are unsigned and all offsets constants:
the compiler then sees that nothing wraps around or overlaps, and makes vector code.

Rows of motion: position of the centre (m), velocity (m/s) and angular velocity (rad/s) at half
steps, and the change of each over the coming half step, by which a dashpot sees the velocity at
full full steps. Where nothing turns and contacts have dashpots, rows have the velocity of the full step:
only dashpots see it, and a contact reads half a row. Rows of force: force (N) and torque about the
centre (N m).
"""

import math
from typing import NamedTuple

import numpy as np

BLOCK = 64  # contacts; what they need fits well into the first-level cache
LINE = 8  # numbers to a cache line; also between rows, whose places in the cache then differ

ZERO, ONE, TWO, THREE, FOUR, FIVE, EIGHT = map(np.uint64, (0, 1, 2, 3, 4, 5, 8))
X, Y, VX, VY, W, DVX, DVY, DW = range(8)
FX, FY, TAU = range(3)

ROW = np.uint64(BLOCK + LINE)  # from one row of lanes to the next
# lanes[offset + k]: geometry and force (the first SEEN rows are handed out, see dem.dynamics.system),
# whether the last normal was near enough, velocities and spins of 2 relative to 1 and their
# changes, root of the law, torques, powers; then four at a time, as bodies have them side by side: position
# and velocity of 2 relative to 1; spin of 1, with the changes after it, and of 2; cosine and sine of both
# angles, with two columns of zeros
# fmt: off
(OVERLAP, NX, NY, N1, T1, N2, T2, RADIUS, FORCE_X, FORCE_Y,
 UNCONVERGED, V_NORMAL, V_TANGENT, SPIN, DV_NORMAL, DV_TANGENT, D_SPIN, MEAN_ROOT,
 TORQUE_1, TORQUE_2, DAMPED, SLID, ROLLED, D_X, D_Y, D_VX, D_VY,
 W1, DVX1, DVY1, DW1, W2, DVX2, DVY2, DW2, C1, S1, _, _, C2, S2, _, _) = (
    np.uint64(k) * ROW for k in range(43)
)
# fmt: on
LANES = 43 * int(ROW)
WALL_OFFSET, X1, Y1 = MEAN_ROOT, TORQUE_1, TORQUE_2  # a wall has these before its root and torques
SEEN = 10

# numbers[offset + k] of a block: constituent 1, body 2 as a row of motion, and where forces on it go
CONSTITUENT, PARTNER, TARGET = (np.uint64(k * BLOCK) for k in range(3))
NUMBERS = np.uint64(3 * BLOCK)

COLUMN = np.uint64(BLOCK)  # from one column of a list to the next

# friction[offset + k]: Coulomb's mu; tangential stiffness over K times the measure of the law;
# tangential over normal damping, sqrt(k_t / k_n)
COEFFICIENT, FRICTION_STIFFNESS, FRICTION_DASHPOT = (np.uint64(k * BLOCK) for k in range(3))
FRICTIONS = 3 * BLOCK

# account: power (W) that dashpots take, tangential springs, and rolling springs; their energies;
# work on the granules, of boundaries and of gravity; its greatest sum in size; what granules that came
# brought, less what others took along: kinetic and elastic energy, and work of gravity
POWER_DAMPED, POWER_SPRINGS, POWER_ROLLING, ACCOUNTS, WORK, FALL, PEAK = 0, 1, 2, 3, 6, 7, 8
BROUGHT, RAISED, ACCOUNT = 9, 10, 11


class Layout(NamedTuple):
    """Where each column of a block begins, -1 of one that a scene lacks; and what else rows and
    columns hold. What a step needs of it is constants of its kernel, by the same names in capitals.

    Attributes
    ----------
    stiffness : int
        The constant K of the law; the modulus that K follows from where it is `local`.
    length : int
        Second constant (m) of the law.
    dashpot : int
        alpha sqrt(m* K); alpha sqrt(m*) where it is `local`.
    arm, rolling_dashpot : int
        mu_r R_r (m), and the constant of its dashpot over the root of the law.
    mass_x, mass_y, mass_turn : int
        m/m* for a normal along x and along y, where a driven boundary yields, and what a squared lever
        (m2) about one that turns adds to it; the dashpot then belongs to the mass m.
    shift_x, shift_y : int
        Whole periods (m) from body 2 to its image beside body 1.
    sizes : int
        Outlines of both bodies without cosine and sine.
    tangential_force, measure, rolling_moment : int
        Springs (N, N m), and the measure of the law in the last step.
    normal_x, normal_y : int
        Normal in the last step, of bodies that are not round.
    history : int
        From here on, what contacts remember.
    second : int
        From the sizes of body 1 to the sizes of body 2.
    stride : int
        From a block to the next.
    size_count, outline_size_count : int
        How many sizes granules have, and solids that are like granules.
    local : bool
        Whether R* is found at each contact.
    full : bool
        Whether rows of motion have velocities of full steps.
    """

    stiffness: int
    length: int
    dashpot: int
    arm: int
    rolling_dashpot: int
    mass_x: int
    mass_y: int
    mass_turn: int
    shift_x: int
    shift_y: int
    sizes: int
    tangential_force: int
    measure: int
    rolling_moment: int
    normal_x: int
    normal_y: int
    history: int
    second: int
    stride: int
    size_count: int
    outline_size_count: int
    local: bool
    full: bool

    @property
    def constants(self) -> dict[str, np.uint64]:
        """The places of columns that there are, as step kernels name them. Whether it is local or full
        is a flag of a kernel."""
        places = self._asdict().items()
        return {name.upper(): np.uint64(at) for name, at in places if type(at) is int and at >= 0}


def layout_of(flags: dict[str, bool], sizes: int, outline_sizes: int) -> Layout:
    """The layout of a scene with some flags (dem.dynamics.kinds); sizes, outline_sizes: how many
    numbers the outlines of granules, and of solids that are like granules, have."""
    friction, rolling, yields = flags["FRICTION"], flags["ROLLING"], flags["YIELDS"]
    most = max(sizes, outline_sizes if flags["WITH_OUTLINES"] else 0)
    present = {"stiffness": 1, "length": flags["LONG"], "dashpot": flags["DAMPING"]}
    present |= dict.fromkeys(("arm", "rolling_dashpot"), rolling)
    present |= dict.fromkeys(("mass_x", "mass_y", "mass_turn"), yields)
    present |= dict.fromkeys(("shift_x", "shift_y"), flags["PERIODIC"])
    present |= {"sizes": 2 * most}
    remembered = dict.fromkeys(("tangential_force", "measure"), friction)
    remembered |= {"rolling_moment": rolling}
    remembered |= dict.fromkeys(("normal_x", "normal_y"), flags["GUESSES"])
    places, at = {}, 0
    for name, count in (present | remembered).items():
        places[name] = at if count else -1
        at += BLOCK * int(count)
    return Layout(
        **places,
        history=BLOCK * sum(map(int, present.values())),
        second=BLOCK * most,
        stride=at,
        size_count=sizes,
        outline_size_count=outline_sizes,
        local=flags["LOCAL"],
        full=flags["FULL"],
    )


def aligned(*shape: int) -> np.ndarray:
    """Zeros that begin on a cache line: a row of eight numbers then never straddles two."""
    size = math.prod(shape)
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
