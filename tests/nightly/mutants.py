"""Faults of which the quick part of the suite must notice every one (test_nightly.py).

Each mutant is one fault, put into a copy of the project: in `file` of dem/, `right` becomes `wrong`. The
quick part (pytest -m quick) must fail on it. A kernel that is changed is compiled again, half a minute a
kind of scene; so the test that is most likely to fail is asked first, and all others only if it passes.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from dem.base.source_hash import cache_folder

PROJECT = Path(__file__).parents[2]
COPIED = shlex.split(
    "dem tests conftest.py studies config rules docs profiles pyproject.toml Snakefile README.md"
)
LONGEST = 600.0  # s of the processor, for one mutant
TWIN = "tests/dynamics/test_twin.py::test_a_run_is_that_of_the_model[{}]"
LARGE = "tests/dynamics/test_twin.py::test_a_large_bed_is_that_of_the_model[{}]"


class Mutant(NamedTuple):
    """A fault of a kind: in `file` of dem/, `right` becomes `wrong`; `asks`: the test to ask first."""

    file: str
    kind: str
    right: str
    wrong: str
    asks: str


BOX, DISCS, SMOOTH = (TWIN.format(scene) for scene in ("box of discs", "discs", "smooth discs"))
SOLIDS, TURNED = (
    TWIN.format("discs around solids"),
    TWIN.format("ellipses of local radius around solids"),
)
DUMBBELLS, ELLIPSES = TWIN.format("dumbbells"), TWIN.format("ellipses")
LOCAL, CHORD = TURNED, TWIN.format("ellipses by the chord")
SUPER, ONE_THREAD, TWO_THREADS = TWIN.format("superellipses"), LARGE.format(1), LARGE.format(2)
RUN = "tests/dynamics/test_twin.py::test_a_run_of_a_configuration_is_that_of_the_model"
THREADS = "tests/dynamics/test_continuation.py::test_the_number_of_threads_changes_no_bit"
SAVED = "tests/dynamics/test_continuation.py::test_a_run_goes_on_with_the_same_bits"
KEYS = "tests/experiment/test_every_key.py"
HELD = "tests/dynamics/test_step.py::test_the_time_step_is_held_where_the_bound_goes_up_and_down"
ROUNDS = "tests/sweep/test_replicates.py::test_{}"
BED, SWEEP, STORE = (
    "tests/packing/test_packing.py",
    "tests/sweep/test_sweep.py",
    "tests/sweep/test_store.py",
)
STATES = "tests/sweep/test_by_chance.py"
FILES = "tests/base/test_files.py"
WHOLE = f"{FILES}::test_a_file_is_written_whole_or_not_at_all"
ROWS = f"{SWEEP}::test_a_combined_file_holds_every_run_at_its_place"
FAILED = "tests/sweep/test_faults.py"
NEEDED = f"{SWEEP}::test_prune_removes_what_no_sweep_needs"

MUTANTS = (
    # the force law, and what a contact does with it
    Mutant("contacts/force_law.py", "sign", "elastic + damping", "elastic - damping", BOX),
    Mutant("contacts/force_law.py", "limit", "max(force, -limit), limit)", "max(force, 0.0), limit)", BOX),
    Mutant("contacts/force_law.py", "missing factor", "+ kept * last)", "+ last)", BOX),
    Mutant("contacts/force_law.py", "limit", "max(last, TINY), 1.0)", "max(last, TINY), 2.0)", BOX),
    Mutant("contacts/force_law.py", "constant", "-(math.pi - 2.0 * psi)", "-(math.pi - psi)", BOX),
    Mutant("contacts/response.py", "time", "rate = -plus(velocity[0], change[0])", "rate = -velocity[0]", BOX),
    Mutant("contacts/response.py", "sign", "minus(gx * nx + gy * ny, times(t2", "plus(gx * nx + gy * ny, times(t2", ELLIPSES),
    Mutant("contacts/response.py", "missing term", "either(times(given(radius, math.sqrt(constant)), known), known)", "known", LOCAL),
    Mutant("dynamics/assembly.py", "missing term", "meeting(one.appended(*more).take(number), scene.shape)", "one.appended(*more).take(number)", LOCAL),
    Mutant("contacts/force_law.py", "order", "capped(mindlin(history[p], measured, last, stiffness, distance), limit)", "mindlin(history[p], measured, last, stiffness, distance)", BOX),
    Mutant("contacts/loops.py", "sign", "gx, gy, -torque, 0.0)", "gx, gy, torque, 0.0)", BOX),
    Mutant("contacts/blocks.py", "index", "+= two[j + FIVE]", "+= two[j + SIX]", SMOOTH),
    Mutant("contacts/blocks.py", "sign", "+= contacts.shift_x[p]", "-= contacts.shift_x[p]", ONE_THREAD),
    Mutant("contacts/loops.py", "not summed", "loads[b, 0] += normal", "loads[b, 0] = normal", BOX),
    Mutant("contacts/loops.py", "missing term", "on[b, FX] += hx + tx", "on[b, FX] += hx", DISCS),
    Mutant("contacts/loops.py", "not summed", "on[b, TAU] += values[TORQUE_2 + k]", "on[b, TAU] = values[TORQUE_2 + k]", DISCS),
    Mutant("dynamics/assembly.py", "missing term", "math.sqrt(restitution * partner.restitution)", "partner.restitution", DISCS),
    # motion
    Mutant("dynamics/forces.py", "index", "contact_forces[b, 1] = on[b, FX], on[b, FY]", "contact_forces[b, 1] = on[b, FX], on[b, FX]", SMOOTH),
    Mutant("dynamics/forces.py", "not cleared", "force[source + c] = 0.0", "force[source + c] *= 1.0", ONE_THREAD),
    Mutant("dynamics/integration.py", "constant", "((pending_kick + half, ahead), (half, 0.0))", "((half, ahead), (half, 0.0))", BOX),
    Mutant("dynamics/integration.py", "factor", "dv = half * extrapolated", "dv = dt * extrapolated", BOX),
    Mutant("dynamics/integration.py", "missing term", "ahead = 2.0 * now - previous_acceleration[i, c]", "ahead = now", BOX),
    Mutant("contacts/blocks.py", "missing call", "values[lane.MEAN_ROOT + k] = mean\n", "pass\n", BOX),
    Mutant("dynamics/integration.py", "sign", "rotate(orientation, i, angle[i], dt * spin)", "rotate(orientation, i, angle[i], -dt * spin)", ELLIPSES),
    Mutant("dynamics/integration.py", "dropped wait", "        barrier(thread)\n        if leads(thread):\n            boundary_forces", "        if leads(thread):\n            boundary_forces", TWO_THREADS),
    Mutant("dynamics/boundary_motion.py", "time", "impulses[b, c] += kick * contact_forces", "impulses[b, c] += dt * contact_forces", BOX),
    Mutant("dynamics/boundary_motion.py", "time", "after, 0.5 * (time + stop), c)", "after, stop, c)", SMOOTH),
    Mutant("dynamics/boundary_motion.py", "sign", "end, c) - motion[b, VX + c]", "end, c) + motion[b, VX + c]", SMOOTH),
    Mutant("dynamics/boundary_motion.py", "factor", "account[WORK] -= 0.5 * kick", "account[WORK] -= kick", "tests/test_motion.py::test_the_work_of_a_drive_is_what_it_and_the_bed_gain"),
    Mutant("dynamics/boundary_motion.py", "sign", "boundaries.angle[b], dt * motion[b, W])", "boundaries.angle[b], -dt * motion[b, W])", SOLIDS),
    Mutant("dynamics/neighbor_list.py", "missing term", "mass * both if both + turns > 0.0 else 1.0", "1.0", SMOOTH),
    Mutant("dynamics/diagnostics.py", "missing term", "squared += 2.0 * skin * driven_acceleration", "squared += 0.0 * driven_acceleration", "tests/test_motion.py::test_the_work_of_a_drive_is_what_it_and_the_bed_gain"),
    Mutant("dynamics/contact_history.py", "memory lost", "new[p] = old[source[p]]", "new[p] = 0.0", BOX),
    Mutant("dynamics/neighbor_list.py", "missing term", "lowest[home] = min(lowest[home], other)", "lowest[home] = home", THREADS),
    Mutant("dynamics/cell_list.py", "missing term", "reach = radius[i] + radius[j] + skin", "reach = radius[i] + radius[j]", BOX),
    Mutant("dynamics/contact_history.py", "comparison", "old_partner[q] < j)", "old_partner[q] <= j)", BOX),
    Mutant("dynamics/stepping.py", "comparison", "if steps - candidate_since >= QUIET:", "if candidate_dt < math.inf:", HELD),
    Mutant("dynamics/stepping.py", "missing call", "world = rebuild_neighbor_list(world, table)\n            budget", "budget", BOX),
    Mutant("dynamics/stepping.py", "not cleared", "= before[b, c] - seen[b, c]", "= before[b, c]", RUN),
    Mutant("dynamics/critical_step.py", "constant", "* 2.0 / max(rate + root", "* 4.0 / max(rate + root", "tests/dynamics/test_step.py"),
    Mutant("dynamics/energy.py", "constant", "total += 0.5 * squared", "total += squared", RUN),
    Mutant("laws/hertz.py", "constant", "return 0.4 * stiffness", "return 0.5 * stiffness", "tests/dynamics/test_energy.py"),
    Mutant("dynamics/stress.py", "sign", "moving -= _outer", "moving += _outer", "tests/observables/test_stress.py"),
    Mutant("dynamics/simulation.py", "order", "back = np.argsort(self.engine.order)", "back = self.engine.order", ONE_THREAD),
    Mutant("dynamics/checkpoint.py", "not kept", '"world.shape.", "world.lanes.motion"', '"world.pairs.tangential_force", "world.lanes.motion"', SAVED),
    # shapes
    Mutant("shapes/dumbbell.py", "sign", "- oy * (constituent_force", "+ oy * (constituent_force", DUMBBELLS),
    Mutant("shapes/ellipse.py", "constant", "else rho1 * rho2 / (rho1 + rho2)", "else 0.5 * rho1 * rho2 / (rho1 + rho2)", LOCAL),
    Mutant("shapes/common_normal.py", "sign", "t2 = -(q2 +", "t2 = (q2 +", ELLIPSES),
    Mutant("shapes/common_normal.py", "comparison", "if gap > best:", "if gap < best:", "tests/shapes/test_geometry.py"),
    Mutant("shapes/geometric_potential.py", "comparison", "if g1 >= 0.0:", "if g1 >= -0.1:", CHORD),
    Mutant("shapes/smooth.py", "constant", "return 0.25 * _integral", "return 0.5 * _integral", SUPER),
    Mutant("shapes/superellipse.py", "sign", "root + (1.0 - q) * root", "root - (1.0 - q) * root", SUPER),
    Mutant("shapes/polygon.py", "sign", "place = -(x * ny - y * nx)", "place = (x * ny - y * nx)", SOLIDS),
    Mutant("shapes/polygon.py", "sign", "ry * nx - rx * ny", "rx * ny - ry * nx", TURNED),
    # beds
    Mutant("packing/minimise.py", "missing call", "        forces(world, 0.0, math.inf)\n    return", "    return", BED),
    Mutant("packing/random.py", "missing term", "(r + radius[near]) ** 2", "radius[near] ** 2", BED),
    Mutant("packing/swelling.py", "missing factor", "KEPT * end.velocity", "end.velocity", BED),
    # runs
    Mutant("experiment/box.py", "sign", "(granules / fraction + area)", "(granules / fraction - area)", RUN),
    Mutant("experiment/kinds/drag.py", "order", "min(every - done % every, BINS_A_CALL)", "BINS_A_CALL", RUN),
    Mutant("experiment/observables/drag.py", "sign", '"drag": -(total @ along)', '"drag": (total @ along)', RUN),
    Mutant("experiment/kinds/jamming.py", "constant", "load[start:] ** (1.0 / power)", "load[start:] ** (3.0 / 2.0)", "tests/experiment/test_onset.py::test_a_bed_jams_where_the_line_of_its_loads_begins"),
    Mutant("experiment/kinds/onset.py", "constant", "HOLDING = 3", "HOLDING = 2", "tests/experiment/test_onset.py"),
    Mutant("experiment/identity.py", "missing term", '"packing.fraction", "packing.friction"', '"packing.fraction"', KEYS),
    # sweeps, their store, files and numbers
    Mutant("sweep/grouping.py", "index", "for run in batch.runs:\n", "for run in batch.runs[1:]:\n", SWEEP),
    Mutant("sweep/batch.py", "missing call", "    store.keep(replicate.id, values)\n", "", STORE),
    Mutant("sweep/batch.py", "comparison", "list(_rows_of(store, batch)) == runs", "list(_rows_of(store, batch)) != runs", STATES),
    Mutant("sweep/batch.py", "order", "    if list(_rows_of(store, batch)) != runs:  # another", "    store.forget(runs)\n    if list(_rows_of(store, batch)) != runs:  # another", STORE),
    Mutant("sweep/batch.py", "index", "np.asarray(row.get(name, gap)", "np.asarray(rows[0].get(name, gap)", ROWS),
    Mutant("sweep/batch.py", "comparison", "if (row := store.kept(replicate.id, aside=True)) is None:", "if (row := store.kept(replicate.id, aside=True)) is not None:", STATES),
    Mutant("sweep/batch.py", "condition", "    if list(_rows_of(store, batch)) == runs:\n        return path", "    if path.exists():\n        return path", STORE),
    Mutant("sweep/batch.py", "missing call", "            store.keep(run, rows[run])\n", "            pass\n", FAILED),
    Mutant("sweep/batch.py", "condition", 'return None if row is None or row["failure"] else row', "return row", f"{FAILED}::test_a_run_that_failed_in_the_batch_of_another_sweep_is_tried_again"),
    Mutant("sweep/grouping.py", "order", "(batch_id(results, *b.runs) != b.id, -len", "(-len", f"{SWEEP}::test_a_sweep_keeps_to_its_batches_while_another_makes_their_runs"),
    Mutant("sweep/prune.py", "index", 'path.name.partition(".")[0] not in', "path.stem not in", NEEDED),
    Mutant("sweep/prune.py", "missing term", "runs.union(beds, (batch.id", "runs.union((batch.id", NEEDED),
    Mutant("sweep/prune.py", "missing term", "if not batch.runs or runs.intersection", "if runs.intersection", NEEDED),
    Mutant("sweep/prune.py", "missing term", "for run in combined_runs(path)}, set()", "for run in ()}, set()", f"{SWEEP}::test_prune_keeps_runs_that_a_combined_file_names"),
    Mutant("sweep/prune.py", "order", "list(store.files()), list(", "store.files(), list(", f"{SWEEP}::test_prune_leaves_the_plans_of_a_sweep_that_starts_meanwhile"),
    Mutant("sweep/combine.py", "index", "[list(rows)]", "[list(rows[::-1])]", ROWS),
    Mutant("sweep/combine.py", "condition", "if left and not (partial and file.dimensions):", "if left and not file.dimensions:", f"{SWEEP}::test_a_run_that_no_file_holds_is_named"),
    Mutant("sweep/combine.py", "missing call", "            _check(sweep, block, failed)\n", "            pass\n", FAILED),
    Mutant("sweep/combine.py", "comparison", "if count == groups[group]:", "if count > groups[group]:", f"{FAILED}::test_runs_that_fail_stop_a_sweep_that_does_not_allow_so_many"),
    Mutant("base/files.py", "order", "        yield part\n", "        try:\n            yield part\n        except BaseException:\n            part.replace(path)\n            raise\n", WHOLE),
    Mutant("base/files.py", "missing call", "        part.unlink(missing_ok=True)\n", "        pass\n", WHOLE),
    Mutant("sweep/restart.py", "condition", "            if not alive:\n", "            if alive:\n", FILES),
    Mutant("sweep/precision.py", "limit", "GROWTH * now[other]", "100 * now[other]", ROUNDS.format("replicates_are_added_until_a_mean_is_known_as_well_as_asked_and_no_longer")),
    Mutant("base/statistics.py", "sign", "for sign in (-1.0, 1.0))", "for sign in (1.0, -1.0))", "tests/base/test_statistics.py"),
    Mutant("sweep/precision.py", "condition", 'return math.nan, str(row["failure_reason"])', 'return 0.0, str(row["failure_reason"])', ROUNDS.format("a_failed_run_counts_and_is_not_replaced")),
    Mutant("sweep/state.py", "condition", "if any(len(values[point]) < count for point, count in block.counts.items()):", "if False:", ROUNDS.format("a_stopped_sweep_goes_on_to_the_same_runs")),
    Mutant("sweep/state.py", "missing call", "                if not self.grow(name):\n                    break\n", "                break\n", ROUNDS.format("replicates_are_added_until_a_mean_is_known_as_well_as_asked_and_no_longer")),
    Mutant("base/statistics.py", "constant", "stdtrit(freedom, 0.5 + 0.5 * level)", "stdtrit(freedom, level)", "tests/base/test_statistics.py"),
    Mutant("analysis/onset.py", "sign", "return y @ share - slope * middle", "return y @ share + slope * middle", "tests/experiment/test_onset.py"),
    # how kernels are compiled
    Mutant("jit/compilation.py", "missing term", "*map(str, key), *code)", "*map(str, key))", "tests/jit/test_compilation.py::test_machine_code_for_a_law_of_ones_own_is_known_by_the_code_of_its_file"),
    Mutant("jit/optional.py", "sign", "return lambda a, b: -b", "return lambda a, b: b", ELLIPSES),
    Mutant("jit/block_memory.py", "index", "load_outline(like[1:], values, at + step, step)", "load_outline(like[1:], values, at, step)", ELLIPSES),
)  # fmt: skip


def copied(folder: Path) -> Path:
    """A copy of the project, with the kernels that are compiled: those that a fault does not concern stay."""
    copy = folder / "project"
    for name in COPIED:
        source = PROJECT / name
        if source.is_dir():
            shutil.copytree(
                source, copy / name, ignore=shutil.ignore_patterns("__pycache__", "_build")
            )
        else:
            shutil.copy(source, copy / name)
    cache = cache_folder()
    if cache.is_dir():
        shutil.copytree(cache, copy / ".numba", ignore=shutil.ignore_patterns("*.lock"))
    return copy


def faulty_copy(mutant: Mutant, folder: Path) -> Path:
    """A copy of the project with the fault."""
    copy = copied(folder)
    broken = copy / "dem" / mutant.file
    text = broken.read_text(encoding="utf-8")
    assert text.count(mutant.right) == 1, f"{mutant.file} has no single {mutant.right!r}"
    broken.write_text(text.replace(mutant.right, mutant.wrong), encoding="utf-8")
    return copy


def first_failure(copy: Path, *words: str) -> str | None:
    """The first test that fails in a copy of the project, as pytest names it; None if none does."""
    options = "-x -n0 -p no:cacheprovider --hypothesis-profile=mutants -m quick"
    command = [sys.executable, "-m", "pytest", *options.split(), *words]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(copy / ".numba"), "PYTHONPATH": str(copy)}
    process = subprocess.Popen(
        command, cwd=copy, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, start_new_session=True, preexec_fn=_limited,
    )  # fmt: skip
    output, _ = process.communicate()
    failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
    if failed:
        return failed[0].partition(" - ")[0]
    if process.returncode < 0:
        return f"stopped by signal {-process.returncode}"  # it crashes, or never ends
    assert process.returncode == 0, output  # else no test was asked
    return None


def _limited():
    """A mutant that never ends, or fills the memory, is stopped, and so noticed."""
    import resource

    resource.setrlimit(resource.RLIMIT_CPU, (int(LONGEST), int(LONGEST) + 5))


def notices(mutant: Mutant) -> str | None:
    """The first quick test that fails on a mutant, None if it survives."""
    with tempfile.TemporaryDirectory() as folder:
        copy = faulty_copy(mutant, Path(folder))
        return first_failure(copy, mutant.asks) or first_failure(copy)


def notices_patch(patch: Path) -> str | None:
    """The first quick test that fails where a patch of tests/faults is applied, None if none does."""
    with tempfile.TemporaryDirectory() as folder:
        copy = copied(Path(folder))
        subprocess.run(["git", "apply", str(patch)], cwd=copy, check=True)
        asks = re.search(r"^Asks: (.*)$", patch.read_text(encoding="utf-8"), re.MULTILINE)[1]
        return first_failure(copy, asks) or first_failure(copy)
