"""What a file of results holds, as tables for the terminal (100 columns are enough)."""

from itertools import islice
from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.one_run import columns_of, replicate_of
from dem.analysis.statistics import (
    LEVEL,
    by_case,
    half_interval,
    over_seeds,
    summarise,
    within,
)
from dem.analysis.tables import numbers
from dem.analysis.values import value_of
from dem.base.errors import InputError
from dem.base.schema import seed_words
from dem.experiment.config import Replicate
from dem.io.dataset import LABELS
from dem.io.lazily import open_lazily, require
from dem.sweep.combine import open_combined

ROWS = 60  # of a table, at most
LEGEND = """\
mean drag within the window; 95 % interval of the mean by Student's t over the runs; standard
deviation of the drag over a run and of the means between runs, both over the mean drag; greatest
overlap over the smaller granule radius; median time step; mean processor time of a run"""
OF_CASES = ("kind", "ratio", "D_g\nµm", "density\nkg/m³")  # beside the case
OF_DRAG = (
    "runs", "mean\nN", "95 %\n± N", "sd over\nrun %", "sd betw.\nruns %", "great.\noverlap", "step\nns",
    "run\ntime s",
)  # fmt: skip
ORIGIN = ("title", "history", "git_revision", "source_hash", "versions")
WINDOW = ("window_start", "window_stop")
OF_A_RUN = ("drag", "displacement", "max_overlap", "time_step", "run_time", "packing_pressure")
RUN = ("shape", "density\nkg/m³", "seed")
RUN_OF_DRAG = ("mean\nN", "sd over\nrun %", "great.\noverlap", "step\nns", "pressure\nMPa")
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
            return _means(path, dataset)
    with open_combined(path) as dataset:
        require(dataset, path, {}, OF_A_RUN, (*ORIGIN, "configuration"))
        return _sweep(dataset)


def _study_of(path: Path, dataset: xr.Dataset) -> str:
    """What shows the file of a study, as the file itself says who wrote it."""
    writer, _, rest = str(dataset.attrs.get("source", "")).partition(" -m studies ")
    return f"; {writer} -m studies {rest.split()[0]} info {path} shows this one" if rest else ""


def drag_table(dataset: xr.Dataset) -> tuple[Table, int]:
    """Mean drag and scatter, one row per place on the axes, and the number of rows left out."""
    cases = by_case(dataset)
    dataset = dataset if cases is None else cases
    found, axes = summarise(dataset), _axes(dataset)
    table = numbers(*axes, *(OF_CASES if cases is not None else ()), *OF_DRAG)
    for place in islice(_places(dataset, axes), ROWS):
        about, own = dataset.isel(place), found.isel(place)
        labels = [_word(own[axis]) for axis in axes]
        labels += _of_case(about) if cases is not None else []
        table.add_row(*labels, *_of_drag(about, own))
    return table, max(0, _count(dataset, axes) - ROWS)


def _axes(dataset: xr.Dataset) -> list[str]:
    """What the rows of a table differ in."""
    return [str(dim) for dim in dataset["run_id"].dims if dim != "seed"]


def _places(dataset: xr.Dataset, axes: list[str]):
    """Places on some axes, the last one fastest."""
    return (
        dict(zip(axes, at, strict=True)) for at in np.ndindex(*(dataset.sizes[a] for a in axes))
    )


def _count(dataset: xr.Dataset, axes: list[str]) -> int:
    return int(np.prod([dataset.sizes[axis] for axis in axes]))


def _word(value) -> str:
    """A value of an axis."""
    value = np.asarray(value).item()
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _of_case(about: xr.Dataset) -> list[str]:
    return [
        str(about["kind"].values),
        _number(about["aspect_ratio"], "g"),
        _number(1e6 * about["diameter"], ".4g"),
        _number(about["density"], "g"),
    ]


def _of_drag(about: xr.Dataset, own: xr.Dataset) -> list[str]:
    """Cells in the order of OF_DRAG."""
    mean = own["mean"]
    return [
        str(int(own["run_mean"].count())),
        _number(mean, ".0f"),
        _number(own["half_interval"], ".0f"),
        _number(100.0 * own["sd_over_run"] / mean, ".1f"),
        _number(100.0 * own["sd_between_runs"] / mean, ".1f"),
        *_of_steps(about),
        _number(about["run_time"].mean(), ".1f"),
    ]


def _of_steps(about: xr.Dataset) -> list[str]:
    """Greatest overlap and median time step."""
    step = 1e9 * np.nanmedian(about["time_step"])
    return [_number(about["max_overlap"].max(), ".3f"), _number(step, ".1f")]


def _sweep(dataset: xr.Dataset) -> Group:
    """Title, provenance and the table of drag.nc."""
    attrs = dataset.attrs
    table, more = drag_table(dataset)
    window = f"{_millimetres(*(attrs[name] for name in WINDOW))} of displacement"
    lines = _provenance(
        attrs, seeds=_seeds(dataset),
        window=f"{window}, cylinder at {_range(value_of(dataset, 'cylinder.velocity'))} m/s",
    )  # fmt: skip
    if "failure" in dataset and (missing := _missing(dataset["failure"])):
        lines.add_row("missing", missing)
    return _told(attrs, lines, table, more, LEGEND)


def _range(values: xr.DataArray) -> str:
    """A number, or the least and the greatest of those that vary."""
    ends = dict.fromkeys((float(values.min()), float(values.max())))
    return " to ".join(f"{end:g}" for end in ends)


def _seeds(dataset: xr.Dataset) -> str:
    return seed_words(dataset["seed"].values.ravel()) if "seed" in dataset else "-"


def _told(attrs: dict, lines: Table, table: Table, more: int = 0, legend: str = "") -> Group:
    parts = [Text(attrs["title"], style="bold"), lines, "", table]
    if more:
        parts.append(Text(f"... and {more} rows more; figure sweep shows all."))
    return Group(*parts, Text(legend, style="dim"))


def _means(path: Path, dataset: xr.Dataset) -> Group:
    """Means of the first quantities of a combined file without drag, over the runs."""
    axes, attrs = _axes(dataset), dataset.attrs
    dims = set(dataset["run_id"].dims)
    names = [
        str(name) for name, values in dataset.data_vars.items()
        if dims <= set(values.dims) and values.dtype.kind == "f"
    ][:MEANS]  # fmt: skip
    inside = dataset
    if "snapshot_displacement" in dataset:
        require(dataset, path, {}, (), WINDOW)
        moved = dataset["snapshot_displacement"].values
        held = (moved >= attrs["window_start"]) & (moved <= attrs["window_stop"])
        inside = dataset.isel(snapshot=np.flatnonzero(held))
    runs = {
        name: over_seeds(inside[name].mean(set(inside[name].dims) - dims).compute())
        for name in names
    }
    table = numbers(*axes, "runs", *(f"{name}\n± {LEVEL:.0%}" for name in names))
    halves = {name: half_interval(values) for name, values in runs.items()}
    for place in islice(_places(dataset, axes), ROWS):
        cells = [
            f"{_number(values.isel(place).mean(), '.4g')} ± {_number(halves[name].isel(place), '.2g')}"
            for name, values in runs.items()
        ]
        count = max((int(values.isel(place).count()) for values in runs.values()), default=0)
        table.add_row(
            *(_word(dataset[axis].values[place[axis]]) for axis in axes), str(count), *cells
        )
    told = [Text(each) for each in _verdict(dataset)]
    more = max(0, _count(dataset, axes) - ROWS)
    group = _told(attrs, _provenance(attrs, seeds=_seeds(dataset)), table, more)
    return Group(group, *told)


def _verdict(dataset: xr.Dataset) -> list[str]:
    """What flow.nc says of the paper's sentence on irregularity."""
    cases = by_case(dataset)
    if cases is None or "non_affine" not in dataset:
        return []
    from dem.analysis.flow.verdict import sentences, verdict

    return [verdict(cases), *sentences(cases)]


def _runs(path: Path, dataset: xr.Dataset) -> Group:
    """The runs of a file of runs, one row each."""
    attrs, count = dataset.attrs, dataset.sizes["run"]
    replicates = [replicate_of(path, dataset, row) for row in range(min(count, ROWS))]
    of_drag = "drag" in dataset
    if of_drag:
        require(dataset, path, {}, OF_A_RUN)
    varied = [each for each in columns_of(dataset) if len(set(each.values.tolist())) > 1]
    varied = [each for each in varied if each.name not in LABELS][:VARIED]
    names = (each.name for each in varied)
    table = numbers(
        "run", *RUN, *names, *(RUN_OF_DRAG if of_drag else ()), "processor\ntime s", "failed"
    )
    for row, replicate in enumerate(replicates):
        one = dataset.isel(run=row)
        table.add_row(
            str(one["run_id"].values)[:12], replicate.label, f"{replicate.density:g}",
            str(replicate.seed), *(_word(each.values[row]) for each in varied),
            *(_of_one(one, replicate) if of_drag else ()), _number(one.get("spent", np.nan), ".1f"),
            str(one["failure_reason"].values).strip()[:60],
        )  # fmt: skip
    return _told(attrs, _provenance(attrs), table, count - len(replicates))


def _of_one(one: xr.Dataset, replicate: Replicate) -> list[str]:
    """Cells in the order of RUN_OF_DRAG."""
    drag = within(one["drag"], *replicate.configuration.record.window)
    return [
        _number(drag.mean(), ".0f"),
        _number(100.0 * drag.std() / drag.mean(), ".1f"),
        *_of_steps(one),
        _number(1e-6 * one["packing_pressure"], ".3g"),
    ]


def _missing(failure: xr.DataArray) -> str:
    """How many runs failed, by the flags of the variable; "" where none did."""
    meanings = failure.attrs["flag_meanings"].split()
    counts = np.bincount(failure.values.ravel(), minlength=len(meanings))
    words = [f"{n} {word}" for n, word in zip(counts[1:], meanings[1:], strict=True) if n]
    return f"{counts[1:].sum()} of {failure.size} runs: {', '.join(words)}" if words else ""


def _provenance(attrs: dict, **more: str) -> Table:
    """Where the numbers come from, one line each; more than one source hash where runs differ."""
    return _plain({
        "written": attrs["history"],
        "revision": attrs["git_revision"],
        "sources": ", ".join(each[:16] for each in attrs["source_hash"].split("; ")),
        "versions": attrs["versions"],
        **more,
    })  # fmt: skip


def _plain(lines: dict[str, str]) -> Table:
    """Names and texts without headings."""
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, show_header=False)
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
