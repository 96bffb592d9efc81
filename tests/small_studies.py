"""Studies beside the library: each works in its smallest form, and the rest without it."""

import shutil

from project import CONFIG, ROOT
from sweeps import assert_shown_and_drawn, of_file
from workflows import completed, run

import studies
from studies.common.results import write_results


def assert_the_rest_works_without(copy, folder, names):
    """The workflow plans the paper, and the other studies answer; all of them may go with their folder."""
    shutil.copytree(copy, folder)
    for name in names:
        shutil.rmtree(folder / studies.FOLDERS[name].relative_to(ROOT), ignore_errors=True)
    if names == studies.NAMES:
        shutil.rmtree(folder / "studies")
    completed(folder, "-n")
    if names != studies.NAMES:
        run("-m", "studies", "--help", cwd=folder)


def assert_works_in_its_smallest_form(name, folder):
    """Its runs are made below the working folder, and its file is written, shown and drawn."""
    config = CONFIG / "smoke.yaml"
    if studies.has_sweep(name):
        of_file(config := studies.FOLDERS[name] / "smoke.yaml")
    write_results(name, file := folder / f"{name}.nc", config)
    assert_shown_and_drawn(name, file)
