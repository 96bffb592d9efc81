"""Shapes in boxes of several widths: the line finds the drag at infinite width."""

import numpy as np
import pytest
from intervals import assert_held
from sweeps import dataset_of

from studies.pressure.widths import Widths

WIDTH = np.array([1.0, 2.0, 4.0, 1.0])
BOXES = ["1", "2", "4", "high"]


def boxes(power=1.0, slope=(0.8, 1.5), seeds=4, noise=0.0, seed=1):
    """A file of runs: drags of 1000 N and 500 N at infinite width, to which walls add in
    proportion to 1 / width; or, with power -1, to the inverse of which a top wall does."""
    rng = np.random.default_rng(seed)
    drag = np.array([[1000.0], [500.0]]) * (1.0 + np.array(slope)[:, None] / WIDTH) ** power
    drag = drag[..., None] * (1.0 + noise * rng.standard_normal((2, 4, seeds)))
    return dataset_of(drag, {"shape": ["c1", "e1"], "box": BOXES}).assign_coords(
        box_width=("box", 20e-3 * WIDTH), cylinder_start=("box", [0.25] * 3 + [0.125])
    )


@pytest.mark.parametrize("power", [1.0, -1.0])
def test_the_line_finds_the_box_without_end(power):
    """And in which of both ways the walls count, and how wide is within 5 % of it."""
    widths = Widths(boxes(power))
    assert widths.along.tolist() == [True, True, True, False] and widths.power == power
    assert widths.drag_limit("c1").value == pytest.approx(1000.0)
    assert widths.limit("e1").value == pytest.approx(0.5)
    near = widths.share("c1", widths.enough("c1")).value
    assert near == pytest.approx(1.0 + 0.05 * power)


def test_a_drag_that_only_walls_make_has_no_limit():
    """A bed that is not jammed makes room at infinite width."""
    widths = Widths(boxes(slope=(0.8, 1e9), noise=0.1))
    assert widths.limit("e1").low == 0.0 and widths.limit("e1").value < 0.5e6


@pytest.mark.parametrize("power", [1.0, -1.0])
def test_intervals_hold_the_truth_as_often_as_they_say(power):
    """Where the scatter is so small that the drags tell in which way the walls count; and of the
    drag in a box that is as wide as the first."""
    made = [Widths(boxes(power, noise=0.02, seed=seed)) for seed in range(100)]
    assert_held([widths.limit("e1")[1:] for widths in made], 0.5)
    assert_held([widths.change("e1", "high")[1:] for widths in made], 1.0)
