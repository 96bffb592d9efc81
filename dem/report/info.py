"""What a file of results holds, as tables for the terminal (100 columns are enough)."""

from itertools import islice
from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.means import WINDOW, heading, run_means
from dem.analysis.one_run import columns_of, replicate_of
from dem.analysis.statistics import (
    LEVEL,
    by_case,
    half_interval,
    over_seeds,
    summarise,
    takes,
    window_text,
)
from dem.analysis.tables import digits, numbers
from dem.analysis.values import designs_of, factors_of, value_of
from dem.base.errors import InputError
from dem.base.schema import seed_words
from dem.io.dataset import LABELS
from dem.io.lazily import open_lazily, require
from dem.sweep.combine import open_combined

ROWS = 60  # of a table, at most
LEGEND = """\
mean drag within the window; 95 % interval of the mean by Student's t over the runs; standard
deviation of the drag over a run and of the means between runs, both over the mean drag; how many runs
a mean within 5 % takes; where the file has them, greatest overlap over the smaller granule radius,
median time step and mean processor time of a run"""
FEW = 3  # runs below which the scatter, and so every interval, is a guess
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
            return _runs(path, dataset)
        if "drag" not in dataset:
            return _told(dataset.attrs, _runs_of(dataset), *means_table(path, dataset))
    with open_combined(path) as dataset:
        require(dataset, path, {}, (), (*ORIGIN, "configuration"))
        return _sweep(dataset)


def _study_of(path: Path, dataset: xr.Dataset) -> str:
    """What shows the file of a study, as the file itself says who wrote it."""
    writer, _, rest = str(dataset.attrs.get("source", "")).partition(" -m studies ")
    return f"; {writer} -m studies {rest.split()[0]} info {path} shows this one" if rest else ""


def drag_table(dataset: xr.Dataset) -> tuple[Table, int]:
    """Mean drag and scatter, one row per place on the axes, and the number of rows left out."""
    if (cases := by_case(dataset)) is None:
        return _table(dataset, _of_drag(dataset))
    columns = {
        "kind": (cases["kind"], ""),
        "ratio": (cases["aspect_ratio"], "g"),
        "D_g\nµm": (1e6 * cases["diameter"], ".4g"),
        "density\nkg/m³": (cases["density"], "g"),
    }
    return _table(cases, columns | _of_drag(cases))


def _of_drag(dataset: xr.Dataset) -> dict[str, tuple[xr.DataArray, str]]:
    """Columns of drag as _table has them."""
    found = summarise(dataset)
    mean, size = found["mean"], abs(found["mean"])
    overlap, step, spent = (
        dataset.get(name, np.nan * mean) for name in ("max_overlap", "time_step", "run_time")
    )
    if step.chunks:  # a median needs all values of a place, one place after another
        step = step.chunk({dim: 1 if dim in mean.dims else -1 for dim in step.dims})
    middle = step.median(set(step.dims) - set(mean.dims))
    return {
        "runs": (found["run_mean"].count("seed"), ""),
        "mean\nN": (mean, ".0f"),
        "95 %\n± N": (found["half_interval"], ".0f"),
        "sd of\nrun %": (100.0 * found["sd_over_run"] / size, ".1f"),
        "betw.\nruns %": (100.0 * found["sd_between_runs"] / size, ".1f"),
        "runs\nfor 5 %": (takes(found["run_mean"], 0.05), ".0f"),
        "over-\nlap": (overlap.max(set(overlap.dims) - set(mean.dims)), ".3f"),
        "step\nns": (1e9 * middle.compute(scheduler="synchronous"), ".1f"),
        "run\ns": (spent.mean(set(spent.dims) - set(mean.dims)), ".1f"),
    }


def _table(dataset: xr.Dataset, columns: dict[str, tuple[xr.DataArray, str]]) -> tuple[Table, int]:
    """One row per place on the axes, the last one fastest, and the number of rows left out.

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
        words = [_text(each, form) for each in by_place[:ROWS].tolist()]
        if set(words) != {"-"}:
            cells[name] = words
    table = numbers(*cells, rows=zip(*cells.values(), strict=True))
    return table, max(0, places.size - ROWS)


def _text(value, form: str) -> str:
    """A value as text, a dash where there is no number."""
    if not isinstance(value, float):
        return str(value)
    return format(value, form) if np.isfinite(value) else "-"


def plain_table(frame) -> Table:
    """A table of numbers and words as it is, its first rows."""
    rows = frame.head(ROWS).itertuples(index=False)
    rows = ((_text(each, ".5g") for each in row) for row in rows)
    table = numbers(*map(str, frame.columns), rows=rows)
    if len(frame) > ROWS:
        table.caption = f"and {len(frame) - ROWS} rows more; -o table.csv has all"
    return table


def _sweep(dataset: xr.Dataset) -> Group:
    """Title, provenance and the table of drag.nc."""
    attrs = dataset.attrs
    table, more = drag_table(dataset)
    speed = _range(value_of(dataset, "cylinder.velocity"))
    window = f"{window_text(dataset)} of displacement, cylinder at {speed} m/s"
    about = _runs_of(dataset) | {"window": window}
    return _told(attrs, about, table, more, LEGEND + _few(dataset["drag"]))


def _few(values: xr.DataArray) -> str:
    """A sentence where some places have too few runs for an interval; "" where none has."""
    count = over_seeds(values.isel(displacement=0, missing_dims="ignore")).count("seed")
    few = int((count < FEW).sum())
    return f"\nOf {few} of {count.size} places there are fewer than {FEW} runs: their intervals are guesses." if few else ""


def _range(values: xr.DataArray) -> str:
    """A number, or the least and the greatest of those that vary."""
    ends = dict.fromkeys((float(values.min()), float(values.max())))
    return " to ".join(f"{end:g}" for end in ends)


def _runs_of(dataset: xr.Dataset) -> dict[str, str]:
    """Seeds of the runs of a combined file, how many there are so far, and which are missing and why."""
    told = {"seeds": seed_words(dataset["seed"].values.ravel()) if "seed" in dataset else "-"}
    if "partial" in dataset.attrs:
        told["so far"] = dataset.attrs["partial"]
    if "failure" in dataset and (missing := _missing(dataset["failure"], int((dataset["run_id"] != "").sum()))):
        told["missing"] = missing
    return told


def _told(attrs: dict, about: dict, table: Table, more: int = 0, legend: str = "") -> Group:
    """Title, where the numbers come from, more about them, and a table of which `more` rows are left out.

    There is more than one source hash where runs differ.
    """
    lines = {
        "written": attrs["history"],
        "revision": attrs["git_revision"],
        "sources": ", ".join(each[:16] for each in attrs["source_hash"].split("; ")),
        "versions": attrs["versions"],
        **about,
    }
    origin = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
    for name, line in lines.items():
        origin.add_row(name, Text(line))
    rest = [Text(f"... and {more} rows more; figure sweep shows all.")] if more else []
    return Group(Text(attrs["title"], style="bold"), origin, "", table, *rest, Text(legend, style="dim"))


def means_table(path: Path, dataset: xr.Dataset) -> tuple[Table, int]:
    """Means of the first quantities of a combined file without drag, over the runs, and the number of
    rows left out."""
    runs = run_means(path, dataset, MEANS)
    counts = xr.Dataset(runs).count("seed").to_array()
    counts = xr.apply_ufunc(
        _range, counts, input_core_dims=[["variable"]], vectorize=True, output_dtypes=[object]
    )
    columns = {"runs": (counts, "")} | {
        f"{heading(values)}\n± {LEVEL:.0%}": (_with_interval(values), "") for values in runs.values()
    }
    return _table(dataset, columns)


def _with_interval(sample: xr.DataArray) -> xr.DataArray:
    """Mean over the runs and half its interval as text."""

    def words(mean, half):
        return f"{_text(mean, '.4g')} ± {_text(half, '.2g')}"

    mean, half = sample.mean("seed"), half_interval(sample)
    return xr.apply_ufunc(words, mean, half, vectorize=True, output_dtypes=[object])


def _runs(path: Path, dataset: xr.Dataset) -> Group:
    """The runs of a file of runs, one row each."""
    attrs, whole = dataset.attrs, dataset
    dataset = dataset.isel(run=slice(ROWS))
    replicates = [replicate_of(path, dataset, row) for row in range(dataset.sizes["run"])]
    varied = {
        name: values[:ROWS] for name, values in columns_of(whole).items()
        if name not in LABELS and len(set(values.tolist())) > 1
    }  # fmt: skip
    told = {
        "run": [run[:12] for run in dataset["run_id"].values.tolist()],
        "shape": [each.label for each in replicates],
        "density\nkg/m³": [f"{each.density:g}" for each in replicates],
        "seed": [each.seed for each in replicates],
        **dict(islice(varied.items(), VARIED)),
    }
    columns = {name: (xr.DataArray(values, dims="run"), ".5g") for name, values in told.items()}
    if "drag" in dataset:
        window = dict(zip(WINDOW, replicates[0].configuration.record.window, strict=True))
        columns |= _of_drag(dataset.assign_attrs(window))
        del columns["runs"]  # one each
    failed = [each.strip()[:60] for each in dataset["failure_reason"].values.tolist()]
    columns["processor\ntime s"] = dataset["spent"], ".1f"
    columns["failed"] = xr.DataArray(failed, dims="run"), ""
    table, _ = _table(dataset, columns)
    return _told(attrs, {}, table, whole.sizes["run"] - len(replicates))


def _missing(failure: xr.DataArray, total: int) -> str:
    """How many runs failed of all, by the flags of the variable; "" where none did."""
    meanings = failure.attrs["flag_meanings"].split()
    counts = np.bincount(failure.values.ravel(), minlength=len(meanings))
    words = [f"{n} {word}" for n, word in zip(counts[1:], meanings[1:], strict=True) if n]
    why = f" ({failure.attrs['comment']})" if "comment" in failure.attrs else ""
    return f"{counts[1:].sum()} of {total} runs: {', '.join(words)}{why}" if words else ""
