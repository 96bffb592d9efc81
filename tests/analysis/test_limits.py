"""Where beds of infinitely many granules jam: lines over the number of granules."""

import numpy as np
import pytest
from synthetic import jammed

from dem.analysis.onset import limits

pytestmark = pytest.mark.quick


def test_lines_find_what_beds_without_end_have():
    result, n = limits(jammed(noise=0.0)), np.array([50, 100, 200])
    for found, truth in (
        (result.fraction, 0.84),
        (result.coordination, 4.0),
        (result.fractions, [0.84 - 0.05 * n**-0.5] * 2),
        (result.contacts, [4.0 - 2.0 / n] * 2),
    ):
        np.testing.assert_allclose(found, truth)


def test_a_size_has_the_weight_of_its_granules():
    """As numpy fits with the square root of it, on either axis."""
    beds = jammed(granules=(40, 90, 500, 160), noise=0.02)
    result, n = limits(beds), np.array([40.0, 90.0, 160.0, 500.0])
    means = beds["onset_fraction"].mean("seed").values[0, 0, [0, 1, 3, 2]]
    assert result.granules.tolist() == n.tolist()
    for estimate, power in ((result.fraction, -0.5), (result.other, -1.0)):
        expected = np.polyfit(n**power, means, 1, w=np.sqrt(n))[1]
        assert estimate[0].value == pytest.approx(expected, rel=1e-9)


def test_rattlers_count_neither_as_granules_nor_for_contacts():
    """Half of the granules are rattlers, and a quarter in the smallest beds."""
    beds = jammed(noise=0.0)
    share = 0.5 - 0.25 * (beds["granules"] == 50)
    rattlers = share * beds["granules"] + 0.0 * beds["onset_rattlers"]
    of_rest = beds["onset_contacts"] * (1.0 - share)
    loose = limits(beds.assign(onset_rattlers=rattlers, onset_contacts=of_rest))
    np.testing.assert_allclose(loose.contacts, limits(beds).contacts)
    np.testing.assert_allclose(loose.rattlers, 0.5)
