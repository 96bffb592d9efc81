"""What a result was made with: versions of packages, git revision."""

import importlib.metadata
import platform
import subprocess
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent.parent


@cache
def versions() -> str:
    """Python and the packages that touch the numbers, as one line."""
    names = ("numpy", "numba", "llvmlite", "netCDF4")
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return f"Python {platform.python_version()}, {packages}"


@cache
def git_revision() -> str:
    """Revision of the checkout, "-dirty" if edited, "unknown" outside a repository."""
    if not (
        PACKAGE.parent / ".git"
    ).exists():  # a parent folder may be another project's repository
        return "unknown"
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
