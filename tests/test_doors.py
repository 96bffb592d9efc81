"""Tests ask at doors that stay: public names, files, commands. Whoever rewrites a room edits no test of behaviour.

What stays behind a door is a stand-in for something of dem, a name with an underscore, an attribute of dem that is
put in place of another, and what is inside of the engine.
"""

import ast
import re

import pytest
from project import ROOT

pytestmark = pytest.mark.quick
FILES = [ROOT / "conftest.py", *ROOT.glob("tests/**/*.py"), *ROOT.glob("studies/*/tests/*.py")]
PRIVATE = re.compile("_(?!_|(replace|asdict|fields|make)$)")  # but for what tuples have
INSIDE = re.compile(
    r"dem\.(jit|dynamics\.(engine|world|(step|checkpoint)$)|.*\b_)|numba\.core|llvmlite|(.*\.)?test_"
)
OWN = "dem", "'dem", "studies", "'studies"
PATCH = re.compile("(?i)patch[.](setattr|setitem|delattr|object)$|mock[.]patch$")


def behind(tree):
    """What a syntax tree asks behind the doors."""
    names = {}  # what they stand for, as they were imported
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            room = f"{node.module}." if isinstance(node, ast.ImportFrom) else ""
            for alias in node.names:
                names[alias.asname or alias.name.partition(".")[0]] = room + alias.name
    yield from filter(INSIDE.match, names.values())
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            name, owner = node.attr, ast.unparse(node.value)
            if name in ("engine", "world"):
                yield f".{name}"
            if PRIVATE.match(name) and owner.partition(".")[0] not in ("self", "os"):
                yield f"{owner}.{name}"
        elif isinstance(node, ast.Name) and node.id == "SimpleNamespace":
            yield "SimpleNamespace"
        elif isinstance(node, ast.Call) and PATCH.search(ast.unparse(node.func)):
            target = ast.unparse(node.args[0])
            first = target.partition(".")[0]
            # a local name may be of the project, and a string says what it means
            if names.get(first, first if "'" in first else "dem").startswith(OWN):
                yield f"{target} patched"


# "file: what it asks", and why.
EXCEPTIONS = {
    "studies/benchmark/tests/test_benchmark.py: .world": "tiles of a bed are made of what a simulation computes with",
    "studies/benchmark/tests/test_benchmark.py: lammps.Build patched": "LAMMPS is missing, also where it is installed",
    "studies/stability/tests/test_stability.py: .world": "a watch must see a contact that is not listed",
    "studies/verification/tests/test_verification.py: assembly patched": "a law of the engine is broken",
    "tests/dynamics/test_lists.py: System patched": "no public number says how often lists are renewed",
    "tests/base/test_files.py: SimpleNamespace": "what the system says of a disk that is full",
    "tests/experiment/test_identity.py: replicate patched": "no other version of Numba can be installed in a test",
    "tests/experiment/test_scenes.py: run_checkpoint patched": "the process ends once a checkpoint is written",
    "tests/figures/test_plot.py: film patched": "a computer without an encoder",
    "tests/kinds.py: dem.jit.kernel.Kernel": "it counts the kinds of kernels that are compiled",
    "tests/packing/test_packing.py: 'dem.packing.random.most_iterations' patched": "a bed that takes an hour not to come to rest",
    "tests/shapes/test_shapes.py: dem.Disc patched": "a shape of one's own, with the kernels of discs",
    "tests/sweep/test_sweep.py: 'dem.sweep.prune.sweeps' patched": "another sweep starts at that very moment",
    "tests/sweep/test_workers.py: client patched": "workers on one computer all see its disk",
    "tests/sweep/test_workers.py: cluster patched": "workers on one computer have the same packages",
    "tests/workflow/test_rules.py: workflow._workflow": "Snakemake shows its rules nowhere else",
}


def test_what_is_asked_behind_a_door_has_its_reason():
    """Each exception is used, and a new one must be given a reason here."""
    asked = {
        f"{file.relative_to(ROOT).as_posix()}: {what}"
        for file in FILES
        for what in behind(ast.parse(file.read_text(encoding="utf-8")))
    }
    assert asked == EXCEPTIONS.keys()
