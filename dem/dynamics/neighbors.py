"""Which pairs may touch: Verlet lists with a skin, made from a cell list.

A list holds every pair of constituents whose bounding circles are less than `skin` apart. It is
complete until something has moved by skin / 2. The order of a list depends on the present
positions alone. What a contact remembers is carried from the old list to the new one.
"""

import numpy as np

from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, optional, plus


@optional
def image(period, distance):
    """Whole periods (m) that lead from a distance along a periodic side to the nearest image."""
    return -period * np.floor(distance / period + 0.5)


@inlined
def nearest(period, distance):
    """A distance (m) between two bodies along a side, to the nearest image of the other."""
    return plus(distance, image(period, distance))


@optional
def into_first(period, distance):
    """A distance less whole periods (m)."""
    return distance - period * np.floor(distance / period)


@optional
def fitting(period, size):
    """How many cells of at least this size (m) one after another make a period."""
    return max(int(period / size), 1)


@optional
def share(period, count):
    return period / count


@inlined
def split(period, extent, size):
    """Number of cells along a side, and their size (m), at least `size`."""
    count = either(fitting(period, size), int(extent / size) + 1)
    return count, either(share(period, count), size)


@inlined
def place_of(period, distance, count, size):
    """Number of the cell at a distance (m) from the first."""
    return min(int(either(into_first(period, distance), distance) / size), count - 1)


@optional
def around_period(period, cell, count):
    return cell - 1, cell - 1 + min(count, 3)


@inlined
def around(period, cell, count):
    """First and last (excluded) of a cell and those beside it; see `turned`."""
    return either(around_period(period, cell, count), (max(cell - 1, 0), min(cell + 2, count)))


@optional
def turned_once(period, cell, count):
    return cell + count if cell < 0 else (cell - count if cell >= count else cell)


@inlined
def turned(period, cell, count):
    """The cell that follows the last along a periodic side is the first."""
    return either(turned_once(period, cell, count), cell)


@compiled(allocates=True)
def cells(constituents, size, period):
    """Sort constituents into cells of at least the given size (m): counting sort.

    Returns cell of each constituent (constituents,), members sorted by cell (constituents,), start
    of each cell in members (cells + 1,), and the number of columns. Cells never outnumber the
    constituents fourfold. Along a periodic side the cells make one period.
    """
    n = constituents.shape[0]
    left, bottom, right, top = (
        constituents[0, X],
        constituents[0, Y],
        constituents[0, X],
        constituents[0, Y],
    )
    for i in range(n):
        left, right = min(left, constituents[i, X]), max(right, constituents[i, X])
        bottom, top = min(bottom, constituents[i, Y]), max(top, constituents[i, Y])
    width, height = either(period[0], right - left), either(period[1], top - bottom)
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
def near_pairs(constituents, radius, skin, per_granule, period):
    """Pairs of constituents of different granules closer than skin (m).

    Returns (first, constituent, partner) of Contacts.

    radius (constituents,): bounding radius (m); period along x and y (m), None where the scene does
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
                cell = turned(period[1], r, rows) * columns + turned(period[0], c, columns)
                for m in range(start[cell], start[cell + 1]):
                    j = members[m]
                    if j <= i or j // per_granule == i // per_granule:
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


@compiled(allocates=True)
def near_planes(constituents, radius, skin, planes):
    """Constituents closer than skin (m) to a wall: sorted (constituent, partner) of Contacts."""
    constituent = np.empty(constituents.shape[0] * planes.shape[0], np.uint32)
    partner = np.empty_like(constituent)
    count = 0
    for i in range(constituents.shape[0]):
        for k in range(planes.shape[0]):
            reach = (
                constituents[i, X] * planes[k, 0]
                + constituents[i, Y] * planes[k, 1]
                + radius[i]
                + skin
            )
            if reach > planes[k, 2]:
                constituent[count], partner[count] = i, k
                count += 1
    return constituent[:count].copy(), partner[:count].copy()


@compiled(allocates=True)
def near_circle(constituents, radius, skin, x, y, size, period):
    """Parts closer than skin (m) to a circle of radius size (m) at x, y: (constituent, partner)."""
    constituent = np.empty(constituents.shape[0], np.uint32)
    count = 0
    for i in range(constituents.shape[0]):
        dx = nearest(period[0], constituents[i, X] - x)
        dy = nearest(period[1], constituents[i, Y] - y)
        reach = radius[i] + size + skin
        if dx * dx + dy * dy < reach * reach:
            constituent[count] = i
            count += 1
    return constituent[:count].copy(), np.zeros(count, np.uint32)


@compiled(allocates=True)
def match_pairs(first, partner, old_first, old_partner):
    """Row of each pair in the old list, -1 for a new pair."""
    source = np.empty(partner.shape[0], np.int64)
    for i in range(first.shape[0] - 1):
        q = old_first[i]
        for p in range(first[i], first[i + 1]):
            source[p] = -1
            while q < old_first[i + 1] and old_partner[q] < partner[p]:
                q += 1
            if q < old_first[i + 1] and old_partner[q] == partner[p]:
                source[p] = q
    return source


@compiled(allocates=True)
def match_listed(constituent, partner, old_constituent, old_partner):
    """The same for the lists of walls and cylinder."""
    source = np.empty(constituent.shape[0], np.int64)
    q = 0
    for p in range(constituent.shape[0]):
        source[p] = -1
        while q < old_constituent.shape[0] and (
            old_constituent[q] < constituent[p]
            or (old_constituent[q] == constituent[p] and old_partner[q] < partner[p])
        ):
            q += 1
        if (
            q < old_constituent.shape[0]
            and old_constituent[q] == constituent[p]
            and old_partner[q] == partner[p]
        ):
            source[p] = q
    return source
