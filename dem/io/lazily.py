"""netCDF files whose variables are read when they are needed, and what must hold for them."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from dem.base.errors import InputError
from dem.io.dataset import content_of

if TYPE_CHECKING:  # half a second to load, which what only writes files need not wait for
    import xarray as xr

SMALL = 64_000_000  # bytes of a file whose variables are read in one piece


def open_results(path: str | Path) -> xr.Dataset:
    """Open a file of results, such as drag.nc, of any size.

    Each variable is checked as it is read, by the checksums that its format has of numbers. In a file
    of more than 64 MB it is a Dask array in the pieces of the file, so that what you compute of it
    takes little memory.

    Parameters
    ----------
    path : str or Path
        A netCDF file.

    Returns
    -------
    xarray.Dataset
        Its variables, read when they are needed; units are in the attributes of each. It is a
        context that closes the file.

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
        chunks = None if Path(path).stat().st_size <= SMALL else {}
        try:
            return xr.open_dataset(path, engine="netcdf4", chunks=chunks)
        except (OSError, ValueError, RuntimeError):
            raise InputError(
                f"{path}: it is not a readable netCDF file; it is cut off, damaged or another file: "
                "make it again, or copy it again."
            ) from None


@contextmanager
def open_lazily(path: Path):
    """The same as a context, where damage, or a content that does not fit, is an InputError also
    when it shows only as a value is read or used."""
    with open_results(path) as dataset, content_of(path):
        yield dataset


def require(dataset: xr.Dataset, path: Path, layout: dict, variables, attributes=()) -> None:
    """Check a file against a layout as in dem.io.dataset.

    Raises InputError unless it has these variables and attributes, and all its variables of the
    layout have the dimensions that the layout gives them.
    """
    absent = [f"variable {name}" for name in variables if name not in dataset.variables]
    absent += [f"attribute {name}" for name in attributes if name not in dataset.attrs]
    if absent:
        raise InputError(f"{path}: it has no {absent[0]}; is it another file?")
    for name in layout.keys() & dataset.variables.keys():
        if dataset.variables[name].dims != layout[name][0]:
            over = ", ".join(layout[name][0]) or "no dimension"
            raise InputError(f"{path}: its {name} is not over {over}; is it another file?")


def require_drag(dataset: xr.Dataset, path: Path) -> None:
    """Raise InputError unless a file has the drag of all runs of a block."""
    require(dataset, path, {}, ("run_id",))
    layout = {"drag": ((*dataset["run_id"].dims, "displacement"), "N", "")}
    names = "shape", "displacement", "displacement_bounds", "drag"
    require(dataset, path, layout, names, ("window_start", "window_stop"))
