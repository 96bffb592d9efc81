"""What a file of results holds, as tables for the terminal (100 columns are enough)."""

import json
from pathlib import Path

import numpy as np
import xarray as xr
from rich import box
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.benchmark import report as benchmark
from dem.combine import open_lazily, require
from dem.errors import InputError
from dem.schema import seed_words
from dem.statistics import summarise, within

# Headings in two lines, so that a row fits; LEGEND says what stands below them.
COLUMNS = (
    "case", "kind", "ratio", "D_g\nµm", "density\nkg/m³", "runs", "mean\nN", "95 %\n± N",
    "sd over\nrun %", "sd betw.\nruns %", "great.\noverlap", "step\nns", "run\ntime s",
)  # fmt: skip
LEGEND = """\
mean drag within the window; 95 % interval of the mean by Student's t over the runs; standard
deviation of the drag over a run and of the means between runs, both over the mean drag; greatest
overlap over the smaller granule radius; median time step; mean processor time of a run"""
# What a file must hold to be summarised; SWEEP stands in drag.nc only.
NEEDED = ("drag", "max_overlap", "time_step", "run_time", "kind", "seed")
ORIGIN = ("title", "history", "git_revision", "source_hash", "versions", "configuration")
SWEEP = ("window_start", "window_stop", "cylinder_velocity")


def summary(path: Path) -> Group:
    """Renderable summary of drag.nc, a replicate or the file of a study; raises InputError for other files."""
    with open_lazily(path) as dataset:
        if "granule_steps_per_second" in dataset:
            return benchmark.summary(dataset)
        if "trial_drag" in dataset:
            from dem.accuracy import report

            require(dataset, path, ("contact_method", "integrator", "replicate_drag"))
            return report.summary(dataset.load())
        if "non_affine" in dataset:
            from dem.flow import verdict

            require(dataset, path, ("case", "seed", "displacement"), ("window_start", "title"))
            lines = [dataset.attrs["title"], verdict.verdict(dataset), *verdict.sentences(dataset)]
            return Group(*map(Text, lines))
        if "run_part" in dataset:
            from dem.claims import report

            require(dataset, path, ("run_drag", "jam_fraction", "run_factor"), ("window_start",))
            return report.summary(dataset.load())
        if "check_value" in dataset:
            from dem.stability import report

            require(dataset, path, ("map_residual", "paper_residual"))
            return report.summary(dataset.load())
        if "displacement" not in dataset.dims:
            raise InputError(f"{path}: it is neither drag.nc nor a replicate: it holds no drag.")
        whole = "case" in dataset.dims
        require(dataset, path, NEEDED, ORIGIN + SWEEP if whole else ORIGIN)
        return _sweep(dataset) if whole else _replicate(dataset)


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
    """How many runs failed, by the flags of dem.failures; "" where none did."""
    meanings = failure.attrs["flag_meanings"].split()
    counts = np.bincount(failure.values.ravel(), minlength=len(meanings))
    words = [f"{n} {word}" for n, word in zip(counts[1:], meanings[1:], strict=True) if n]
    return f"{counts[1:].sum()} of {failure.size} runs: {', '.join(words)}" if words else ""


def _row(case: xr.Dataset, numbers: xr.Dataset) -> list[str]:
    """Cells of one case, in the order of COLUMNS."""
    mean = float(numbers["mean"])
    return [
        str(case["case"].values),
        str(case["kind"].values),
        f"{float(case['aspect_ratio']):g}",
        f"{1e6 * float(case['diameter']):.4g}",
        f"{float(case['density']):g}",
        str(int(numbers["run_mean"].count())),
        f"{mean:.0f}",
        _number(numbers["half_interval"], ".0f"),
        _number(100.0 * numbers["sd_over_run"] / mean, ".1f"),
        _number(100.0 * numbers["sd_between_runs"] / mean, ".1f"),
        _number(case["max_overlap"].max(), ".3f"),
        _number(1e9 * np.nanmedian(case["time_step"]), ".1f"),
        _number(case["run_time"].mean(), ".1f"),
    ]


def _replicate(dataset: xr.Dataset) -> Group:
    """Title, provenance and the numbers of one run; its window stands in its configuration."""
    attrs, record = dataset.attrs, json.loads(dataset.attrs["configuration"])
    start, stop = record["record"]["window"]
    drag = within(dataset["drag"], start, stop)
    mean = float(drag.mean())
    values = {
        "mean drag within the window": f"{mean:.0f} N",
        "standard deviation over the run": f"{100.0 * float(drag.std()) / mean:.1f} %",
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
