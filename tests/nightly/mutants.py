"""Faults of which the quick part of the suite must notice every one (test_nightly.py).

Each mutant is one fault, put into a copy of the project: in `file` of dem/, `right` becomes `wrong`. The
quick part (pytest -m quick) must fail on it. A kernel that is changed is compiled again, half a minute a
kind of scene; so the test that is most likely to fail is asked first, and all others only if it passes.
"""

import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile
from functools import partial
from pathlib import Path
from resource import RLIMIT_CPU, setrlimit
from typing import NamedTuple

from dem.base.source_hash import cache_folder

PROJECT = Path(__file__).parents[2]
COPIED = (
    "dem tests conftest.py studies config rules docs profiles pyproject.toml Snakefile README.md"
)
LIMITS = 600, 605  # s of the processor, after which a run of pytest is stopped, and so has noticed


class Mutant(NamedTuple):
    """A fault: in `file` of dem/, `right` becomes `wrong`; `asks`: the tests to ask first, those of its room if
    absent."""

    file: str
    right: str
    wrong: str
    asks: str = ""


TWIN = "tests/dynamics/test_twin.py::test_a_run_is_that_of_the_model"
BOX, DISCS = f"{TWIN}[box of discs]", f"{TWIN}[discs]"
SMOOTH = f"{TWIN}[smooth discs]"
SOLIDS = f"{TWIN}[discs around solids]"
TURNED = f"{TWIN}[ellipses of local radius around solids]"
ELLIPSES = f"{TWIN}[ellipses]"
SUPER = f"{TWIN}[superellipses]"
LARGE = "tests/dynamics/test_twin.py::test_a_large_bed_is_that_of_the_model[1]"
THREADS = "tests/dynamics/test_continuation.py::test_the_number_of_threads_changes_no_bit"
RUN = "tests/dynamics/test_twin.py::test_a_run_of_a_configuration_is_that_of_the_model"
ROWS = (
    # the force law, and what a contact does with it
    ("contacts/response.py", "rate = rate + lanes[k + DV_NORMAL]", "rate = lanes[k + V_NORMAL]", BOX),
    ("contacts/response.py", "math.sqrt(constant) * dashpot", "dashpot", TURNED),
    ("dynamics/assembly.py", "rows = shape.outlines if own else map", "rows = map", TURNED),
    ("contacts/response.py", "            spring = capped(spring, limit)\n            table[p + TANGENTIAL_FORCE]", "            table[p + TANGENTIAL_FORCE]", BOX),
    ("dynamics/motion.py", "+= motion[b, DVY]", "+= motion[b, DVX]", SMOOTH),
    ("contacts/geometry.py", "dx + table[p + SHIFT_X]", "dx - table[p + SHIFT_X]", LARGE),
    ("contacts/response.py", "loads[b, 0] += normal", "loads[b, 0] = normal", BOX),
    ("dynamics/assembly.py", "math.sqrt(restitution * partner.restitution)", "partner.restitution", DISCS),
    ("contacts/geometry.py", "place = -(x * ny - y * nx)", "place = (x * ny - y * nx)", SOLIDS),
    ("contacts/layout.py", "return table[at], table[at + COLUMN]\n", "return table[at], table[at]\n", ELLIPSES),
    # motion
    ("dynamics/forces.py", "loads[b, 1] = on[b, FX], on[b, FY]", "loads[b, 1] = on[b, FX], on[b, FX]", DISCS),
    ("dynamics/forces.py", "force[source + c] = 0.0", "force[source + c] *= 1.0", LARGE),
    ("dynamics/system.py", "drift(pending_kick + half, ahead)", "drift(half, ahead)", BOX),
    ("dynamics/motion.py", "return 2.0 * now - before", "return now", BOX),
    ("dynamics/motion.py", "<= limit else 1", "<= limit else 0", SMOOTH),
    ("shapes/rotation.py", "sine * x + cosine * y", "cosine * y", ELLIPSES),
    ("contacts/response.py", "lanes[k + MEAN_ROOT] = mean\n", "pass\n", BOX),
    ("dynamics/motion.py", "* py - (s * x + c * y) * px", "* py + (s * x + c * y) * px", "tests/dynamics/test_twin.py::test_a_run_is_that_of_the_model[dumbbells]"),
    ("dynamics/step.py", "        barrier(thread.arrivals, thread.size)\n        if thread.number == 0:\n            clear", "        if thread.number == 0:\n            clear", THREADS),
    ("dynamics/motion.py", "after, 0.5 * (time + stop), c)", "after, stop, c)", SMOOTH),
    ("dynamics/motion.py", "account[WORK] -= 0.5 * kick", "account[WORK] -= kick", "tests/test_motion.py::test_the_work_of_a_drive_is_what_it_and_the_bed_gain"),
    ("dynamics/assembly.py", "alike=len(scene.materials) == 1", "alike=True", "tests/dynamics/test_twin.py::test_a_run_is_that_of_the_model"),
    ("dynamics/contact_constants.py", "layout.mass_y, mass * both if both + second[2] > 0.0 else 1.0", "layout.mass_y, 1.0", DISCS),
    ("dynamics/measures.py", "squared += 2.0 * skin * driven_acceleration", "squared += 0.0 * driven_acceleration", "tests/test_motion.py::test_the_work_of_a_drive_is_what_it_and_the_bed_gain"),
    ("dynamics/neighbours.py", "world.contacts.table[old + c] if old >= 0 else 0.0", "0.0", BOX),
    ("dynamics/neighbours.py", "lowest[home] = min(lowest[home], patch)", "lowest[home] = home", THREADS),
    ("dynamics/neighbours.py", "reach = radius[i] + radius[j] + skin", "reach = radius[i] + radius[j]", BOX),
    ("dynamics/engine.py", "if now.steps - since >= QUIET:", "if candidate < math.inf:", "tests/dynamics/test_step.py::test_the_time_step_is_held_where_the_bound_goes_up_and_down"),
    ("dynamics/engine.py", "self.progress = now._replace(narrow=narrow, scanned=-1)\n        self.rebuild()", "self.progress = now._replace(narrow=narrow, scanned=-1)", BOX),
    ("dynamics/engine.py", "impulses[:] -= boundaries.impulses", "impulses[:] -= 0.0", RUN),
    ("dynamics/critical_step.py", "* 2.0 / max(rate + root", "* 4.0 / max(rate + root", "tests/dynamics/test_step.py"),
    ("laws/hertz.py", "return 0.4 * stiffness", "return 0.5 * stiffness", "tests/dynamics/test_energy.py"),
    ("dynamics/stress.py", "moving -= _outer", "moving += _outer", "tests/observables/test_stress.py"),
    ("dynamics/assembly.py", "getattr(state, name)[order] = values", "getattr(state, name)[np.argsort(order)] = values", LARGE),
    ("dynamics/checkpoint.py", '"world.shape.", "world.outlines."', '"world.shape.", "world.outlines.", "world.granules.previous"', "tests/dynamics/test_continuation.py::test_a_run_goes_on_with_the_same_bits"),
    # shapes
    ("shapes/ellipse.py", "rho1 * rho2 / (rho1 + rho2)", "0.5 * rho1 * rho2 / (rho1 + rho2)", TURNED),
    ("shapes/geometric_potential.py", "if g1 >= 0.0:", "if g1 >= -0.1:", "tests/dynamics/test_twin.py::test_a_run_is_that_of_the_model[ellipses by the chord]"),
    ("shapes/superellipse.py", "root + (1.0 - q) * root", "root - (1.0 - q) * root", SUPER),
    # beds
    ("packing/minimise.py", "    system.forces(0.0)\n    return", "    return"),
    ("packing/random.py", "(r + other) ** 2", "other**2"),
    ("packing/swelling.py", "KEPT * end.velocity", "end.velocity"),
    # runs
    ("experiment/phases.py", "min(every - partial.bins % every, BINS_A_CALL)", "BINS_A_CALL", RUN),
    ("experiment/kinds/jamming.py", "load[start:] ** (1.0 / power)", "load[start:] ** (3.0 / 2.0)", "tests/experiment/test_onset.py::test_a_bed_jams_where_the_line_of_its_loads_begins"),
    ("experiment/kinds/onset.py", "HOLDING = 3", "HOLDING = 2", "tests/experiment/test_onset.py"),
    ("experiment/bed_description.py", 'NO_VALUES = {"label"', 'NO_VALUES = {"friction", "label"'),
    # sweeps, their store, files and numbers
    ("sweep/batches.py", "for run in batch.runs:\n", "for run in batch.runs[1:]:\n"),
    ("sweep/batch_job.py", "    store.keep(replicate.id, values)\n", ""),
    ("sweep/batch_job.py", "    if list(_rows_of(store, batch)) != runs:  # another", "    store.forget(runs)\n    if list(_rows_of(store, batch)) != runs:  # another"),
    ("sweep/batch_job.py", "np.asarray(row.get(name, gap)", "np.asarray(rows[0].get(name, gap)"),
    ("sweep/batch_job.py", "    if list(_rows_of(store, batch)) == runs:\n        return path", "    if path.exists():\n        return path"),
    ("sweep/batch_job.py", "            store.keep(run, rows[run])\n", "            pass\n"),
    ("sweep/batch_job.py", 'return None if row is None or row["failure"] else row', "return row"),
    ("sweep/batches.py", "(batch_id(results, *b.runs) != b.id, -len", "(-len"),
    ("sweep/prune.py", 'path.name.partition(".")[0] not in', "path.stem not in"),
    ("sweep/prune.py", "runs.union(beds, (batch.id", "runs.union((batch.id"),
    ("sweep/prune.py", "if not batch.runs or runs.intersection", "if runs.intersection"),
    ("sweep/prune.py", "for run in combined_runs(path)}, set()", "for run in ()}, set()"),
    ("sweep/prune.py", "list(store.files()), list(", "store.files(), list("),
    ("sweep/combine.py", "[list(rows)]", "[list(rows[::-1])]"),
    ("sweep/combine.py", "if left and not (partial and file.dimensions):", "if left and not file.dimensions:"),
    ("sweep/combine.py", "            _check(sweep, block, failed)\n", "            pass\n"),
    ("base/files.py", "        yield part\n", "        try:\n            yield part\n        except BaseException:\n            part.replace(path)\n            raise\n"),
    ("base/files.py", "        part.unlink(missing_ok=True)\n", "        pass\n"),
    ("sweep/restart.py", "            if not alive:\n", "            if alive:\n"),
    ("sweep/precision.py", "GROWTH * now[other]", "100 * now[other]"),
    ("sweep/precision.py", 'return math.nan, str(row["failure_reason"])', 'return 0.0, str(row["failure_reason"])'),
    ("sweep/state.py", "if any(len(values[point]) < count for point, count in block.counts.items()):", "if False:"),
    ("sweep/state.py", "                if not self.grow(name):\n                    break\n", "                break\n"),
    ("base/statistics.py", "stdtrit(freedom, 0.5 + 0.5 * level)", "stdtrit(freedom, level)"),
    # how kernels are compiled
    ("jit/cache.py", "value.co_code, value.co_names", "value.co_names", "tests/jit/test_compilation.py::test_machine_code_for_a_law_of_ones_own_is_known_by_the_code_of_its_file"),
    ("jit/intrinsics.py", "builder.fadd(before, change)", "builder.fsub(before, change)", BOX),
    ("jit/intrinsics.py", "map(builder.fsub, ", "map(builder.fadd, ", BOX),
    ("jit/intrinsics.py", "for at in ((0, 1, 4, 5), (2, 3, 6, 7))", "for at in ((2, 3, 6, 7), (0, 1, 4, 5))", BOX),
)  # fmt: skip
# Mutants and patches of tests/faults, with the tests to ask first
FAULTS = {
    mutant: mutant.asks or f"tests/{mutant.file.partition('/')[0]}"
    for mutant in itertools.starmap(Mutant, ROWS)
} | {
    patch: re.search("Asks: (.*)", patch.read_text(encoding="utf-8"))[1]
    for patch in sorted(PROJECT.glob("tests/faults/*.patch"))
}


def copy_of_project(folder, names):
    """A copy of some files and folders of the project."""
    for name in names.split():
        if (source := PROJECT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "_build")
            shutil.copytree(source, folder / name, ignore=ignored)
        else:
            shutil.copy(source, folder)


def copied(folder):
    """A copy of the project, with the kernels that are compiled: those that a fault does not concern stay."""
    copy = folder / "project"
    copy_of_project(copy, COPIED)
    if (cache := cache_folder()).is_dir():
        shutil.copytree(cache, copy / ".numba")
    return copy


def faulty_copy(mutant, folder):
    """A copy of the project with the fault."""
    copy = copied(folder)
    broken = copy / "dem" / mutant.file
    text = broken.read_text(encoding="utf-8")
    assert text.count(mutant.right) == 1, f"{mutant.file} has no single {mutant.right!r}"
    broken.write_text(text.replace(mutant.right, mutant.wrong), encoding="utf-8")
    return copy


def first_failure(copy, asks):
    """The first quick test that fails in a copy of the project, as pytest names it, of some and then of all; None
    if none does."""
    options = "-x -n0 -p no:cacheprovider --hypothesis-profile=mutants -m quick"
    environment = os.environ | {"NUMBA_CACHE_DIR": str(copy / ".numba"), "PYTHONPATH": str(copy)}
    for words in ([asks], []):
        process = subprocess.run(
            [sys.executable, "-m", "pytest", *options.split(), *words],
            cwd=copy, env=environment, capture_output=True, text=True, start_new_session=True,
            preexec_fn=partial(setrlimit, RLIMIT_CPU, LIMITS),
        )  # fmt: skip
        failed = re.search("^(FAILED|ERROR) [^ ]+", process.stdout, re.MULTILINE)
        if failed or process.returncode < 0:  # it crashes, or never ends
            return failed[0] if failed else f"stopped by signal {-process.returncode}"
        assert process.returncode == 0, process.stdout  # else no test was asked
    return None


def notices(fault):
    """The first quick test that fails on a mutant, or where a patch is applied; None if it survives."""
    with tempfile.TemporaryDirectory() as folder:
        if isinstance(fault, Mutant):
            copy = faulty_copy(fault, Path(folder))
        else:
            copy = copied(Path(folder))
            subprocess.run(["git", "apply", fault], cwd=copy, check=True)
        return first_failure(copy, FAULTS[fault])
