"""What the rules say of their jobs, without a job: the code that one depends on, and the cores that it takes."""

import ast
import os
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from project import ROOT, needs_study, posix
from snakemake.api import SnakemakeApi
from snakemake.iocontainers import Wildcards
from snakemake.settings.types import ConfigSettings, OutputSettings, Quietness, ResourceSettings

from dem.base.source_hash import run_codes
from studies import FOLDERS, package_of
from studies.catalogue import figures, reported

pytestmark = [posix, pytest.mark.quick, needs_study("claims", "benchmark")]
CORES, THREADS = 3, 2


@pytest.fixture(scope="module")
def rules(tmp_path_factory):
    """The rules by name, where a hash of code is the files that it is of; and the names that they know."""
    with (
        pytest.MonkeyPatch.context() as patch,
        SnakemakeApi(OutputSettings(quiet={Quietness.ALL})) as api,
    ):
        patch.chdir(tmp_path_factory.mktemp("planned"))
        patch.setattr(sys, "path", sys.path.copy())  # which the rules change, and these two
        for name in ("PATH", "PYTHONPATH"):
            patch.setenv(name, os.environ.get(name, ""))
        config = ConfigSettings({"threads": THREADS}, configfiles=[ROOT / "config/smoke.yaml"])
        workflow = api.workflow(ResourceSettings(CORES), config, snakefile=ROOT / "Snakefile")
        known = workflow._workflow
        known.globals.update(codes=lambda files, folder: dict.fromkeys(files), code_hash=tuple)
        known.globals["code_of"].cache_clear()
        yield {rule.name: rule for rule in known.rules}


def code(rule, **wildcards):
    """The files whose code a job depends on."""
    return set(rule.params.code(Wildcards(fromdict=wildcards)))


@cache
def named(file: Path):
    """The files of the project that a file imports."""
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    places = [ROOT.joinpath(*name.split(".")) for name in names]
    paths = {path for place in places for path in (place.with_suffix(".py"), place / "__init__.py")}
    return set(filter(Path.is_file, paths))


# Rooms that make the numbers of pages and pictures; the rooms below make runs, or read, check and write.
ROOMS = [
    ROOT / room for room in ("dem/analysis", "dem/base/statistics.py", "dem/figures", "studies")
]
LISTS = "catalogue.py", "__init__.py", "__main__.py"  # of what there is


def needed(file: Path):
    """A file of these rooms, and all of them that it imports, directly or not."""
    found, queue = set(), [file]
    while queue:
        path = queue.pop()
        if path not in found and any(path.is_relative_to(room) for room in ROOMS):
            found.add(path)
            queue += named(path)
    return {path for path in found if path.name not in LISTS}


@pytest.mark.parametrize("name", figures())
def test_a_figure_depends_on_all_that_makes_its_numbers(rules, name):
    """On each file of these rooms that its own imports, and on no other figure."""
    file = ROOT / f"{figures()[name].module.replace('.', '/')}.py"
    files = code(rules["figure"], figure=name, folder="results")
    assert needed(file) <= files
    drawn = {ROOT / f"{figure.module.replace('.', '/')}.py" for figure in figures().values()}
    assert files & drawn <= needed(file) | {ROOT / "dem/figures/sweep.py"}


@pytest.mark.parametrize("study", reported())
def test_results_and_table_of_a_study_depend_on_all_that_makes_their_numbers(rules, study):
    """What a study measures by itself depends on the code of runs too."""
    for rule, name in ("results", "results.py"), ("table", "findings.py"):
        files, runs = code(rules[rule], study=study), set(run_codes())
        assert needed(FOLDERS[study] / name) <= files
        assert runs <= files if rule == "results" and measures(study) else runs.isdisjoint(files)


def measures(study):
    """Whether a study declares that it simulates or measures by itself."""
    return getattr(import_module(f"{package_of(study)}.results"), "MEASURES", False)


@pytest.mark.parametrize("study", reported())
def test_what_measures_takes_all_cores_and_what_reads_takes_one(rules, study):
    """A batch takes the threads of its runs."""
    assert rules["batch"].resources["_cores"].value == THREADS
    cores = rules["results"].resources["_cores"].evaluate(Wildcards(fromdict={"study": study}))
    assert cores.value == (CORES if measures(study) else 1)
