"""Which pairs may touch: Verlet lists with a skin, made from a cell list.

A list holds every pair of constituents whose bounding circles are less than `skin` apart. It is
complete until something has moved by skin / 2. The order of a list depends on the present
positions alone. What a contact remembers is carried from the old list to the new one.
"""

import numpy as np

from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined


@compiled(allocates=True)
def cells(constituents, size):
    """Sort constituents into square cells of the given size (m): counting sort.

    Returns cell of each constituent (constituents,), members sorted by cell (constituents,), start
    of each cell in members (cells + 1,), and the number of columns. Cells never outnumber the
    constituents fourfold.
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
    width, height = right - left, top - bottom
    while (width / size + 1.0) * (height / size + 1.0) > 4.0 * n + 16.0:
        size *= 2.0
    columns = int(width / size) + 1
    rows = int(height / size) + 1
    where = np.empty(n, np.int64)
    start = np.zeros(columns * rows + 1, np.int64)
    for i in range(n):
        where[i] = int((constituents[i, Y] - bottom) / size) * columns + int(
            (constituents[i, X] - left) / size
        )
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
def near_pairs(constituents, radius, skin, per_granule):
    """Pairs of constituents of different granules closer than skin (m).

    Returns (first, constituent, partner) of Contacts.

    radius (constituents,): bounding radius (m). Each pair is listed once, under its lower index,
    partners in ascending order.
    """
    n = constituents.shape[0]
    where, members, start, columns = cells(constituents, 2.0 * radius.max() + skin)
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
        for r in range(max(row - 1, 0), min(row + 2, rows)):
            low = start[r * columns + max(column - 1, 0)]
            high = start[r * columns + min(column + 1, columns - 1) + 1]
            for m in range(low, high):
                j = members[m]
                if j <= i or j // per_granule == i // per_granule:
                    continue
                dx, dy = (
                    constituents[j, X] - constituents[i, X],
                    constituents[j, Y] - constituents[i, Y],
                )
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
def near_circle(constituents, radius, skin, x, y, size):
    """Parts closer than skin (m) to a circle of radius size (m) at x, y: (constituent, partner)."""
    constituent = np.empty(constituents.shape[0], np.uint32)
    count = 0
    for i in range(constituents.shape[0]):
        dx, dy = constituents[i, X] - x, constituents[i, Y] - y
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
