"""A linear spring, as most of the two-dimensional literature takes it."""

import math
from typing import NamedTuple

from dem.base.types import Stiffness, checked
from dem.laws.protocol import answer

LAW = "Linear"


@checked
class Linear(NamedTuple):
    """A linear spring, ``F = k delta``.

    Parameters
    ----------
    stiffness : float, optional
        Normal stiffness k (N/m) of all contacts; None for ``pi/4 E* L``, with the thickness L (m)
        of the granules.

    Raises
    ------
    InputError
        If `stiffness` is not positive.

    Notes
    -----
    Cundall and Strack (1979). ``pi/4 E* L`` is Hertz's line contact without its logarithm, as books
    on discrete elements give it. The tangential stiffness is the normal one times ``4 G*/E*``, the
    ratio of Mindlin, and `Friction.stiffness`.

    Examples
    --------
    >>> import dem
    >>> dem.Scene(dem.Disc([1e-3]), law=dem.Linear(stiffness=1e6)).law
    Linear(stiffness=1000000.0)
    """

    stiffness: Stiffness | None = None

    def modulus(self, young: float, thickness: float) -> float:
        """k (N/m)."""
        return self.stiffness or 0.25 * math.pi * young * thickness


def measure(law, overlap, length):
    return 1.0 if overlap > 0.0 else 0.0


def force(law, stiffness, overlap, measured):
    return stiffness * overlap


def energy(law, stiffness, overlap, measured):
    return 0.5 * stiffness * overlap * overlap


def root(law, overlap, measured):
    return measured


answer(Linear, measure, force, energy, root)
