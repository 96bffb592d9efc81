"""The catalogue of faults that the quick part of the suite must notice (mutants.py)."""

import pytest
from mutants import MUTANTS, PROJECT


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda m: f"{m.file} {m.kind}")
def test_a_fault_can_still_be_put_into_the_code(mutant):
    """What it replaces is there once, and what replaces it is Python."""
    text = (PROJECT / "dem" / mutant.file).read_text(encoding="utf-8")
    assert text.count(mutant.right) == 1
    compile(text.replace(mutant.right, mutant.wrong), mutant.file, "exec")


def test_the_faults_are_of_all_rooms_and_no_two_are_one():
    """In every room whose numbers can be wrong, and where files are written."""
    assert len({(m.file, m.right, m.wrong) for m in MUTANTS}) == len(MUTANTS)
    assert {m.file.partition("/")[0] for m in MUTANTS} == {
        "contacts", "dynamics", "shapes", "packing", "experiment", "sweep", "io", "analysis", "jit", "base",
    }  # fmt: skip
