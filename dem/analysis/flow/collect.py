"""flow.nc: how all beds of a block move, and the snapshots of one run a case.

If the runs do not record the measures, they are computed from the snapshots, batch by batch.
"""

import json
from pathlib import Path

import numpy as np

from dem.analysis.flow.layout import BEDS, OF_BATCH
from dem.analysis.one_run import motion_of, names_of, read_run
from dem.base import provenance
from dem.base.errors import InputError
from dem.experiment.config import of_values
from dem.experiment.flow_measures import LAYERS
from dem.experiment.motion import Motion
from dem.experiment.observables.flow import VARIABLES as MEASURED
from dem.experiment.observables.flow import lag_of, measured
from dem.io.dataset import attributes, content_of, global_attributes, read, write
from dem.io.lazily import open_lazily
from dem.periodic import wrapped
from dem.sweep.campaign import Campaign
from dem.sweep.combine import PROVENANCE, combine, shared
from dem.sweep.expand import Block

MOVED = "snapshot_displacement"


def measure_batch(
    batch: Path, output: Path, progress=lambda share: None, shapes: Path | str | None = None
) -> None:
    """Write the measures of all runs of a batch, NaN for those that failed; shapes: folder of the files
    of shapes of a user's own."""
    values, attrs = read(batch, (MOVED, "run_id", "failure", "failure_reason"))
    with content_of(batch):
        replicates = [of_values(each, str(batch)) for each in json.loads(attrs["values"])]
        names = tuple(name for name in names_of(replicates[0]) if name != MOVED)
    count, snapshots = len(values["run_id"]), len(values[MOVED])
    found = {name: np.full((count, snapshots), np.nan) for name in MEASURED}
    with open_lazily(batch) as kept:  # one run after another: a batch may be larger than memory
        for row, replicate in enumerate(replicates):
            if not values["failure"][row]:
                own = {name: kept[name][row].values for name in names} | {MOVED: values[MOVED]}
                motion = motion_of(batch, replicate.with_shapes(shapes), own)
                for name, each in measured(motion).items():
                    found[name][row] = each
            progress((row + 1) / count)
    told = {name: attrs.get(name, "unknown") for name in (*PROVENANCE, "values")}
    told["versions"] = provenance.versions()
    about = global_attributes("how beds move", "dem flow", **told)
    write(output, values | found, about, OF_BATCH)


def sources(campaign: Campaign, block: str) -> list[Path]:
    """The files that hold the measures of the runs of a block: its batches, or what was measured of them
    beside its results; raises InputError where the runs have neither measures nor snapshots, or where
    they are not measured yet."""
    recorded, batches = _recorded(campaign, block), campaign.files(block)
    if "flow" in recorded:
        return batches
    if "snapshots" not in recorded:
        raise InputError(
            f"{campaign.sweep.title}: its runs record neither snapshots nor flow, so how beds move is not "
            "known; add snapshots to record.observables and run again."
        )
    found = [campaign.results / "flow" / batch.name for batch in batches]
    for path, batch in zip(found, batches, strict=True):
        if not path.is_file():
            raise InputError(f"{path}: it is missing; make it from {batch} first: dem flow.")
    return found


def make_flow(campaign: Campaign, block: str, progress=lambda share: None) -> None:
    """Measure the batches of a block that are not measured yet, and write its flow.nc; nothing where
    its runs are of another experiment, or record neither measures nor snapshots."""
    recorded = _recorded(campaign, block)
    if not {"flow", "snapshots"} & set(recorded):
        return
    batches = campaign.files(block) if "flow" not in recorded else []
    for number, batch in enumerate(batches):
        measured = campaign.results / "flow" / batch.name
        if not measured.is_file():
            measure_batch(batch, measured, shapes=campaign.sweep.beside)
        progress((number + 1) / len(batches))
    write_flow(campaign, block, campaign.root / campaign.folder_of(block) / "flow.nc")


def write_flow(campaign: Campaign, block: str, output: Path, progress=lambda share: None) -> None:
    """Write flow.nc of a block from its sources."""
    found = campaign.block(block)

    def more(file):
        campaign.sign(file)
        _describe(file, found)
        base = set(found.dims) - {"seed"}
        if "snapshots" in _recorded(campaign, block) and base in ({"case"}, {"shape"}):
            _keep_beds(file, campaign, found, base.pop())

    combine(sources(campaign, block), campaign.sweep, found, "flow", output, progress, more)


def _recorded(campaign: Campaign, block: str) -> tuple[str, ...]:
    return campaign.block(block).runs[0].replicate.configuration.recorded


def _describe(file, block: Block) -> None:
    """What readers need to draw beds and to name the lag."""
    moved = file.variables["snapshot_displacement"][...]
    lag = lag_of(moved) * float(moved[1] - moved[0])
    file.setncatts({"title": f"{file.title}: how the beds move", "layers": LAYERS, "lag": lag})
    own = shared(
        block, box_width="box_width", cylinder_diameter="cylinder.diameter", periodic="periodic"
    )
    if own.get("periodic") == "none":
        del own["periodic"]
    file.setncatts(own)


def _keep_beds(file, campaign: Campaign, found: Block, base: str) -> None:
    """Add the snapshots of the run of the lowest seed of each case that did not fail."""
    batches = campaign.batches(found.name)
    files = {run: campaign.store.file_of(each.id) for each in batches for run in each.runs}
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
            batch = files[run.replicate.id]
            _keep_bed(file, row, motion_of(batch, *read_run(batch, run.replicate.id)))


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
