"""What the night puts into the code: an edit may take the text of a fault away, or the test that it asks."""

import subprocess

import pytest
from project import ROOT, quick


@quick
@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="a copy may have one of the faults")
def test_each_fault_of_the_night_fits_the_code_and_asks_a_test_that_is_there():
    night = pytest.importorskip("nightly.mutants")  # Windows lacks some of it
    for fault, asks in night.FAULTS.items():
        if isinstance(fault, night.Mutant):
            text = (ROOT / "dem" / fault.file).read_text(encoding="utf-8")
            assert text.count(fault.right) == 1, fault
        else:
            subprocess.run(["git", "apply", "--check", fault], cwd=ROOT, check=True)
        file, _, test = asks.partition("::")
        assert not test or test.partition("[")[0] in (ROOT / file).read_text(encoding="utf-8"), asks
