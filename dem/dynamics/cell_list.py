"""Pairs that may touch, found by a cell list, for Verlet lists with a skin.

A list holds every pair of constituents whose bounding circles are less than `skin` apart. It is
complete until something has moved by skin / 2. The order of a list depends on the present
positions alone. What a contact remembers is carried from the old list to the new one.
"""

import numpy as np

from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined
from dem.shapes.protocol import owner_of


@inlined
def image(period, distance):
    """Whole periods (m) that lead from a distance along a side to the nearest image."""
    return -period * np.floor(distance / period + 0.5) if period > 0.0 else 0.0


@inlined
def nearest(period, distance):
    """A distance (m) between two bodies along a side, to the nearest image of the other."""
    return distance + image(period, distance)


@inlined
def split(period, extent, size):
    """Number of cells along a side, and their size (m), at least `size`."""
    if period > 0.0:
        count = max(int(period / size), 1)
        return count, period / count
    return int(extent / size) + 1, size


@inlined
def place_of(period, distance, count, size):
    """Number of the cell at a distance (m) from the first."""
    if period > 0.0:
        distance -= period * np.floor(distance / period)
    return min(int(distance / size), count - 1)


@inlined
def around(period, cell, count):
    """First and last (excluded) of a cell and those beside it. The cell that follows the last along
    a periodic side is the first, modulo `count`."""
    if period > 0.0:
        return cell - 1, cell - 1 + min(count, 3)
    return max(cell - 1, 0), min(cell + 2, count)


@compiled(allocates=True)
def cells(constituents, size, period):
    """Sort constituents into cells of at least the given size (m): counting sort.

    Returns cell of each constituent (constituents,), members sorted by cell (constituents,), start
    of each cell in members (cells + 1,), and the number of columns. Cells never outnumber the
    constituents fourfold. Along a periodic side the cells make one period.
    """
    n = constituents.shape[0]
    left, bottom = right, top = constituents[0, X], constituents[0, Y]
    for i in range(n):
        left, right = min(left, constituents[i, X]), max(right, constituents[i, X])
        bottom, top = min(bottom, constituents[i, Y]), max(top, constituents[i, Y])
    width = period[0] if period[0] > 0.0 else right - left
    height = period[1] if period[1] > 0.0 else top - bottom
    while (width / size + 1.0) * (height / size + 1.0) > 4.0 * n + 16.0:
        size *= 2.0
    columns, wide = split(period[0], width, size)
    rows, high = split(period[1], height, size)
    where = np.empty(n, np.int64)
    start = np.zeros(columns * rows + 1, np.int64)
    for i in range(n):
        row = place_of(period[1], constituents[i, Y] - bottom, rows, high)
        where[i] = row * columns + place_of(period[0], constituents[i, X] - left, columns, wide)
        start[where[i] + 1] += 1
    for c in range(columns * rows):
        start[c + 1] += start[c]
    members = np.empty(n, np.int64)
    filled = start[:-1].copy()
    for i in range(n):
        members[filled[where[i]]] = i
        filled[where[i]] += 1
    return where, members, start, columns


@inlined
def sort_few(values, start, stop):
    """Sort values[start:stop] in place, by insertion: a row of a list is short."""
    for p in range(start + 1, stop):
        value, q = values[p], p
        while q > start and values[q - 1] > value:
            values[q] = values[q - 1]
            q -= 1
        values[q] = value


@compiled(allocates=True)
def near_pairs(shape, constituents, radius, held, skin, period):
    """Pairs of constituents of different granules closer than skin (m).

    Returns (first, constituent, partner) of Contacts.

    radius (constituents,): bounding radius (m); held (constituents,): those of which no two make a
    pair, or None; period along x and y (m), 0 where the scene does
    not repeat itself. Each pair is listed once, under its lower index, partners in ascending order.
    """
    n = constituents.shape[0]
    where, members, start, columns = cells(constituents, 2.0 * radius.max() + skin, period)
    rows = (start.shape[0] - 1) // columns
    first = np.zeros(n + 1, np.uint32)
    partner = np.empty(8 * n + 8, np.uint32)
    count = 0
    for i in range(n):
        row, column = where[i] // columns, where[i] % columns
        if count + n > partner.shape[0]:
            larger = np.empty(2 * partner.shape[0] + n, np.uint32)
            for p in range(count):  # a slice would bring in the text of its error message
                larger[p] = partner[p]
            partner = larger
        lowest, highest = around(period[1], row, rows)
        leftmost, rightmost = around(period[0], column, columns)
        for r in range(lowest, highest):
            for c in range(leftmost, rightmost):
                cell = r % rows * columns + c % columns
                for m in range(start[cell], start[cell + 1]):
                    j = members[m]
                    if j <= i or owner_of(shape, j) == owner_of(shape, i):
                        continue
                    if held is not None and held[i] and held[j]:
                        continue
                    dx = nearest(period[0], constituents[j, X] - constituents[i, X])
                    dy = nearest(period[1], constituents[j, Y] - constituents[i, Y])
                    reach = radius[i] + radius[j] + skin
                    if dx * dx + dy * dy < reach * reach:
                        partner[count] = j
                        count += 1
        sort_few(partner, first[i], count)
        first[i + 1] = count
    constituent = np.empty(count, np.uint32)
    for i in range(n):
        for p in range(first[i], first[i + 1]):
            constituent[p] = i
    return first, constituent, partner[:count].copy()


@inlined
def distance_from(faces, boundaries, b, x, y):
    """Distance (m) from boundary b, a polygon, to a point x, y (m) from its position; inside it is
    zero."""
    orientation = boundaries.orientation
    c, s = orientation[b, 0], orientation[b, 1]
    px, py = c * x + s * y, c * y - s * x
    nearest, inside = np.inf, True
    for f in range(faces.first[b], faces.first[b + 1]):
        dx, dy = px - faces.row[f, 0], py - faces.row[f, 1]
        nx, ny, length = faces.row[f, 2], faces.row[f, 3], faces.row[f, 4]
        along, above = dy * nx - dx * ny, dx * nx + dy * ny
        inside = inside and above < 0.0
        beside = max(-along, along - length, 0.0)
        nearest = min(nearest, np.sqrt(beside * beside + above * above))
    return 0.0 if inside else max(nearest - faces.radius[b], 0.0)


@inlined
def near_surface(surface, boundaries, constituents, radius, skin, period):
    """Constituents closer than skin (m) to walls, or to solids: sorted (constituent, partner) of
    Contacts."""
    bodies, count = surface.boundary.shape[0], 0
    planes, faces, size, motion = surface.planes, surface.faces, surface.radius, boundaries.motion
    constituent = np.empty(constituents.shape[0] * bodies, np.uint32)
    partner = np.empty_like(constituent)
    for i in range(constituents.shape[0]):
        x, y = constituents[i, X], constituents[i, Y]
        for q in range(bodies):
            b = surface.boundary[q]
            dx, dy = nearest(period[0], x - motion[b, X]), nearest(period[1], y - motion[b, Y])
            if planes is not None:
                near = x * planes[b, 0] + y * planes[b, 1] + radius[i] + skin > planes[b, 2]
            elif faces is not None:
                near = distance_from(faces, boundaries, b, dx, dy) < radius[i] + skin
            else:
                reach = radius[i] + (boundaries.reach[b] if size is None else size[b]) + skin
                near = dx * dx + dy * dy < reach * reach
            if near:
                constituent[count], partner[count] = i, b
                count += 1
    return constituent[:count].copy(), partner[:count].copy()
