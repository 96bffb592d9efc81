"""The runs of a block in one file, over its axes: drag.nc over (case, seed, displacement).

Batches are read one after another (netCDF4 is not safe with threads) and written at once: one batch
is in memory, and what the library buffers, however many there are. What has a value for every
granule stays in the batches, but for the beds of snapshots.nc.
"""

import json
import math
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from functools import reduce
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from dem.base.errors import InputError, RunError
from dem.base.messages import say
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
from dem.sweep.axis import RUN_KEYS
from dem.sweep.config import Sweep
from dem.sweep.expand import Block
from dem.sweep.precision import short_of

PROVENANCE = ("versions", "git_revision", "source_hash", "processor", "history")
BLOCK = 64  # runs along the last axis that are compressed and read together, at most
CHUNK = 4_000_000  # bytes that are, at most, and that netCDF buffers of each variable
BEDS = "snapshots"  # the observable whose file has values for every granule, of the first seeds
REASONS = 5  # of failed runs that a file tells, at most


def combine(
    paths: list[Path],
    sweep: Sweep,
    block: Block,
    observable: str,
    output: Path,
    progress=lambda done: None,
    partial: bool = False,
) -> None:
    """Write what an observable gave for all runs of a block.

    paths:   files of batches in any order; runs of other sweeps in them are left out
    partial: what no file holds is a gap, and the attribute `partial` says how many runs there are

    The file is written atomically and without loss. Where the sweep allows failures, those are gaps
    (NaN) and `failure` tells why; so are seeds that a point has no replicate of. Raises InputError
    for a damaged file and for a run that no file holds; RunError where too many runs failed, or
    all of a case or shape.
    """
    layout, names = layout_of(block, observable)
    left, failed = set(block.points), {}
    sizes = {run.granules for run in block.runs.values()}
    gaps = bool(sweep.failures or partial or block.until or observable == BEDS or len(sizes) > 1)
    origins = []
    with create(output) as file:
        for done, path in enumerate(paths, 1):
            values, origin = read(path, (*names, "run_id", "failure", "failure_reason"))
            runs = values["run_id"].tolist()
            places = sorted(
                (place, row)
                for row, run in enumerate(runs)
                if run in left
                for place in block.points[run]
            )
            if places and not file.dimensions:
                _create_variables(file, block, layout, {n: values[n] for n in names}, gaps)
            with content_of(path):
                origins.append({name: origin[name] for name in PROVENANCE})
                for first, group in groupby(places, lambda place: place[0][:-1]):
                    points, rows = zip(*group, strict=True)
                    last = [point[-1] for point in points]
                    for name in names:  # some runs have fewer granules than others
                        array = values[name][list(rows)]
                        of_run = map(slice, array.shape[1:])
                        file.variables[name][(*first, last, *of_run)] = array
            failed |= {
                place: (int(values["failure"][row]), str(values["failure_reason"][row]))
                for place, row in places
                if values["failure"][row]
            }
            left.difference_update(runs)
            progress(done / len(paths))
        if left and not (partial and file.dimensions):
            missing = next(run for run in block.runs.values() if run.id in left)
            raise InputError(f"{missing.words()} is in none of the {len(paths)} files; run again.")
        if not (partial or (observable == BEDS and sweep.failures)):
            _check(sweep, block, failed)
        for variable in _labels(block, layout, left):
            add(file, *variable)
        if gaps:
            flags = np.zeros(block.shape, "i1")
            for place, (flag, _) in failed.items():
                flags[place] = flag
            reasons = list(dict.fromkeys(reason for _, reason in failed.values()))
            comment = {"comment": "; ".join(reasons[:REASONS])} if reasons else {}
            add(file, "failure", block.dims, flags, attributes("failure", layout) | comment)
        merged = {name: "; ".join(dict.fromkeys(o[name] for o in origins)) for name in PROVENANCE}
        # when the last of its runs was made, so that the same runs give the same bytes
        merged["history"] = max(o["history"] for o in origins) + ", dem sweep"
        if left:
            merged["partial"] = f"{len(block.points) - len(left)} of {len(block.points)} runs"
        file.setncatts(about(sweep, block, merged))


def layout_of(block: Block, observable: str) -> tuple[dict, list[str]]:
    """Layout of the combined file, and the names of what its runs give."""
    experiment = block.first.configuration.module
    recorded = experiment.layout
    variables = {
        name: entry
        for name, entry in experiment.variables(observable).items()
        if name in recorded
        and (observable in (BEDS, experiment.label) or "granule" not in entry[0])
    }
    of_runs = variables | {name: OF_STORE[name] for name in ("run_id", "bed_family", "failure")}
    layout = {name: ((*block.dims, *dims), *rest) for name, (dims, *rest) in of_runs.items()}
    used = {dim for dims, *_ in variables.values() for dim in dims}
    axes = experiment.along
    return layout | {n: entry for n, entry in axes.items() if set(entry[0]) & used}, list(variables)


def _create_variables(file, block: Block, layout: dict, values: dict, gaps: bool) -> None:
    """Create the dimensions of a file, and the variables of which a batch has some values, empty.

    gaps: whether runs may be missing, which a variable then has a value for.
    """
    add_dimensions(file, block.dims, block.shape)
    most = max(run.granules for run in block.runs.values())
    labels = " ".join(block.labels())
    for name, array in values.items():
        dims = layout[name][0][len(block.dims) :]
        shape = [
            most if dim == "granule" else size
            for dim, size in zip(dims, array.shape[1:], strict=True)
        ]
        add_dimensions(file, dims, shape)
        fitting = CHUNK // (math.prod(shape) * array.dtype.itemsize)
        runs = max(1, min(BLOCK, block.shape[-1], fitting))
        variable = file.createVariable(
            name,
            array.dtype,
            layout[name][0],
            zlib=True,
            fletcher32=True,
            chunk_cache=CHUNK,
            chunksizes=(*[1] * (len(block.dims) - 1), runs, *shape),
            fill_value=np.nan if gaps else False,
        )
        variable.setncatts(attributes(name, layout) | {"coordinates": labels})


def _labels(block: Block, layout: dict, left: set[str]) -> Iterator[tuple]:
    """Name, dimensions, values and attributes of axes and labels, and of the identities of all runs
    but those that are left out."""
    labels = block.labels()
    for axis in block.axes:
        labels[axis.name] = axis.entry, (axis.name,), axis.coordinate
    for name, (entry, dims, values) in labels.items():
        known = LABELS | OF_SWEEP
        if entry is not None and entry.about:
            known = {name: (dims, entry.units, entry.about)}
        yield name, dims, values, attributes(name, known)
    axes = block.first.configuration.module.axes
    for run in {id(run.configuration): run for run in block.runs.values()}.values():
        for name, values in run.configuration.module.axes.items():
            if not np.array_equal(values, axes[name]):
                raise InputError(
                    f"the coordinate {name} must be the same in all runs of {block.name}; use "
                    "blocks."
                )
    for name, values in axes.items():
        if name in layout:
            yield name, layout[name][0], values, attributes(name, layout)
    ids, families = (np.zeros(block.shape, "U32") for _ in range(2))
    for point, run in block.runs.items():
        if run.id not in left:
            ids[point], families[point] = run.id, run.bed_description.family
    yield "run_id", block.dims, ids, attributes("run_id", layout)
    if "jam_fraction" in layout:
        yield "bed_family", block.dims, families, attributes("bed_family", layout)
    if block.until:
        dims = tuple(axis.name for axis in block.beside_seed)
        attrs = attributes(REPLICATES, OF_SWEEP) | block.until.model_dump()
        yield REPLICATES, dims, (ids != "").sum(block.dims.index("seed")), attrs


def _check(sweep: Sweep, block: Block, failed: dict) -> None:
    """Raise RunError where more runs failed than the sweep allows, or all of a case or shape.

    failed: kind of error and reason, by point.
    """
    if not failed:
        return
    first = min(failed)
    groups, failures = (
        Counter(block.runs[point].words().partition(",")[0] for point in points)
        for points in (block.runs, failed)
    )
    for group, count in failures.items():
        if count == groups[group]:
            raise RunError(
                f"{group}: none of its {count} runs could be made ({failed[first][1]}); take it "
                "out of the configuration, or change its values."
            )
    if len(failed) > sweep.failures * len(block.runs) + 1e-9:  # 0.29 * 100 is a little less than 29
        raise RunError(
            f"{len(failed)} of {len(block.runs)} runs could not be made; failures allows "
            f"{sweep.failures:g} of them: change their values, raise failures, or after a change "
            f"of the code use dem sweep FILE --retry. The first is {block.runs[first].words()}: "
            f"{failed[first][1]}"
        )


def about(sweep: Sweep, block: Block, provenance: dict) -> dict:
    """Attributes of the file. The averaging window is among them, so that figures need nothing
    else, and the cylinder's velocity where all runs have the same. The configuration is the
    sweep's, with what all runs of the block share."""
    configuration, drawn = sweep.dump(), {}
    if sweep.record and sweep.cylinder:
        drawn["window_start"], drawn["window_stop"] = sweep.record.window
        velocities = {run.at("cylinder.velocity") for run in block.runs.values()}
        if len(velocities) == 1:
            drawn["cylinder_velocity"] = velocities.pop()
    for path in block.paths:
        *groups, last = path.split(".")
        values = {
            run.at(path)
            for run in block.runs.values()
            if groups[:1] != ["shapes"] or groups[1] in run.configuration.shapes
        }
        if len(values) == 1 and path not in RUN_KEYS:
            reduce(dict.__getitem__, groups, configuration)[last] = values.pop()
    return global_attributes(
        sweep.title, "dem sweep", configuration=json.dumps(configuration), **provenance, **drawn
    )


def combined_runs(path: Path) -> set[str]:
    """Identities of the runs of a combined file, none where it is not there, damaged or another file."""
    with suppress(InputError):
        return set(map(str, read(path, ("run_id",))[0]["run_id"].ravel().tolist())) - {""}
    return set()


def combine_block(
    state,
    name: str,
    observable: str,
    output: Path,
    progress=lambda done: None,
    partial: bool = False,
) -> None:
    """Write what an observable gave for all runs of a block of a SweepState.

    partial: for those runs that exist. Raises InputError for an observable that the runs lack.
    """
    known = state.observables(name)
    if observable not in known:
        raise InputError(f"observable is {observable!r}; runs of {name} have {', '.join(known)}.")
    block = state.block(name)
    asked = block.until and not partial and observable == known[0]
    if asked and (words := short_of(block, state.values(block))):
        say(words)
    if observable == BEDS:
        block = block.first_seeds()
    places = block.points
    batches = [batch for batch in state.batches(name) if not places.keys().isdisjoint(batch.runs)]
    # in the order of the grid, so that each chunk is compressed once
    batches.sort(key=lambda batch: min(places[run] for run in batch.runs if run in places))
    files = [state.store.file_of(batch.id) for batch in batches]
    with TemporaryDirectory() as folder:
        if partial:
            from dem.sweep.batch_job import write_batch  # with the kernels

            runs, files = {run.id: run for run in block.unique()}, []
            for batch in batches:
                path, kept = state.store.file_of(batch.id), state.store.kept
                if not path.is_file():  # what its runs have so far
                    rows = {run: row for run in batch.runs if run in runs and (row := kept(run))}
                    path = Path(folder, path.name)
                    if rows:
                        write_batch(path, [runs[run] for run in rows], [*rows.values()])
                files += [path] * path.is_file()
            if not files:
                raise InputError(
                    f"no run of {name} is finished yet; dem status shows how far the sweep is."
                )
        combine(files, state.sweep, block, observable, output, progress, partial)
