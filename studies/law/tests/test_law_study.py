"""What the findings of the sweep over contact laws say of known drags."""

import numpy as np
import pytest
from sweeps import dataset_of

from studies.law import findings

DRAG = np.array([[1000.0, 2000.0, 400.0], [1000.0, 2500.0, 600.0]])  # N, by law and shape


def test_shapes_are_compared_under_one_law():
    axes = {"law": ["hertz", "linear"], "state": ["fraction", "pressure"]}
    axes |= {"shape": ["c1", "d1", "e3"], "density": [3900.0]}
    drag = np.repeat(DRAG[:, None, :, None, None], 2, axis=1) * np.linspace(0.99, 1.01, 4)
    study = findings.law.of(dataset_of(drag, axes))
    assert study.over("hertz", "e3").value == pytest.approx(0.4)
    assert study.over("linear", "e3", "pressure").value == pytest.approx(0.6)
    assert study.same_order("fraction") and study.below("e3") and study.above("d1")
    assert study.apart("e3", "hertz", "linear") and not study.apart("c1", "hertz", "linear")
