"""Arithmetic in which an absent quantity costs nothing.

A disc has no lever in the tangential direction, a frictionless contact no tangential force. Such
a quantity is ``None``: its type is known while compiling, so the terms with it are never
compiled at all (a float 0.0 would stay, since 0.0 * x is not 0.0 for every x).
"""

from dem.compilation import inlined


@inlined
def plus(total, term):
    """total + term."""
    if term is None:
        return total
    if total is None:
        return term
    return total + term


@inlined
def minus(total, term):
    """total - term."""
    if term is None:
        return total
    if total is None:
        return -term
    return total - term


@inlined
def times(a, b):
    """a * b, absent if either is."""
    if a is None:
        return None
    if b is None:
        return None
    return a * b
