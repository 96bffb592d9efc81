"""netCDF files whose variables are read when they are needed, and what must hold for them."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dem.base.errors import InputError
from dem.base.hints import of_missing_file
from dem.io.checksums import is_sealed
from dem.io.dataset import content_of, is_text

if TYPE_CHECKING:  # half a second to load, which what only writes files need not wait for
    import xarray as xr

NUMBERS = (
    "window_start", "window_stop", "cylinder_velocity", "box_width", "lag", "cylinder_diameter",
    "layers", "default_fraction",
)  # attributes; all others are texts  # fmt: skip


@contextmanager
def open_lazily(path: Path):
    """Any netCDF file with variables that are read when needed, an xarray.Dataset.

    A file with a checksum must hold what was written; one without, of the user's own making, is
    taken as it is. Raises InputError for another file, also where damage, or a content that does
    not fit, shows only when a value is read or used.
    """
    import xarray as xr

    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file{of_missing_file(path)}.")
    with content_of(path):
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
        if not (_is_number(value) if name in NUMBERS else isinstance(value, str)):
            kind = "number" if name in NUMBERS else "text"
            raise InputError(f"{path}: its attribute {name} is {value}; it must be a {kind}.")


def _is_number(value) -> bool:
    """Whether an attribute is one finite number."""
    array = np.asarray(value)
    return array.dtype.kind in "iuf" and array.ndim == 0 and bool(np.isfinite(array))
