"""Files of granules beside a sweep file: CSV, text dumps of LAMMPS, and files of results."""

import re
from itertools import product
from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.experiment.granule_table import GranuleTable, table_of, table_of_lines

NETCDF = b"\x89HDF", b"CDF"  # how such files begin
DUMP = "ITEM:"
SECTIONS = "NUMBER OF ATOMS", "BOX BOUNDS", "ATOMS"  # of a dump
NUMBERS = "id", "x", "y", "xu", "yu", "xs", "ys", "xsu", "ysu", "angle", "diameter", "radius"


def with_granules(data: dict, source: str, folder: Path) -> dict:
    """Values of a file, with the lines of a table in place of the file in its folder that has them."""
    packing = data.get("packing")
    if not isinstance(packing, dict) or not isinstance(words := packing.get("file"), str):
        return data
    start = f"{source}: packing.file is {words!r}; "
    try:
        table = _granules(words, folder)
    except OSError as error:
        raise InputError(f"{start}it cannot be read ({error.strerror or error}).") from None
    except (InputError, ValueError) as error:
        raise InputError(f"{start}{str(error).removesuffix('.')}.") from None
    return data | {"packing": packing | {"file": list(table.lines)}}


def _granules(words: str, folder: Path) -> GranuleTable:
    """The granules of a file by its name, and of a file of results by words such as seed=1."""
    name, *select = re.split(r"\s+(?=[^\s=]+=)", words)
    path = folder / name
    content = path.read_bytes()
    if content.startswith(NETCDF):
        return _of_results(path, select)
    if select:
        raise ValueError(f"{' '.join(select)} chooses a run of a file of results; leave it out")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError("it is no text in UTF-8") from None
    if text.startswith(DUMP):
        return _of_dump(text)
    return table_of_lines(tuple(line for line in text.splitlines() if not line.startswith("#")))


def _of_dump(text: str) -> GranuleTable:
    """The last frame of a text dump of LAMMPS, in the order of its id.

    Format: https://docs.lammps.org/dump.html. A dump has no angles: they are zero without a column of
    that name.
    """
    units = re.search(rf"{DUMP} UNITS\s+(\S+)", text)
    if units and units[1] != "si":
        raise ValueError(f"its units are {units[1]}; they must be si")
    frame, sections = text.rpartition(f"{DUMP} TIMESTEP")[2], {}
    for section in frame.split(DUMP)[1:]:
        head, *rows = section.strip().splitlines()
        name = next((name for name in SECTIONS if head.startswith(name)), head)
        sections[name] = head.removeprefix(name).split(), list(map(str.split, rows))
    try:
        names, rows = sections["ATOMS"]
        (count,), bounds = sections["NUMBER OF ATOMS"][1][0], sections["BOX BOUNDS"][1]
    except (KeyError, ValueError, IndexError):
        raise ValueError("its last frame is no frame of a text dump") from None
    if len(rows) != int(count) or any(len(row) != len(names) for row in rows):
        raise ValueError(f"its last frame must have {count} lines of {len(names)} values")
    texts = dict(zip(names, zip(*rows, strict=True), strict=False))  # some may be no numbers
    columns = {name: np.array(texts[name], float) for name in NUMBERS if name in texts}
    taken = {name: columns[name] for name in ("angle", "diameter") if name in columns}
    if "radius" in columns:
        taken["diameter"] = 2.0 * columns["radius"]
    for (axis, ends), end in product(zip("xy", bounds, strict=False), ("", "u", "s", "su")):
        if (values := columns.get(axis + end)) is not None:
            if "s" in end:
                if len(ends) != 2:
                    raise ValueError("its box is tilted; let it give x and y in place of xs and ys")
                low, high = map(float, ends)
                values = low + (high - low) * values
            taken.setdefault(axis, values)
    if "id" in columns:
        order = np.argsort(columns["id"])
        taken = {name: values[order] for name, values in taken.items()}
    return table_of(taken)


def _of_results(path: Path, select: list[str]) -> GranuleTable:
    """The last snapshot of a run."""
    from dem.io.lazily import open_lazily  # half a second to load
    from dem.sweep.selection import run_of

    names = {"x": "granule_x", "y": "granule_y", "angle": "granule_angle", "diameter": "granule_diameter"}  # fmt: skip
    with open_lazily(path) as dataset:
        if not {"run_id", *names.values()} <= dataset.variables.keys():
            raise ValueError("it has no snapshots of runs")
        last = run_of(dataset, select).isel(snapshot=-1)
        # others may have more, and some may have left
        last = last.dropna("granule", subset=["granule_diameter", "granule_x"])
        if not last.sizes["granule"]:
            raise ValueError("this run failed")
        return table_of({column: last[name].values for column, name in names.items()})
