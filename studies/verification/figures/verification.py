"""What came out of each case, over what is expected: a panel a case."""

import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.verification.findings import verification
from studies.verification.measure import case

FILE = "verification"
CAPTION = "Known cases of the field: what came out and what is expected"
VARIABLES = ("row_case", "row_value")


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per case, drawn by the case itself."""
    found = verification.of(dataset)
    names = dataset["case"].values.tolist()
    figure, grid = style.panels(len(names), 2, 0.6, 2.9)
    for axes, name in zip(grid, names, strict=True):
        case(name).plot(axes, found.rows_of(name))
        axes.set_title(found.title_of(name), loc="left")
    figure.suptitle(
        f"{found.total() - found.failed()} of {found.total()} numbers are within their tolerances"
    )
    return figure
