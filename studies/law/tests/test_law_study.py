"""The sweep over contact laws, and what its findings say of known drags."""

from pathlib import Path

import numpy as np
import pytest
from pictures import assert_not_blank
from sweeps import dataset_of

from dem.figures.catalogue import possible
from dem.figures.style import save
from dem.sweep.config import load
from studies.catalogue import figures
from studies.law import findings
from studies.law.figures.law import plot

STUDY = Path(__file__).parent.parent
DRAG = np.array([[1000.0, 2000.0, 400.0], [1000.0, 2500.0, 600.0]])  # N, by law and shape


@pytest.fixture
def runs():
    axes = {"law": ["hertz", "linear"], "state": ["fraction", "pressure"]}
    axes |= {"shape": ["c1", "d1", "e3"], "density": [3900.0]}
    drag = np.broadcast_to(DRAG[:, None, :, None, None], (2, 2, 3, 1, 4))
    return dataset_of(drag * np.linspace(0.99, 1.01, 4), axes)


def test_the_sweep_packs_and_runs_under_each_law():
    block = load(STUDY / "sweep.yaml").block("drag")
    assert "law" in possible(block, figures())
    contacts = [run.configuration.contact for run in block.runs.values()]
    assert len({contact.law for contact in contacts}) == 3


def test_shapes_are_compared_under_one_law(runs, tmp_path):
    study = findings.law.of(runs)
    assert study.over("hertz", "e3").value == pytest.approx(0.4)
    assert study.over("linear", "e3", "pressure").value == pytest.approx(0.6)
    assert study.same_order("fraction") and study.below("e3") and study.above("d1")
    assert study.apart("e3", "hertz", "linear") and not study.apart("c1", "hertz", "linear")
    figure = plot(runs)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["hertz", "linear"]
    assert_not_blank(save(figure, tmp_path / "law")[1])
