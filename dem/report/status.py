"""How far a sweep is: point by point what is done, running, waiting and failed, and how well its
mean is known. It only reads, so any terminal may ask while the sweep runs."""

import time
from collections import Counter
from math import ceil, isfinite, nan

import pandas as pd
from rich.console import Group
from rich.text import Text

from dem.analysis.tables import TextTable
from dem.base.errors import InputError
from dem.base.intervals import moments
from dem.io.progress import span
from dem.sweep.axis import POINT
from dem.sweep.estimate import time_of
from dem.sweep.expand import Block
from dem.sweep.precision import Until, estimates, is_near_zero, numbers_of, replicates_needed
from dem.sweep.state import SweepState

VARIED = 4  # values of a design that are shown, at most
REASONS = 5  # failures that are told, at most
USUAL = "5 %"  # what is asked for where a sweep does not say


def status(state: SweepState) -> Group:
    """What a sweep has now, one table a block, and what is left of it."""
    under_way, parts, left, failed, done = state.store.under_way(), [], [], Counter(), set()
    for name in state.sweep.blocks:
        block = state.block(name)
        until = block.until or _usual(block)
        numbers = state.numbers(until.variable)
        results = numbers.of(block, kept=True)
        done |= results.keys()
        left += [
            run
            for run in block.unique()
            if under_way.get(run.id, 0.0) is not None and run.id not in results
        ]
        failed.update(numbers.failed[run] for run in block.points if run in numbers.failed)
        table = TextTable(_table(block, until, results, under_way, numbers.failed))
        parts += [Text(f"\n{state.folder_of(name)}", style="bold"), table]
    running = sum(run.id in under_way for run in left)
    verb = "run is" if running == 1 else "runs are"
    words = f"{running} {verb} under way and {len(left) - running} wait. " if left else ""
    if left:
        seconds, how = time_of(state.store, left, max(1, running))
        words += f"About {span(seconds)} left with {max(1, running)} at a time ({how}). "
    batches = state.store.complete().values()
    files = [state.store.file_of(each.id) for each in batches if done.intersection(each.runs)]
    size = 1e-6 * sum(path.stat().st_size for path in files if path.exists())
    words = f"{words or 'All runs finished. '}{size:.1f} MB of disk are used."
    reasons = [Text(f"{count} failed: {why}") for why, count in failed.most_common(REASONS)]
    return Group(Text(words), *reasons, *parts)


def _usual(block: Block) -> Until:
    names = numbers_of(block.first.configuration)
    if not names:
        raise InputError(f"runs of {block.name} record no number, whose mean could be known.")
    return Until(until=USUAL, of="drag" if "drag" in names else names[0])


def _table(block: Block, until: Until, results: dict, under_way: dict, failed: dict):
    """One row a point: its values, its runs, its mean."""
    axes = block.beside_seed
    shown = [axis for axis in axes if len(axis.points) > 1] or axes[:1]
    configuration = block.first.configuration
    units = "" if until.reference else configuration.module.layout(configuration)[until.variable][1]
    values = {
        point: [results[run.id] for run in runs if run.id in results]
        for point, runs in block.replicates.items()
    }
    means, rows = estimates(until, values, block.partners), []
    for point, runs in block.replicates.items():
        row = {}
        for at, axis in zip(point, axes, strict=True):
            if axis in shown and axis.entry.about == POINT:
                row |= list(axis.points[at].items())[:VARIED]
            elif axis in shown:
                row[axis.name] = axis.coordinate[at]
        since = [
            under_way[run.id] for run in runs if under_way.get(run.id) and run.id not in results
        ]
        done = sum(run.id in results or under_way.get(run.id, 0.0) is None for run in runs)
        bad = sum(run.id in failed for run in runs)
        row |= {"runs": len(runs), "done": done - bad}
        row["running"] = f"{len(since)}, {span(time.time() - min(since))}" if since else 0
        row |= {"waiting": len(runs) - done - len(since), "failed": bad}
        heads = f"{until.of} {units}".strip(), "±", "within %", f"for {until.until}"
        row |= zip(heads, _mean(means.get(point), moments(values[point])[0], until), strict=True)
        rows.append(row)
    frame = pd.DataFrame(rows)
    empty = [name for name in ("running", "waiting", "failed") if not frame[name].any()]
    return frame.drop(columns=empty)


def _mean(mean, runs: int, until: Until) -> tuple:
    """A mean, half its interval, that as a share, and how many replicates what is asked for
    takes."""
    if mean is None:  # the reference of all ratios
        return 1, nan, nan, nan
    if runs < 3 or not isfinite(mean.half):
        return mean.value, nan, nan, "too few runs"
    if is_near_zero(mean, until):
        return mean.value, mean.half, nan, "near zero"
    share = 100.0 * mean.half / abs(mean.value)
    return mean.value, mean.half, share, ceil(replicates_needed(mean, runs, until))
