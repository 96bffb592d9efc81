"""The onset of jamming of a frictionless bed: its packing fraction, and the contacts that carry it.

The granules grow until the bed is jammed, and shrink again until it just is. Pressure of a Hertzian
bed goes as the distance from the onset to the power of 3/2 (O'Hern et al. 2003, Phys. Rev. E 68,
011306), so the line of load^(2/3) through the last two beds tells where the load vanishes, and each
bed is chosen nearer to that by the same factor. Of a linear bed it is the load itself.
"""

import numpy as np

from dem.base.errors import PackingError
from dem.dynamics.contact_output import ContactList
from dem.experiment.bed import room_of
from dem.experiment.replicate import Replicate
from dem.laws.hertz import Hertz
from dem.packing.compaction import Press

VARIABLES = {
    "onset_fraction": ((), "1", "packing fraction at the onset of jamming"),
    "onset_load": (
        (),
        "1",
        "load of the bed whose contacts are counted, over E* and the mean diameter, or over K",
    ),
    "onset_contacts": ((), "1", "contacts between granules that are no rattlers"),
    "onset_rattlers": (
        (),
        "1",
        "granules that are held by too few contacts, left out of the contacts",
    ),
}
SECTIONS = {"cylinder": False, "record": True}
ASKS = {
    "packing.pressure": (None, "the bed is compressed"),
    "packing.friction": (0.0, "rattlers are told by their contacts"),
    "packing.preparation": ("relaxed", "granules grow until the bed is jammed"),
}
BED_ALONE = True
STEP = 0.002  # of the packing fraction, while granules grow
STEPS = 200  # at most; 0.98 would be reached after 120
# load: mean normal stress of the contacts over E* and the mean diameter. JAMMED, MARGINAL and GROWN
# are those under Hertz's law; another law has others at these overlaps, by its power.
JAMMED = 1e-5  # about 0.001 of packing fraction beyond the onset
MARGINAL = 1e-9  # about 2e-6 beyond it, where nearly all contacts are as at the onset
BACK = 1e-4  # first step back, of the packing fraction
NEARER = 8.0  # by what factor a bed is nearer to the onset than the one before
LOOSE = 1e-3  # load over the load of the bed before, below which contact was lost
GROWN = 1e-7  # E* R^2: greatest net force at rest while granules grow
STILL = 1e-5  # greatest net force at rest over E* R^2 and the load of the bed before
PATIENCE = 100_000  # iterations of FIRE
HOLDING = 3  # contacts that hold a granule of two dimensions, round or not, without friction


def run(replicate: Replicate, bed=None, progress=lambda done: None) -> dict:
    """Find the onset of jamming of a run; returns the variables of a run by name. Raises PackingError
    where there is none."""
    press, law = Press(*room_of(replicate.bed_description)), replicate.law
    unit, jammed = law.scale(1.0, replicate.shape.diameter), JAMMED ** (law.power / Hertz.power)
    for _ in range(STEPS):
        load = press.press(press.fraction + STEP, GROWN * (jammed / JAMMED), PATIENCE) / unit
        if load > jammed and (fraction := _loosen(press, load, unit, law.power)):
            break  # a bed that comes loose had not come to rest: it grows on
    else:
        raise PackingError(
            f"no bed jams up to the packing fraction {press.fraction:.4g} (seed {replicate.seed})."
        )
    contacts = press.contacts()
    holds = contacts.force > press.net_force * press.unit  # others are not at rest
    contacts = ContactList(*(column[holds] for column in contacts))
    firm = backbone(contacts, replicate.shape.granules)
    between = firm[contacts.granule] & firm[contacts.partner] & (contacts.partner >= 0)
    return {
        "onset_fraction": fraction,
        "onset_load": press.pressure / unit,
        "onset_contacts": between.sum(),
        "onset_rattlers": (~firm).sum(),
    }


def _loosen(press: Press, load: float, unit: float, power: float) -> float | None:
    """Shrink the granules of a jammed bed until it just is; the packing fraction at the onset, or
    None where contact is lost, or where the bed gives way to another."""
    fraction, goal = press.fraction, press.fraction - BACK
    while True:
        before = fraction, load ** (1.0 / power)
        last, load = load, press.press(goal, STILL * load, PATIENCE) / unit
        if not LOOSE * last < load < last:
            return None
        fraction, height = press.fraction, load ** (1.0 / power)
        onset = fraction - height * (fraction - before[0]) / (height - before[1])
        if load < MARGINAL ** (power / Hertz.power):
            return onset
        goal = onset + (fraction - onset) / NEARER


def backbone(contacts: ContactList, granules: int) -> np.ndarray:
    """Which granules (n,) are no rattlers: each has HOLDING contacts with others that are none.

    Walls and cylinder are none. Those with too few are taken out until none is left.
    """
    first, second = contacts.granule, contacts.partner
    firm, kept = np.zeros(granules, bool), np.ones(granules, bool)
    while (kept != firm).any():
        firm = kept
        both = firm[first] & ((second < 0) | firm[second])
        ends = np.concatenate([first[both], second[both & (second >= 0)]])
        kept = firm & (np.bincount(ends, minlength=granules) >= HOLDING)
    return firm
