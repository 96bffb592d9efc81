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


# Each as "file: what it asks", with its reason.
TO_BE_REMOVED = """
studies/benchmark/tests/test_benchmark.py: .world
studies/benchmark/tests/test_benchmark.py: lammps patched
studies/stability/tests/test_stability.py: .world
studies/verification/tests/test_verification.py: assembly patched
tests/contacts/test_rolling.py: SimpleNamespace
tests/dynamics/test_force_reference.py: .world
tests/dynamics/test_large.py: .engine
tests/dynamics/test_large.py: .world
tests/dynamics/test_large.py: dem.dynamics.world.PATCH
tests/dynamics/test_library.py: .world
tests/dynamics/test_neighbors.py: SimpleNamespace
tests/dynamics/test_neighbors.py: dem.dynamics.world.PATCH
tests/dynamics/test_neighbors.py: dem.jit.compilation.compiled
tests/dynamics/test_step.py: .engine
tests/dynamics/test_step.py: .world
tests/experiment/test_identity.py: identity patched
tests/experiment/test_shear.py: shear._below
tests/experiment/test_shear.py: shear._sample
tests/figures/test_plot.py: film patched
tests/jit/test_compilation.py: add_all._cache
tests/jit/test_compilation.py: add_all._cache._file
tests/jit/test_compilation.py: compilation patched
tests/jit/test_compilation.py: compilation.CODE patched
tests/jit/test_compilation.py: compilation._say_compiling
tests/jit/test_compilation.py: dem.jit.address.FEW
tests/jit/test_compilation.py: dem.jit.address.local
tests/jit/test_compilation.py: dem.jit.compilation
tests/jit/test_compilation.py: dem.jit.compilation.compiled
tests/jit/test_compilation.py: dem.jit.compilation.computing
tests/jit/test_compilation.py: dem.jit.compilation.inlined
tests/jit/test_compilation.py: numba.core.registry.cpu_target
tests/jit/test_compilation.py: numba.core.runtime._nrt_python.memsys_enable_stats
tests/jit/test_compilation.py: numba.core.runtime.rtsys
tests/kinds.py: dem.jit.address.Address
tests/kinds.py: dem.jit.compilation.Kernel
tests/kinds.py: numba.core.types
tests/lists.py: SimpleNamespace
tests/lists.py: dem.dynamics.world.Faces
tests/nightly/test_fuzz.py: drag patched
tests/nightly/test_kernels.py: cli.test_library_input
tests/nightly/test_kernels.py: dynamics.test_large.assert_threads_change_no_bit
tests/nightly/test_kernels.py: dynamics.test_twin
tests/nightly/test_kernels.py: shapes.test_clumps.mixed
tests/nightly/test_kernels.py: test_motion
tests/nightly/test_long_studies.py: workflow.test_studies
tests/nightly/test_store_states.py: making patched
tests/observables/test_stress.py: .engine
tests/observables/test_stress.py: .world
tests/observables/test_stress.py: dem.jit.columns.FX
tests/observables/test_stress.py: dem.jit.columns.FY
tests/observables/test_stress.py: dem.jit.columns.TAU
tests/packing/test_large_beds.py: 'dem.io.lazily.SMALL' patched
tests/packing/test_large_beds.py: 'dem.packing.random.most_iterations' patched
tests/packing/test_large_beds.py: .world
tests/packing/test_large_beds.py: dem.dynamics.world.PATCH
tests/packing/test_packing.py: 'dem.packing.swelling._moved' patched
tests/packing/test_packing.py: 'dem.packing.swelling.dilute_start' patched
tests/packing/test_packing.py: dem.packing.swelling._moved
tests/report/test_report.py: figure._suptitle
tests/shapes/test_clumps.py: .world
tests/shapes/test_geometry.py: .world
tests/shapes/test_geometry.py: dem.jit.compilation.compiled
tests/shapes/test_shapes.py: dem.jit.compilation.inlined
tests/shapes/test_shapes.py: round_shapes() patched
tests/shapes/test_shapes.py: shape patched
tests/sweep/test_by_chance.py: nightly.test_fuzz
tests/sweep/test_by_chance.py: nightly.test_fuzz.good
tests/sweep/test_by_chance.py: nightly.test_store_states.Sweeps
tests/sweep/test_estimate.py: show.time patched
tests/sweep/test_faults.py: SimpleNamespace
tests/sweep/test_faults.py: drag patched
tests/sweep/test_faults.py: making patched
tests/sweep/test_faults.py: working patched
tests/sweep/test_stopping.py: .engine
tests/sweep/test_stopping.py: .world
tests/sweep/test_stopping.py: Replicate patched
tests/sweep/test_stopping.py: SimpleNamespace
tests/sweep/test_stopping.py: dem.dynamics.engine
tests/sweep/test_stopping.py: drag patched
tests/sweep/test_stopping.py: engine patched
tests/sweep/test_stopping.py: making patched
tests/sweep/test_sweep.py: 'dem.sweep.prune.sweeps' patched
tests/sweep/test_sweep.py: combining patched
tests/sweep/test_sweep.py: work._planned
tests/sweep/test_workers.py: client patched
tests/sweep/test_workers.py: cluster patched
tests/test_periodic.py: .world
tests/test_solids.py: .world
"""
EXCEPTIONS = dict.fromkeys(TO_BE_REMOVED.strip().splitlines(), "to be removed") | {
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
