"""What a file of results holds, as tables for the terminal (100 columns are enough)."""

import json
from importlib import import_module
from pathlib import Path

import numpy as np
import xarray as xr
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.statistics import summarise, within
from dem.base.errors import InputError
from dem.base.schema import seed_words
from dem.io.dataset import VARIABLES
from dem.sweep.combine import COMBINED, open_lazily, require

# Headings in two lines, so that a row fits; LEGEND explains them.
COLUMNS = (
    "case", "kind", "ratio", "D_g\nµm", "density\nkg/m³", "runs", "mean\nN", "95 %\n± N",
    "sd over\nrun %", "sd betw.\nruns %", "great.\noverlap", "step\nns", "run\ntime s",
)  # fmt: skip
LEGEND = """\
mean drag within the window; 95 % interval of the mean by Student's t over the runs; standard
deviation of the drag over a run and of the means between runs, both over the mean drag; greatest
overlap over the smaller granule radius; median time step; mean processor time of a run"""
# What a file must hold to be summarised; SWEEP is for drag.nc only.
NEEDED = ("drag", "max_overlap", "time_step", "run_time", "kind", "seed")
ORIGIN = ("title", "history", "git_revision", "source_hash", "versions", "configuration")
WINDOW = ("window_start", "window_stop")
SWEEP = (*WINDOW, "cylinder_velocity")
OF_A_RUN = ("steps", "box_height", "packing_pressure")
# The variable that tells a study's file: the package with its `layout` and `report`, what else its
# report needs of variables and of attributes.
STUDIES = {
    "granule_steps_per_second": (
        "dem.studies.benchmark", (), ("history", "processor", "versions", "codes")),
    "trial_drag": (
        "dem.studies.accuracy", ("contact_method", "integrator", "replicate_drag"),
        (*WINDOW, "default_fraction"),
    ),
    "non_affine": (
        "dem.analysis.flow", ("case", "seed", "shape", "density", "displacement"), WINDOW),
    "run_part": ("dem.studies.claims", ("run_drag", "jam_fraction", "run_factor"), WINDOW),
    "check_value": (
        "dem.studies.stability", ("map_residual", "paper_residual"), ("default_fraction",)),
}  # fmt: skip


def summary(path: Path) -> Group:
    """Renderable summary of drag.nc, a replicate or the file of a study; raises InputError for other files."""
    with open_lazily(path) as dataset:
        for sign, (package, variables, attributes) in STUDIES.items():
            if sign in dataset:
                layout = import_module(f"{package}.layout").VARIABLES
                require(dataset, path, layout, variables, ("title", *attributes))
                return import_module(f"{package}.report").summary(dataset.load())
        if "displacement" not in dataset.dims:
            raise InputError(f"{path}: it is neither drag.nc nor a replicate: it holds no drag.")
        if "case" in dataset.dims:
            require(dataset, path, COMBINED, NEEDED, ORIGIN + SWEEP)
            return _sweep(dataset)
        require(dataset, path, VARIABLES, (*NEEDED, *OF_A_RUN), ORIGIN)
        return _replicate(dataset)


def _sweep(dataset: xr.Dataset) -> Group:
    """Title, provenance and a table with a row a case."""
    attrs = dataset.attrs
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for number, name in enumerate(COLUMNS):
        table.add_column(name, justify="left" if number < 2 else "right", no_wrap=True)
    numbers = summarise(dataset)
    for label in dataset["case"].values:
        table.add_row(*_row(dataset.sel(case=label), numbers.sel(case=label)))
    seeds = seed_words(dataset["seed"].values)
    window = _millimetres(attrs["window_start"], attrs["window_stop"])
    lines = _provenance(attrs, seeds, window, attrs["cylinder_velocity"])
    if "failure" in dataset and (missing := _missing(dataset["failure"])):
        lines.add_row("missing", missing)
    return Group(Text(attrs["title"], style="bold"), lines, "", table, Text(LEGEND, style="dim"))


def _missing(failure: xr.DataArray) -> str:
    """How many runs failed, by the flags of dem.sweep.failures; "" where none did."""
    meanings = failure.attrs["flag_meanings"].split()
    counts = np.bincount(failure.values.ravel(), minlength=len(meanings))
    words = [f"{n} {word}" for n, word in zip(counts[1:], meanings[1:], strict=True) if n]
    return f"{counts[1:].sum()} of {failure.size} runs: {', '.join(words)}" if words else ""


def _row(case: xr.Dataset, numbers: xr.Dataset) -> list[str]:
    """Cells of one case, in the order of COLUMNS."""
    mean = numbers["mean"]
    return [
        str(case["case"].values),
        str(case["kind"].values),
        f"{float(case['aspect_ratio']):g}",
        f"{1e6 * float(case['diameter']):.4g}",
        f"{float(case['density']):g}",
        str(int(numbers["run_mean"].count())),
        _number(mean, ".0f"),
        _number(numbers["half_interval"], ".0f"),
        _number(100.0 * numbers["sd_over_run"] / mean, ".1f"),
        _number(100.0 * numbers["sd_between_runs"] / mean, ".1f"),
        _number(case["max_overlap"].max(), ".3f"),
        _number(1e9 * np.nanmedian(case["time_step"]), ".1f"),
        _number(case["run_time"].mean(), ".1f"),
    ]


def _replicate(dataset: xr.Dataset) -> Group:
    """Title, provenance and the numbers of one run; its window is in its configuration."""
    attrs, record = dataset.attrs, json.loads(dataset.attrs["configuration"])
    start, stop = record["record"]["window"]
    drag = within(dataset["drag"], start, stop)
    mean = drag.mean()
    values = {
        "mean drag within the window": f"{_number(mean, '.0f')} N",
        "standard deviation over the run": f"{_number(100.0 * drag.std() / mean, '.1f')} %",
        "greatest overlap over the smaller radius": _number(dataset["max_overlap"].max(), ".3f"),
        "median time step": f"{1e9 * np.median(dataset['time_step']):.1f} ns",
        "steps": str(int(dataset["steps"])),
        "processor time": f"{float(dataset['run_time']):.1f} s",
        "height of the box": f"{1e3 * float(dataset['box_height']):.2f} mm",
        "pressure before the run": f"{1e-6 * float(dataset['packing_pressure']):.3g} MPa",
    }
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    for name, value in values.items():
        table.add_row(name, value)
    seed, velocity = str(int(dataset["seed"])), record["cylinder"]["velocity"]
    lines = _provenance(attrs, seed, _millimetres(start, stop), velocity)
    return Group(Text(attrs["title"], style="bold"), lines, "", table)


def _provenance(attrs: dict, seeds: str, window: str, velocity: float) -> Table:
    """Where the numbers come from, a line each; more than one source hash where runs differ."""
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    lines = {
        "written": attrs["history"],
        "revision": attrs["git_revision"],
        "sources": ", ".join(each[:16] for each in attrs["source_hash"].split("; ")),
        "versions": attrs["versions"],
        "seeds": seeds,
        "window": f"{window} of displacement, cylinder at {velocity:g} m/s",
    }
    for name, line in lines.items():
        table.add_row(name, Text(line))
    return table


def _millimetres(start: float, stop: float) -> str:
    """A range of lengths, given in m."""
    return f"{1e3 * start:g} mm to {1e3 * stop:g} mm"


def _number(value, form: str) -> str:
    """A number as text, a dash where there is none."""
    value = float(value)
    return format(value, form) if np.isfinite(value) else "-"
