"""How irregular the flow is, by shape: four measures against displacement."""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.statistics import find, table1
from dem.experiment.observables.flow import lag_of
from dem.figures import style
from studies.claims.irregularity import SHAPES, compared, mean_and_half, verdict
from studies.claims.layout import MEASURES

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
    here = dataset.sel(case=table1(dataset))
    compared_cases = [find(dataset, shape) for shape in SHAPES]
    figure = Figure(figsize=(style.WIDTH, 7.2))
    grid = figure.subplots(2, 2, sharex=True).ravel()
    x = style.millimetres(here["snapshot_displacement"])
    for axes, name in zip(grid, MEASURES, strict=True):
        for number, case in enumerate(here["case"].values):
            mean, half = mean_and_half(here[name].sel(case=case))
            look = {"color": style.CASES[number % 7], "linestyle": LINES[number % 7]}
            told = case in compared_cases or None in compared_cases
            axes.plot(x, mean, linewidth=2.0 if told else 1.0, label=str(case), **look)
            if told:
                style.band(axes, x, mean, half, look["color"], alpha=0.16)
        axes.set_ylabel(LABELS[name])
        axes.set_title(_reading(dataset, name), loc="left")
        style.from_zero(axes)
    for axes in grid[2:]:
        axes.set_xlabel("Displacement of the cylinder (mm)")
    lag = x[lag_of(here["snapshot_displacement"].values)]
    bands = "; bands: 95 %" if dataset.sizes["seed"] > 1 else ""
    figure.suptitle(f"{verdict(dataset)}\n(motions over {lag:g} mm{bands})")
    style.legend(figure, grid[0], "outside lower center", ncols=7)
    return figure


def _reading(dataset, name) -> str:
    """The two cases that the paper compares, in words."""
    found = compared(dataset, name)
    if found is None:
        return MEASURES[name]
    return f"e3 over c1: {found.ratio:.2f} ± {found.half:.2f}"
