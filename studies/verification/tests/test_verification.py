"""Known cases are met, and a broken law is noticed."""

import json

import pytest
from laws import FILE, LAWS, notices
from matplotlib.figure import Figure

from studies.verification import cases
from studies.verification.contact_law import Contact, damping_ratio
from studies.verification.findings import verification
from studies.verification.measure import case, run


@pytest.mark.parametrize("name", cases.NAMES)
def test_a_case_says_what_it_is_and_why_its_tolerance(name):
    module = case(name)
    assert module.TITLE and module.SOURCE
    assert "?" in module.__doc__ and "olerance" in module.__doc__


def test_what_is_expected_of_a_contact_comes_from_no_code_of_the_library():
    """The differential equation returns the restitution, and friction makes no energy."""
    before = (0.3, -1.0, 0.2)
    elastic = Contact(2.0, 0.4, 1.0, 1e6, 4e6, 0.0, 0.2)
    energy = [
        u * u + v * v + 0.2 * w * w for u, v, w in (before, elastic.collide((0.3, -1.0), 0.2))
    ]
    smooth = elastic._replace(zeta=damping_ratio(0.3), friction=0.0)
    assert energy[1] < energy[0]
    assert elastic.collide((0.3, -1.0), 0.2)[1] == pytest.approx(1.0, rel=1e-6)
    assert smooth.collide((0.3, -1.0), 0.2) == pytest.approx([0.3, 0.3, 0.2], rel=1e-6)


def test_a_case_passes_and_fails_once_a_law_is_broken():
    law = next(each for each in LAWS if each.kind == "half of the mass in the dashpot")
    assert all(row.passed for row in run("stacked")[1])
    assert notices(law, "stacked")["stacked"] >= 1


def test_each_broken_law_is_noticed():
    """Of the table that laws.py wrote."""
    found = json.loads(FILE.read_text())["laws"]
    assert set(found) == {law.kind for law in LAWS}
    assert all(any(each.values()) for each in found.values())


@pytest.mark.skipif(not verification.path.is_file(), reason="verification.nc is not there yet")
def test_the_released_numbers_are_of_all_cases_and_can_be_drawn():
    assert tuple(verification.dataset["case"].values) == cases.NAMES
    for name in cases.NAMES:
        axes = Figure().subplots()
        case(name).plot(axes, verification.rows_of(name))
        assert axes.get_xlabel()
