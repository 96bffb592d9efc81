"""The sweeps of intruders, and what their figures and findings say of a known force."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from pictures import assert_not_blank

from dem.figures.catalogue import possible
from dem.figures.style import save
from dem.sweep.config import load
from studies.catalogue import figures
from studies.intruders import findings
from studies.intruders.figures import intruders, pairs

STUDY = Path(__file__).parent.parent


def forces(drag, side, coordinates, solids=2) -> xr.Dataset:
    """Runs with forces (N), whose drags scatter by a tenth between seeds."""
    dims = (*coordinates, "seed", "solid", "displacement")
    shape = (*map(len, coordinates.values()), 4, solids, 2)
    scatter = np.linspace(0.9, 1.1, 4)[:, None, None]
    drag, side = (np.broadcast_to(values, shape) for values in (drag * scatter, side))
    names = ["cylinder", "second"][:solids]
    axes = {"seed": np.arange(4), "solid": names, "displacement": [2e-3, 3e-3]}
    return xr.Dataset(
        {"solid_drag": (dims, drag), "solid_side_force": (dims, side)},
        coordinates | axes,
        {"window_start": 1e-3, "window_stop": 4e-3},
    )


@pytest.mark.parametrize(("name", "figure"), [("sweep", "intruders"), ("pairs", "pairs")])
def test_a_sweep_makes_what_its_figure_needs(name, figure):
    """Also the forces on each solid, which are no part of the paper's drag."""
    block = load(STUDY / f"{name}.yaml").block("drag")
    assert figure in possible(block, figures())
    assert all("solids" in run.configuration.observables for run in block.runs.values())


def test_intruders_are_compared_with_the_cylinder(tmp_path):
    labels = ["cylinder", "square", "plate 0", "plate 45"]
    drag = np.array([700.0, 1050.0, 700.0, 500.0])[:, None, None, None]
    side = np.array([0.0, 0.0, 0.0, 250.0])[:, None, None, None]
    dataset = forces(drag, side, {"intruder": labels}, solids=1)
    study = findings.intruders.of(dataset)
    assert study.over("square").value == pytest.approx(1.5)
    assert study.aside("plate 45").value == pytest.approx(0.5)
    assert study.angles == {"plate 0": 0.0, "plate 45": 45.0}
    figure = intruders.plot(dataset)
    ticks = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert ticks == ["square", "cylinder"]
    assert_not_blank(save(figure, tmp_path / "intruders")[1])


def test_cylinders_that_push_each_other_away_have_a_force_apart_above_zero(tmp_path):
    """The first is on the left: its side force is then to the left, below zero."""
    side = np.array([-100.0, 100.0])[:, None]
    gaps = {"pair": ["beside", "ahead"], "second_gap": [1e-3, 2e-3]}
    dataset = forces(np.float64(500.0), side, gaps)
    assert findings.pairs.of(dataset).apart(1e-3).value == pytest.approx(100.0)
    assert_not_blank(save(pairs.plot(dataset), tmp_path / "pairs")[1])
