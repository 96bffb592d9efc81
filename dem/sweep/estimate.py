"""What a sweep costs: how many runs exist, why others must be made again, and how long that takes."""

import json
import shlex
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import islice
from math import pi

import numpy as np

from dem.base.errors import InputError
from dem.base.files import fullness
from dem.base.provenance import versions
from dem.base.source_hash import run_codes
from dem.experiment.config import of_results
from dem.experiment.replicate import Replicate
from dem.io.dataset import read
from dem.io.progress import span
from dem.packing.cost import packing_time
from dem.sweep.state import SweepState
from dem.sweep.store import Store

# s an effort, where no run like it exists: of a usual processor, by kind of granule
GUESS = {"disc": 3e-8, "dumbbell": 6e-8, "ellipse": 6e-8}
ITERATED = 6e-7  # the same of shapes whose contacts are found by iteration, as of superellipses
DAMPED = 30.0  # ratio of the bounds of the step by damping and by stiffness, per damping ratio
NEWEST = 100  # batches of the store that are read
SAMPLE = 200  # runs to be made that are compared with them


def summary(state: SweepState, jobs: int, retry: bool = False) -> str:
    """Runs and beds of a sweep, how many exist, and an estimate for the others.

    retry: whether runs that failed are made again.
    """
    lines, coming = [], []
    for name in state.sweep.blocks:
        block = state.block(name)
        runs = list(block.unique())
        rows = state.store.rows(block.points, kept=True)
        failed = {run for run, row in rows.items() if row["failure"]}
        new = [run for run in runs if run.id not in rows or (retry and run.id in failed)]
        beds = {run.bed_id for run in new if not state.store.file_of_bed(run).is_file()}
        axes = ", ".join(f"{axis.name} {len(axis.points)}" for axis in block.axes)
        words = "these are made again" if retry else "dem sweep --retry makes these again"
        lines.append(
            f"{state.folder_of(name)}: {len(runs)} runs ({axes}), {len(rows) - len(failed)} finished"
            f"{f', {len(failed)} failed ({words})' if failed else ''}, {len(new)} to be made; "
            f"{len(beds)} beds to pack."
        )
        if block.until:
            most = len(block.counts) * block.until.most
            lines.append(f"  {block.until.words()} takes {len(runs):,} to {most:,} runs.")
        why = reasons(state.store, new).most_common()
        lines += [f"  {count} because {reason}." for reason, count in why]
        coming += new
    if coming:
        processes = min(jobs, len(coming))
        seconds, how = time_of(state.store, coming, processes)
        lines.append(
            f"About {span(seconds)} with {processes} process{'es' if processes > 1 else ''} ({how}), "
            "and some minutes where kernels are not compiled yet."
        )
    return "\n".join(lines)


def time_of(store: Store, runs: list[Replicate], processes: int) -> tuple[float, str]:
    """Time (s) in which some processes make some runs and their beds, and how that is known."""
    ratios = {}  # processor time over that guessed, by kind, in the newest batches of the store
    for made, values, _ in newest(store):
        of_runs = zip(made, values["spent"], values["failure"], guessed(made, set()), strict=True)
        for run, spent, failure, guess in of_runs:
            if not failure:
                ratios.setdefault(_kind(run), []).append(spent / guess)
    speeds = {kind: float(np.median(some)) for kind, some in ratios.items()}
    new = sorted({kind for run in runs if (kind := _kind(run)) not in speeds})
    how = f"a guess: no {' and '.join(new)} was made here yet" if new else "as such runs took"
    packed = {run.bed_description.text for run in runs if store.file_of_bed(run).is_file()}
    times = zip(guessed(runs, packed), runs, strict=True)
    return sum(time * speeds.get(_kind(run), 1.0) for time, run in times) / processes, how


def guessed(runs: list[Replicate], packed: set[str]) -> Iterator[float]:
    """Processor time (s) of some runs, each bed with the first that needs it; packed: text of
    the beds that exist."""
    for run in runs:
        speed = GUESS.get(run.shape.kind, ITERATED)
        seconds = speed * effort(run)
        bed = run.bed_description.text
        if run.configuration.module.observed and bed not in packed:
            time = packing_time(run.shape.granules, run.configuration.packing.fraction)
            seconds += time * speed / GUESS["disc"]  # as if its granules were discs
            packed.add(bed)
        yield seconds


def newest(store: Store) -> Iterator[tuple[list[Replicate], dict, dict]]:
    """Runs of the newest batches of a store, with variables and attributes of their files."""
    paths = (store.folder / "batches").glob("*.nc")
    for path in sorted(paths, key=lambda path: path.stat().st_mtime)[-NEWEST:]:
        with suppress(InputError, KeyError, ValueError):  # of another version
            values, attrs = read(path, ("spent", "failure"))
            yield [of_results(run) for run in json.loads(attrs["values"])], values, attrs


def reasons(store: Store, runs: Iterable[Replicate]) -> Counter:
    """Reasons, in words, why runs must be made again whose values are in the store, with how many
    runs have each: the code of some file has changed, or the version of a package."""
    stored = {run.run_key(): attrs for runs, _, attrs in newest(store) for run in runs}
    words = Counter()
    for run in islice(runs, SAMPLE):
        if (attrs := stored.get(run.run_key())) is None:
            continue
        then, now = json.loads(attrs["code"]), run_codes(*run.files)
        if names := sorted(name for name in now | then if now.get(name) != then.get(name)):
            words[f"the code has changed since it was made: {', '.join(names)}"] += 1
        else:
            words[f"it was made with {attrs['versions']}, which is now {versions()}"] += 1
    return words


def _kind(run: Replicate) -> str:
    return f"{run.configuration.experiment} of {run.shape.kind}s"


def effort(run: Replicate) -> float:
    """How much there is to do, but for a factor: granules times steps, without the bed."""
    configuration, shape = run.configuration, run.shape
    if (duration := configuration.module.answer("duration", run)) is None:
        return 1e5 * shape.granules
    speed = np.sqrt(configuration.material.young_modulus / run.density)
    decay = -np.log(configuration.material.restitution)
    damped = DAMPED * decay / np.sqrt(pi**2 + decay**2)  # (step / f)^2 + damped step = 1
    step = 2.0 / (np.sqrt(damped**2 + 4.0 / configuration.numerics.step_fraction**2) + damped)
    return shape.granules * duration * speed / shape.diameter / step


def interrupted(state: SweepState) -> str:
    """Message when a sweep is interrupted. A job cannot say it where its log is on a full disk."""
    runs, total = state.counts()
    why = fullness(state.results)
    return f"{why}{'; ' * bool(why)}{runs} of {total} runs are kept; run the same command to go on"


def outcome(state: SweepState, new: int | None = None, draws: str = "dem figure all {}") -> str:
    """Message when a sweep is done: where its runs are, and what to do with them.

    new: how many of them were just made, None where that is unknown; draws: the command that draws
    a file of drag.
    """
    counts = f"{state.counts()[1]} runs{'' if new is None else f', {new} of them new'}"
    first = state.combined()[0]
    file = shlex.quote(str(first))
    draw = f" or {draws.format(file)}" if first.stem == "drag" else ""
    return f"{state.results} holds {counts}. Next: dem info {file}{draw}"
