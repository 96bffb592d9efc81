"""Materials of granules, walls and solids; friction and rolling resistance of their contacts, and
friction with the plate on which a bed lies."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import Field, WrapValidator

from dem.base.types import (
    MOST,
    Coefficient,
    Density,
    Number,
    PoissonRatio,
    Positive,
    Pressure,
    Ratio,
    Restitution,
    Unit,
    adapter,
    array,
    checked,
)


@checked
@dataclass(frozen=True)
class Material:
    """Elastic material with a coefficient of restitution.

    The defaults are the density of the paper and the elasticity of glass.

    Parameters
    ----------
    density : float
        Density (kg/m3).
    young_modulus : float
        Young's modulus E (Pa).
    poisson_ratio : float
        Poisson's ratio, without unit, above -1 and up to 0.5.
    restitution : float
        Coefficient of restitution of a head-on collision of two bodies of this material, without
        unit, from 0.001 to 1. It does not depend on the speed. If it is 1 for all materials, the
        kernels are compiled without damping.

    Raises
    ------
    InputError
        If a value is not a number in its range.

    Notes
    -----
    The normal force follows Hertz (1882; Johnson, "Contact Mechanics", 1985, chapter 4) for
    spheres, ``F = 4/3 E* sqrt(R*) delta^1.5``, for an overlap ``delta``. The dashpot in parallel
    has the form of Tsuji, Tanaka and Ishida (1992), ``alpha sqrt(m* k) delta^0.25`` with
    ``k = 4/3 E* sqrt(R*)``. The constant ``alpha`` follows from the restitution exactly for a
    contact that never pulls (Schwager and Poeschel 2007).

    Examples
    --------
    >>> import dem
    >>> steel = dem.Material(density=7.8e3, young_modulus=2.1e11, poisson_ratio=0.3)
    >>> steel.restitution
    0.5
    """

    density: Density = 3.9e3
    young_modulus: Pressure = 70e9
    poisson_ratio: PoissonRatio = 0.22
    restitution: Restitution = 0.5


Tilt = Annotated[Number, Field(gt=-1.5, lt=1.5), Unit("rad")]
TABLE = array(None, None, low=0.0, high=MOST)


def number_or_table(value: Any, take: Callable[[Any], Any]) -> Any:
    """A coefficient, or a symmetric table of them as tuples; raises ValueError."""
    if not np.ndim(value):
        return take(value)
    rows = adapter(Annotated[Any, TABLE]).validate_python(value)
    if rows.shape[0] != rows.shape[1] or not np.array_equal(rows, rows.T):
        raise ValueError("it must be symmetric, with a row and a column for each material")
    return tuple(map(tuple, rows.tolist()))


@checked
@dataclass(frozen=True)
class Friction:
    """Coulomb friction of granules with each other, with walls and with solids.

    Parameters
    ----------
    granule : float or array_like of shape (s, s)
        Coefficient of friction between granules, without unit; or a symmetric table of those
        between granules of each two of the s materials of a scene.
    wall : float
        Coefficient of friction between granules and walls, without unit, of walls that have none
        of their own.
    solid : float
        Coefficient of friction between granules and solids, without unit, of solids that have none
        of their own.
    stiffness : float
        Stiffness of the tangential springs over Mindlin's, without unit.

    Raises
    ------
    InputError
        If a coefficient is negative, a table is not symmetric, or `stiffness` is not positive.

    Notes
    -----
    The tangential spring has the stiffness of a contact that sticks, ``8 G* sqrt(R* delta)``
    (Mindlin and Deresiewicz 1953; Johnson, "Contact Mechanics", 1985, chapter 7). When a contact
    unloads, its spring force shrinks with the contact radius (Thornton, Cummins and Cleary 2013).
    A dashpot acts in parallel. Coulomb's law caps the force at the coefficient times the normal
    force. `Rolling` resists rolling.

    Examples
    --------
    >>> import dem
    >>> dem.Friction(granule=0.5, solid=0.0)
    Friction(granule=0.5, wall=0.3, solid=0.0, stiffness=1.0)
    """

    granule: Annotated[Coefficient, WrapValidator(number_or_table)] = 0.3
    wall: Coefficient = 0.3
    solid: Coefficient = 0.3
    stiffness: Ratio = 1.0


@checked
@dataclass(frozen=True)
class Rolling:
    """Rolling resistance of discs with each other, with walls and with solids.

    Parameters
    ----------
    granule : float
        Coefficient of rolling resistance between granules, without unit.
    wall : float
        Coefficient of rolling resistance between granules and walls, without unit.
    solid : float
        Coefficient of rolling resistance between granules and solids, without unit.
    damping : float
        Damping ratio of granules that rock on a contact without rolling, without unit.

    Raises
    ------
    InputError
        If a value is negative.

    Notes
    -----
    A spring resists the rotation of one body relative to the other with the elastic-plastic moment
    of Ai, Chen, Rotter and Ooi (2011), model C: its stiffness is ``3 (mu_r R_r)^2`` times the
    normal stiffness, and its moment is at most ``mu_r R_r N``, where ``1/R_r = 1/R_1 + 1/R_2`` and
    `mu_r` is the coefficient. A disc stays at rest on a slope up to ``tan(slope) = mu_r``. When a
    contact unloads, the moment shrinks with the stiffness. A dashpot acts in parallel until the
    moment reaches its limit. Both bodies feel opposite moments. At a coefficient of 1 a run takes
    more than twice as many steps.

    Examples
    --------
    >>> import dem
    >>> dem.Rolling(wall=0.0)
    Rolling(granule=0.1, wall=0.0, solid=0.1, damping=0.3)
    """

    granule: Coefficient = 0.1
    wall: Coefficient = 0.1
    solid: Coefficient = 0.1
    damping: Coefficient = 0.3


@checked
@dataclass(frozen=True)
class BasePlate:
    """A plate on which the bed lies flat, and its friction with granules.

    Parameters
    ----------
    friction : float
        Coefficient of friction between granules and the plate, without unit.
    solid : float
        Coefficient of friction between the plate and solids that forces move (`Drive`, `Turn`),
        without unit; zero for solids that do not touch the plate.
    gravity : float
        Gravity (m/s2), which presses granules on the plate.
    slope : float
        Angle (rad) by which the plate is tilted, so that the bed is pulled along -y.
    slip : float
        Mean distance by which a granule moves before it slides, over the mean radius, without unit.

    Raises
    ------
    InputError
        If a value is not a number in its range.

    Notes
    -----
    A granule presses on the plate evenly over its area, so that sliding and spinning share one
    friction, and end together: with ``v / (R omega) = 0.653`` for a disc (Farkas, Bartels, Unger and
    Wolf, Phys. Rev. Lett. 90, 248302, 2003). One that is not round counts as a disc with its radius
    of gyration: its friction when it only slides is exact, and the torque when it only spins is 3
    per cent too high for ellipses twice as long as wide, 5 per cent at three times. A granule that rests is held by a spring and
    a dashpot, which is critical. The weight of a solid follows from the mass of its `Drive`.

    Examples
    --------
    A disc slides on a plate, and stops after v^2 / (2 mu g):

    >>> import dem
    >>> plate = dem.BasePlate(friction=0.5)
    >>> scene = dem.Scene(dem.Disc([1e-3]), friction=dem.Friction(), base_plate=plate)
    >>> run = dem.Simulation(scene, dem.State([[0.0, 0.0]], velocity=[[0.1, 0.0]]))
    >>> shortest = run.advance(0.1)
    >>> print(f"{1e3 * run.state.position[0, 0]:.2f} mm, {1e3 * 0.1**2 / (2 * 0.5 * 9.81):.2f} mm")
    1.02 mm, 1.02 mm
    """

    friction: Coefficient
    solid: Coefficient = 0.0
    gravity: Annotated[Positive, Unit("m s-2")] = 9.81
    slope: Tilt = 0.0
    slip: Ratio = 1e-3

    @property
    def pressing(self) -> float:
        """Acceleration (m/s2) with which gravity presses on the plate."""
        return self.gravity * math.cos(self.slope)
