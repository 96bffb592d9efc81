"""flow.nc: how all beds of a block move, and the snapshots of one run a case.

If the runs do not record the measures, they are computed from the snapshots, chunk by chunk.
"""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from dem.analysis.flow.layout import BEDS, OF_CHUNK
from dem.analysis.one_run import motion_of, names_of, read_run
from dem.base import provenance
from dem.base.errors import InputError
from dem.experiment.config import Replicate, of_values
from dem.experiment.flow_measures import LAYERS
from dem.experiment.motion import Motion
from dem.experiment.observables.flow import VARIABLES as MEASURED
from dem.experiment.observables.flow import lag_of, measured
from dem.io.dataset import attributes, content_of, global_attributes, read, write
from dem.periodic import wrapped
from dem.sweep.combine import combine, shared
from dem.sweep.expand import Block
from dem.sweep.work import Work

MOVED = "snapshot_displacement"


def measure_chunk(
    chunk: Path, output: Path, progress=lambda share: None, shapes: Path | str | None = None
) -> None:
    """Write the measures of all runs of a chunk, NaN for those that failed; shapes: folder of the files
    of shapes of a user's own."""
    values, attrs = read(chunk, (MOVED, "run_id", "failure", "failure_reason"))
    count, snapshots = len(values["run_id"]), len(values[MOVED])
    found = {name: np.full((count, snapshots), np.nan) for name in MEASURED}
    for row, (replicate, own) in enumerate(_runs(chunk, values, attrs)):
        if own is not None:
            motion = motion_of(chunk, replicate.with_shapes(shapes), own)
            for name, each in measured(motion).items():
                found[name][row] = each
        progress((row + 1) / count)
    told = {name: attrs[name] for name in ("git_revision", "source_hash", "values")}
    about = global_attributes("how beds move", "dem flow", **told, versions=provenance.versions())
    write(output, values | found, about, OF_CHUNK)


def _runs(chunk: Path, values: dict, attrs: dict) -> Iterator[tuple[Replicate, dict | None]]:
    """All runs of a chunk and their snapshots; None where a run failed."""
    with content_of(chunk):
        replicates = [of_values(each, str(chunk)) for each in json.loads(attrs["values"])]
        names = tuple(name for name in names_of(replicates[0]) if name != MOVED)
    kept, _ = read(chunk, names)
    for row, replicate in enumerate(replicates):
        own = {name: kept[name][row] for name in names} | {MOVED: values[MOVED]}
        yield replicate, None if values["failure"][row] else own


def sources(work: Work, block: str) -> list[Path]:
    """The files that hold the measures of the runs of a block: its chunks, or what was measured of them beside
    its results; raises InputError where the runs have neither measures nor snapshots, or where they
    are not measured yet."""
    recorded = _recorded(work, block)
    if "flow" in recorded:
        return work.files(block)
    if "snapshots" not in recorded:
        raise InputError(
            f"{work.sweep.title}: its runs record neither snapshots nor flow, so how beds move is not "
            "known; add snapshots to record.observables and run again."
        )
    found = [_measured(work, each.id) for each in work.chunks(block)]
    for path in found:
        if not path.is_file():
            raise InputError(
                f"{path}: it is missing; make it from {work.sweep.results}/chunks/{path.name} "
                "first: dem flow."
            )
    return found


def _measured(work: Work, chunk: str) -> Path:
    """Where the measures of a chunk are."""
    return Path(work.sweep.results) / "flow" / f"{chunk}.nc"


def make_flow(work: Work, block: str, progress=lambda share: None) -> None:
    """Measure the chunks of a block that are not measured yet, and write its flow.nc; nothing where
    its runs are of another experiment, or record neither measures nor snapshots."""
    recorded = _recorded(work, block)
    if not {"flow", "snapshots"} & set(recorded):
        return
    chunks = work.chunks(block) if "flow" not in recorded else []
    for number, chunk in enumerate(chunks):
        measured = _measured(work, chunk.id)
        if not measured.is_file():
            measure_chunk(work.store.file_of(chunk.id), measured, shapes=work.sweep.beside)
        progress((number + 1) / len(chunks))
    write_flow(work, block, Path(work.folder_of(block)) / "flow.nc")


def write_flow(work: Work, block: str, output: Path, progress=lambda share: None) -> None:
    """Write flow.nc of a block from its sources."""
    found = work.block(block)

    def more(file):
        _describe(file, found)
        base = set(found.dims) - {"seed"}
        if "snapshots" in _recorded(work, block) and base in ({"case"}, {"shape"}):
            _keep_beds(file, work, found, base.pop())

    combine(sources(work, block), work.sweep, found, "flow", output, progress, more, work.file)


def _recorded(work: Work, block: str) -> tuple[str, ...]:
    return work.block(block).runs[0].replicate.configuration.recorded


def _describe(file, block: Block) -> None:
    """What readers need to draw beds and to name the lag."""
    moved = file.variables["snapshot_displacement"][...]
    file.setncatts({
        "title": f"{file.title}: how the beds move", "layers": LAYERS,
        "lag": lag_of(moved) * float(moved[1] - moved[0]),
    })  # fmt: skip
    own = shared(
        block, box_width="box_width", cylinder_diameter="cylinder.diameter", periodic="periodic"
    )
    if own.get("periodic") == "none":
        del own["periodic"]
    file.setncatts(own)


def _keep_beds(file, work: Work, found: Block, base: str) -> None:
    """Add the snapshots of the run of the lowest seed of each case that did not fail."""
    chunks = {
        run: work.store.file_of(each.id) for each in work.chunks(found.name) for run in each.runs
    }
    runs = sorted(found.runs, key=lambda run: run.replicate.seed)
    granules = max(run.replicate.shape.granules for run in runs)
    file.createDimension("granule", granules)
    pressed = runs[0].replicate.configuration.packing.pressure is not None
    for name, (dims, *_) in BEDS.items():
        if name == "bed_top_y" and not pressed:
            continue
        made = file.createVariable(
            name, "f8", (base, *dims[1:]), zlib=True, shuffle=True, fletcher32=True,
            fill_value=np.nan,
        )  # fmt: skip
        made.setncatts(attributes(name, BEDS))
    at, kept = found.dims.index(base), set()
    for run in runs:
        row = run.place[at]
        failed = "failure" in file.variables and bool(file.variables["failure"][run.place])
        if row not in kept and not failed:
            kept.add(row)
            chunk = chunks[run.replicate.id]
            _keep_bed(file, row, motion_of(chunk, *read_run(chunk, run.replicate.id)))


def _keep_bed(file, row: int, motion: Motion) -> None:
    """Snapshots of one run; NaN beyond its granules."""
    x, y = np.moveaxis(wrapped(motion.position, motion.periodic), -1, 0)
    axis = np.column_stack([np.zeros_like(motion.cylinder_y), motion.cylinder_y])
    kept = {
        "bed_height": motion.height[0], "bed_top_y": motion.height,
        "bed_cylinder_y": wrapped(axis, motion.periodic)[:, 1],
        "bed_diameter": motion.diameters, "bed_x": x, "bed_y": y, "bed_angle": motion.angle,
    }  # fmt: skip
    for name, found in kept.items():
        if name in file.variables:
            file.variables[name][(row, *(slice(size) for size in np.shape(found)))] = found
