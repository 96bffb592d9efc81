"""The sweep over contact laws, and what its findings say of known drags."""

from pathlib import Path

import numpy as np
import pytest
from sweeps import dataset_of

from dem.sweep.config import load
from studies.law import findings

DRAG = np.array([[1000.0, 2000.0, 400.0], [1000.0, 2500.0, 600.0]])  # N, by law and shape


def test_the_sweep_packs_and_runs_under_each_law():
    block = load(Path(findings.__file__).parent / "sweep.yaml").block("drag")
    assert len({run.configuration.contact.law for run in block.runs.values()}) == 3


def test_shapes_are_compared_under_one_law():
    axes = {"law": ["hertz", "linear"], "state": ["fraction", "pressure"]}
    axes |= {"shape": ["c1", "d1", "e3"], "density": [3900.0]}
    drag = np.repeat(DRAG[:, None, :, None, None], 2, axis=1) * np.linspace(0.99, 1.01, 4)
    study = findings.law.of(dataset_of(drag, axes))
    assert study.over("hertz", "e3").value == pytest.approx(0.4)
    assert study.over("linear", "e3", "pressure").value == pytest.approx(0.6)
    assert study.same_order("fraction") and study.below("e3") and study.above("d1")
    assert study.apart("e3", "hertz", "linear") and not study.apart("c1", "hertz", "linear")
