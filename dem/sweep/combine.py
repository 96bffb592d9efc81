"""Many replicates into one file: drag.nc, over (case, seed, displacement).

Replicates are opened one after another (netCDF4 is not safe with threads) and written at once: at
any moment one replicate, and the few blocks of the file that are not full yet, are in memory,
however many there are. Snapshots stay in the replicates' own files.
"""

import json
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import xarray as xr

from dem.base.errors import InputError
from dem.experiment.config import Replicate, Sweep, density_label
from dem.io.checksums import is_sealed
from dem.io.dataset import (
    AGAIN,
    VARIABLES,
    WALLS,
    attributes,
    content_of,
    create,
    global_attributes,
    is_text,
    read,
)
from dem.sweep import failures
from dem.sweep.failures import Failed

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
ON_CASE = ("shape", "kind", "aspect_ratio", "density", "diameter", "granules")


def _over(names, *dims: str) -> dict:
    """Some of VARIABLES with further dimensions in front."""
    return {name: ((*dims, *VARIABLES[name][0]), *VARIABLES[name][1:]) for name in names}


# The layout of drag.nc, as in dem.io.dataset.
COMBINED = (
    _over(("case", *ON_CASE), "case") | _over(("seed",), "seed") | _over((*AXIS, "wall"))
    | _over((*SERIES, *SCALARS, "failure"), "case", "seed")
)  # fmt: skip
NUMBERS = (
    "window_start", "window_stop", "cylinder_velocity", "box_width", "lag", "cylinder_diameter",
    "layers", "default_fraction",
)  # attributes; all others are texts  # fmt: skip
BLOCK = 64  # runs of a case that are kept, compressed and read together


def combine(
    paths: list[Path], sweep: Sweep, output: Path, progress=lambda done: None, failed: Failed = ()
) -> None:
    """Write all runs of a sweep, in the order of its cases, seeds ascending as CF wants an axis.

    The replicates may come in any order; each says itself which run it holds. The attributes tell
    the provenance of the replicates, all of it where they differ. The file is written atomically
    and without loss. Where the sweep allows failures, those of dem.sweep.failures.sort_out are gaps (NaN)
    and `failure` tells why. Raises InputError for a replicate that is missing, damaged or of another
    configuration, and for a run that no file holds; RunError where too many failed.
    """
    failures.check(sweep, failed)
    cases, seeds = case_places(sweep), seed_places(sweep)
    origin = np.full((len(cases), len(seeds)), -1)  # number of the path that a run comes from
    provenance = {name: {} for name in PROVENANCE}
    with create(output) as file:
        for number, path in enumerate(paths):
            replicate, run, attrs = _load(path, sweep)
            shape, density, seed = replicate.key
            place = cases.get((shape, density), -1), seeds.get(seed, -1)
            if -1 in place:
                raise InputError(
                    f"{path}: it holds {shape} at {density} kg/m3, seed {seed}, which the "
                    "configuration does not ask for."
                )
            if origin[place] >= 0:
                raise InputError(f"{path}: it holds the same run as {paths[origin[place]]}.")
            if number == 0:
                _make_room(file, sweep, run)
            origin[place] = number
            for name in PROVENANCE:
                provenance[name][attrs[name]] = None
            for name in (*SERIES, *SCALARS):
                file.variables[name][place] = run[name]
            progress((number + 1) / len(paths))
        for replicate, about in failed:
            row, column = cases[replicate.key[:2]], seeds[replicate.seed]
            origin[row, column] = len(paths)
            file.variables["failure"][row, column] = failures.flag(about)
        if (origin < 0).any():
            row, column = np.argwhere(origin < 0)[0]
            shape, density = list(cases)[row]
            raise InputError(
                f"{shape} at {density} kg/m3, seed {list(seeds)[column]}, is in none of the "
                f"{len(paths)} files."
            )
        file.setncatts(_about(sweep, {name: "; ".join(kept) for name, kept in provenance.items()}))


def case_places(sweep: Sweep) -> dict[tuple[str, str], int]:
    """Place of a shape at a density, as files name them, along the axis of cases."""
    cases = sweep.cases.values()
    return {(case.shape, density_label(case.density)): row for row, case in enumerate(cases)}


def seed_places(sweep: Sweep) -> dict[int, int]:
    """Place of a seed along its axis."""
    return {seed: column for column, seed in enumerate(sorted(sweep.seeds))}


def places_of(sweep: Sweep) -> dict[tuple, tuple[int, int]]:
    """Place (case, seed) in the result of every run that the configuration asks for."""
    return {
        (*case, seed): (row, column)
        for case, row in case_places(sweep).items()
        for seed, column in seed_places(sweep).items()
    }


def _load(path: Path, sweep: Sweep) -> tuple[Replicate, dict, dict]:
    """Run, variables and attributes of a replicate that was made with this configuration.

    Its run_key holds all that its run depended on: it must be what the sweep would write today.
    """
    if not Path(path).is_file():
        raise InputError(
            f"{path}: there is no such file; delete the folder batches, if there is one, and run again."
        )
    values, attrs = read(path, (*AXIS, *SERIES, *SCALARS, *LABELS))
    with content_of(path):
        for name in (*PROVENANCE, "run_key"):
            if not isinstance(attrs.get(name), str):
                raise InputError(f"{path}: it has no text as attribute {name}; is it another file?")
        label = str(values["shape"])
        run = Replicate.of(sweep, label, float(values["density"]), int(values["seed"]))
        if label not in sweep.shapes or attrs["run_key"] != run.run_key():
            raise InputError(f"{path}: it was made with another configuration; {AGAIN}.")
        sizes = {"displacement": sweep.record.bins, "bound": 2, "wall": len(WALLS)}
        for name in (*AXIS, *SERIES, *SCALARS):
            if values[name].shape != tuple(sizes[dim] for dim in VARIABLES[name][0]):
                raise InputError(f"{path}: its variable {name} has the wrong size.")
    return run, values, attrs


def _make_room(file, sweep: Sweep, run: dict) -> None:
    """Dimensions, axes, labels and empty variables of drag.nc; only where runs may be missing has a
    variable a value that means so."""
    shapes = [sweep.shapes[case.shape] for case in sweep.cases.values()]
    labels = (
        (case.shape, shape.kind, float(shape.ratio), case.density, shape.diameter, shape.granules)
        for case, shape in zip(sweep.cases.values(), shapes, strict=True)
    )
    on_case = dict(zip(ON_CASE, zip(*labels, strict=True), strict=True))
    axes = {"case": list(sweep.cases), "seed": sorted(sweep.seeds), "wall": list(WALLS)}
    axes |= {"displacement": run["displacement"]}
    for name, values in axes.items():
        file.createDimension(name, len(values))
        _write(file, name, (name,), np.asarray(values))
    file.createDimension("bound", 2)
    _write(file, "displacement_bounds", AXIS[:1] + ("bound",), run["displacement_bounds"])
    for name, values in on_case.items():
        _write(file, name, ("case",), np.asarray(values))
    block = min(BLOCK, len(sweep.seeds))
    for name in (*SERIES, *SCALARS):
        dims = ("case", "seed", *VARIABLES[name][0])
        sizes = 1, block, *run[name].shape
        gap = np.nan if run[name].dtype.kind == "f" else -1
        made = file.createVariable(
            name, run[name].dtype, dims, zlib=True, complevel=4, shuffle=True, fletcher32=True,
            chunksizes=sizes, fill_value=gap if sweep.failures else False,
        )  # fmt: skip
        # two blocks: runs mostly come in order, and what is full is written and forgotten
        size = 2 * int(np.prod(sizes)) * run[name].dtype.itemsize
        made.set_var_chunk_cache(size=max(size, 4096), nelems=1009, preemption=1.0)
        made.setncatts(attributes(name) | {"coordinates": " ".join(on_case)})
    if sweep.failures:
        made = file.createVariable("failure", "i1", ("case", "seed"), fill_value=False)
        made.setncatts(attributes("failure") | failures.FLAGS)
        made[...] = 0


def _write(file, name: str, dims: tuple[str, ...], values: np.ndarray) -> None:
    """An axis or a label; texts of an axis are characters, CF keeps strings off it."""
    kind, options = values.dtype, {"fill_value": False}
    if kind.kind == "U":
        kind, options, values = str, {}, values.astype(object)
        if name in file.dimensions:
            width = max(map(len, values))
            file.createDimension(f"{name}_length", width)
            dims, kind, values = (*dims, f"{name}_length"), "S1", values.astype(f"S{width}")
    made = file.createVariable(name, kind, dims, **options)
    made.setncatts(attributes(name))
    if kind == "S1":
        made._Encoding = "utf-8"
        values = values.astype(str)
    made[...] = values


def _about(sweep: Sweep, provenance: dict) -> dict:
    """Attributes of the file. The averaging window and the cylinder's velocity are among them, so
    that figures need nothing else."""
    return global_attributes(
        sweep.title,
        "dem simulate, dem combine",
        configuration=json.dumps(sweep.own_dump()),
        **provenance,
        window_start=sweep.record.window[0],
        window_stop=sweep.record.window[1],
        cylinder_velocity=sweep.cylinder.velocity,
    )


@contextmanager
def open_combined(path: Path):
    """drag.nc with variables that are read when needed; raises InputError for any other file."""
    needed = ("case", *LABELS, *AXIS, "kind", "drag")
    with open_lazily(path) as dataset:
        require(dataset, path, COMBINED, needed, ("window_start", "window_stop"))
        yield dataset


@contextmanager
def open_lazily(path: Path):
    """Any netCDF file with variables that are read when needed, an xarray.Dataset.

    A file with a checksum must hold what was written; one without, of the user's own making, is
    taken as it is. Raises InputError for another file, also where damage, or a content that does
    not fit, shows only when a value is read or used.
    """
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file.")
    with content_of(path):
        is_sealed(path)
        try:
            dataset = xr.open_dataset(path, engine="netcdf4", chunks={})
        except (OSError, ValueError, RuntimeError) as error:
            raise InputError(f"{path}: it is not a readable netCDF file ({error}).") from None
        with dataset:
            yield dataset


def require(dataset: xr.Dataset, path: Path, layout: dict, variables, attributes=()) -> None:
    """Check a file against a layout as in dem.io.dataset.

    Raises InputError unless it has these variables and attributes, and all its variables of the
    layout have the dimensions and the kind of values that the layout gives them.
    """
    absent = [f"variable {name}" for name in variables if name not in dataset.variables]
    absent += [f"attribute {name}" for name in attributes if name not in dataset.attrs]
    if absent:
        raise InputError(f"{path}: it has no {absent[0]}; is it another file?")
    for name in layout.keys() & dataset.variables.keys():
        dims, found = layout[name][0], dataset.variables[name]
        if found.dims != dims:
            over = ", ".join(dims) or "no dimension"
            raise InputError(f"{path}: its {name} is not over {over}; is it another file?")
        kinds, words = ("OUT", "text") if is_text(name, layout) else ("iuf", "numbers")
        if found.dtype.kind not in kinds:
            raise InputError(
                f"{path}: its {name} holds {found.dtype}, not {words}; is it another file?"
            )
    for name in attributes:
        value = dataset.attrs[name]
        if name not in NUMBERS and not isinstance(value, str):
            raise InputError(f"{path}: its attribute {name} is {value}; it must be a text.")
        if name in NUMBERS and not _is_number(value):
            raise InputError(f"{path}: its attribute {name} is {value}; it must be a number.")


def _is_number(value) -> bool:
    """Whether an attribute is one finite number."""
    array = np.asarray(value)
    return array.dtype.kind in "iuf" and array.ndim == 0 and bool(np.isfinite(array))
