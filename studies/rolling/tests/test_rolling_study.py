"""The sweep over rolling resistance, and what its findings say of known drags."""

from pathlib import Path

import numpy as np
import pytest
from pictures import assert_not_blank
from sweeps import dataset_of

from dem.figures.catalogue import possible
from dem.figures.style import save
from dem.sweep.config import load
from studies.catalogue import figures
from studies.rolling import findings
from studies.rolling.figures.rolling import plot

STUDY = Path(__file__).parent.parent
LABELS = ["c1", "mu 0.2", "mu 1", "e3"]
DRAG = np.array([[1000.0, 2000.0, 4000.0, 500.0], [800.0, 1000.0, 2000.0, 1000.0]])  # N, by state


def test_the_sweep_makes_what_its_figure_needs():
    assert "rolling" in possible(load(STUDY / "sweep.yaml").block("drag"), figures())


def test_discs_are_compared_with_other_granules(tmp_path):
    """At equal fraction no disc drags as little as e3, at equal pressure one of 0.2 drags as much."""
    drag = np.broadcast_to(DRAG.T[:, :, None, None], (4, 2, 1, 4)) * np.linspace(0.99, 1.01, 4)
    axes = {"model": LABELS, "state": ["fraction", "pressure"], "density": [3900.0]}
    runs = dataset_of(drag, axes)
    study = findings.rolling.of(runs)
    assert study.rises("fraction") and study.beyond("e3", "fraction")
    assert not study.reaches("e3", "fraction") and study.reaches("e3", "pressure")
    assert study.equivalent("e3", "pressure") == pytest.approx(0.2)
    assert_not_blank(save(plot(runs), tmp_path / "rolling")[1])
