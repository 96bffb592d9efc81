"""What replicates buy, and what a longer stroke buys instead."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from dem.figures import style
from studies.accuracy import replicates

FILE = "accuracy"
CAPTION = "What replicates and a longer stroke buy"
VARIABLES = ("replicate_drag",)
PAPER = 5  # runs a case
DRAWN = (3, 5, 8, 12, 20, 35, 60)  # sizes of the random subsets


def plain(axis) -> None:
    """Numbers as they are spoken on a logarithmic axis: 1, 2, 5, 10."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Interval against number of runs above; memory along the stroke and longer windows below."""
    figure = Figure(figsize=(style.WIDTH, 7.6))
    above, below = figure.subfigures(2, 1, height_ratios=(1.15, 1.0))
    _intervals(above.subplots(), dataset)
    left, right = below.subplots(1, 2)
    _memory(left, dataset)
    _windows(right, dataset)
    figure.suptitle("What more runs buy, and what longer ones")
    return figure


def _intervals(axes, dataset) -> None:
    """Half-interval over the mean against the number of runs, with processor time above."""
    found = replicates.replicates(dataset)
    total = dataset.sizes["replicate"]
    axes.loglog(found.runs, 100 * found.half, color=style.CURVE,
                label=f"expected from the scatter of {total} runs")  # fmt: skip
    sizes = [n for n in DRAWN if n <= total // 2]
    quantiles = [np.quantile(replicates.subsets(dataset, n)[0], (0.05, 0.5, 0.95)) for n in sizes]
    if sizes:
        low, middle, high = 100 * np.transpose(quantiles)
        axes.errorbar(sizes, middle, (middle - low, high - middle), fmt="o", color="0.3", capsize=4,
                      markersize=5, label="as random groups find it: median, 5 % to 95 %")  # fmt: skip
    axes.axhline(100 * replicates.TARGET, **style.REFERENCE)
    axes.axvline(found.needed, **style.REFERENCE)
    axes.annotate(f"{found.needed} runs", (found.needed, 0.92), (-5, 0), textcoords="offset points",
                  ha="right", xycoords=("data", "axes fraction"))  # fmt: skip
    axes.set_xlabel("Number of runs")
    axes.set_ylabel("Half the 95 % interval\nof the mean drag (%)")
    plain(axes.xaxis)
    plain(axes.yaxis)
    axes.grid(axis="x", visible=True)
    second = axes.secondary_xaxis(
        "top", functions=(lambda n: n * found.time, lambda s: s / found.time)
    )
    second.set_xlabel("Processor time (s)")
    plain(second.xaxis)
    axes.legend(loc="upper center")
    own = replicates.expected(found.scatter, PAPER)
    axes.set_title(
        f"The paper's {PAPER} runs give ± {100 * own:.0f} %, and ± {100 * replicates.TARGET:.0f} % "
        f"takes {found.needed}", loc="left",
    )  # fmt: skip


def _memory(axes, dataset) -> None:
    """Autocorrelation of the drag along the stroke."""
    lags, values = replicates.autocorrelation(dataset)
    length = replicates.correlation_length(dataset)
    axes.plot(style.millimetres(lags), values, color=style.CURVE)
    axes.axhline(0.0, color="0.4", linewidth=0.8)
    axes.set_xlabel("Distance along the stroke (mm)")
    axes.set_ylabel("Autocorrelation of the drag")
    axes.set_title(f"One independent value every {1e3 * length:.2f} mm", loc="left")


def _windows(axes, dataset) -> None:
    """Scatter of one run against the length of its window."""
    lengths, scatter = replicates.windows(dataset)
    axes.loglog(style.millimetres(lengths), 100 * scatter, color=style.CURVE, marker="o",
                markersize=3.5, label="runs")  # fmt: skip
    middle = len(lengths) // 2
    axes.loglog(style.millimetres(lengths), 100 * scatter[middle] * np.sqrt(lengths[middle] / lengths),
                label="if pieces were independent", **style.REFERENCE)  # fmt: skip
    used = dataset.attrs["window_stop"] - dataset.attrs["window_start"]
    axes.axvline(1e3 * used, color="0.5", linewidth=1.0)
    axes.set_xlabel("Length of the window (mm)")
    axes.set_ylabel("Scatter of one run (%)")
    plain(axes.xaxis)
    plain(axes.yaxis)
    shift = 100.0 * replicates.drift(dataset)
    axes.set_title(
        f"A window of {1e3 * lengths[-1]:.0f} mm: {100 * scatter[-1]:.0f} %,\nbut another mean ({shift:+.0f} %)",
        loc="left",
    )
    axes.legend(loc="lower left")
