"""The rooms of the package: which may import which, and where files are deleted."""

import ast
import re

from importlinter.cli import EXIT_STATUS_SUCCESS, lint_imports
from project import quick
from workflows import run

from dem.base.source_hash import PACKAGE, ROOT


def test_a_room_imports_only_from_below(monkeypatch):
    """The contracts of pyproject.toml hold: layers without exception, no study imports another."""
    monkeypatch.chdir(ROOT)
    assert lint_imports(no_cache=True) == EXIT_STATUS_SUCCESS


# Each place that deletes a file, or takes any error for one of a kind, by file and function: why nothing is lost
# there. What cannot be read now is never taken for damaged: see `reading` of dem/base/files.py.
DELETES_OR_CATCHES = {
    "base/files.py atomic: unlink": "a part that did not take the place of its file",
    "base/files.py arrays_of: Exception": "of bytes that were read; no memory is raised before",
    "base/plugins.py load: Exception": "any error of a user's file becomes a sentence",
    "base/types.py real_array: Exception": "any error of a user's object becomes a sentence",
    "base/refusals.py shown: Exception": "any error of a user's object becomes a sentence",
    "cli/sweep.py simulate: unlink": "checkpoints of a run whose file is written",
    "io/dataset.py content_of: Exception": "it becomes a sentence, once all bytes could be read",
    "jit/cache.py checked: unlink": "machine code that is damaged; it is compiled again",
    "jit/kernel.py compile_apart: Exception": "the other process ends, and this one compiles and raises",
    "sweep/batch_job.py _row: Exception": "an error of a user's file becomes a failed run; all others are raised",
    "sweep/batch_job.py _row: unlink": "the checkpoint of a run that is kept",
    "sweep/batch_job.py retry: unlink": "its sound runs are kept, and the user asks for the failed ones",
    "sweep/cluster.py connected: Exception": "it becomes a sentence; no file is read",
    "sweep/prune.py prune: unlink": "what no sweep needs, where the user asks for it",
    "sweep/restart.py clear_parts: unlink": "parts of processes that are no more",
    "sweep/store.py bed: unlink": "the checkpoint of a bed that is kept",
    "sweep/store.py forget: unlink": "runs that a batch holds, or that failed and are asked for again",
    "sweep/store.py replicates: Exception": "of bytes that were read; the plan is written again",
    "sweep/workers.py _make_runs: unlink": "batches of one run, which is kept",
    "sweep/workers.py make_batch: unlink": "a batch whose content goes to the client",
    "cli/terminal.py reported: Exception": "all but what has a sentence is raised again",
}
DELETES = re.compile(r"\b(unlink|rmtree|rmdir|removedirs)\(")
CATCHES = re.compile(r"except:|(except |.*\bsuppress\().*Exception")


def places(tree, name=None):
    """What deletes or catches any error, with the function around it."""
    for node in ast.iter_child_nodes(tree):
        inside = node.name if isinstance(node, ast.FunctionDef) else name
        if isinstance(node, ast.ExceptHandler | ast.Call):
            line = ast.unparse(node).partition("\n")[0]
            yield from (f"{inside}: {name}" for name in DELETES.findall(line))
            if CATCHES.match(line):
                yield f"{inside}: Exception"
        yield from places(node, inside)


def test_each_place_that_deletes_a_file_or_catches_any_error_has_its_reason():
    """A new one must be given a reason here."""
    found = {
        f"{file.relative_to(PACKAGE).as_posix()} {place}"
        for file in PACKAGE.rglob("*.py")
        for place in places(ast.parse(file.read_text(encoding="utf-8")))
    }
    assert found == DELETES_OR_CATCHES.keys()


# What each file of the package takes of Numba and of LLVM: what they promise to keep.
COMPILERS = {
    "base/provenance.py": ["llvmlite.binding"],
    "jit/cache.py": ["llvmlite.binding", "numba"],
    "jit/intrinsics.py": ["llvmlite", "numba", "numba.extending"],
    "jit/kernel.py": ["numba", "numba.extending"],
}


def imports_of(file):
    """Modules of Numba and of LLVM that a file imports."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        names = [alias.name for alias in getattr(node, "names", ()) if isinstance(node, ast.Import)]
        names += [node.module] if isinstance(node, ast.ImportFrom) else []
        yield from (name for name in names if name and name.startswith(("numba", "llvmlite")))


@quick
def test_numba_and_llvm_are_asked_in_four_files_for_what_they_promise():
    """All else is plain functions."""
    found = {
        file.relative_to(PACKAGE).as_posix(): sorted(set(imports_of(file)))
        for file in PACKAGE.rglob("*.py")
    }
    assert {name: modules for name, modules in found.items() if modules} == COMPILERS


@quick
def test_shapes_laws_and_scenes_need_no_compiler():
    """Geometry and planning start at once."""
    ask = """
import sys, dem
from dem import laws, shapes
kinds = [kind.shape for kind in shapes.KINDS.values()]
dem.Scene(dem.Disc([1e-3]), law=dem.Hertz(), solids=dem.Cylinder(diameter=1e-3, position=(0.0, 0.0)))
dem.check_shape(dem.Ellipse.of_size([1e-3], 1.5)), dem.check_law(dem.Linear())
print("numba" in sys.modules)
"""
    assert run("-c", ask, cwd=ROOT) == "False\n"
