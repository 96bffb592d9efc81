"""What a file of results holds, as tables for the terminal and the report."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from rich.console import Group
from rich.text import Text

from dem.analysis.means import WINDOW, heading, quantities_of, run_means
from dem.analysis.one_run import replicate_of, values_of_runs
from dem.analysis.statistics import by_case, over_seeds, summarise, window_text
from dem.analysis.tables import Shown, digits
from dem.analysis.values import designs_of, factors_of, value_of
from dem.base.errors import InputError
from dem.base.intervals import half_interval
from dem.base.schema import seed_words
from dem.io.dataset import LABELS
from dem.io.lazily import open_lazily, require
from dem.sweep.combine import open_combined

LEGEND = """\
mean: of the drag within the window; ±: half its 95 % interval by Student's t over the runs; over run and
between runs: standard deviations over the mean; overlap: the greatest, over the smaller granule radius"""
ORIGIN = ("title", "history", "git_revision", "source_hash", "versions")
VARIED = 4  # values more that runs of a file differ in, at most
MEANS = 5  # quantities of a file without drag that are shown


def summary(path: Path) -> Group:
    """Renderable summary of a combined file or a file of runs; raises InputError for other files."""
    with open_lazily(path) as dataset:
        if "run_id" not in dataset:
            raise InputError(
                f"{path}: it holds no runs; name drag.nc or a file of runs{_study_of(path, dataset)}."
            )
        require(dataset, path, {}, (), ORIGIN)
        if dataset["run_id"].dims == ("run",):
            return _shown(dataset.attrs, {}, runs_table(path, dataset))
        if "drag" not in dataset:
            return _shown(dataset.attrs, _runs_of(dataset), means_table(path, dataset))
    with open_combined(path) as dataset:
        require(dataset, path, {}, (), (*ORIGIN, "configuration"))
        speed = value_of(dataset, "cylinder.velocity")
        window = f"{window_text(dataset)} of displacement, cylinder at {_range(speed)} m/s"
        return _shown(
            dataset.attrs, _runs_of(dataset) | {"window": window}, drag_table(dataset), LEGEND
        )


def _study_of(path: Path, dataset: xr.Dataset) -> str:
    """What shows the file of a study, as the file itself says who wrote it."""
    writer, _, rest = str(dataset.attrs.get("source", "")).partition(" -m studies ")
    return f"; {writer} -m studies {rest.split()[0]} info {path} shows this one" if rest else ""


def _shown(attrs: dict, about: dict, table: pd.DataFrame, legend: str = "") -> Group:
    """Title, where the numbers come from, more about them, and a table."""
    origin = {
        "written": attrs["history"],
        "revision": attrs["git_revision"],
        "sources": ", ".join(each[:16] for each in attrs["source_hash"].split("; ")),
        "versions": attrs["versions"],
        **about,
    }
    lines = "\n".join(f"{name:9} {line}" for name, line in origin.items())
    title = Text(attrs["title"], style="bold")
    return Group(title, Text(lines), "", Shown(table), "", Text(legend, style="dim"))


def drag_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Mean drag and scatter, one row per place on the axes."""
    columns = {}
    if (cases := by_case(dataset)) is not None:
        dataset = cases
        columns = {
            "kind": (cases["kind"], ""),
            "ratio": (cases["aspect_ratio"], "g"),
            "D_g µm": (1e6 * cases["diameter"], ".4g"),
            "kg/m³": (cases["density"], "g"),
        }
    found = summarise(dataset)
    mean, size = found["mean"], abs(found["mean"])
    columns |= {
        "runs": (found["run_mean"].count("seed"), ""),
        "mean N": (mean, ".0f"),
        "± N": (found["half_interval"], ".0f"),
        "over run %": (100.0 * found["sd_over_run"] / size, ".1f"),
        "between runs %": (100.0 * found["sd_between_runs"] / size, ".1f"),
    }
    if "max_overlap" in dataset:
        overlap = dataset["max_overlap"]
        columns["overlap"] = overlap.max(set(overlap.dims) - set(mean.dims)), ".3f"
    return _table(dataset, columns)


def means_table(path: Path, dataset: xr.Dataset) -> pd.DataFrame:
    """Means of the first quantities of a combined file without drag, with half their intervals."""
    runs = run_means(dataset, path, quantities_of(dataset)[:MEANS])
    columns = {"runs": (runs.count("seed").to_array().max("variable"), "")}
    for name, values in runs.items():
        columns[heading(values)] = values.mean("seed"), ".4g"
        columns[f"± {name}"] = half_interval(values), ".2g"
    return _table(dataset, columns)


def runs_table(path: Path, dataset: xr.Dataset) -> pd.DataFrame:
    """The runs of a file of runs, one row each."""
    values = values_of_runs(dataset)
    varied = [name for name in values if name not in LABELS and values[name].nunique() > 1]
    frame = values[["shape", "density", "seed", *varied[:VARIED]]].reset_index(names="run")
    frame["run"] = frame["run"].str[:12]
    if record := replicate_of(path, dataset, 0).configuration.record:
        dataset = dataset.assign_attrs(dict(zip(WINDOW, record.window, strict=True)))
    frame = frame.join(means_table(path, dataset).drop(columns="runs"))
    return frame.assign(failed=dataset["failure_reason"].str.slice(0, 60))


def _table(dataset: xr.Dataset, columns: dict[str, tuple[xr.DataArray, str]]) -> pd.DataFrame:
    """One row per place on the axes, the last one fastest, as text.

    columns: values over some of the axes by heading, and the format of their numbers; those without any
    number are left out.
    """
    places = over_seeds(dataset["run_id"]).isel(seed=0)
    axes, designs, cells = {}, designs_of(places), {}
    for dim in (str(dim) for dim in places.dims if dim != "run"):
        for name in factors_of(dataset, dim)[:VARIED] if dim in designs else [dim]:
            axes[name] = dataset[name], digits(dataset[name].values.ravel().tolist())
    for name, (values, form) in (axes | columns).items():
        by_place = values.broadcast_like(places).transpose(*places.dims).values.ravel()
        words = [_text(each, form) for each in by_place.tolist()]
        if not {"-", ""}.issuperset(words):
            cells[name] = words
    return pd.DataFrame(cells)


def _text(value, form: str) -> str:
    """A value as text, a dash where there is no number."""
    if not isinstance(value, float):
        return str(value)
    return format(value, form) if np.isfinite(value) else "-"


def _range(values) -> str:
    """A number, or the least and the greatest of those that vary."""
    ends = dict.fromkeys((float(values.min()), float(values.max())))
    return " to ".join(f"{end:g}" for end in ends)


def _runs_of(dataset: xr.Dataset) -> dict[str, str]:
    """Seeds of the runs of a combined file, how many there are so far, and which are missing and why."""
    told = {"seeds": seed_words(dataset["seed"].values.ravel()) if "seed" in dataset else "-"}
    if "partial" in dataset.attrs:
        told["so far"] = dataset.attrs["partial"]
    if "failure" in dataset and (failed := int((dataset["failure"] != 0).sum())):
        total, why = int((dataset["run_id"] != "").sum()), dataset["failure"].attrs.get("comment")
        told["missing"] = f"{failed} of {total} runs failed ({why})"
    return told
