"""The onset of jamming: what carries a bed there, and what lies below and above."""

import numpy as np
import pytest
from project import ROOT, quick

from dem.dynamics.contact_output import ContactList
from dem.experiment.bed import room_of
from dem.experiment.kinds import jamming, onset
from dem.packing.compaction import Press
from dem.sweep.config import load

FILE = ROOT / "studies/onset/sweep.yaml"
if not FILE.is_file():
    pytest.skip("needs the study onset", allow_module_level=True)
SWEEP = load(FILE)


def bed(ratio=1.0, granules=40, **changes):
    """A run of the sweep with few granules."""
    width = 0.98e-3 * np.sqrt(granules)
    new = {"shapes.e.aspect_ratio": ratio, "shapes.e.granules": granules, "box_width": width}
    new |= {"shapes.e.kind": "disc", "shapes.e.aspect_ratio": None} if ratio == 1.0 else {}
    return SWEEP.changed(new | changes, "e").replicate("e", 3900.0, 1)


@pytest.mark.parametrize("ratio", [pytest.param(1.0, marks=quick), 1.5])
def test_discs_jam_with_as_many_contacts_as_degrees_of_freedom_and_ellipses_with_fewer(ratio):
    """Two a disc; two less because the whole may move, one more because the bed bears a load. Ellipses have more
    than discs, which do not feel that they turn."""
    result = onset.run(bed(ratio))
    granules, contacts = 40 - result["onset_rattlers"], result["onset_contacts"]
    if ratio == 1.0:
        assert contacts == 2 * granules - 1
        assert 0.80 < result["onset_fraction"] < 0.87
    else:
        assert 2 * granules - 1 < contacts < 3 * granules - 1


LINEAR = {"contact.law": "linear", "periodic": "x"}  # discs between a floor and a lid


@pytest.mark.parametrize(
    ("ratio", "changes", "power"),
    [(1.3, {}, 1.5), pytest.param(1.0, LINEAR, 1.0, marks=quick)],
)
def test_a_bed_bears_no_load_below_the_onset_and_that_of_its_law_above(ratio, changes, power):
    """The load goes as the distance from the onset to the power of 3/2 under Hertz's law, in proportion to it
    under a linear one."""
    replicate, soft = bed(ratio, **changes), onset.JAMMED ** (power / 1.5 - 1.0)
    press, fraction = (
        Press(*room_of(replicate.bed_description)),
        onset.run(replicate)["onset_fraction"],
    )
    while press.fraction < fraction + 1e-3:  # as the onset was found
        press.press(press.fraction + onset.STEP, onset.GROWN * soft, onset.PATIENCE)
    far, near = (press.press(fraction + gap, 1e-10, onset.PATIENCE) for gap in (4e-4, 1e-4))
    assert far / near == pytest.approx(4.0**power, rel=0.1)
    assert press.press(fraction - 1e-4, 1e-12, onset.PATIENCE) < 1e-3 * near


@quick
@pytest.mark.parametrize("power", [1.5, 1.0])
def test_a_bed_jams_where_the_line_of_its_loads_begins(power):
    """Loads that begin at 0.8137, with noise below; too few of them make no line."""
    fraction = np.arange(0.74, 0.90, 0.005)
    load = (0.2 * np.maximum(fraction - 0.8137, 0.0)) ** power
    load += 0.1 * jamming.NOISE * (fraction < 0.81)
    assert jamming.line(fraction, load, power) == pytest.approx((0.8137, 0.2), rel=1e-5)
    assert np.isnan(jamming.line(fraction[:5], load[:5], power)).all()


def test_the_onset_is_just_below_where_the_line_of_greater_loads_meets_zero():
    """The experiment jamming fits that line to beds that are farther beyond the onset."""
    replicate = bed(granules=80)
    wide = jamming.run(replicate)["jam_fraction"]
    assert onset.run(replicate)["onset_fraction"] == pytest.approx(wide, abs=0.01)


@quick
def test_granules_that_too_few_contacts_hold_are_rattlers():
    """A chain on a firm square of four goes link by link; walls and the cylinder hold granules."""
    square = (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)
    chain = (3, 4), (4, 5), (5, 6)
    held = (5, 2), (5, 1), (6, 4), (6, 0), (4, -1)
    for more, count in (((), 4), ((*chain, (5, 3)), 4), ((*chain, *held), 7)):
        first, second = np.array([*square, *more]).T
        fields = dict.fromkeys(ContactList._fields) | {"granule": first, "partner": second}
        backbone = onset.backbone(ContactList(**fields), 8)
        assert backbone.tolist() == [True] * count + [False] * (8 - count)
