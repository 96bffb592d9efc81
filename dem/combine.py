"""Many replicates into one file: drag.nc, over (case, seed, displacement).

Replicates are opened one after another (netCDF4 is not safe with threads); at any moment the
result and one replicate are in memory. Snapshots stay in the replicates' own files.
"""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from dem.config import Replicate, Sweep, density_label
from dem.dataset import VARIABLES, WALLS, atomic, attributes, global_attributes, read
from dem.errors import InputError

# What a replicate records along its stroke, once a run, and on the axis that all runs share.
SERIES = tuple(
    name
    for name, (dims, _, _) in VARIABLES.items()
    if dims[-1:] == ("displacement",) and name != "displacement"
)
SCALARS = (
    "box_height", "packing_pressure", "packing_coordination_number", "packing_net_force",
    "packing_max_overlap", "run_time", "steps",
)  # fmt: skip
AXIS = ("displacement", "displacement_bounds")
# Which run a replicate holds, and the attributes that say what it was made from.
LABELS = ("shape", "density", "seed")
PROVENANCE = ("versions", "git_revision", "source_hash")


def combine(paths: list[Path], sweep: Sweep) -> xr.Dataset:
    """All runs of a sweep, in the order of its cases, seeds ascending as CF wants an axis.

    The replicates may come in any order; each says itself which run it holds. The attributes tell
    the provenance of the replicates, all of it where they differ. Raises InputError for a file
    that is missing, damaged or of another configuration, and for a run that no file holds.
    """
    places = places_of(sweep)
    size = len(sweep.cases), len(sweep.seeds)
    values, origins, provenance = {}, {}, {name: {} for name in PROVENANCE}
    for path in paths:
        run, attrs = _load(path, sweep)
        key = key_of(run["shape"], run["density"], run["seed"])
        if key not in places:
            raise InputError(
                f"{path}: it holds {key[0]} at {key[1]} kg/m3, seed {key[2]}, which the "
                "configuration does not ask for."
            )
        if key in origins:
            raise InputError(f"{path}: it holds the same run as {origins[key]}.")
        origins[key] = path
        for name in PROVENANCE:
            provenance[name][attrs[name]] = None
        for name in (*SERIES, *SCALARS):
            if name not in values:
                values[name] = np.empty((*size, *run[name].shape), run[name].dtype)
            values[name][places[key]] = run[name]
        values |= {name: run[name] for name in AXIS}
    for shape, density, seed in places:
        if (shape, density, seed) not in origins:
            raise InputError(
                f"{shape} at {density} kg/m3, seed {seed}, is in none of the {len(paths)} files."
            )
    return _dataset(values, sweep, {name: "; ".join(kept) for name, kept in provenance.items()})


def key_of(shape, density, seed) -> tuple[str, str, int]:
    """A run as its file and the configuration both name it."""
    return str(shape), density_label(float(density)), int(seed)


def places_of(sweep: Sweep) -> dict[tuple, tuple[int, int]]:
    """Place (case, seed) in the result of every run that the configuration asks for."""
    return {
        key_of(case.shape, case.density, seed): (row, column)
        for row, case in enumerate(sweep.cases.values())
        for column, seed in enumerate(sorted(sweep.seeds))
    }


def _load(path: Path, sweep: Sweep) -> tuple[dict, dict]:
    """Variables and attributes of a replicate that was made with this configuration.

    Its run_key holds all that its run depended on: it must be what the sweep would write today.
    """
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file.")
    try:
        values, attrs = read(path, (*AXIS, *SERIES, *SCALARS, *LABELS))
    except (RuntimeError, AttributeError) as error:
        raise InputError(f"{path}: it is damaged ({error}).") from None
    for name in (*PROVENANCE, "run_key"):
        if name not in attrs:
            raise InputError(f"{path}: it has no attribute {name}; is it another file?")
    label = str(values["shape"])
    run = {"label": label, "density": float(values["density"]), "seed": int(values["seed"])}
    if label not in sweep.shapes or attrs["run_key"] != Replicate(sweep=sweep, **run).run_key():
        raise InputError(f"{path}: it was made with another configuration; simulate it again.")
    sizes = {"displacement": sweep.record.bins, "bound": 2, "wall": len(WALLS)}
    for name in (*AXIS, *SERIES, *SCALARS):
        if values[name].shape != tuple(sizes[dim] for dim in VARIABLES[name][0]):
            raise InputError(f"{path}: its variable {name} has the wrong size.")
    return values, attrs


def _dataset(values, sweep, provenance) -> xr.Dataset:
    """Arrays by name, with coordinates and attributes.

    The averaging window and the cylinder's velocity stand in the attributes, so that figures need
    nothing but the Dataset.
    """
    shapes = [sweep.shapes[case.shape] for case in sweep.cases.values()]
    on_case = {
        "case": list(sweep.cases),
        "shape": [case.shape for case in sweep.cases.values()],
        "kind": [shape.kind for shape in shapes],
        "aspect_ratio": [shape.ratio for shape in shapes],
        "density": [case.density for case in sweep.cases.values()],
        "diameter": [shape.diameter for shape in shapes],
        "granules": [shape.granules for shape in shapes],
    }
    coordinates = {name: ("case", found, attributes(name)) for name, found in on_case.items()}
    displacement = values.pop("displacement")
    axes = {"seed": sorted(sweep.seeds), "wall": list(WALLS), "displacement": displacement}
    coordinates |= {name: (name, found, attributes(name)) for name, found in axes.items()}
    variables = {}
    for name, array in values.items():
        own = VARIABLES[name][0]
        dims = own if name in AXIS else ("case", "seed", *own)
        variables[name] = (dims, array, attributes(name))
    return xr.Dataset(
        variables,
        coordinates,
        global_attributes(
            sweep.title,
            "dem simulate, dem combine",
            configuration=json.dumps(sweep.model_dump()),
            **provenance,
            window_start=sweep.record.window[0],
            window_stop=sweep.record.window[1],
            cylinder_velocity=sweep.cylinder.velocity,
        ),
    )


def write_combined(dataset: xr.Dataset, path: Path) -> None:
    """Write what `combine` returned, atomically and without loss.

    No variable has a fill value: there are no gaps.
    """
    encoding = {}
    for name, variable in dataset.variables.items():
        if np.issubdtype(variable.dtype, np.number):
            packed = {"zlib": True, "complevel": 4, "shuffle": True} if variable.dims else {}
            encoding[name] = {"_FillValue": None, **(packed if name in dataset.data_vars else {})}
        elif name in dataset.dims:  # labels of an axis are characters: CF keeps strings off it
            encoding[name] = {"dtype": "S1", "char_dim_name": f"{name}_length"}
    with atomic(path) as part:
        dataset.to_netcdf(part, engine="netcdf4", format="NETCDF4", encoding=encoding)


def open_combined(path: Path) -> xr.Dataset:
    """drag.nc with variables that are read when needed; use it in a `with` block.

    Raises InputError for any other file.
    """
    dataset = open_lazily(path)
    try:
        require(dataset, path, ("case", *LABELS, *AXIS, "kind", "drag"), ("window_start",))
    except InputError:
        dataset.close()
        raise
    return dataset


def open_lazily(path: Path) -> xr.Dataset:
    """Any netCDF file with variables that are read when needed; raises InputError."""
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file.")
    try:
        return xr.open_dataset(path, engine="netcdf4", chunks={})
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: it is not a readable netCDF file ({error}).") from None


def require(dataset: xr.Dataset, path: Path, variables, attributes=()) -> None:
    """Raise InputError unless the file has these variables and attributes."""
    absent = [f"variable {name}" for name in variables if name not in dataset.variables]
    absent += [f"attribute {name}" for name in attributes if name not in dataset.attrs]
    if absent:
        raise InputError(f"{path}: it has no {absent[0]}; is it another file?")
