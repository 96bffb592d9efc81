"""What a result was made from: source hash, versions, git revision."""

import hashlib
import importlib.metadata
import platform
import subprocess
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent

# What can not change a replicate, and what holds no compiled code; all else counts.
_NOT_PHYSICS = {
    "__main__.py", "accuracy", "batch.py", "benchmark", "claims", "figures", "flow", "report", "stability", "calibrate.py", "checkpoint.py", "cli.py",
    "combine.py", "failures.py", "files.py", "info.py", "progress.py", "sources.py", "statistics.py", "study.py", "tables.py", "terminal.py",
    "tiling.py", "touching.py", "workplace.py",
}  # fmt: skip
_NOT_COMPILED = _NOT_PHYSICS | {
    "__init__.py", "assembly.py", "compaction.py", "config.py", "dataset.py", "drag.py", "errors.py", "packing.py", "provenance.py", "room.py",
    "scene.py", "schema.py", "simulation.py", "stopping.py", "validate.py", "warmup.py", "yaml_file.py",
}  # fmt: skip


def _hash_without(names) -> str:
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE)
        if name.parts[0] not in names:
            digest.update(str(name).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


@cache
def source_hash() -> str:
    """SHA-256 of the sources that a replicate depends on."""
    return _hash_without(_NOT_PHYSICS)


@cache
def compiled_hash() -> str:
    """SHA-256 of the sources that the compiled kernels depend on."""
    return _hash_without(_NOT_COMPILED)


@cache
def versions() -> str:
    """Python and the packages that touch the numbers, as one line."""
    names = ("numpy", "numba", "llvmlite", "netCDF4")
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return f"Python {platform.python_version()}, {packages}"


@cache
def git_revision() -> str:
    """Revision of the checkout, "-dirty" if edited, "unknown" outside a repository."""
    if not (PACKAGE.parent / ".git").exists():  # some other project's repository may lie above
        return "unknown"
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
