"""Values beside what is expected, a panel a case."""

import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.verification.findings import verification
from studies.verification.results import CASES

FILE = "verification"
CAPTION = "Known cases of the field: values (marks) and what is expected (lines; grey: tolerance)"
VARIABLES = ("row_case", "row_value")
MARKERS = "os^Dv"


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per case."""
    found = verification.of(dataset)
    figure, grid = style.panels(len(found.by_case), 2, 0.6, 2.9)
    for axes, (name, title, rows) in zip(grid, found.by_case, strict=True):
        settings = getattr(CASES[name], "AXES", None)
        rows = rows[rows.name.str.contains(getattr(CASES[name], "DRAWN", ""), regex=False)]
        if settings is None:
            _errors(axes, rows)
        else:
            _values(axes, rows[rows.x.notna()], getattr(CASES[name], "DRAWN", ""))
            axes.set(**settings)
            for along in "xy":
                if settings.get(f"{along}scale") == "log":
                    style.logarithmic(axes, along)
        axes.set_title(title, loc="left")
    right = found.total() - found.failed()
    figure.suptitle(f"{right} of {found.total()} numbers are within their tolerances")
    return figure


def _values(axes, rows, drawn: str) -> None:
    """Values, what is expected and the tolerance over the abscissa; drawn: part of the names."""
    for (name, part), marker in zip(rows.groupby("name", sort=False), MARKERS, strict=False):
        line = axes.plot(part.x, part.expected, linewidth=1.0)[0]
        low, high = part.expected - part.tolerance, part.expected + part.tolerance
        axes.fill_between(part.x, low, high, color="0.85", linewidth=0.0)
        look = {"color": line.get_color(), "markersize": 5.0, "label": name.replace(drawn, "")}
        axes.plot(part.x, part.value, marker, **look)
    if rows.name.nunique() > 1:
        axes.legend(fontsize=8)


def _errors(axes, rows) -> None:
    """Errors over their tolerances, one row a number."""
    for place, row in enumerate(rows.itertuples()):
        axes.plot((row.value - row.expected) / row.tolerance, place, "o", color="0.2")
        axes.text(1.2, place, row.name, fontsize=7, va="center", in_layout=False)
    axes.axvspan(-1.0, 1.0, color="0.9", zorder=0)
    axes.set(xlim=(-1.2, 8.0), xticks=(-1, 0, 1), yticks=(), xlabel="Error over its tolerance")
