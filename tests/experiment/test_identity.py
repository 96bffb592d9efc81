"""A run is made again where an edit may change its numbers, and nowhere else."""

import ast
import hashlib
import json
import shutil
from importlib import import_module
from pathlib import Path

import pytest

from dem.base.source_hash import PACKAGE, ROOT, RUNS, code_hash, codes, files_of
from dem.experiment import replicate
from dem.experiment.config import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.io import dataset
from dem.sweep.config import load

LINE = "\nEDITED = True\n"
USED = "experiment/kinds/drag.py", "experiment/observables/drag.py"  # by the run
EDITS = {  # file: what is added, or what is put in place of what
    "contacts/springs.py": LINE,
    "experiment/observables/drag.py": LINE,
    "experiment/phases.py": ("BINS_A_CALL = 20", "BINS_A_CALL = 21"),
}
HARMLESS = {
    "io/dataset.py": LINE,
    "analysis/drag.py": LINE,
    "contacts/response.py": "\n# a comment\n",
    "experiment/scene.py": ('"""The scene of the run."""', '"""Another word."""'),
    "experiment/kinds/drag.py": ("-> np.ndarray:", "-> list:"),
    "experiment/kinds/heat.py": "SECTIONS = {}\n",
}


def hash_of(package: Path) -> str:
    return code_hash(codes(files_of((*RUNS, *USED), package), package))


@pytest.mark.parametrize(
    ("name", "edit", "expected"),
    [(*item, True) for item in EDITS.items()] + [(*item, False) for item in HARMLESS.items()],
)
def test_a_run_is_made_again_only_where_its_numbers_may_change(tmp_path, name, edit, expected):
    package = shutil.copytree(PACKAGE, tmp_path / "dem")
    path, digest = package / name, hash_of(package)
    text = path.read_text() if path.exists() else ""
    path.write_text(text + edit if isinstance(edit, str) else text.replace(*edit))
    assert text != path.read_text() and (hash_of(package) != digest) == expected


BASE = (
    "declarations",
    "errors",
    "files",
    "plugins",
    "messages",
    "provenance",
    "refusals",
    "source_hash",
)
# imported by what makes runs: read, check, write or say something, and set no number
NO_NUMBERS = {
    *(f"base/{name}.py" for name in BASE),
    "experiment/config.py",  # values, which are part of the identity themselves
    "experiment/scene_sections.py",
    "experiment/sections.py",
    "experiment/kinds/__init__.py",
    "experiment/observables/__init__.py",
    "experiment/run_checkpoint.py",
    "io/dataset.py",  # names of variables, whose layout has a version
}


def test_all_that_sets_a_number_of_a_run_is_known():
    """What makes runs imports nothing else of the package."""
    files = set(files_of((*RUNS, "experiment/kinds", "experiment/observables")))
    sources = files | set(files_of(NO_NUMBERS))
    for file in files - {PACKAGE / name for name in NO_NUMBERS}:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("dem."):
                for name in (node.module, *(f"{node.module}.{alias.name}" for alias in node.names)):
                    path = ROOT.joinpath(*name.split(".")).with_suffix(".py")
                    assert path in sources or not path.is_file(), f"{file} imports {path}"


def test_a_run_depends_on_versions(monkeypatch):
    first = load("config/smoke.yaml").block("drag").first.id
    monkeypatch.setattr(replicate, "compilers", lambda: "numba 0.1")
    assert load("config/smoke.yaml").block("drag").first.id != first


# what runs of each version of the layout hold: raise LAYOUT, and add a line, where this changes
LAYOUTS = {
    1: "07117a61fa96d550",
    2: "91b1ae9fe55f297a",
    3: "e1c54b0a87aaee7e",
    4: "c08aec18bef56dfe",
    5: "24a144b0957c1d1d",
    6: "8e51c47a446ea2aa",
}


def test_another_layout_of_the_files_of_runs_has_another_version():
    """Because what only writes files is no part of the identity of a run."""
    tables = [EXPERIMENTS["drag"]["AXIS"], dataset.LABELS, dataset.OF_RUN, dataset.OF_STORE]
    tables += [header["VARIABLES"] for header in OBSERVABLES.values()]
    for name in EXPERIMENTS:
        tables.append(getattr(import_module(f"dem.experiment.kinds.{name}"), "VARIABLES", {}))
    # names, dimensions and units; words may change
    layout = [{name: entry[:2] for name, entry in table.items()} for table in tables]
    digest = hashlib.sha256(json.dumps(layout, sort_keys=True).encode()).hexdigest()[:16]
    assert LAYOUTS[replicate.LAYOUT] == digest
