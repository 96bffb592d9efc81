"""Friction of granules with the plate that a bed lies on.

A granule presses on the plate evenly over its area. Each point of it that slides is pulled against
its own velocity, so that sliding and spinning share the friction: force and torque are the slopes of
``mu N d``, where d is the mean distance by which the points have slid (Farkas, Bartels, Unger and
Wolf, Phys. Rev. Lett. 90, 248302, 2003, for velocities in place of distances). Up to a mean distance
`slip` a granule sticks to its anchor: then ``mu N d^2 / (2 slip)`` is the energy of its spring, with a
dashpot in what friction leaves. Beyond, it slides, and the anchor follows.

All of it is proportional to the mass, so that accelerations are computed. A granule that is not round
counts as a disc with its radius of gyration.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from dem.contacts.layout import ACCOUNTS, FX, FY, POWER_SPRINGS, TAU, VX, VY, W, X, Y
from dem.dynamics.critical_step import stable_step
from dem.dynamics.motion import collect
from dem.dynamics.world import INVERSE_MASS, Base
from dem.jit.intrinsics import noinline

if TYPE_CHECKING:
    from dem.scene import Scene

NODES = 257  # of the table of shares
STEEPEST = 1.7  # greatest curvature of d^2 / 2 along any motion of a disc, over its mass


LEDGER = COMPOSED = True  # what a kernel has: dem.dynamics.kinds


def shares_of_friction() -> np.ndarray:
    """Rows (NODES, 2): force over mu N, torque over mu N R of a disc whose middle slides by 1 - u while
    its rim turns by u, for u from 0 to 1 (Farkas and others 2003, equations 4 and 5)."""
    from scipy.special import ellipe, ellipk  # 0.1 s, which only scenes with a plate need

    u = np.linspace(0.0, 1.0, NODES)[1:-1]
    e = (1.0 - u) / u
    with np.errstate(divide="ignore", invalid="ignore"):
        inner, outer = np.minimum(e, 1.0) ** 2, np.minimum(1.0 / e, 1.0) ** 2
        m = np.where(e < 1.0, inner, outer)
        complete, second = ellipk(np.minimum(m, 1.0 - 1e-15)), ellipe(m)
        force = np.where(
            e < 1.0,
            ((e**2 + 1.0) * second + (e**2 - 1.0) * complete) / e,
            (e**2 + 1.0) * second - (e**2 - 1.0) * complete,
        )
        torque = np.where(
            e < 1.0,
            (4.0 - 2.0 * e**2) * second + (e**2 - 1.0) * complete,
            e * ((4.0 - 2.0 * e**2) * second + (2.0 * e**2 - 5.0 + 3.0 / e**2) * complete),
        )
    rows = np.column_stack([4.0 / 3.0 / np.pi * force, 4.0 / 9.0 / np.pi * torque])
    return np.vstack([[1.0, 0.0], rows, [0.0, 2.0 / 3.0]])


def base_of(scene: "Scene", position: np.ndarray, angle: np.ndarray) -> Base:
    """What the granules of a scene feel of its plate, then its boundaries, at rest where they are
    (n + r, 2) in m at angles (n + r,); empty without a plate."""
    plate, n, walls = scene.base_plate, scene.granules, len(scene.walls)
    if plate is None:
        none = np.empty(0)
        return Base(np.empty((0, 3)), none, none, none, none, np.empty((0, 2)))
    radius, grip = np.ones(len(angle)), np.zeros(len(angle))
    radius[:n] = np.sqrt(2.0 * scene.shape.gyration_squared)
    grip[:n] = plate.friction * plate.pressing * ~scene.is_held
    for b, solid in enumerate(scene.solids, n + walls):
        radius[b], grip[b] = math.sqrt(2.0 * solid.gyration_squared), plate.solid * plate.pressing
    slip = plate.slip * float(scene.shape.constituent_radius.mean())
    frequency = math.sqrt(grip.max() / slip)  # of the spring of a granule (rad/s)
    return Base(
        anchor=np.column_stack([position, angle]),
        radius=radius,
        grip=grip,
        slip=np.array([slip]),
        delay=np.array([2.0 / max(frequency, 1e-300)]),  # critical
        shares=shares_of_friction(),
    )


def sliding(shares, x, y, turned):
    """Mean distance (m) by which the points of a disc slide that moves by x, y while its rim turns
    (m), and the slopes of it along these three; of velocities (m/s) likewise."""
    along, around = math.sqrt(x * x + y * y), abs(turned)
    total = along + around
    if total == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    place = around / total * (NODES - 1)
    k = min(int(place), NODES - 2)
    w = place - k
    force = (1.0 - w) * shares[k, 0] + w * shares[k + 1, 0]
    torque = (1.0 - w) * shares[k, 1] + w * shares[k + 1, 1]
    part = force / along if along > 0.0 else 0.0
    return along * force + around * torque, part * x, part * y, math.copysign(torque, turned)


def rub(base, row, motion, i, angle, moves, kick):
    """Kick body i, row `row` of the Base, at an angle (rad) by friction over a time (s), along the axes x,
    y and angle that forces move. Returns the changes of velocity (m/s) and spin (rad/s)."""
    noinline()
    anchor, radius, grip, slip = base.anchor, base.radius[row], base.grip[row], base.slip[0]
    x, y = motion[i, X] - anchor[row, 0], motion[i, Y] - anchor[row, 1]
    turned = radius * (angle - anchor[row, 2])
    distance, fx, fy, torque = sliding(base.shares, x, y, turned)
    if distance > slip:  # the anchor follows
        part = 1.0 - slip / distance
        anchor[row, 0] += part * x
        anchor[row, 1] += part * y
        anchor[row, 2] += part * turned / radius
        distance = slip
    vx, vy, spin = motion[i, VX], motion[i, VY], motion[i, W]
    speed, dx, dy, twist = sliding(base.shares, vx, vy, radius * spin)
    held = distance / slip
    damped = min(base.delay[0] * speed / slip, 1.0 - held)  # both together: no more than Coulomb's
    push = -kick * grip
    x = push * (held * fx + damped * dx) if moves[0] else 0.0
    y = push * (held * fy + damped * dy) if moves[1] else 0.0
    # radius^2 / 2 is inertia over mass
    turn = push * (held * torque + damped * twist) * 2.0 / radius if moves[2] else 0.0
    motion[i, VX], motion[i, VY], motion[i, W] = vx + x, vy + y, spin + turn
    return x, y, turn


ALL = True, True, True


def rub_granules(base, granules, constituents, gravity, account, kick, low, high):
    """Kick granules low to high by friction with the plate over a time (s)."""
    motion, force = granules.motion, granules.force
    if LEDGER and COMPOSED:
        collect(force, constituents, low, high)
    for i in range(low, high):
        if base.grip[i] > 0.0:
            x, y, turn = rub(base, i, motion, i, granules.angle[i], ALL, kick)
            if LEDGER:  # at the mean velocity of the kick, which other forces change too
                inverse, half = granules.inverse_mass[i], 0.5 * kick
                vx = motion[i, VX] - 0.5 * x + half * (force[i, FX] * inverse + gravity[0])
                vy = motion[i, VY] - 0.5 * y + half * (force[i, FY] * inverse + gravity[1])
                spin = half * force[i, TAU] * granules.inverse_inertia[i]
                spin = 0.5 * base.radius[i] ** 2 * turn * (motion[i, W] - 0.5 * turn + spin)
                account[ACCOUNTS + POWER_SPRINGS] -= (x * vx + y * vy + spin) / inverse


def rub_boundaries(base, boundaries, kick):
    """Kick driven boundaries likewise."""
    drive, first = boundaries.drive, base.grip.shape[0] - boundaries.angle.shape[0]
    for b in range(boundaries.angle.shape[0]):
        if base.grip[first + b] > 0.0:
            x, y, turn = INVERSE_MASS, INVERSE_MASS + 1, INVERSE_MASS + 2
            moves = drive[b, x] > 0.0, drive[b, y] > 0.0, drive[b, turn] > 0.0
            rub(base, first + b, boundaries.motion, b, boundaries.angle[b], moves, kick)


def step_with(base: Base, step: float) -> float:
    """Time step (s) of a bed with friction on the plate, from that without."""
    if not base.grip.any():
        return step
    stiffness = STEEPEST * float(base.grip.max()) / base.slip[0]
    damping = STEEPEST * float(base.grip.max()) / base.slip[0] * base.delay[0]
    return 1.0 / (1.0 / step + 1.0 / stable_step(stiffness, damping, 1.0))
