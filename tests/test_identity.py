"""A run is made again where an edit may change its bits, and nowhere else."""

import hashlib
import json
from importlib import import_module

import pytest
from edits import AGAIN, KEPT, asked, copied, edit

from dem.experiment.config import EXPERIMENTS, LAYOUT
from dem.experiment.observables import OBSERVABLES, module_of
from dem.io import dataset

EDITS = {**AGAIN, **KEPT}


@pytest.fixture(scope="module")
def before(tmp_path_factory):
    """A copy of the package, and the names of its runs."""
    folder = copied(tmp_path_factory.mktemp("edited") / "copy")
    return folder, asked(folder)


@pytest.mark.parametrize("name", EDITS)
def test_a_run_is_made_again_only_where_its_bits_may_change(before, name):
    folder, names = before
    path = folder / EDITS[name][0]
    text = path.read_text() if path.exists() else None
    edit(folder, *EDITS[name])
    try:
        assert (asked(folder) != names) == (name in AGAIN)
    finally:
        if text is None:
            path.unlink()
        else:
            path.write_text(text)


# what runs of each version of the layout hold: raise LAYOUT, and add a line, where this changes
LAYOUTS = {1: "e5191c8438788141"}


def test_another_layout_of_the_files_of_runs_has_another_version():
    """Because what only writes files is no part of what a run is known by."""
    tables = [dataset.AXES, dataset.LABELS, dataset.OF_RUN, dataset.OF_STORE]
    tables += [module_of(name).VARIABLES for name in OBSERVABLES]
    for name in EXPERIMENTS:
        tables.append(getattr(import_module(f"dem.experiment.kinds.{name}"), "VARIABLES", {}))
    # names, dimensions and units; words may change
    told = [{name: entry[:2] for name, entry in table.items()} for table in tables]
    digest = hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:16]
    assert LAYOUTS[LAYOUT] == digest
