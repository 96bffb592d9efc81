"""Tests ask at doors that stay: public names, files, commands. Whoever rewrites a room edits no test of behaviour.

What stays behind a door is a stand-in for something of dem, a name with an underscore, an attribute of dem that is
put in place of another, and what is inside of the engine.
"""

import ast

import pytest
from project import ROOT

pytestmark = pytest.mark.quick
FILES = [ROOT / "conftest.py", *ROOT.glob("tests/**/*.py"), *ROOT.glob("studies/*/tests/*.py")]
OF_TUPLES = {"_replace", "_asdict", "_fields", "_make"}  # which Python has made public
INSIDE = "dem.jit", "dem.dynamics.world", "dem.dynamics.engine", "numba.core", "llvmlite"
ROOMS_OF_DYNAMICS = {"engine", "world", "step", "checkpoint"}
PATCHES = "setattr", "setitem", "delattr", "object", "patch"
OWN = "dem", "studies"


def origins(tree):
    """What the names of a file stand for, as they were imported."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (
                (alias.asname or alias.name.split(".")[0], alias.name) for alias in node.names
            )
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                yield alias.asname or alias.name, f"{node.module}.{alias.name}"


def is_ours(target, names):
    """Whether what a patch is put on is of the project, as far as a file says; a local name may be."""
    if isinstance(target, ast.Constant):
        return str(target.value).startswith(tuple(f"{room}." for room in OWN))
    first = ast.unparse(target).partition(".")[0]
    return names.get(first, "dem").partition(".")[0] in OWN


def behind(tree):
    """What a syntax tree asks behind the doors."""
    pairs = list(origins(tree))
    names = dict(pairs)
    for _, imported in pairs:
        room, _, last = imported.rpartition(".")
        if (
            imported.startswith(INSIDE)
            or (room.startswith("dem") and last.startswith("_"))
            or (room == "dem.dynamics" and last in ROOMS_OF_DYNAMICS)
            or any(part.startswith("test_") for part in imported.split("."))
        ):
            yield imported
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            name = node.attr
            if name in ("engine", "world"):
                yield f".{name}"
            private = name.startswith("_") and not name.startswith("__") and name not in OF_TUPLES
            if private and (owner := ast.unparse(node.value)).partition(".")[0] not in (
                "self",
                "os",
            ):
                yield f"{owner}.{name}"
        elif isinstance(node, ast.Name) and node.id == "SimpleNamespace":
            yield "SimpleNamespace"
        elif isinstance(node, ast.Call):
            call = ast.unparse(node.func) if isinstance(node.func, ast.Attribute | ast.Name) else ""
            if call.endswith(("engine.run", "Schedule")):
                yield call
            is_patch = "patch" in call.lower() and call.rpartition(".")[2] in PATCHES
            if is_patch and is_ours(node.args[0], names):
                yield f"{ast.unparse(node.args[0])} patched"


# "file: what it asks", and why.
KERNELS = "it counts the kinds of kernels that are compiled"
EXCEPTIONS = {
    "studies/benchmark/tests/test_benchmark.py: .world": "tiles of a bed are made of what a simulation computes with",
    "studies/benchmark/tests/test_benchmark.py: lammps patched": "LAMMPS is missing, also where it is installed",
    "studies/stability/tests/test_stability.py: .world": "a watch must see a contact that is not listed",
    "studies/verification/tests/test_verification.py: assembly patched": "a law of the engine is broken",
    "tests/base/test_files.py: SimpleNamespace": "what the system says of a disk that is full",
    "tests/experiment/test_identity.py: identity patched": "no other version of Numba can be installed in a test",
    "tests/figures/test_plot.py: film patched": "a computer without an encoder",
    "tests/kinds.py: dem.jit.address.Address": KERNELS,
    "tests/kinds.py: dem.jit.compilation.Kernel": KERNELS,
    "tests/kinds.py: numba.core.types": KERNELS,
    "tests/packing/test_packing.py: 'dem.packing.random.most_iterations' patched": "a bed that takes an hour not to come to rest",
    "tests/sweep/test_sweep.py: 'dem.sweep.prune.sweeps' patched": "another sweep starts at that very moment",
    "tests/sweep/test_workers.py: client patched": "workers on one computer all see its disk",
    "tests/sweep/test_workers.py: cluster patched": "workers on one computer have the same packages",
    "tests/workflow/test_rules.py: workflow._workflow": "Snakemake shows its rules nowhere else",
}


def found():
    """What all files ask behind the doors."""
    for file in FILES:
        tree = ast.parse(file.read_text(encoding="utf-8"))
        yield from (f"{file.relative_to(ROOT).as_posix()}: {what}" for what in behind(tree))


def test_what_is_asked_behind_a_door_has_its_reason():
    """Each exception is used, and a new one must be given a reason here."""
    asked = set(found())
    assert sorted(asked - EXCEPTIONS.keys()) == []
    assert sorted(EXCEPTIONS.keys() - asked) == []
    assert all(EXCEPTIONS.values())
