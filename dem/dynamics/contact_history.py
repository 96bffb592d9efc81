"""What contacts remember, carried from an old neighbour list to a new one."""

import numpy as np

from dem.jit.compilation import compiled, inlined


@compiled(allocates=True)
def match(constituent, partner, old_constituent, old_partner):
    """Row of each contact in the old list, -1 for a new one; both lists are in ascending order."""
    source, q = np.full(constituent.shape[0], -1), 0
    for p in range(constituent.shape[0]):
        i, j = constituent[p], partner[p]
        while q < old_constituent.shape[0] and (
            old_constituent[q] < i or (old_constituent[q] == i and old_partner[q] < j)
        ):
            q += 1
        if q < old_constituent.shape[0] and old_constituent[q] == i and old_partner[q] == j:
            source[p] = q
    return source


@inlined
def carried(old, source):
    """What each contact remembers from row source[p] of the old list; 0 if it was not there."""
    if old is None:
        return None
    new = np.zeros(source.shape[0])
    for p in range(source.shape[0]):
        if source[p] >= 0:
            new[p] = old[source[p]]
    return new
