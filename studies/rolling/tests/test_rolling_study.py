"""What the findings of the sweep over rolling resistance say of known drags."""

import numpy as np
import pytest
from sweeps import dataset_of

from studies.rolling import findings

LABELS = ["c1", "mu 0.2", "mu 1", "e3"]
DRAG = np.array([[1000.0, 2000.0, 4000.0, 500.0], [800.0, 1000.0, 2000.0, 1000.0]])  # N, by state


def test_discs_are_compared_with_other_granules():
    """At equal fraction no disc drags as little as e3, at equal pressure one of 0.2 drags as much."""
    axes = {"model": LABELS, "state": ["fraction", "pressure"], "density": [3900.0]}
    study = findings.rolling.of(
        dataset_of(DRAG.T[:, :, None, None] * np.linspace(0.99, 1.01, 4), axes)
    )
    assert study.rises("fraction") and study.beyond("e3", "fraction")
    assert not study.reaches("e3", "fraction") and study.reaches("e3", "pressure")
    assert study.equivalent("e3", "pressure") == pytest.approx(0.2)
