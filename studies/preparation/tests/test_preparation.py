"""Beds that were made in several ways, side by side."""

import numpy as np
from sweeps import dataset_of

from studies.preparation.figures.preparation import plot


def test_the_figure_shows_the_ratio_of_both_ways():
    """Where grown beds drag half as much, each mark of the ratio is at a half."""
    drag = np.array([1000.0, 500.0])[:, None, None, None] * np.ones((2, 2, 3, 4))
    axes = {"packing_preparation": ["relaxed", "grown"], "box": ["1", "2"]}
    axes |= {"shape": ["c1", "e1", "e3"]}
    width = "box", [0.02, 0.04], {"long_name": "width", "units": "m"}
    runs = dataset_of(drag * np.linspace(0.9, 1.1, 4), axes).assign_coords(box_width=width)
    line, *_ = plot(runs).axes[2].lines
    np.testing.assert_allclose(line.get_ydata(), 0.5 * np.ones(3))
