"""Figure 13: mean drag within the window, by shape, at the density of the first case."""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import summarise, table1
from dem.figures import style

FILE = "drag"
CAPTION = "Mean drag by shape"
CASES = {}
PAPER = {"c1": 1295.0}  # N, section 3.2


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One bar per shape with its interval, its single runs and its value."""
    labels = table1(dataset)
    numbers = summarise(dataset).sel(case=labels)
    figure = Figure(figsize=(style.WIDTH, 5.2))
    axes = figure.subplots()
    name = f"mean of {style.runs(numbers['run_mean'])}"
    axes.fill_between([], [], facecolor="0.8", edgecolor="0.3", label=name)  # of any colour
    for place, label in enumerate(labels):
        case_numbers = numbers.sel(case=label)
        look = style.look(case_numbers)  # by the kind of its granules
        top = style.bar(
            axes,
            place,
            0.62,
            case_numbers,
            color=look.fill,
            edgecolor=look.color,
            hatch=look.hatch,
        )
        style.write_above(axes, place, top, style.newtons(case_numbers))
        if paper := PAPER.get(str(case_numbers["shape"].values)):
            axes.plot(place + 0.42, paper, label=f"paper, {paper:.0f} N", **style.STAR)
    ticks = [f"{label}\n" + style.describe(numbers.sel(case=label), "\n") for label in labels]
    style.finish_bars(axes, ticks, dataset)
    axes.set_title("Above each bar: mean drag and its 95 % interval", loc="left")
    over = numbers["mean"] / numbers["mean"][0]
    ends = (
        f"{float(share):.2f} for {_named(numbers, label.item())}"
        for share, label in ((over.min(), over.idxmin("case")), (over.max(), over.idxmax("case")))
    )
    figure.suptitle(f"Mean drag over that of {_named(numbers, labels[0])}: {', '.join(ends)}")
    style.legend(figure, axes, ncols=4)
    return figure


def _named(numbers: xr.Dataset, label: str) -> str:
    """Kind and label of a case: ellipse e3."""
    return f"{numbers['kind'].sel(case=label).item()} {label}"
