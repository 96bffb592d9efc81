"""Machine code is found again wherever the same sources lie, and never that of others."""

import os
import shutil
import subprocess
import sys

from dem.provenance import PACKAGE

ASK = """
import numpy as np
from dem.survey import kinetic
kinetic(np.ones((2, 8)), np.ones(2), None)
print(*(sum(count.values()) for count in (kinetic.stats.cache_hits, kinetic.stats.cache_misses)))
"""


def asked(folder, cache):
    """Hits and misses of one kernel in a process that uses the sources in a folder."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(folder)}
    ran = subprocess.run(
        [sys.executable, "-c", ASK], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stderr
    return tuple(map(int, ran.stdout.split()))


def test_copies_share_kernels_and_edits_do_not(tmp_path):
    """Another copy of the same sources compiles nothing; one edited character does."""
    ignore = shutil.ignore_patterns("__pycache__")
    for name in ("first", "second"):
        shutil.copytree(PACKAGE, tmp_path / name / "dem", ignore=ignore)
    assert asked(tmp_path / "first", tmp_path / "cache") == (0, 1)
    assert asked(tmp_path / "second", tmp_path / "cache") == (1, 0)
    with (tmp_path / "second/dem/columns.py").open("a") as file:
        file.write("#")
    assert asked(tmp_path / "second", tmp_path / "cache") == (0, 1)
