"""The compiled kernels are never stale."""

import re
import shutil

from dem import provenance


def test_every_file_with_compiled_code_counts():
    """No file left out of the hash of the cache folder holds or feeds compiled code."""
    for name in provenance._NOT_COMPILED:
        path = provenance.PACKAGE / name
        files = path.rglob("*.py") if path.is_dir() else [path]
        for file in files:
            code = file.read_text()
            assert not re.search(r"^@(compiled|inlined|optional)\b", code, re.M), file
            assert "njit" not in code, file


def test_an_edit_changes_the_hash(monkeypatch, tmp_path):
    """A copy of the package with one edited kernel has another hash; an edited figure has not."""
    shutil.copytree(provenance.PACKAGE, tmp_path / "dem")
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "dem")

    def hashes():
        names = provenance._NOT_PHYSICS, provenance._NOT_COMPILED
        return tuple(provenance._hash_without(left_out) for left_out in names)

    before = hashes()
    with (tmp_path / "dem/figures/style.py").open("a") as file:
        file.write("# edited\n")
    assert hashes() == before
    with (tmp_path / "dem/simulation.py").open("a") as file:
        file.write("# edited\n")
    assert hashes()[0] != before[0] and hashes()[1] == before[1]
    with (tmp_path / "dem/kernel.py").open("a") as file:
        file.write("# edited\n")
    assert hashes()[1] != before[1]
