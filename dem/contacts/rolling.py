"""Rolling resistance of one contact: its stiffness, its dashpot and the moment M."""

import math

from dem.contacts.force_law import effective_radius, spring_and_dashpot
from dem.jit.compilation import inlined
from dem.jit.optional import optional
from dem.laws.protocol import slope


@inlined
def rolling_stiffness(contacts, p, constant):
    """Rolling stiffness of contact p over the measure of the law: 3 (mu_r R_r)^2 times that of the
    normal force; constant: of the law."""
    arm = contacts.rolling[0, p]
    return 3.0 * arm * arm * slope(contacts.law, constant, 1.0)


@optional
def rolling_moment(rolling, contacts, p, normal, elastic, rotation, account):
    """Moment on body 2: see `spring_and_dashpot`, and dem.dynamics.world.Contacts."""
    constant, _, _, _, root = elastic
    limit, stiffness = rolling[0, p] * normal, rolling_stiffness(contacts, p, constant)
    history, dashpot = contacts.rolling_moment, rolling[1, p] * root
    return spring_and_dashpot(history, p, limit, stiffness, dashpot, elastic, rotation, account)


@optional
def set_rolling(rolling, contacts, p, partner, radii, squares):
    """Rolling resistance of contact p of a disc with another (partner 0), a wall (1), a solid (2).

    rolling: GranuleTable.rolling; radii: as for `set_constants`; squares: mass times radius squared
    (kg m2), of both bodies as of two springs in a row; 3/2 of it is I_r, about the contact.
    """
    contacts.rolling[0, p] = rolling[partner] * effective_radius(radii[0], radii[1])
    constant = rolling_stiffness(contacts, p, contacts.stiffness[p])
    contacts.rolling[1, p] = 2.0 * rolling[3] * math.sqrt(1.5 * squares * constant)
