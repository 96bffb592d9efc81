"""Boxes that repeat themselves: their periods, and places in them. SI units; x to the right, y upwards."""

from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator

from dem.base.types import Length, must

Sides = Literal["none", "x", "y", "xy"]  # along which a box repeats itself
Periods = (
    Annotated[
        tuple[Length | None, Length | None],
        must("be two periods (x, y), None for a side that does not repeat itself"),
        AfterValidator(lambda periods: None if periods == (None, None) else periods),
    ]
    | None
)
ROOM = 2.5  # least period over the reach of a scene; two would leave no skin to neighbour lists
SIDES = {"none": (False, False), "x": (True, False), "y": (False, True), "xy": (True, True)}


def periods_of(width: float, height: float, periodic: str) -> Periods:
    """Periods (m) of a box that repeats itself along the sides that a key of SIDES names."""
    x, y = SIDES[periodic]
    return (width if x else None, height if y else None) if x or y else None


def walled(periodic: Periods) -> np.ndarray:
    """Which of the four walls of a box stand (4,), in the order of `box`."""
    return np.repeat([period is None for period in periodic or (None, None)], 2)


def wrapped(position: np.ndarray, periodic: Periods) -> np.ndarray:
    """Positions (..., 2) in m less whole periods: from 0 to below the period along a periodic side."""
    # twice: of a tiny negative number the first is the period
    return _by_side(position, periodic, lambda x, period: np.mod(np.mod(x, period), period))


def nearest_image(away: np.ndarray, periodic: Periods) -> np.ndarray:
    """Vectors (..., 2) in m from one body to another less whole periods: to its nearest image."""
    return _by_side(away, periodic, lambda x, period: x - period * np.rint(x / period))


def _by_side(places: np.ndarray, periodic: Periods, change: Callable) -> np.ndarray:
    if periodic is None:
        return places
    columns = zip(np.moveaxis(places, -1, 0), periodic, strict=True)
    return np.stack([change(x, period) if period else x for x, period in columns], axis=-1)
