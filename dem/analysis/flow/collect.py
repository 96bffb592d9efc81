"""flow.nc from the replicates of a sweep: measures of every run, snapshots of one run a case."""

from pathlib import Path

import numpy as np

from dem.analysis.flow import measures
from dem.analysis.flow.layout import VARIABLES
from dem.analysis.flow.motion import Motion, read_motion
from dem.analysis.flow.one_run import lag_of, measure
from dem.base import provenance
from dem.base.errors import InputError
from dem.experiment.config import Replicate, Sweep
from dem.io.dataset import content_of, global_attributes, write
from dem.sweep import failures
from dem.sweep.combine import places_of
from dem.sweep.failures import Failed


def same_run(replicate: Replicate, sweep: Sweep) -> bool:
    """Whether the sweep would make this run today."""
    own = replicate.label, replicate.density, replicate.seed
    return replicate.run_key() == Replicate.of(sweep, *own).run_key()


def collect(
    files: list[Path], sweep: Sweep, progress=lambda done: None, failed: Failed = ()
) -> dict:
    """Variables of dem.analysis.flow.layout by name; raises InputError where a run is missing.

    failed: runs that dem.sweep.failures.sort_out tells of, whose measures are NaN; RunError if too many.
    """
    failures.check(sweep, failed)
    places = places_of(sweep)
    for replicate, _ in failed:
        places.pop(replicate.key)
    first = {}  # seed of the run of a case that snapshots are kept of: the lowest
    for row, column in places.values():
        first[row] = min(column, first.get(row, column))
    values, snapshots = {}, sweep.record.snapshots
    granules = max(sweep.shapes[case.shape].granules for case in sweep.cases.values())
    for done, path in enumerate(files):
        motion = read_motion(path)
        run = motion.replicate
        place = places.pop(run.key, None)
        if place is None or not same_run(run, sweep):
            raise InputError(
                f"{path}: it is not a run of this configuration, or it is there twice."
            )
        with content_of(path):
            measured = measure(motion)
        for name, found in measured.items():
            shape = len(sweep.cases), len(sweep.seeds), snapshots
            values.setdefault(name, np.full(shape, np.nan))[place] = found
        if place[1] == first[place[0]]:
            _keep_bed(values, place[0], motion, len(sweep.cases), granules)
        values["displacement"] = motion.displacement
        progress((done + 1) / len(files))
    if places:
        shape, density, seed = next(iter(places))
        raise InputError(f"{shape} at {density} kg/m3, seed {seed}, is in none of the files.")
    return values | _labels(sweep)


def _keep_bed(values, row, motion: Motion, cases: int, granules: int) -> None:
    """Snapshots of one run; NaN beyond its granules."""
    snapshots = len(motion.displacement)
    x, y = np.moveaxis(motion.position, -1, 0)
    kept = {
        "bed_height": motion.height, "bed_cylinder_y": motion.cylinder_y,
        "bed_diameter": motion.diameters, "bed_x": x, "bed_y": y, "bed_angle": motion.angle,
    }  # fmt: skip
    sizes = {"snapshot": snapshots, "granule": granules}
    for name, found in kept.items():
        shape = [sizes[dim] for dim in VARIABLES[name][0][1:]]
        room = values.setdefault(name, np.full((cases, *shape), np.nan))
        room[(row, *(slice(size) for size in np.shape(found)))] = found


def _labels(sweep: Sweep) -> dict:
    shapes = [sweep.shapes[case.shape] for case in sweep.cases.values()]
    return {
        "case": np.array(list(sweep.cases)),
        "seed": np.array(sorted(sweep.seeds)),
        "kind": np.array([shape.kind for shape in shapes]),
        "shape": np.array([case.shape for case in sweep.cases.values()]),
        "density": np.array([case.density for case in sweep.cases.values()]),
        "aspect_ratio": np.array([float(shape.ratio) for shape in shapes]),
        "diameter": np.array([shape.diameter for shape in shapes]),
    }


def write_flow(path: Path, sweep: Sweep, values: dict) -> None:
    """Write flow.nc, atomically."""
    low, high = sweep.record.window
    moved = values["displacement"]
    attrs = global_attributes(
        f"{sweep.title}: how the beds move", "dem flow",
        versions=provenance.versions(), git_revision=provenance.git_revision(),
        window_start=low, window_stop=high, box_width=sweep.box_width,
        lag=lag_of(moved) * float(moved[1] - moved[0]),
        cylinder_diameter=sweep.cylinder.diameter, layers=measures.LAYERS,
    )  # fmt: skip
    write(path, values, attrs, VARIABLES)
