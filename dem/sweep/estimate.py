"""What a sweep costs: how many runs exist, and roughly how long the others take."""

import json
import shlex
from itertools import islice
from math import pi

import numpy as np

from dem.base.errors import InputError
from dem.experiment.config import Replicate, of_values
from dem.io.dataset import read
from dem.io.progress import span
from dem.sweep.explain import reasons
from dem.sweep.state import SweepState
from dem.sweep.store import Store

# s an effort, where no run like it exists: of a usual processor, by kind of granule
GUESS = {"disc": 3e-8, "dumbbell": 6e-8, "ellipse": 6e-8}
ITERATED = 6e-7  # the same of shapes whose contacts are found by iteration, as of superellipses
DAMPED = 30.0  # by how much damping bounds the step, over how much stiffness does, a damping ratio
NEWEST = 40  # batches of the store whose times are read
REASONS = 10  # that are listed


def summary(state: SweepState, jobs: int, retry: bool = False) -> str:
    """Runs and beds of a sweep, how many exist, and an estimate for the others.

    retry: whether runs that failed are made again.
    """
    lines, coming = [], []
    for name in state.sweep.blocks:
        block = state.block(name)
        runs = list(block.unique())
        finished, failed = existing(state, name)
        new = [run for run in runs if run.id not in (finished if retry else finished | failed)]
        beds = {run.bed_id for run in new if not state.store.file_of_bed(run).is_file()}
        axes = ", ".join(f"{axis.name} {len(axis.points)}" for axis in block.axes)
        words = "these are made again" if retry else "dem sweep --retry makes these again"
        lines.append(
            f"{state.folder_of(name)}: {len(runs)} runs ({axes}), {len(finished)} finished"
            f"{f', {len(failed)} failed ({words})' if failed else ''}, {len(new)} to be made; "
            f"{len(beds)} beds to pack."
        )
        if block.until:
            least, most = sum(block.counts.values()), len(block.counts) * block.until.most
            lines.append(f"  {block.until.words()} takes {least:,} to {most:,} runs.")
        why = reasons(state.store, new).most_common(REASONS)
        lines += [f"  {count} because {reason}." for reason, count in why]
        coming += new
    if coming:
        seconds, how = time_of(state.store, coming, jobs)
        lines.append(
            f"About {span(seconds)} with {jobs} processes ({how}), and some minutes where kernels "
            "are not compiled yet."
        )
    return "\n".join(lines)


def existing(state: SweepState, name: str) -> tuple[set[str], set[str]]:
    """Identities of the runs of a block that are finished, and of those that failed."""
    store, wanted = state.store, set(state.block(name).points)
    finished, failed = set(), set()
    for batch in store.complete().values():
        if shared := wanted.intersection(batch.runs):
            bad = store.failed(batch.id)
            finished |= shared - bad
            failed |= shared & bad
    for run in wanted - finished - failed:
        if (row := store.kept(run)) is not None:
            (failed if row["failure"] else finished).add(run)
    return finished, failed - finished


def time_of(store: Store, runs: list[Replicate], processes: int) -> tuple[float, str]:
    """Time (s) in which some processes make some runs, and how that is known."""
    speeds = speeds_of(store)
    new = sorted({kind for run in runs if (kind := _kind(run)) not in speeds})
    how = f"a guess: no {' and '.join(new)} was made here yet" if new else "as such runs took"
    guesses = (GUESS.get(run.shape.kind, ITERATED) for run in runs)
    each = (speeds.get(_kind(run), guess) for run, guess in zip(runs, guesses, strict=True))
    return sum(effort(run) * speed for run, speed in zip(runs, each, strict=True)) / processes, how


def speeds_of(store: Store) -> dict[str, float]:
    """Processor time (s) over effort, by kind of run, in the newest batches of the store."""
    paths = (store.folder / "batches").glob("*.nc")
    times = {}
    for path in islice(sorted(paths, key=lambda path: -path.stat().st_mtime), NEWEST):
        try:
            values, attrs = read(path, ("spent", "failure"))
            runs = [of_values(run) for run in json.loads(attrs["values"])]
        except (InputError, KeyError, ValueError):  # of another version
            continue
        for run, spent, failure in zip(runs, values["spent"], values["failure"], strict=True):
            if not failure:
                times.setdefault(_kind(run), []).append(spent / effort(run))
    return {kind: float(np.median(some)) for kind, some in times.items()}


def _kind(run: Replicate) -> str:
    return f"{run.configuration.experiment} of {run.shape.kind}s"


def effort(run: Replicate) -> float:
    """How much there is to do, but for a factor: granules times steps, without the bed."""
    own, shape = run.configuration, run.shape
    if (duration := own.module.duration(run)) is None:
        return 1e5 * shape.granules
    speed = np.sqrt(own.material.young_modulus / run.density)
    decay = -np.log(own.material.restitution)
    damped = DAMPED * decay / np.sqrt(pi**2 + decay**2)  # (step / f)^2 + damped step = 1
    step = 2.0 / (np.sqrt(damped**2 + 4.0 / own.numerics.step_fraction**2) + damped)
    return shape.granules * duration * speed / shape.diameter / step


def interrupted(state: SweepState, how: str = "run the same command to go on") -> str:
    """Message when a sweep is interrupted."""
    (runs, total), failed = state.counts(), state.failed()
    return f"{runs} of {total} runs are kept{f', {failed} of them failed' if failed else ''}; {how}"


def outcome(state: SweepState, new: int | None = None, draws: str = "dem figure all {}") -> str:
    """Message when a sweep is done: where its runs are, and what to do with them.

    new: how many of them were just made, None where that is unknown; draws: the command that draws
    a file of drag.
    """
    first, failed = [state.combined(name)[0] for name in state.sweep.blocks], 0
    if state.sweep.failures:
        failed = sum(int((read(path, ("failure",))[0]["failure"] != 0).sum()) for path in first)
    words = f"{state.results} holds {state.counts()[1]} runs"
    words += "" if new is None else f", {new} of them new"
    words += f"; {failed} of them failed." if failed else "."
    file = shlex.quote(str(first[0]))
    after = [f"dem info {file}", *([draws.format(file)] if first[0].stem == "drag" else [])]
    return f"{words} Next: {' or '.join(after)}"
