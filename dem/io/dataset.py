"""netCDF files: the layout of runs, in tables; writing is atomic, arrays have checksums of HDF5.

CF-1.11, SI units, in the classic model of netCDF-4 (characters, whole numbers of 32 bits), which
programs without strings and other formats can take over.
"""

import json
import warnings
import zlib
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

import netCDF4
import numpy as np

from dem.base.errors import InputError, OverlapError, PackingError, RunError, StateError
from dem.base.files import atomic, bytes_of

# Tables of variables, name: (dimensions, units, long name). What a run records is in
# dem.experiment.observables.
LABELS = {
    "shape": ((), None, "label of the shape, as in Table 1 of the paper"),
    "kind": ((), None, "kind of granule"),
    "aspect_ratio": ((), "1", "length over width of a granule"),
    "density": ((), "kg m-3", "density of the granules"),
    "diameter": ((), "m", "mean volume diameter of the granules"),
    "granules": ((), "1", "number of granules"),
    "seed": ((), "1", "seed of the replicate"),
}
CHECK = "e0"  # label of the ellipse code at aspect ratio 1: a check, not a shape of Table 1
BY_CASE = {"case", "seed"}, {"shape", "seed"}  # axes of runs that differ in nothing else
OF_RUN = {
    "run_time": (
        (),
        "s",
        "processor time of the run, without compiling",
    ),
    "steps": ((), "1", "number of time steps of the run"),
    "box_height": ((), "m", "height of the box"),
    "packing_pressure": ((), "Pa", "mean normal stress on the walls of the bed at rest"),
    "packing_coordination_number": (
        (),
        "1",
        "mean number of contacts of a granule with others in the bed at rest",
    ),
    "packing_net_force": (
        (),
        "1",
        "greatest net force on a granule in the bed at rest divided by E* R^2",
    ),
    "packing_max_overlap": (
        (),
        "1",
        "greatest overlap relative to the smaller granule radius in the bed at rest",
    ),
}
OF_STORE = {  # of a run in a file of many
    "run_id": (
        (),
        None,
        "identity of the run: a hash of the values that it reads and the code that it runs",
    ),
    "bed_family": (
        (),
        None,
        "all that beds like that of the run depend on, but packing fraction, friction and seed",
    ),
    "spent": (
        (),
        "s",
        "processor time of bed, run and observables, without compiling",
    ),
    "failure": ((), None, "why there is no run, and its values are missing"),
    "failure_reason": ((), None, "the error that stopped the run, empty where none did"),
}
REPLICATES = "replicates"  # where seeds have no end
OF_SWEEP = {
    "case": ((), None, "case: a shape at a density, as in Tables 1 and 2 of the paper"),
    REPLICATES: ((), "1", "number of replicates, whose seeds are the first ones"),
}

# Why a run failed, and the attributes of the variable `failure` that say so (CF, section 3.5).
FAILURES = ("none", PackingError.__name__, OverlapError.__name__, StateError.__name__, "other")
AGAIN = "delete it and run again"
# attribute of a file: of all bytes of each variable, because HDF5 has none of texts and of where a value is
CHECKSUM = "crc32"
FORMAT = "NETCDF4_CLASSIC"
COMPRESSED = 8192  # bytes of an array from which compressing it makes the file smaller
WALLS = ("left", "right", "bottom", "top")
MORE = {  # attributes of CF beside name and units
    "failure": {
        "flag_values": np.arange(len(FAILURES), dtype="i1"),
        "flag_meanings": " ".join(FAILURES),
    },
    "time_step": {"cell_methods": "displacement: minimum"},
    "seed": {"standard_name": "realization"},
    **{
        key: {"cell_methods": "displacement: mean"}
        for key in ("drag", "drag_normal", "drag_tangential", "transverse_force", "wall_force")
    },
}


def attributes(name: str, layout: dict) -> dict:
    """CF attributes of a variable."""
    _, units, long_name = layout[name]
    attrs = {"long_name": long_name, "units": units} | MORE.get(name, {})
    if name == "displacement" and "displacement_bounds" in layout:
        attrs["bounds"] = "displacement_bounds"
    return {key: value for key, value in attrs.items() if value is not None}


def global_attributes(title: str, source: str, **more) -> dict:
    """Attributes every file has; more of them by name, in SI units."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {
        "Conventions": "CF-1.11",
        "title": title,
        "source": source,
        "history": f"{now} {source}",
        "references": "Zhou, Advani and Wetzel: slow drag of a cylinder through a confined "
        "pressurized bed of dumbbell and elliptically cylindrical granules",
        **more,
    }


@contextmanager
def create(path: Path):
    """A netCDF4.Dataset to fill; atomic."""
    with atomic(path) as part, netCDF4.Dataset(part, "w", format=FORMAT) as file:
        yield file


def write(path: Path, values: dict, attrs: dict, layout: dict) -> None:
    """Write one file: values by the names of a layout, atomically, with a checksum of each."""
    with create(path) as file:
        for name, value in values.items():
            add(file, name, layout[name][0], value, attributes(name, layout))
        sums = {name: _checksum(_stored(variable)) for name, variable in file.variables.items()}
        file.setncatts(attrs | {CHECKSUM: json.dumps(sums)})


def add_dimensions(file, dims: tuple, shape: tuple) -> None:
    """Add the dimensions that a file lacks."""
    for dim, size in zip(dims, shape, strict=True):
        if dim not in file.dimensions:
            file.createDimension(dim, size)


def add(file, name: str, dims: tuple, values, attrs: dict) -> None:
    """Add a variable to a file: texts as characters, along a dimension of that length, and whole
    numbers in 32 bits, or as real ones where they are larger."""
    values = np.asarray(values)
    if values.dtype.kind == "U":
        values = np.char.encode(values, "utf-8")[..., None].view("S1")
        dims, attrs = (*dims, f"string{values.shape[-1]}"), attrs | {"_Encoding": "utf-8"}
    elif values.dtype == np.int64:
        values = values.astype("i4" if np.abs(values).max(initial=0) < 2**31 else float)
    elif values.dtype == bool:  # netCDF has no truth values
        values = values.astype("i1")
    add_dimensions(file, dims, values.shape)
    variable = file.createVariable(
        name,
        values.dtype,
        dims,
        zlib=values.nbytes > COMPRESSED,
        fletcher32=bool(dims) and values.dtype.kind != "S",  # so that any reader notices damage
        fill_value=False,
    )
    variable.set_auto_chartostring(False)
    variable.setncatts(attrs)
    variable[...] = values


def read(path: Path, names: tuple[str, ...]) -> tuple[dict, dict]:
    """The named variables and all global attributes of a file that was written here.

    Raises InputError if they are not there, or not what was written.
    """
    with content_of(path, AGAIN):
        if not Path(path).is_file():
            raise InputError(f"{path}: there is no such file.")
        with netCDF4.Dataset(path) as file:
            attrs = {name: file.getncattr(name) for name in file.ncattrs()}
            sums = json.loads(attrs.pop(CHECKSUM, "{}"))
            return {name: _checked(file.variables[name], sums) for name in names}, attrs


def _stored(variable) -> np.ndarray:
    """What a file has for a variable, texts as characters."""
    variable.set_auto_maskandscale(False)
    variable.set_auto_chartostring(False)
    return variable[...]


def _checksum(stored: np.ndarray) -> str:
    return f"{zlib.crc32(stored.tobytes()):08x}"


def _checked(variable, sums: dict[str, str]) -> np.ndarray:
    """The values of a variable; raises InputError where they have another checksum than its own."""
    stored = _stored(variable)
    if sums.get(variable.name) not in (None, _checksum(stored)):
        raise InputError(f"the values of {variable.name} are damaged: {AGAIN}.")
    return netCDF4.chartostring(stored, "utf-8") if stored.dtype.kind == "S" else stored


@contextmanager
def content_of(path: Path, remedy: str = "make it again"):
    """Turn errors that the content of a file causes into an InputError with the file's name.

    remedy: what to do about a file that is damaged. Gaps of a file are NaN, and so is what follows
    from them: numpy does not warn.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            yield
    except (RunError, MemoryError):
        raise
    except InputError as error:
        if str(path) in str(error):
            raise
        raise InputError(f"{path}: {error}") from None
    except Exception as error:
        with suppress(FileNotFoundError):
            bytes_of(Path(path))  # an error of the disk is raised here
        if isinstance(error, OSError) and (error.errno or 0) > 0:  # of another file
            raise
        words = " ".join(str(error).split())[:200]
        raise InputError(
            f"{path}: its content cannot be used ({type(error).__name__}: {words}); it is cut off, "
            f"damaged or another file: {remedy}."
        ) from error
