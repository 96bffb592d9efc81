"""Where beds of infinitely many granules jam: lines over the number of granules."""

import numpy as np
import pytest
from synthetic import jammed

from dem.analysis.onset import limits

pytestmark = pytest.mark.quick


def test_lines_find_what_beds_without_end_have():
    """Rattlers, half of the granules, count neither as granules nor for contacts."""
    beds, n = jammed(noise=0.0), np.array([50, 100, 200])
    rattlers = 0.5 * beds["granules"] + beds["onset_rattlers"]
    beds = beds.assign(onset_rattlers=rattlers, onset_contacts=0.5 * beds["onset_contacts"])
    result = limits(beds)
    for found, truth in (
        (result.fraction, 0.84),
        (result.coordination, 4.0),
        (result.fractions, [0.84 - 0.05 * n**-0.5] * 2),
        (result.contacts, [4.0 - 2.0 / n] * 2),
        (result.rattlers, 0.5),
    ):
        np.testing.assert_allclose(found, truth)


def test_a_size_has_the_weight_of_its_granules():
    """As numpy fits with the square root of it, on either axis."""
    beds = jammed(granules=(40, 90, 500, 160), noise=0.02)
    result, n = limits(beds), beds["granules"].values[0]
    means = beds["onset_fraction"].mean("seed").values[0, 0]
    assert result.granules.tolist() == sorted(n)
    for estimate, power in ((result.fraction, -0.5), (result.other, -1.0)):
        expected = np.polyfit(n**power, means, 1, w=np.sqrt(n))[1]
        assert estimate[0].value == pytest.approx(expected, rel=1e-9)
