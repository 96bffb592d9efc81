"""What the rules say of their jobs, without a job: the code that one depends on, and the cores that it takes."""

import os
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest
from grimp import build_graph
from project import ROOT, needs_study, posix
from snakemake.api import SnakemakeApi
from snakemake.iocontainers import Wildcards
from snakemake.settings.types import ConfigSettings, OutputSettings, Quietness, ResourceSettings

from dem.base.source_hash import run_codes
from studies import package_of
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


def file(module):
    return ROOT / f"{module.replace('.', '/')}.py"


# Rooms that make the numbers of pages and pictures; the rooms below make runs, or read, check and write.
ROOMS = "dem.analysis", "dem.base.statistics", "dem.figures", "studies"
LISTS = ".catalogue", ".__main__"  # of what there is


@cache
def imports():
    """What the modules of these rooms import of each other."""
    graph = build_graph("dem", "studies", cache_dir=None)
    for module in graph.modules:
        if file(module).is_file() and (not module.startswith(ROOMS) or module.endswith(LISTS)):
            graph.remove_module(module)
    return graph


def needed(module):
    """The files of a module and of all that it imports of these rooms, directly or not."""
    return {*filter(Path.is_file, map(file, {module} | imports().find_upstream_modules(module)))}


@pytest.mark.parametrize("name", figures())
def test_a_figure_depends_on_all_that_makes_its_numbers(rules, name):
    """On each file of these rooms that its own imports, and on no other figure."""
    module = figures()[name].module
    files = code(rules["figure"], figure=name, folder="results")
    assert needed(module) <= files
    drawn = {file(figure.module) for figure in figures().values()}
    assert files & drawn <= needed(module) | {file("dem.figures.sweep")}


@pytest.mark.parametrize("study", reported())
def test_results_and_table_of_a_study_depend_on_all_that_makes_their_numbers(rules, study):
    """What a study measures by itself depends on the code of runs too."""
    for rule, name in ("results", "results"), ("table", "findings"):
        files, runs = code(rules[rule], study=study), set(run_codes())
        assert needed(f"{package_of(study)}.{name}") <= files
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
