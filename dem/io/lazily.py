"""netCDF files whose variables are read when they are needed, and what must hold for them."""

from __future__ import annotations

import math
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dem.base.errors import InputError
from dem.io.checksums import is_sealed
from dem.io.dataset import content_of, is_text

if TYPE_CHECKING:  # half a second to load, which what only writes files need not wait for
    import xarray as xr

NUMBERS = (
    "window_start", "window_stop", "cylinder_velocity", "box_width", "lag", "cylinder_diameter",
    "layers", "default_fraction",
)  # attributes; all others are texts  # fmt: skip


CHECKED = 64_000_000  # bytes of a file that are all read to check it
PIECE = 16_000_000  # bytes of a variable that are in memory at once, about


def open_results(path: str | Path) -> xr.Dataset:
    """Open a file of results, such as drag.nc, of any size.

    A file of up to 64 MB must hold what was written here, or is one of your own making. In a larger one
    each variable is checked as it is read, by the sums of its format, and variables of more than 32 MB
    are Dask arrays in pieces of some 16 MB, so that what you compute of them takes little memory.

    Parameters
    ----------
    path : str or Path
        A netCDF file.

    Returns
    -------
    xarray.Dataset
        Its variables, read when they are needed; units are in the attributes of each. It is a context
        that closes the file.

    Raises
    ------
    InputError
        If there is no such file, or another or a damaged one.

    Examples
    --------
    >>> import dem
    >>> with dem.open_results("docs/data/drag.nc") as results:
    ...     float(results["drag"].sel(case="c1").mean().round(-2))
    1300.0
    """
    import xarray as xr

    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file.")
    with content_of(path):
        if Path(path).stat().st_size <= CHECKED:
            is_sealed(path)
        try:
            dataset = xr.open_dataset(path, engine="netcdf4")
        except (OSError, ValueError, RuntimeError):
            why = "it is cut off, damaged or another file: make it again, or copy it again"
            if Path(path).suffix in (".yaml", ".yml"):
                why = (
                    f"it is a configuration: make its results with dem sweep {path}, and name those"
                )
            raise InputError(f"{path}: it is not a readable netCDF file; {why}.") from None
        large = {name: v for name, v in dataset.items() if v.nbytes > 2 * PIECE}
        found = dataset.assign({name: v.chunk(_pieces(v)) for name, v in large.items()})
        found.set_close(dataset.close)
        return found


def _pieces(variable: xr.DataArray) -> dict[str, int]:
    """Sizes of the pieces of a large variable: many whole chunks of its file, first along the last axes."""
    sizes = list(variable.encoding.get("chunksizes") or [1] * variable.ndim)[: variable.ndim]
    for axis in reversed(range(variable.ndim)):
        fit = PIECE // (variable.dtype.itemsize * math.prod(sizes))
        sizes[axis] = min(variable.shape[axis], sizes[axis] * max(1, fit))
    return dict(zip(variable.dims, sizes, strict=True))


@contextmanager
def open_lazily(path: Path):
    """The same as a context, where damage, or a content that does not fit, is an InputError also when
    it shows only as a value is read or used."""
    with open_results(path) as dataset, content_of(path):
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
        kind, array = "number" if name in NUMBERS else "text", np.asarray(value)
        number = array.dtype.kind in "iuf" and array.ndim == 0 and np.isfinite(array)
        if not (number if kind == "number" else isinstance(value, str)):
            raise InputError(f"{path}: its attribute {name} is {value}; it must be a {kind}.")
