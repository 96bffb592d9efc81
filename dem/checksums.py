"""Checksums of what a netCDF file holds, kept in one of its attributes: damage is noticed on reading.

netCDF's own filters guard arrays only. These cover scalars, texts and attributes as well.
"""

import json
from collections.abc import Iterable, Iterator
from hashlib import sha256

import netCDF4
import numpy as np

ATTRIBUTE = "checksums"


class Changed(ValueError):
    """A file does not hold what was written."""


def seal(file: netCDF4.Dataset, names: Iterable[str] | None = None) -> None:
    """Add the checksums of all headers, and of the values of these variables (all unless told)."""
    file.set_auto_mask(False)
    names = list(file.variables) if names is None else names
    values = {name: _of_values(file.variables[name][...]) for name in names}
    file.setncattr(ATTRIBUTE, json.dumps({"headers": _of_headers(file), "values": values}))


def is_sealed(file: netCDF4.Dataset) -> bool:
    """Whether a file has checksums."""
    return ATTRIBUTE in file.ncattrs()


def verified(
    file: netCDF4.Dataset, names: Iterable[str] | None = None
) -> Iterator[tuple[str, np.ndarray]]:
    """Names and values of these variables of a sealed file (of all that have a checksum unless told).

    Raises Changed where a value or a header is not what was written; headers come first, because a
    damaged size would be read as an array of any length.
    """
    file.set_auto_mask(False)
    try:
        sums = json.loads(file.getncattr(ATTRIBUTE))
        headers, values = sums["headers"], dict(sums["values"])
    except (ValueError, TypeError, KeyError):
        raise Changed("its checksums are damaged") from None
    if headers != _of_headers(file):
        raise Changed("its names, sizes or attributes have changed")
    for name in values if names is None else names:
        value = file.variables[name][...]
        if values.get(name) != _of_values(value):
            raise Changed(f"the values of {name} have changed")
        yield name, value


def _short(content: bytes) -> str:
    return sha256(content).hexdigest()[:16]


def _of_values(values) -> str:
    """Checksum of numbers or texts."""
    array = np.asarray(values)
    if array.dtype.kind in "OUS":
        return _short(json.dumps(array.tolist(), default=repr).encode())
    return _short(array.tobytes())


def _of_headers(file: netCDF4.Dataset) -> str:
    """Checksum of all attributes but the checksums, of dimensions, and of what variables are."""
    dimensions = {name: len(dimension) for name, dimension in file.dimensions.items()}
    variables = {
        name: [str(variable.dtype), variable.dimensions, _attributes(variable)]
        for name, variable in file.variables.items()
    }
    about = [_attributes(file), dimensions, variables]
    return _short(json.dumps(about, sort_keys=True, default=repr).encode())


def _attributes(holder) -> dict:
    """Attributes with their types: 1 and 1.0 are not the same."""
    found = {}
    for name in holder.ncattrs():
        if name != ATTRIBUTE:
            value = np.asarray(holder.getncattr(name))
            found[name] = [value.dtype.kind + str(value.dtype.itemsize), value.tolist()]
    return found
