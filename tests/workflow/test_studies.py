"""Studies beside the library: each may go, and the rest works."""

import shutil

import pytest
from project import ROOT, needs_study, posix
from small_studies import assert_works_in_its_smallest_form
from workflows import completed, run

import studies
from dem.figures.catalogue import drawable_from
from dem.io.lazily import open_lazily
from studies.catalogue import figures, reported


@pytest.mark.parametrize("names", [studies.NAMES, studies.NAMES[::2], studies.NAMES[1::2]])
@posix
def test_studies_can_be_removed(copy, tmp_path, names):
    """All with their folder, or every other one: the workflow plans the paper, and the other studies answer."""
    folder = shutil.copytree(copy, tmp_path / "copy")
    for name in names:
        shutil.rmtree(folder / studies.FOLDERS[name].relative_to(ROOT), ignore_errors=True)
    if names == studies.NAMES:
        shutil.rmtree(folder / "studies")
    completed(folder, "-n")
    if names != studies.NAMES:
        run("-m", "studies", "--help", cwd=folder)


ELSEWHERE = {"claims", "benchmark"}  # the workflow makes its file; kernels of its own, at night


@pytest.mark.parametrize("name", sorted(reported().keys() - ELSEWHERE))
def test_a_study_works_in_its_smallest_form(name, folder):
    """Its runs are made, and its file is written, shown and drawn."""
    assert_works_in_its_smallest_form(name, folder)


@needs_study("verification")
def test_a_file_without_runs_suffices_for_the_figures_of_its_study():
    with open_lazily(studies.FOLDERS["verification"] / "verification.nc") as dataset:
        assert "verification" in drawable_from(dataset, figures())
