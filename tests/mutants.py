"""Does the suite notice a broken kernel?  python tests/mutants.py  (some minutes; not part of pytest)

Each mutant is one fault put into a copy of the project; the tests named beside it must fail on it.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

PROJECT = Path(__file__).parent.parent


class Mutant(NamedTuple):
    """A fault: in `file`, `right` becomes `wrong`; `tests` are asked."""

    fault: str
    file: str
    right: str
    wrong: str
    tests: str


MUTANTS = (
    Mutant("sign of damping turned", "dem/contacts/force_law.py", "elastic + damping", "elastic - damping",
           "tests/test_collision.py"),
    Mutant("memory not carried to a new list", "dem/dynamics/neighbor_list.py",
           "new[p] = old[source[p]]", "new[p] = 0.0", "tests/test_neighbors.py"),
    Mutant("list never made again", "dem/dynamics/stepping.py",
           "world = rebuild_neighbor_list(world, table)  # by value", "world = world", "tests/test_simulate.py"),
    Mutant("torque of walls and cylinder reversed", "dem/contacts/blocks.py",
           "gx, gy, -torque, 0.0)", "gx, gy, torque, 0.0)",
           "tests/test_force_reference.py"),
)  # fmt: skip


def survives(mutant: Mutant) -> bool:
    """Whether all tests pass in spite of the fault; prints the first that does not."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "project"
        shutil.copytree(
            PROJECT, copy,
            ignore=shutil.ignore_patterns(".git", ".venv", "results", ".snakemake", "__pycache__"),
        )  # fmt: skip
        broken = copy / mutant.file
        text = broken.read_text()
        assert text.count(mutant.right) == 1, f"{mutant.file} has no single {mutant.right!r}"
        broken.write_text(text.replace(mutant.right, mutant.wrong))
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-n0", "--no-header", mutant.tests]
        environment = os.environ | {"NUMBA_CACHE_DIR": str(copy / ".numba")}
        ran = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True)
    said = [line for line in ran.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    print(f"{mutant.fault}: {said[0] if said else 'NOT NOTICED ' + ran.stderr[-500:]}", flush=True)
    return ran.returncode != 1  # pytest: some tests failed


if __name__ == "__main__":
    sys.exit(any([survives(mutant) for mutant in MUTANTS]))
