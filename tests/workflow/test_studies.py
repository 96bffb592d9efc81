"""Studies beside the library: each may go, and the rest works."""

import shutil
import subprocess
import sys

import pytest
from project import CONFIG, needs_study, posix
from sweeps import assert_shown_and_drawn, of_file
from workflows import snakemake

import studies
from dem.figures.catalogue import drawable_from
from dem.io.lazily import open_lazily
from studies.catalogue import figures, reported
from studies.common.results import write_results

ROOT = CONFIG.parent


def assert_the_rest_works_without(copy, folder, names):
    """The workflow plans the paper, and the other studies answer; all of them may go with their folder."""
    shutil.copytree(copy, folder)
    for name in names:
        shutil.rmtree(folder / studies.FOLDERS[name].relative_to(ROOT), ignore_errors=True)
    if names == studies.NAMES:
        shutil.rmtree(folder / "studies")
    run = snakemake(folder, "-n")
    assert run.returncode == 0, run.stdout + run.stderr
    if names != studies.NAMES:
        command = [sys.executable, "-m", "studies", "--help"]
        assert subprocess.run(command, cwd=folder, capture_output=True).returncode == 0


@pytest.mark.parametrize("names", [studies.NAMES, studies.NAMES[::2], studies.NAMES[1::2]])
@posix
def test_studies_can_be_removed(copy, tmp_path, names):
    """All, or every other one; each alone is removed at night."""
    assert_the_rest_works_without(copy, tmp_path / "copy", names)


ELSEWHERE = {"claims", "benchmark"}  # the workflow makes its file; kernels of its own, at night


@pytest.mark.parametrize("name", sorted(reported().keys() - ELSEWHERE))
def test_a_study_works_in_its_smallest_form(name, tmp_path, monkeypatch):
    """Its runs are made, and its file is written, shown and drawn."""
    monkeypatch.chdir(tmp_path)
    config = CONFIG / "smoke.yaml"
    if studies.has_sweep(name):
        of_file(config := studies.FOLDERS[name] / "smoke.yaml")
    write_results(name, file := tmp_path / f"{name}.nc", config)
    assert_shown_and_drawn(name, file)


@needs_study("verification")
def test_a_file_without_runs_suffices_for_the_figures_of_its_study():
    with open_lazily(studies.FOLDERS["verification"] / "verification.nc") as dataset:
        assert "verification" in drawable_from(dataset, figures())
