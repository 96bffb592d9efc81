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
LABELS = ("shape", "density", "seed")
PROVENANCE = ("versions", "git_revision", "source_hash")


def combine(paths: list[Path], sweep: Sweep) -> xr.Dataset:
    """All runs of a sweep, in the order of its cases, seeds ascending.

    The replicates may come in any order; each says itself which run it holds. Raises InputError
    for a file that is missing, damaged or of another configuration, and for a run without file.
    """
    cases, seeds = list(sweep.cases), sorted(sweep.seeds)
    numbers = {
        (case.shape, density_label(case.density)): number
        for number, case in enumerate(sweep.cases.values())
    }
    values, origins, provenance = {}, {}, {name: {} for name in PROVENANCE}
    for path in paths:
        run, made_from = _load(path, sweep)
        run_of = (str(run["shape"]), density_label(float(run["density"])))
        seed = int(run["seed"])
        if run_of not in numbers or seed not in seeds:
            raise InputError(
                f"{path}: it holds {run_of[0]} at {run_of[1]} kg/m3, seed {seed}, which the "
                "configuration does not ask for."
            )
        place = numbers[run_of], seeds.index(seed)
        if place in origins:
            raise InputError(f"{path}: it holds the same run as {origins[place]}.")
        origins[place] = path
        for name in PROVENANCE:
            provenance[name][made_from[name]] = None
        for name in (*AXIS, *SERIES, *SCALARS):
            _put(values, name, run[name], place, (len(cases), len(seeds)))
    for case, label in enumerate(cases):
        for number, seed in enumerate(seeds):
            if (case, number) not in origins:
                raise InputError(f"No file among {len(paths)} holds case {label}, seed {seed}.")
    return _dataset(values, sweep, seeds, {k: "; ".join(v) for k, v in provenance.items()})


def _put(values, name, array, place, size) -> None:
    """Put what a run recorded into its place in the array over (case, seed, ...)."""
    if name in AXIS:
        values[name] = array
        return
    if name not in values:
        values[name] = np.empty((*size, *array.shape), array.dtype)
    values[name][place] = array


def _load(path: Path, sweep: Sweep) -> tuple[dict, dict]:
    """Variables and provenance of a replicate that was made with this configuration."""
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


def _dataset(values, sweep, seeds, provenance) -> xr.Dataset:
    """Arrays by name, with coordinates and attributes."""
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
    for name, found in {"seed": seeds, "wall": list(WALLS), "displacement": None}.items():
        found = values.pop(name) if found is None else found
        coordinates[name] = (name, found, attributes(name))
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
    """Write what `combine` returned, atomically and without loss."""
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
