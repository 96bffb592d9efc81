"""How often the mean is as near as asked for, and at how many runs over those needed, against
the scatter."""

import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.accuracy.precision.findings import precision
from studies.accuracy.precision.sources import CASES
from studies.accuracy.precision.stopping import OTHERS, ROUNDS

FILE = "precision"
CAPTION = "How often the mean is within 5 %, as was asked for, and how many runs it takes"
VARIABLES = ("row_asked",)
LINES = "-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), (0, (1, 1)), "none"
COLUMNS = {
    "Rounds that double": {
        name: (ROUNDS, name) for name in ("normal", "gamma", "lognormal", "mixture")
    }
    | {"the paper's beds": (ROUNDS, CASES)},
    "Rules, of normal values": {rule: (rule, "normal") for rule in (ROUNDS, *OTHERS)},
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """The rule of sweeps on several distributions on the left, several rules on normal values on
    the right."""
    findings, (figure, grid) = (
        precision.of(dataset),
        style.panels(4, 2, 1.0, 3.1, sharex=True, sharey="row"),
    )
    for above, below, title in zip(grid[:2], grid[2:], COLUMNS, strict=True):
        for number, (name, (rule, source)) in enumerate(COLUMNS[title].items()):
            rows = findings.rows(rule, source=source, target=0.05).sort_values("scatter")
            look = style.numbered(number + 4 * (rule in OTHERS)) | {  # no look means two things
                "linestyle": LINES[number],
                "markersize": 7,
                "label": name,
            }
            above.plot(rows.scatter, 100.0 * rows.asked, **look)
            below.plot(rows.scatter, rows.over, **look)
        above.axhline(95.0, **style.REFERENCE)
        above.set_title(title, loc="left")
        below.set_xlabel("Scatter of one run over the mean")
        below.legend()
    rows = findings.rows(target=0.05)
    figure.suptitle(
        f"Sweeps keep their promise: at least {100.0 * rows.asked.min():.1f} % of their means are within 5 %\n"
        f"as asked for, by at most {rows.over.max():.2f} times the runs needed"
    )
    grid[0].set_ylabel("Means within 5 % (%)")
    grid[2].set_ylabel("Runs over those needed")
    return figure
