"""Cohesion: granules that touch hold each other, and let go across a gap."""

from typing import NamedTuple

from dem.base.types import Force, Length, checked
from dem.laws import hertz
from dem.laws.hertz import Hertz
from dem.laws.protocol import answer

LAW = "Cohesive"


@checked
class Cohesive(NamedTuple):
    """Hertz's law with linear cohesion: a constant pull in contact, which fades across a gap.

    Parameters
    ----------
    pull_off : float
        Force (N) with which two bodies that touch attract each other, and that parts them.
    range : float
        Gap (m) across which the pull falls to zero in proportion.

    Raises
    ------
    InputError
        If a value is not positive.

    Notes
    -----
    ``F = 4/3 E* sqrt(R*) delta^1.5 - F_0`` in contact, and ``-F_0 (1 + delta / d)`` across a gap
    ``-delta`` below the range d. The energy of the pull, which granules lose as they come together,
    is ``F_0 d / 2`` at touch. Nothing is lost by it: on separation the force takes the same way
    back. Coulomb's limit and rolling resistance follow from Hertz's force, so that a contact under
    no load bears a shear force of ``mu F_0``. The dashpot is as in Hertz's law: restitution is as
    prescribed if the pull is small compared with the forces of an impact. Beds are packed without
    the pull. With constant pull-off force this is the linear form of the law of Derjaguin, Muller
    and Toporov (1975), J. Colloid Interface Sci. 53, 314, in which the pull-off force of spheres is
    ``4 pi gamma R*`` for a surface energy gamma.

    Examples
    --------
    Grains of 1 mm that hold thirty times their weight, over a gap of a hundredth of their radius:

    >>> import dem
    >>> law = dem.Cohesive(pull_off=3e-3, range=5e-6)
    >>> scene = dem.Scene(dem.Disc([0.5e-3, 0.5e-3]), friction=dem.Friction(), law=law)
    >>> apart = dem.Simulation(scene, dem.State([[0, 0], [1.002e-3, 0]]))
    >>> print(f"{1e3 * apart.contacts().force[0]:.2f} mN")
    -1.80 mN
    """

    pull_off: Force
    range: Length

    power = Hertz.power
    bulk = Hertz.bulk
    dashpot = Hertz.dashpot
    margin = Hertz.margin
    modulus = Hertz.modulus
    scale = Hertz.scale

    @property
    def repulsion(self) -> Hertz:
        """Hertz's law."""
        return Hertz()


def attraction(law, overlap, length):
    return law.pull_off * min(max(1.0 + overlap / law.range, 0.0), 1.0)


def attraction_energy(law, overlap, length):
    share = min(max(1.0 + overlap / law.range, 0.0), 1.0)
    return -law.pull_off * (0.5 * law.range * share * share + max(overlap, 0.0))


answer(
    Cohesive,
    hertz.stiffness,
    hertz.measure,
    hertz.force,
    hertz.energy,
    hertz.slope,
    hertz.root,
    hertz.mean_root,
    hertz.stiffest,
    attraction,
    attraction_energy,
)
