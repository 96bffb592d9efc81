"""What a file of results holds, as tables for the terminal and the report."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from rich.console import Group
from rich.text import Text

from dem.analysis.drag import summarise, window_text
from dem.analysis.means import WINDOW, heading, means_of, quantities_of, run_means, table_of
from dem.analysis.one_run import replicate_of
from dem.analysis.tables import TextTable
from dem.analysis.values import designs_of, value_of
from dem.base.errors import InputError
from dem.io.dataset import LABELS
from dem.io.lazily import open_lazily, require_drag
from dem.sweep.selection import values_of_runs

LEGEND = """\
mean: of the drag within the window; ±: half its 95 % interval by Student's t over the runs;
over run and between runs: standard deviations, divided by the mean; independent: samples that one
run is worth, their ratio squared; overlap: the greatest, divided by the smaller granule radius"""
VARIED = 4  # values more that runs of a file differ in, at most
MEANS = 5  # quantities of a file without drag that are shown


def summary(path: Path) -> Group:
    """Renderable summary of a combined file or a file of runs; raises InputError for other
    files."""
    with open_lazily(path) as dataset:
        if "run_id" not in dataset:
            raise InputError(f"{path}: it holds no runs; name drag.nc or a file of runs.")
        if dataset["run_id"].dims == ("run",):
            return _shown(dataset.attrs, {}, runs_table(path, dataset))
        if "drag" not in dataset:
            return _shown(dataset.attrs, _runs_of(dataset), means_table(dataset))
        require_drag(dataset, path)
        speed = value_of(dataset, "cylinder.velocity")
        speeds = " to ".join(f"{end:g}" for end in np.unique([speed.min(), speed.max()]))
        window = f"{window_text(dataset)} of displacement, cylinder at {speeds} m/s"
        return _shown(
            dataset.attrs, _runs_of(dataset) | {"window": window}, drag_table(dataset), LEGEND
        )


def _shown(attrs: dict, about: dict, table: pd.DataFrame, legend: str = "") -> Group:
    """Title, where the numbers come from, more about them, and a table."""
    origin = {
        "written": attrs["history"],
        "revision": attrs["git_revision"],
        "sources": ", ".join(code[:16] for code in attrs["source_hash"].split("; ")),
        "versions": attrs["versions"],
        **about,
    }
    lines = "\n".join(f"{name:9} {line}" for name, line in origin.items())
    title = Text(attrs["title"], style="bold")
    return Group(title, Text(lines), "", TextTable(table), "", Text(legend, style="dim"))


def drag_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Mean drag and scatter, one row per point of the axes."""
    result = summarise(dataset)
    mean, size = result["mean"], abs(result["mean"])
    columns = {
        "runs": result["run_mean"].count("seed"),
        "mean (N)": mean,
        "± (N)": result["half_interval"],
        "over run (%)": 100.0 * result["sd_over_run"] / size,
        "between runs (%)": 100.0 * result["sd_between_runs"] / size,
        "independent": (result["sd_over_run"] / result["sd_between_runs"]) ** 2,
    }
    if "max_overlap" in dataset:
        overlap = dataset["max_overlap"]
        columns["overlap"] = overlap.max(set(overlap.dims) - set(mean.dims))
    columns = {name: values.drop_attrs(deep=False) for name, values in columns.items()}
    return brief(xr.Dataset(columns).drop_vars("seed", errors="ignore"))


def means_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Means of the first quantities of a combined file without drag, with half their intervals."""
    return brief(means_of(dataset, quantities_of(dataset)[:MEANS]))


def brief(result: xr.Dataset) -> pd.DataFrame:
    """A table for a terminal: without what belongs to a shape, which its label says, and what is
    the same everywhere; labels of named points last."""
    coords = [values for name, values in result.coords.items() if name not in result.dims]
    left = [values.name for values in coords if {"shape"} >= set(values.dims)]
    frame = table_of(result.drop_vars(left))
    named = {*result.dims}.difference(designs_of(result))
    labels = [
        heading(coord) for coord in coords if coord.name not in left and named >= {*coord.dims}
    ]
    return frame[[*frame.columns.drop(labels), *labels]]


def runs_table(path: Path, dataset: xr.Dataset) -> pd.DataFrame:
    """The runs of a file of runs, one row each, with their means of the first quantities."""
    values = values_of_runs(dataset)
    varied = [name for name in values if name not in LABELS and values[name].nunique() > 1]
    values = values[["shape", "density", "seed", *varied[:VARIED]]]
    record = replicate_of(path, dataset, 0).configuration.record
    if record and record.window:
        dataset = dataset.assign_attrs(dict(zip(WINDOW, record.window, strict=True)))
    result = run_means(dataset, quantities_of(dataset)[:MEANS]).isel(seed=0)
    for quantity in result.values():
        values[heading(quantity)] = quantity.values
    values["failed"] = dataset["failure_reason"].str.slice(0, 60).values
    return values.set_index(values.index.str[:12]).reset_index(names="run")


def _runs_of(dataset: xr.Dataset) -> dict[str, str]:
    """Seeds of the runs of a combined file, how many there are so far, and which are missing and
    why."""
    seeds = dataset["seed"]
    facts = {"seeds": f"{seeds.size}, from {seeds.min():d} to {seeds.max():d}"}
    if "partial" in dataset.attrs:
        facts["so far"] = dataset.attrs["partial"]
    if "failure" in dataset and (failed := int((dataset["failure"] != 0).sum())):
        total, why = int((dataset["run_id"] != "").sum()), dataset["failure"].attrs.get("comment")
        facts["missing"] = f"{failed} of {total} runs failed ({why})"
    return facts
