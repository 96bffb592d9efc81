"""How irregular the flow is, by shape: four measures against displacement."""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import find, table1
from dem.base.statistics import half_interval
from dem.experiment.observables.flow import lag_of
from dem.figures import style
from studies.claims import IRREGULARITY
from studies.claims.irregularity import SHAPES, compared

FILE = "flow"
CAPTION = "How irregular the flow is, by shape: four measures against displacement"
CASES = {}
VARIABLES = ("non_affine",)
LABELS = {
    "non_affine": "D²min over the squared\ndiameter (1)",
    "fluctuation": "Motion apart from neighbours\nover that of the cylinder (1)",
    "mixing": "Pairs of different layers,\ngained since the start (1)",
    "contacts_lost": "Share of contacts lost (1)",
}
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (3, 1, 1, 1)), (0, (6, 1, 1, 1)), "-", "--")


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per measure, one line per case at the density of the first, with 95 % bands."""
    selection = dataset.sel(case=table1(dataset))
    cases = [find(dataset, shape) for shape in SHAPES]
    figure, grid = style.panels(4, 2, 0.0, 3.6, sharex=True)
    x = 1e3 * selection["snapshot_displacement"].values
    for axes, name in zip(grid, IRREGULARITY, strict=True):
        for number, case in enumerate(selection["case"].values):
            runs = selection[name].sel(case=case)
            mean, half = runs.mean("seed"), half_interval(runs).fillna(0.0).values
            look = {"color": style.CASES[number % 7], "linestyle": LINES[number % 7]}
            bold = case in cases or None in cases
            axes.plot(x, mean, linewidth=2.0 if bold else 1.0, label=str(case), **look)
            if bold:
                style.band(axes, x, mean, half, color=look["color"], alpha=0.16)
        axes.set_ylabel(LABELS[name])
        comparison = compared(dataset, name)
        title = (
            f"ratio of e3 to c1: {comparison.ratio:.2f} ± {comparison.half:.2f}"
            if comparison
            else IRREGULARITY[name]
        )
        axes.set_title(title, loc="left")
        axes.set_xlabel("Displacement of the cylinder (mm)")
        style.from_zero(axes)
    lag = x[lag_of(selection["snapshot_displacement"].values)]
    bands = "; bands: 95 %" if dataset.sizes["seed"] > 1 else ""
    figure.suptitle(f"Irregularity of the flow by shape\n(motions over {lag:g} mm{bands})")
    style.legend(figure, grid[0], ncols=7)
    return figure
