"""How granules lie along their way, as an observable measures it."""

import numpy as np
import pytest

from dem.experiment.observables.alignment import alignment

pytestmark = pytest.mark.quick


@pytest.mark.parametrize(("turn", "expected"), [(0.0, 1.0), (np.pi / 2, -1.0), (np.pi, 1.0)])
def test_alignment_tells_along_from_across(turn, expected):
    rng = np.random.default_rng(0)
    start = rng.uniform(-2e-3, 2e-3, (200, 2))
    displacement = 1e-4 * rng.normal(size=(200, 2))
    angle = np.arctan2(displacement[:, 1], displacement[:, 0]) + turn
    angles = [angle, angle + np.pi / 2]
    along, _ = alignment(start, start + displacement, angles, (0.0, 0.0), 1e-3, 1e-3, 5e-4)
    np.testing.assert_allclose(along, [expected, -expected])


def test_alignment_at_random_is_none_and_far_granules_do_not_count():
    rng = np.random.default_rng(0)
    start = rng.uniform(-2e-3, 2e-3, (4000, 2))
    end = start + 1e-4 * rng.normal(size=start.shape)
    angle = rng.uniform(0.0, 2.0 * np.pi, 4000)
    assert np.abs(alignment(start, end, [angle], (0, 0), 1e-3, 1e-3, 5e-4)).max() < 0.06
    assert np.isnan(alignment(start + 1.0, end + 1.0, [angle], (0, 0), 1e-3, 1e-3, 5e-4)).all()
