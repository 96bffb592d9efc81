"""Studies beside the library, in their smallest form."""

from project import CONFIG
from sweeps import assert_shown_and_drawn, of_file

import studies
from studies.common.results import write_results


def assert_works_in_its_smallest_form(name, folder):
    """Its runs are made below the working folder, and its file is written, shown and drawn."""
    config = CONFIG / "smoke.yaml"
    if studies.has_sweep(name):
        of_file(config := studies.FOLDERS[name] / "smoke.yaml")
    write_results(name, file := folder / f"{name}.nc", config)
    assert_shown_and_drawn(name, file)
