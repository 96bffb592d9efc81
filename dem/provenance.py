"""What a result was made from: source hash, versions, git revision."""

import hashlib
import importlib.metadata
import platform
import subprocess
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent

# Edits to these can not change a replicate; everything else in the package can.
_NOT_PHYSICS = ("figures", "cli.py", "combine.py", "info.py", "calibrate.py", "expansion.py")


@cache
def source_hash() -> str:
    """SHA-256 of the sources that a replicate depends on."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE)
        if name.parts[0] not in _NOT_PHYSICS:
            digest.update(str(name).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def versions() -> str:
    """Python and the packages that touch the numbers, as one line."""
    names = ("numpy", "numba", "llvmlite", "netCDF4")
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return f"Python {platform.python_version()}, {packages}"


@cache
def git_revision() -> str:
    """Revision of the checkout, "-dirty" if edited, "unknown" outside a repository."""
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
