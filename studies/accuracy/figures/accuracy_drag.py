"""What the time step costs in mean drag, and what it costs in processor time."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.accuracy.bias import LARGEST, Steps, steps_of
from studies.common.shapes import name

FILE = "accuracy"
CAPTION = "What the time step costs in mean drag and in processor time"
VARIABLES = ("trial_drag",)
SHOWN = 0.15  # change of the mean drag at which the axis ends


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One column per shape: change of the mean drag above; processor time and failed runs below."""
    shapes = steps_of(dataset)
    figure = Figure(figsize=(style.WIDTH, 6.6))
    rows = figure.subplots(
        2, len(shapes), sharex=True, sharey="row", squeeze=False, height_ratios=(1.7, 1.0)
    )
    for (shape, steps), (above, below) in zip(shapes.items(), rows.T, strict=True):
        _changes(above, steps)
        above.set_title(f"{name(shape)}:\nbias {style.percent(*steps.bias[:2])}", loc="left")
        _times(below, steps)
    rows[0, 0].set_ylabel("Change of the mean drag\nagainst the paper's step (%)")
    rows[1, 0].set_ylabel("Processor time\nof a run (s)")
    rows[0, 0].set_ylim(-100.0 * SHOWN, 100.0 * SHOWN)
    rows[1, len(shapes) // 2].set_xlabel("Time step over that of the paper's sweep")
    worst = max(abs(steps.bias.value) + steps.bias.half for steps in shapes.values())
    figure.suptitle(
        f"At the step of the paper's sweep the mean drag is biased by less than {100 * worst:.1f} % (95 %)"
    )
    style.legend(figure, rows[0, 0], ncols=2)
    return figure


def _changes(axes, steps: Steps) -> None:
    """Change of the mean with its interval, the straight line with its band."""
    changes, line = 100.0 * steps.changes, steps.bias
    x, mask = steps.lengths, changes.value.abs() <= 100.0 * SHOWN
    look = {"color": style.CURVE, "markersize": 5, "capsize": 3, "elinewidth": 1.4, "zorder": 4}
    axes.errorbar(
        x[mask],
        changes.value[mask],
        changes.half[mask].fillna(0.0),
        fmt="o",
        label="mean of paired beds, 95 % interval",
        **look,
    )
    _off_scale(axes, x[~mask], changes.value[~mask])
    along = np.linspace(0.0, x[line.fractions.max()], 50)
    share = 100.0 * (along - 1.0)
    words = f"straight line, step fractions up to {LARGEST:g}"
    axes.plot(along, line.value * share, color="0.15", linewidth=1.2, label=words)
    low, high = ((line.value + sign * line.half) * share for sign in (-1.0, 1.0))
    band = {"color": "0.82", "linewidth": 0.0, "zorder": 1, "label": "its 95 % interval"}
    axes.fill_between(along, low, high, **band)
    axes.axvline(1.0, **style.REFERENCE, label="step of the paper's sweep")


def _off_scale(axes, x, y) -> None:
    """Arrows for values outside the axis."""
    for place, value in zip(x, y, strict=True):
        if np.isfinite(value):
            end, marker = (0.97, "^") if value > 0.0 else (0.12, "v")
            frame = axes.get_xaxis_transform()
            axes.plot(place, end, marker, transform=frame, color=style.CURVE, clip_on=False)
            axes.annotate(
                f"{value:.0f}".replace("-", "\N{MINUS SIGN}"),
                (place, end),
                (0, 6),
                xycoords=frame,
                textcoords="offset points",
                fontsize=8.0,
                ha="center",
            )


def _times(axes, steps: Steps) -> None:
    """Median processor time of the runs that came to their end, and the share that did not.

    The curve falls, so the words are above it, in turns, so that neighbours can be read.
    """
    middle = steps.runs[steps.runs.drag.notna()].groupby("fraction").time.median()
    look = {"marker": "s", "color": style.CURVE, "markersize": 4.5, "linewidth": 1.2}
    axes.plot(steps.lengths[middle.index], middle, **look)
    style.logarithmic(axes)
    axes.axvline(1.0, **style.REFERENCE)
    for number, (fraction, share) in enumerate(steps.failed[steps.failed > 0.0].items()):
        axes.annotate(
            f"{100 * share:.0f} %\nfail",
            (steps.lengths[fraction], 1.0 - 0.22 * (number % 2)),
            fontsize=8.0,
            ha="center",
            va="top",
            xycoords=("data", "axes fraction"),
        )
