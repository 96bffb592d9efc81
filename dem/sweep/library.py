"""What a user of the library does with sweeps: runs of a file, one after another, as xarray datasets."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from dem.base.errors import InputError
from dem.experiment import drag
from dem.experiment.bed import make_bed
from dem.experiment.config import Configuration, of_values
from dem.io.dataset import AXES, LABELS, attributes, global_attributes
from dem.sweep.axis import OWN
from dem.sweep.config import extended, load
from dem.sweep.remedy import remedies


def load_sweep(path: str | Path) -> Iterator[dict]:
    """The runs of a sweep file, each as values that `run_experiment` takes.

    A run is a nested dict of the configuration's sections, in SI units, with `shape` (a label),
    `density` (kg/m3) and `seed`. Runs come block by block, in the order of the axes; values that are
    derived from another block's result are those of the file. Raises InputError for a file that cannot be
    used.

    >>> import dem
    >>> values = next(dem.load_sweep("config/smoke.yaml"))
    >>> values["shape"], values["seed"]
    ('c1', 1)
    """
    sweep = load(Path(path))
    return (run.values() for name in sweep.blocks for run in sweep.block(name).unique())


def run_experiment(values: dict) -> xr.Dataset:
    """Make one run: pack its bed and draw the cylinder through it.

    values: as `load_sweep` yields them, or a dict with `extends`, a configuration file, and what
    differs from it: {"extends": "config/paper.yaml", "shape": "e2", "seed": 7, "friction":
    {"granule": 0.1}}; density: that of the file's first case of the shape unless given. Returns what
    the configuration records, over displacement (m), wall, snapshot and granule, with units in the
    attributes. Raises InputError for values that cannot be simulated, RunError where the run fails.
    """
    with remedies("values", Configuration, *OWN):
        replicate = of_values(_whole(values))
    own = replicate.configuration
    experiment = own.module
    found = experiment.run(replicate, make_bed(replicate)) if experiment is drag else experiment.run(replicate)  # fmt: skip
    axes = getattr(experiment, "AXIS", AXES)
    layout = experiment.layout(own) | axes | LABELS
    coordinates = experiment.axes(own) | drag.labels(replicate)
    used = {dim for name in found for dim in layout[name][0]}
    dataset = xr.Dataset({name: (layout[name][0], value) for name, value in found.items()})
    for name, value in coordinates.items():
        if set(layout[name][0]) <= used | {"bound"}:
            dataset = dataset.assign_coords({name: (layout[name][0], np.asarray(value))})
    for name in dataset.variables:
        dataset[name].attrs = attributes(name, layout)
    title = f"{own.experiment}: {replicate.words()}"
    return dataset.assign_attrs(global_attributes(title, "dem.run_experiment", run_id=replicate.id))


def _whole(values: dict) -> dict:
    """Values with those of the file that they extend."""
    if not isinstance(values, dict):
        raise InputError(f"values is {values!r}; it must be a dict.")
    if "extends" not in values:
        return values
    own = {key: new for key, new in values.items() if key not in ("shape", "density", "seed")}
    base = load(Path(values["extends"]))
    found = extended(own | {"results": base.results}, "values")
    known = set(base.values())
    found = {key: new for key, new in found.items() if key in known or key in own}
    found.pop("results", None)
    if "shape" not in values:
        raise InputError("values: shape is missing.")
    density = values.get("density", base.density_of(values["shape"]))
    return found | {"shape": values["shape"], "density": density, "seed": values.get("seed", 1)}
