"""Known cases are met, and a broken law is noticed."""

import pytest

from dem.dynamics import assembly
from studies.verification.contact_law import Contact, damping_ratio
from studies.verification.results import run


def test_what_is_expected_of_a_contact_comes_from_no_code_of_the_library():
    """The differential equation returns the restitution, and friction makes no energy."""
    approach = (0.3, -1.0, 0.2)
    elastic = Contact(2.0, 0.4, 1.0, 1e6, 4e6, 0.0, 0.2)
    rebound = elastic.collide((0.3, -1.0), 0.2)
    energy = [u * u + v * v + 0.2 * w * w for u, v, w in (approach, rebound)]
    smooth = elastic._replace(zeta=damping_ratio(0.3), friction=0.0)
    assert energy[1] < energy[0] and rebound[1] == pytest.approx(1.0, rel=1e-6)
    assert smooth.collide((0.3, -1.0), 0.2) == pytest.approx([0.3, 0.3, 0.2], rel=1e-6)


def test_a_case_fails_once_a_law_is_broken(monkeypatch):
    """Here half of the mass; others are broken in the kernels, at night."""
    right = assembly.mobilities
    monkeypatch.setattr(
        assembly, "mobilities", lambda scene: [2.0 * mobility for mobility in right(scene)]
    )
    assert not all(row.passed for row in run("chain")[0])
