"""What the time step costs in mean drag, and what it costs in processor time."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.accuracy.bias import LARGEST, bias, change, failures, lengths, shapes_of, table

FILE = "accuracy"
CAPTION = "What the time step costs in mean drag and in processor time"
VARIABLES = ("trial_drag",)
SHOWN = 0.15  # change of the mean drag at which the axis ends


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One column per shape: change of the mean drag above; processor time and failed runs below."""
    shapes = shapes_of(dataset)
    default = float(dataset.attrs["default_fraction"])
    figure = Figure(figsize=(style.WIDTH, 6.6))
    rows = figure.subplots(
        2, len(shapes), sharex=True, sharey="row", squeeze=False, height_ratios=(1.7, 1.0)
    )
    for shape, (above, below) in zip(shapes, rows.T, strict=True):
        _changes(above, dataset, shape, default)
        _times(below, dataset, shape)
    rows[0, 0].set_ylabel("Change of the mean drag\nagainst the paper's step (%)")
    rows[1, 0].set_ylabel("Processor time\nof a run (s)")
    rows[0, 0].set_ylim(-100.0 * SHOWN, 100.0 * SHOWN)
    rows[1, len(shapes) // 2].set_xlabel("Time step over that of the paper's sweep")
    figure.suptitle(sentence(dataset))
    style.legend(figure, rows[0, 0], "outside lower center", ncols=2)
    return figure


def sentence(dataset: xr.Dataset) -> str:
    """The reading of the figure: the worst bias, interval included."""
    found = [bias(dataset, shape) for shape in shapes_of(dataset)]
    worst = max(abs(b.value) + b.half for b in found)
    return f"At the step of the paper's sweep the mean drag is biased by less than {100 * worst:.1f} % (95 %)"


def _changes(axes, dataset, shape, default) -> None:
    """Change of the mean with its interval, the straight line with its band."""
    found, line = change(table(dataset, shape), default), bias(dataset, shape)
    at = lengths(dataset, shape)
    x = np.array([at[each] for each in found["fraction"].values.tolist()])
    y, half = 100 * found["value"].values, 100 * found["half"].values
    seen = np.abs(y) <= 100.0 * SHOWN
    axes.errorbar(
        x[seen],
        y[seen],
        np.nan_to_num(half[seen]),
        fmt="o",
        color=style.CURVE,
        markersize=5,
        capsize=3,
        elinewidth=1.4,
        label="mean of paired beds, 95 % interval",
        zorder=4,
    )
    _off_scale(axes, x[~seen], y[~seen])
    steps = np.linspace(0.0, at[line.fractions.max()], 50)
    share = steps - 1.0
    axes.plot(
        steps,
        100 * line.value * share,
        color="0.15",
        linewidth=1.2,
        label=f"straight line, step fractions up to {LARGEST:g}",
    )
    low, high = ((line.value + sign * line.half) * share for sign in (-1.0, 1.0))
    axes.fill_between(
        steps,
        100 * low,
        100 * high,
        color="0.82",
        linewidth=0.0,
        zorder=1,
        label="its 95 % interval",
    )
    axes.axvline(1.0, **style.REFERENCE, label="step of the paper's sweep")
    axes.set_title(f"{shape}: bias {style.percent(line.value, line.half)}", loc="left")


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


def _times(axes, dataset, shape) -> None:
    """Median processor time of the runs that came to their end, and the share that did not.

    The curve falls, so the words are above it, in turns, so that neighbours can be read.
    """
    ran = (dataset["trial_shape"].values == shape) & np.isfinite(dataset["trial_drag"].values)
    fractions, times = dataset["trial_fraction"].values[ran], dataset["trial_time"].values[ran]
    at, ran_at = lengths(dataset, shape), np.unique(fractions).tolist()
    middle = [np.median(times[fractions == f]) for f in ran_at]
    look = {"marker": "s", "color": style.CURVE, "markersize": 4.5, "linewidth": 1.2}
    axes.plot([at[f] for f in ran_at], middle, **look)
    style.logarithmic(axes)
    axes.axvline(1.0, **style.REFERENCE)
    failed = {step: share for step, share in failures(dataset, shape).items() if share > 0.0}
    for number, (fraction, share) in enumerate(failed.items()):
        axes.annotate(
            f"{100 * share:.0f} %\nfail",
            (at[fraction], 1.0 - 0.22 * (number % 2)),
            fontsize=8.0,
            ha="center",
            va="top",
            xycoords=("data", "axes fraction"),
        )
