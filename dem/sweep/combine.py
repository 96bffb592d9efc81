"""The runs of a block in one file, over its axes: drag.nc over (case, seed, displacement).

Batches are read one after another (netCDF4 is not safe with threads) and written at once: at any
moment one batch, and the few blocks of the file that are not full yet, are in memory, however many
there are. What has a value for every granule stays in the batches, but for the beds of
snapshots.nc."""

import json
from collections import Counter
from functools import reduce
from itertools import groupby
from pathlib import Path

import numpy as np

from dem.base.errors import InputError, RunError
from dem.experiment.config import Entry
from dem.io.dataset import (
    LABELS,
    OF_STORE,
    OF_SWEEP,
    REPLICATES,
    add,
    add_dimensions,
    attributes,
    content_of,
    create,
    global_attributes,
    read,
)
from dem.sweep.axis import OWN
from dem.sweep.config import Sweep
from dem.sweep.expand import Block

PROVENANCE = ("versions", "git_revision", "source_hash", "processor")
BLOCK = 64  # runs along the last axis that are kept, compressed and read together
BEDS = "snapshots"  # the observable whose file has values for every granule, of the first seeds
REASONS = 5  # of failed runs that a file tells, at most
HELD = 8_000_000  # bytes of a variable that are in memory until they are written


def combine(
    paths: list[Path],
    sweep: Sweep,
    block: Block,
    observable: str,
    output: Path,
    progress=lambda done: None,
    attrs: dict | None = None,
    partial: bool = False,
) -> None:
    """Write what an observable gave for all runs of a block.

    paths:   files of batches in any order; runs of other sweeps in them are left out
    attrs:   attributes of the file, beside its title and the provenance of the runs
    partial: what no file holds is a gap, and the attribute `partial` says how many runs there are

    The file is written atomically and without loss. Where the sweep allows failures, those are gaps
    (NaN) and `failure` tells why; so are seeds that a place has no replicate of. Raises InputError
    for a damaged file and for a run that no file holds; RunError where too many runs failed, or
    all of a case or shape.
    """
    layout, names = layout_of(block, observable)
    left, failed = set(block.points), []
    gaps = bool(sweep.failures or partial or block.until or observable == BEDS)
    provenance = {name: {} for name in PROVENANCE}
    with create(output) as file:
        for done, path in enumerate(sorted(paths, key=str)):
            values, batch_attrs = read(path, (*names, "run_id", "failure", "failure_reason"))
            given = {name: values[name] for name in names}
            rows = {run: row for row, run in enumerate(values["run_id"].tolist()) if run in left}
            left -= rows.keys()
            if rows and not file.dimensions:
                _make_room(file, block, layout, given, gaps)
            with content_of(path):
                for name in PROVENANCE:
                    provenance[name][batch_attrs.get(name, "unknown")] = None
                places = sorted((p, row) for run, row in rows.items() for p in block.points[run])
                _fill(file, given, places)
            failed += [
                (place, int(values["failure"][row]), str(values["failure_reason"][row]))
                for place, row in places
                if values["failure"][row]
            ]
            progress((done + 1) / len(paths))
        if left and partial and file.dimensions:
            total = len(block.points)
            file.setncattr("partial", f"{total - len(left)} of {total} runs")
            for place in (place for run in left for place in block.points[run]):
                file.variables["run_id"][place] = np.bytes_()
                if block.until:
                    file.variables[REPLICATES][block.without_seed(place)] -= 1
        elif left:
            missing = next(run for run in block.runs.values() if run.id in left)
            raise InputError(f"{missing.words()} is in none of the {len(paths)} files; run again.")
        if not (partial or (observable == BEDS and sweep.failures)):
            _check(sweep, block, sorted(failed))
        if gaps:
            for place, flag, _ in failed:
                file.variables["failure"][place] = flag
            if reasons := list(dict.fromkeys(reason for *_, reason in failed)):
                file.variables["failure"].comment = "; ".join(reasons[:REASONS])
        merged = {name: "; ".join(kept) for name, kept in provenance.items()}
        file.setncatts(about(sweep, block, merged) | (attrs or {}))


def layout_of(block: Block, observable: str) -> tuple[dict, list[str]]:
    """Layout of the combined file, and the names of what its runs give."""
    configuration = block.first.configuration
    experiment = configuration.module
    recorded, variables = experiment.layout(configuration), {}
    for name, entry in experiment.variables(configuration, observable).items():
        if name in recorded and (observable == BEDS or "granule" not in entry[0]):
            variables[name] = entry
    store = {name: OF_STORE[name] for name in ("run_id", "bed_family", "failure")}
    layout = {
        name: ((*block.dims, *dims), *rest) for name, (dims, *rest) in (variables | store).items()
    }
    used = {dim for dims, *_ in variables.values() for dim in dims}
    axes = experiment.along(configuration)
    return layout | {n: entry for n, entry in axes.items() if set(entry[0]) & used}, list(variables)


def _make_room(file, block: Block, layout: dict, sample: dict, gaps: bool) -> None:
    """Dimensions, axes, labels and empty variables; gaps: whether runs may be missing, which a
    variable then has a value for."""
    first = block.first.configuration
    axes = first.module.axes(first)
    for run in {id(run.configuration): run for run in block.runs.values()}.values():
        for name, values in run.configuration.module.axes(run.configuration).items():
            if not np.array_equal(values, axes[name]):
                raise InputError(
                    f"the coordinate {name} must be the same in all runs of {block.name}; use "
                    "blocks."
                )
    for axis in block.axes:
        file.createDimension(axis.name, len(axis.points))
    labels = block.labels()
    for axis in block.axes:
        _write(file, axis.name, (axis.name,), np.asarray(axis.coordinate), axis.entry)
    for name, values in axes.items():
        if name in layout:
            dims = layout[name][0]
            add_dimensions(file, dims, values.shape)
            _write(file, name, dims, values, layout=layout)
    for name, (entry, dims, values) in labels.items():
        _write(file, name, dims, np.asarray(values), entry)
    of_runs = {"run_id": "id"} | ({"bed_family": "bed_family"} if "jam_fraction" in layout else {})
    for name, attribute in of_runs.items():
        texts = np.full(block.shape, "", object)
        for point, run in block.runs.items():
            texts[point] = getattr(run, attribute)
        _write(file, name, block.dims, texts, layout=layout)
    aside = " ".join(labels)
    if block.until:
        array = np.zeros([len(axis.points) for axis in block.beside_seed], np.int64)
        for place, count in block.counts.items():
            array[place] = count
        _write(file, REPLICATES, [axis.name for axis in block.beside_seed], array)
        file.variables[REPLICATES].setncatts(block.until.model_dump())
    most = max(run.shape.granules for run in block.runs.values())
    for name, values in sample.items():
        dims = layout[name][0][len(block.dims) :]
        shape = [
            most if dim == "granule" else size
            for dim, size in zip(dims, values.shape[1:], strict=True)
        ]
        sizes = (*[1] * (len(block.dims) - 1), min(BLOCK, block.shape[-1]), *shape)
        add_dimensions(file, dims, shape)
        variable = file.createVariable(
            name,
            values.dtype,
            layout[name][0],
            zlib=True,
            complevel=4,
            shuffle=True,
            fletcher32=True,
            chunksizes=sizes,
            fill_value=np.nan if gaps else False,
        )
        # runs mostly come in order, and what is full is written and forgotten
        size = 2 * int(np.prod(sizes)) * values.dtype.itemsize
        variable.set_var_chunk_cache(
            size=max(size, 4096, min(HELD, 64 * size)), nelems=1009, preemption=1.0
        )
        variable.setncatts(attributes(name, layout) | ({"coordinates": aside} if aside else {}))
    if gaps:
        variable = file.createVariable(
            "failure", "i1", block.dims, fletcher32=True, fill_value=False
        )
        variable.setncatts(attributes("failure", layout))
        variable[...] = 0


def _write(
    file, name: str, dims, values: np.ndarray, entry: Entry | None = None, layout=None
) -> None:
    """An axis or a label."""
    known = LABELS | OF_SWEEP | (layout or {})
    if entry is not None and entry.about:
        known |= {name: (dims, entry.units, entry.about)}
    if values.dtype == bool:  # netCDF has no truth values
        values = values.astype("i1")
    if values.dtype == object:
        values = values.astype(str)
    add(file, name, tuple(dims), values, attributes(name, known), fill_value=False)


def _fill(file, values: dict, places: list[tuple[tuple[int, ...], int]]) -> None:
    """Write rows at their places; what is side by side along the last axis at once."""
    for _, some in groupby(
        enumerate(places), lambda item: (item[1][0][:-1], item[1][0][-1] - item[0])
    ):
        points, rows = zip(*(place for _, place in some), strict=True)
        there = (*points[0][:-1], slice(points[0][-1], points[0][-1] + len(rows)))
        for name in values.keys() & file.variables.keys():
            of_run = map(slice, values[name].shape[1:])  # some have fewer granules than others
            file.variables[name][(*there, *of_run)] = values[name][list(rows)]


def _check(sweep: Sweep, block: Block, failed) -> None:
    """Raise RunError where more runs failed than the sweep allows, or all of a case or shape."""
    if not failed:
        return
    groups = Counter(run.words().partition(",")[0] for run in block.runs.values())
    fails = Counter(block.runs[point].words().partition(",")[0] for point, *_ in failed)
    for group, count in fails.items():
        if count == groups[group]:
            raise RunError(
                f"{group}: none of its {count} runs could be made ({failed[0][2]}); take it out of "
                "the configuration, or change its values."
            )
    if len(failed) > sweep.failures * len(block.runs) + 1e-9:  # 0.29 * 100 is a little less than 29
        first = block.runs[failed[0][0]]
        raise RunError(
            f"{len(failed)} of {len(block.runs)} runs could not be made; failures allows "
            f"{sweep.failures:g} of them: change their values, raise failures, or after a change "
            f"of the code use dem sweep FILE --retry. The first is {first.words()}: {failed[0][2]}"
        )


def about(sweep: Sweep, block: Block, provenance: dict) -> dict:
    """Attributes of the file. The averaging window is among them, so that figures need nothing
    else, and the cylinder's velocity where all runs have the same. The configuration is that of
    the sweep with what the block sets for all its runs."""
    configuration, drawn = sweep.dump(), {}
    paths = [path for path in block.paths if path not in OWN]
    values = shared(block, [*paths, "cylinder.velocity"])
    if sweep.record and sweep.cylinder:
        drawn["window_start"], drawn["window_stop"] = sweep.record.window
        if "cylinder.velocity" in values:
            drawn["cylinder_velocity"] = values["cylinder.velocity"]
    for path in set(paths) & values.keys():
        *groups, last = path.split(".")
        reduce(dict.__getitem__, groups, configuration)[last] = values[path]
    return global_attributes(
        sweep.title, "dem sweep", configuration=json.dumps(configuration), **provenance, **drawn
    )


def shared(block: Block, paths: list[str]) -> dict:
    """Values by path that are the same in all runs of a block, or in all of the shape whose value
    it is."""
    values = {path: set() for path in paths}
    for run in block.runs.values():
        for path in paths:
            if not path.startswith("shapes.") or path.split(".")[1] == run.label:
                values[path].add(run.at(path))
    return {path: some.pop() for path, some in values.items() if len(some) == 1}
