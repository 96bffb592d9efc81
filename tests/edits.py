"""Thirty edits: which of them make runs again?  python tests/edits.py shows of each whether bits change.

`AGAIN` change, or may change, a bit of a run by one operation; `KEPT` change none. Each puts something else
for what is there in a file, or adds to it. tests/test_identity.py asks for the names of runs after each.
The script makes a run too, and compares its drag, bit by bit: some twenty seconds an edit.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
LINE = "\nEDITED = True\n"

AGAIN = {
    "the order of a sum": (
        "dem/packing/minimise.py",
        "vx * vx + vy * vy + g2 * w * w",
        "g2 * w * w + (vx * vx + vy * vy)",
    ),
    "the order of a product": (
        "dem/contacts/force_law.py",
        "(sqrt_overlap + kept * last_sqrt_overlap) * slip",
        "(slip * sqrt_overlap + slip * kept * last_sqrt_overlap)",
    ),
    "a constant of the law": (
        "dem/contacts/force_law.py",
        "zeta = alpha / math.sqrt(5.0)",
        "zeta = alpha / math.sqrt(5.1)",
    ),
    "less for at most": ("dem/packing/minimise.py", "push > 0.0 else 0.0", "push >= 0.0 else 0.0"),
    "a constant of packing": (
        "dem/packing/minimise.py",
        "ALPHA_START = 0.25",
        "ALPHA_START = 0.26",
    ),
    "a constant of the step": (
        "dem/dynamics/critical_step.py",
        "* 2.0 / max(rate + root",
        "* 1.9 / max(rate + root",
    ),
    "the skin": ("dem/dynamics/skin.py", "SKIN = 0.12", "SKIN = 0.13"),
    "a flag of the compiler": (
        "dem/jit/compilation.py",
        '{"contract", "arcp", "nsz"}',
        '{"arcp", "nsz"}',
    ),
    "the version of Numba": (
        "dem/base/provenance.py",
        'names = ("numpy", "numba", "llvmlite")',
        'names = ("numpy", "numba", "llvmlite", "scipy")',
    ),
    "a default": (
        "dem/experiment/sections.py",
        'critical one", 0.3, le=10)',
        'critical one", 0.4, le=10)',
    ),
    "the stream of a seed": (
        "dem/experiment/box.py",
        "default_rng([seed, 0])",
        "default_rng([seed, 1])",
    ),
    "what is recorded": (
        "dem/experiment/observables/drag.py",
        '"drag": -total[:, 1]',
        '"drag": -1.0 * total[:, 1]',
    ),
    "when it is recorded": ("dem/experiment/kinds/drag.py", "BINS_A_CALL = 20", "BINS_A_CALL = 21"),
    "the layout of files": ("dem/experiment/config.py", "LAYOUT = 1", "LAYOUT = 2"),
}
KEPT = {
    "a comment": ("dem/contacts/force_law.py", None, "\n# edited\n"),
    "a docstring": (
        "dem/experiment/scene.py",
        '"""The scene of the run."""',
        '"""Another word."""',
    ),
    "an annotation": ("dem/experiment/kinds/drag.py", "checkpoint: Path | None", "checkpoint: str | None"),
    "a local variable of a kernel": ("dem/contacts/force_law.py", "kept", "held"),
    "a local variable of the reader": ("dem/experiment/config.py", "plain", "bare"),
    "an import for types": (
        "dem/dynamics/result.py",
        "if TYPE_CHECKING:\n",
        "if TYPE_CHECKING:\n    import pandas\n",
    ),
    "an error's sentence": (
        "dem/dynamics/simulation.py",
        "put it inside, or take",
        "set it inside, or take",
    ),
    "how a value is checked": (
        "dem/experiment/config.py",
        'raise InputError(f"shape is',
        'raise ValueError(f"shape is',
    ),
    "a key with a default": (
        "dem/experiment/config.py",
        "    ellipse: EllipseSection = EllipseSection()\n",
        '    ellipse: EllipseSection = EllipseSection()\n    tilt: NotNegative = value("rad", "tilt", 0.0, 0.0)\n',
    ),
    "a line of files": ("dem/base/files.py", None, LINE),
    "a line of the layout of files": ("dem/io/dataset.py", None, LINE),
    "a line of checkpoints": ("dem/experiment/resume.py", None, LINE),
    "a line of the store": ("dem/sweep/store.py", None, LINE),
    "a line of the report": ("dem/report/build.py", None, LINE),
    "one more experiment": ("dem/experiment/kinds/heat.py", None, "SECTIONS = {}\n"),
    "one more observable": ("dem/experiment/observables/heat.py", None, "VARIABLES = {}\n"),
}

ASK = """
import sys
from dem.sweep.config import load
sweep = load("config/smoke.yaml")
for label in ("c1", "e3"):
    run = sweep.changed({}, label).replicate(label, 3900.0, 1)
    print(run.id, run.bed_id)
"""


def copied(folder: Path) -> Path:
    """A copy of what runs need."""
    for name in ("dem", "config"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


def edit(folder: Path, file: str, there: str | None, instead: str) -> None:
    """Put something else for what is there in a file of a copy, or add to it."""
    path = folder / file
    text = path.read_text() if path.exists() else ""
    assert there is None or there in text, f"{file} has no {there!r}"
    path.write_text(text + instead if there is None else text.replace(there, instead))


def asked(folder: Path, code: str = ASK) -> str:
    """What a program prints with the package of a copy."""
    environment = os.environ | {"PYTHONPATH": str(folder)}
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env=environment, text=True, capture_output=True
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


RUN = """
import dem
found = dem.run_experiment({"extends": "config/smoke.yaml", "shape": "c1"})
print(found["drag"].values.tobytes().hex()[:4000])
"""


def main():
    before = None
    for again, edits in (
        (None, {"nothing": ("dem/base/files.py", None, "")}),
        (True, AGAIN),
        (False, KEPT),
    ):
        for name, change in edits.items():
            with tempfile.TemporaryDirectory() as folder:
                copy = copied(Path(folder) / "copy")
                edit(copy, *change)
                try:
                    found = asked(copy), asked(copy, RUN)
                except AssertionError as error:
                    print(json.dumps({"edit": name, "error": str(error)[-200:]}), flush=True)
                    continue
            before = before or found
            told = {
                "edit": name,
                "should": again,
                "again": found[0] != before[0],
                "bits": found[1] != before[1],
            }
            print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main()
