"""What a result was made with: versions of packages, git revision."""

import importlib.metadata
import platform
import subprocess
from functools import cache

from dem import __version__
from dem.base.source_hash import ROOT


@cache
def versions() -> str:
    """Python and the packages that touch the numbers, as one line."""
    netcdf = importlib.metadata.version("netCDF4")
    return f"Python {platform.python_version()}, {compilers()}, netCDF4 {netcdf}"


@cache
def compilers() -> str:
    """Versions of what decides bits beside the code of this package, as one line."""
    names = ("numpy", "numba", "llvmlite")
    return ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)


@cache
def processor() -> str:
    """The kind of processor, as LLVM names it: on another, the last bits of a result may differ."""
    from llvmlite.binding import get_host_cpu_name

    return get_host_cpu_name()


@cache
def git_revision() -> str:
    """Revision of the checkout, "-dirty" if edited; the tag of the release outside a repository."""
    release = f"v{__version__}"
    # a parent folder may be another project's repository
    if not (ROOT / ".git").exists():
        return release
    words = "describe", "--always", "--exclude=*", "--dirty", "--abbrev=12"  # tags can be moved
    command = ["git", "-C", str(ROOT), *words]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return release
