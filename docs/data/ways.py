"""The ways of two numbers through the package, in one run that this process makes: the friction of granules from a
sweep file to the kernel, and the force of a bin back to drag.nc.

    python docs/data/ways.py

Counted are functions of dem, and their files, that have the number among their arguments or in their result: itself, or
at most DEPTH members deep in tuples, dictionaries, arrays and objects.
"""

import os
import sys
import tempfile
from pathlib import Path

import numpy as np
import xarray as xr

from dem.base.source_hash import PACKAGE
from dem.sweep.library import run_sweep

DEPTH = 2
FRICTION = 0.31234567
SWEEP = f"""
results: results/way
extends: {PACKAGE.parent / "config/smoke.yaml"}
sweep: {{case: [c1], friction.granule: [{FRICTION}], seed: [1]}}
"""


def holds(value, number: float, depth: int = DEPTH) -> bool:
    """Whether a value is a number, or has it among its members."""
    if isinstance(value, float | np.floating):
        return value == number
    if isinstance(value, str | bytes):
        return repr(number) in str(value)
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "f" and bool((value == number).any())
    if depth == 0:
        return False
    if isinstance(value, dict):
        members = value.values()
    elif isinstance(value, list | tuple):
        members = value
    else:
        members = getattr(value, "__dict__", {}).values()
    return any(holds(member, number, depth - 1) for member in members)


def way(number: float, folder: Path) -> tuple[dict[str, None], xr.Dataset]:
    """Functions of dem that have a number, in the order in which they first have it, in a sweep of one run; and its data."""
    os.chdir(folder)
    (folder / "way.yaml").write_text(SWEEP, encoding="utf-8")
    found: dict[str, None] = {}

    def notice(frame, event, result):
        code = frame.f_code
        file = code.co_filename
        if event not in ("call", "return") or not file.startswith(str(PACKAGE)):
            return
        name = f"{Path(file).relative_to(PACKAGE)}: {code.co_qualname}"
        if name in found:
            return
        values = result if event == "return" else tuple(frame.f_locals.values())
        if holds(values, number, DEPTH + 1):
            found[name] = None

    sys.setprofile(notice)
    try:
        data = run_sweep("way.yaml")
    finally:
        sys.setprofile(None)
    return found, data.load()


def main() -> None:
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as two:
        there, data = way(FRICTION, Path(one))
        force = float(data.drag.values.ravel()[data.drag.size // 2])
        back, _ = way(force, Path(two))
    for title, found in (("friction of granules", there), ("force of a bin", back)):
        files = {name.partition(":")[0] for name in found}
        print(f"{title}: {len(found)} functions in {len(files)} files", *found, sep="\n  ")


if __name__ == "__main__":
    main()
