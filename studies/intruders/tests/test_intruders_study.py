"""What the findings of the sweeps of intruders say of known forces."""

import numpy as np
import pytest
import xarray as xr

from studies.intruders import findings
from studies.intruders.figures import intruders


def forces(drag, side, names, coordinates) -> xr.Dataset:
    """Runs with forces (N) on solids, whose drags scatter by a tenth between seeds."""
    coordinates = coordinates | {"seed": range(4), "solid": names, "displacement": [2e-3, 3e-3]}
    dims, shape = [*coordinates], [len(values) for values in coordinates.values()]
    drag = drag * np.linspace(0.9, 1.1, 4)[:, None, None]
    values = {"solid_drag": drag, "solid_side_force": side}
    return xr.Dataset(
        {name: (dims, np.broadcast_to(force, shape)) for name, force in values.items()},
        coordinates,
        {"window_start": 1e-3, "window_stop": 4e-3},
    )


def test_intruders_are_compared_with_the_cylinder():
    labels = ["cylinder", "square", "plate 0", "plate 45"]
    drag = np.array([700.0, 1050.0, 700.0, 500.0])[:, None, None, None]
    side = np.array([0.0, 0.0, 0.0, 250.0])[:, None, None, None]
    dataset = forces(drag, side, ["cylinder"], {"intruder": labels})
    study = findings.intruders.of(dataset)
    assert study.over("square").value == pytest.approx(1.5)
    assert study.aside("plate 45").value == pytest.approx(0.5)
    assert study.angles == {"plate 0": 0.0, "plate 45": 45.0}
    ticks = intruders.plot(dataset).axes[0].get_yticklabels()
    assert [label.get_text() for label in ticks] == ["square", "cylinder"]


def test_cylinders_that_push_each_other_away_have_a_force_apart_above_zero():
    """The first is on the left: its side force is then to the left, below zero."""
    side, gaps = np.array([-100.0, 100.0])[:, None], {"pair": ["beside", "ahead"]}
    dataset = forces(500.0, side, ["cylinder", "second"], gaps | {"second_gap": [1e-3, 2e-3]})
    assert findings.pairs.of(dataset).apart(1e-3).value == pytest.approx(100.0)
