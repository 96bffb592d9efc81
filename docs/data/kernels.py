"""The code that decides how granules move, as hashes: what a released number is compared with.

python docs/data/kernels.py        for `kernels` in a file that is written by hand
"""

import hashlib
import json
from pathlib import Path

from dem.base.sources import ROOT, _read

# What decides how granules move. The rest of dem.dynamics drives these kernels and reads them.
ROOMS = "contacts", "dynamics", "jit", "packing", "shapes"
DRIVERS = (
    "dynamics/simulation.py",
    "dynamics/checkpoint.py",
    "dynamics/result.py",
    "shapes/check.py",
)


def kernels(package: Path) -> dict[str, str]:
    """Hash of the code of every module that decides how granules move, by its path in the package.

    Comments, docstrings and the words of errors do not count.
    """
    found = {
        path.relative_to(package).as_posix(): path
        for room in ROOMS
        for path in sorted((package / room).rglob("*.py"))
    }
    return {name: _read(path).code[:16] for name, path in found.items() if name not in DRIVERS}


def digest(modules: dict[str, str] | None = None) -> str:
    """One hash of what `kernels` returned; of today's if None."""
    modules = modules or kernels(ROOT / "dem")
    return hashlib.sha256(json.dumps(modules).encode()).hexdigest()[:16]


if __name__ == "__main__":
    print(digest())
