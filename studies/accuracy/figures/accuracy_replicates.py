"""What replicates buy, and what a longer stroke buys instead."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from scipy.stats import chi2

from dem.base.statistics import LEVEL
from dem.figures import style
from studies.accuracy import replicates

FILE = "accuracy"
CAPTION = "What replicates and a longer stroke buy"
VARIABLES = ("replicate_drag",)
PAPER = 5  # runs a case
BAND = {"color": style.CURVE, "alpha": 0.2, "linewidth": 0.0}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Interval against the number of runs; scatter of one run against the length of its window."""
    figure = Figure(figsize=(style.WIDTH, 4.4))
    left, right = figure.subplots(1, 2)
    _intervals(left, dataset)
    _windows(right, dataset)
    for axes in (left, right):
        style.logarithmic(axes, "x")
        style.logarithmic(
            axes, "y", (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if axes is right else (1.0, 2.0, 5.0)
        )
    figure.suptitle("What more runs buy, and what longer ones (bands: 95 % intervals)")
    return figure


def _intervals(axes, dataset) -> None:
    """Half-interval over the mean against the number of runs, with processor time above."""
    cost = replicates.cost(dataset)
    runs = np.arange(2, max(dataset.sizes["replicate"], 10) + 1)
    half = 100 * replicates.expected(cost.scatter, runs)
    axes.plot(runs, half, color=style.CURVE)
    axes.fill_between(runs, *(half * end for end in _ends(dataset)), **BAND)
    axes.axhline(100 * replicates.TARGET, **style.REFERENCE)
    axes.axvline(cost.needed, **style.REFERENCE)
    axes.set_xlabel(f"Number of runs ({cost.time:.2f} s each)")
    axes.set_ylabel("Half the 95 % interval\nof the mean drag (%)")
    reported = replicates.expected(cost.scatter, PAPER)
    axes.set_title(
        f"The paper's {PAPER} runs give ± {100 * reported:.0f} %,\n"
        f"and ± {100 * replicates.TARGET:.0f} % takes {cost.needed}",
        loc="left",
    )


def _ends(dataset) -> np.ndarray:
    """Ends of the interval of a scatter, over itself, for normal values."""
    free = dataset.sizes["replicate"] - 1
    return np.sqrt(free / chi2.ppf([0.5 + 0.5 * LEVEL, 0.5 - 0.5 * LEVEL], free))


def _windows(axes, dataset) -> None:
    """Scatter of one run against the length of its window."""
    lengths, scatter = replicates.windows(dataset)
    low, high = (100 * scatter * end for end in _ends(dataset))
    axes.fill_between(1e3 * lengths, low, high, **BAND)
    axes.plot(
        1e3 * lengths,
        100 * scatter,
        color=style.CURVE,
        marker="o",
        markersize=3.5,
        label="runs",
    )
    middle = len(lengths) // 2
    axes.plot(
        1e3 * lengths,
        100 * scatter[middle] * np.sqrt(lengths[middle] / lengths),
        label="if pieces were independent",
        **style.REFERENCE,
    )
    axes.set_xlabel("Length of the window (mm)")
    axes.set_ylabel("Scatter of one run (%)")
    shift = 100.0 * replicates.drift(dataset)
    axes.set_title(
        f"Over {1e3 * lengths[-1]:.0f} mm runs scatter by {100 * scatter[-1]:.0f} %,\n"
        f"about another mean ({shift:+.0f} %)",
        loc="left",
    )
    axes.legend(loc="lower left")
