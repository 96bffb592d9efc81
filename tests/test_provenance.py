"""The compiled kernels are never stale."""

import re
import shutil

from dem.base import provenance


def holds_compiled_code(file):
    """Whether a file decorates functions for the compiler."""
    return re.search(r"^@(compiled|inlined|optional)\b|njit", file.read_text(), re.M)


def test_every_file_with_compiled_code_counts():
    """No file left out of the hash of the cache folder feeds code that is compiled elsewhere.

    Numba notices an edit of the file that holds a compiled function, so that a study may compile
    functions for itself, but no other file with compiled code may take them from it.
    """
    left_out = {
        file for name in provenance._NOT_COMPILED for file in
        ((provenance.PACKAGE / name).rglob("*.py") if (provenance.PACKAGE / name).is_dir()
         else [provenance.PACKAGE / name])
    }  # fmt: skip
    compiled = {file for file in provenance.PACKAGE.rglob("*.py") if holds_compiled_code(file)}
    studies = compiled & left_out
    assert {file.parent.name for file in studies} <= {"accuracy"}
    for study in studies:
        for file in compiled - {study}:
            assert not re.search(
                rf"\b{study.parent.name}[. ].*\b{study.stem}\b", file.read_text()
            ), file


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
    with (tmp_path / "dem/dynamics/simulation.py").open("a") as file:
        file.write("# edited\n")
    assert hashes()[0] != before[0] and hashes()[1] == before[1]
    with (tmp_path / "dem/contacts/loops.py").open("a") as file:
        file.write("# edited\n")
    assert hashes()[1] != before[1]
