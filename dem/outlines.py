"""The outline of convex polygons together: rings of corners, and chains of sides. Points are complex
numbers (m); the inside is on the left."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

NEAR = 1e-9  # of the size of all: points that are nearer to each other are one
BACK = np.pi - 1e-6  # rad: what turns to the right by more goes back, at the tip of a plate
SAMPLES = 65  # of how far a side goes on within a solid


def turn_of(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """By how much directions (k,) turn (rad); what goes back has turned to the left."""
    angle = np.angle(after / before)
    return np.where(angle < -BACK, np.pi, angle)


def rings(polygons: list[np.ndarray]) -> list[np.ndarray]:
    """Corners (k,) of each closed outline of convex polygons together, none of them in a line."""
    start, found = np.concatenate(polygons), []
    near = NEAR * abs(start - start[0]).max()
    a, b = _outer_sides(polygons, start, near)
    # where several go on from one place, the outside is on the right of the one to the right
    follow = [
        np.where(a == end, turn_of(end - begin, b - a), np.inf).argmin()
        for begin, end in zip(a, b, strict=True)
    ]
    left = set(range(len(a)))
    while left:
        side, ring = min(left), []
        while side in left:
            left.remove(side)
            ring.append(a[side])
            side = int(follow[side])
        z = np.array(ring)
        before, after = z - np.roll(z, 1), np.roll(z, -1) - z
        off = abs(turn_of(before, after)) * np.minimum(abs(before), abs(after))
        found.append(z[off > 2.0 * near])
    return found


def _outer_sides(polygons, start, near):
    """Where the straight parts of the outline of polygons begin and end, two arrays (m,)."""
    step, points = np.concatenate([np.roll(z, -1) - z for z in polygons]), [start]
    sides: dict[tuple[complex, complex], None] = {}
    with np.errstate(divide="ignore", invalid="ignore"):
        for a, d in zip(start, step, strict=True):
            away, across = (start - a).conj(), (d.conj() * step).imag
            here, there = (away * step).imag / across, (away * d).imag / across
            meet = (abs(here - 0.5) <= 0.5) & (abs(there - 0.5) <= 0.5)
            points.append(a + here[meet] * d)
    every = np.concatenate(points)
    every = np.unique([every[(abs(every - z) < near).argmax()] for z in every])
    for a, d in zip(start, step, strict=True):
        at = (every - a) * d.conj() / abs(d)
        on = (abs(at.imag) < near) & (at.real > -near) & (at.real < abs(d) + near)
        row = every[on][at.real[on].argsort()].tolist()
        sides |= dict.fromkeys(pairwise(row))
    a, b = np.array([*sides]).T
    hidden = np.zeros(len(a), bool)
    for z in polygons:
        inwards = 1j * (np.roll(z, -1) - z)
        inwards /= abs(inwards)
        deep = ((np.array([a, b])[..., None] - z) * inwards.conj()).real
        # a side that two polygons have from both sides is inside
        twice = ((b - a)[:, None] * inwards.conj()).imag > 0.0
        shared = (abs(deep) < near).all(axis=0)
        hidden |= np.where(shared, twice, deep.sum(axis=0) > 0.0).all(axis=1)
    return a[~hidden], b[~hidden]


def chains(z: np.ndarray, alone: bool, radius: float, depth: Callable) -> list[list]:
    """Rows of faces (Polygon.faces) of a ring, each row convex; alone: whether it is the only ring;
    depth: how far points (m,) are within the outline (m).

    A convex ring that is alone is one row. Other rows have ends: at concave corners, beyond which a
    face goes on as far as the rounding hides it, so that a granule near the corner meets both rows;
    and where they would turn by more than half a circle, so that the greatest gap is that to what is
    nearest: there both rows have a face of no length, across the middle of the corner.
    """
    step, n = np.roll(z, -1) - z, len(z)
    along, size = step / abs(step), abs(step).sum()
    turn = turn_of(along, np.roll(along, -1))  # after each side

    def face(a, b, direction):
        return a.real, a.imag, direction.imag, -direction.real, abs(b - a)

    def end(i, corner, direction, side):
        """Where a side ends, beyond its corner i if that is concave."""
        if turn[i] > 0.0:
            return corner
        far = min(radius / abs(np.sin(turn[i])), size)
        way = corner + direction * np.linspace(0.0, far, SAMPLES)
        hidden = depth(way - 1j * radius * along[side]) >= 0.0
        return way[np.argmin([*hidden[1:], False])]

    def cut(i):
        corner, middle = z[i + 1 - n], along[i] * np.exp(0.5j * turn[i])
        return [face(corner, corner, middle)] if turn[i] > 0.0 else []

    faces = [
        face(end(i - 1, z[i], -along[i], i), end(i, z[i + 1 - n], along[i], i), along[i])
        for i in range(n)
    ]
    last = int(turn.argmin())  # concave, if any is
    if alone and turn[last] > 0.0:
        return [faces]
    rows, turned = [cut(last)], 0.5 * max(turn[last], 0.0)
    for i in np.roll(np.arange(n), -1 - last):
        rows[-1].append(faces[i])
        turned += turn[i]
        if turn[i] < 0.0 or i == last or turned + 0.5 * max(turn[i + 1 - n], 0.0) > np.pi:
            rows[-1] += cut(i)
            rows.append(cut(i))
            turned = 0.5 * max(turn[i], 0.0)
    return rows[:-1]
