"""What the rules say of their jobs, without a job: the code that one depends on, and the cores that it takes."""

import ast
import os
import sys
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


def imported(file: Path, seen=()):
    """A file and all of the project that it imports, directly or not, in its own words."""
    found = {file, *seen}
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            place = ROOT.joinpath(*name.split("."))
            for path in (place.with_suffix(".py"), place / "__init__.py"):
                if path.is_file() and path not in found:
                    found |= imported(path, found)
    return found


# Rooms that make numbers of pages and pictures; the other ones make runs, or read, check and write.
MAKING = "dem/analysis", "dem/figures", "studies"


def of_numbers(files):
    """Those of the rooms that make numbers, but for lists of what there is."""
    rooms = [ROOT / room for room in MAKING]
    listing = {"catalogue.py", "__init__.py", "__main__.py"}
    return {
        file
        for file in files
        if file.name not in listing and any(file.is_relative_to(room) for room in rooms)
    }


@pytest.mark.parametrize("name", figures())
def test_a_figure_depends_on_all_that_makes_its_numbers(rules, name):
    """On each file of these rooms that its own imports, and on no other figure."""
    file = ROOT / f"{figures()[name].module.replace('.', '/')}.py"
    files, needed = code(rules["figure"], figure=name, folder="results"), of_numbers(imported(file))
    assert needed <= files
    drawn = {ROOT / f"{figure.module.replace('.', '/')}.py" for figure in figures().values()}
    assert files & drawn <= needed | {ROOT / "dem/figures/sweep.py"}


@pytest.mark.parametrize("study", reported())
def test_results_and_table_of_a_study_depend_on_all_that_makes_their_numbers(rules, study):
    """What a study measures by itself depends on the code of runs too."""
    for rule, name in ("results", "results.py"), ("table", "findings.py"):
        files, runs = code(rules[rule], study=study), set(run_codes())
        assert of_numbers(imported(FOLDERS[study] / name)) <= files
        assert runs <= files if rule == "results" and measures(study) else runs.isdisjoint(files)


def measures(study):
    """Whether a study declares that it simulates or measures by itself."""
    return getattr(import_module(f"{package_of(study)}.results"), "MEASURES", False)


@pytest.mark.parametrize("study", reported())
def test_what_measures_takes_all_cores_and_what_reads_takes_one(rules, study):
    cores = rules["results"].resources["_cores"].evaluate(Wildcards(fromdict={"study": study}))
    assert cores.value == (CORES if measures(study) else 1)


def test_a_batch_takes_the_threads_of_its_runs(rules):
    assert rules["batch"].resources["_cores"].value == THREADS
