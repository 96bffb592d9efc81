"""How far a sweep is: point by point what is done, running, waiting and failed, and how well its
mean is known. It only reads, so any terminal may ask while the sweep runs."""

from collections import Counter
from math import ceil, isfinite, nan

import pandas as pd
from rich.console import Group
from rich.text import Text

from dem.analysis.tables import TextTable
from dem.base.statistics import moments
from dem.io.progress import span
from dem.sweep.axis import POINT
from dem.sweep.estimate import time_of
from dem.sweep.expand import Block
from dem.sweep.precision import Until, estimates, is_near_zero, numbers_of, replicates_needed, usual
from dem.sweep.state import SweepState

STATES = "done", "running", "waiting", "failed"
VARIED = 4  # values of a design that are shown, at most
REASONS = 5  # failures that are told, at most
USUAL = "5 %"  # what is asked for where a sweep does not say


def status(state: SweepState) -> Group:
    """What a sweep has now, one table a block, and what is left of it."""
    locked, parts, left, reasons = state.store.locked_runs(), [], [], Counter()
    for name in state.sweep.blocks:
        block = state.block(name)
        until = block.until or Until(until=USUAL, of=usual(numbers_of(block.first.configuration)))
        results, states = state.means(block, until.variable, kept=True), {}
        for run in block.unique():
            states[run.id] = "running" if run.id in locked else "waiting"
            if run.id not in results:
                left.append(run)
            elif reason := results[run.id][1]:
                states[run.id] = "failed"
                reasons[reason] += 1
            else:
                states[run.id] = "done"
        table = TextTable(_table(block, until, results, states))
        parts += [Text(f"\n{state.folder_of(name)}", style="bold"), table]
    running = sum(run.id in locked for run in left)
    words = "All runs finished."
    if left:
        seconds, how = time_of(state.store, left, max(1, running))
        words = (
            f"Runs under way: {running}, waiting: {len(left) - running}. About {span(seconds)} left "
            f"with {max(1, running)} at a time ({how})."
        )
    failures = [Text(f"{count} failed: {why}") for why, count in reasons.most_common(REASONS)]
    return Group(Text(words), *failures, *parts)


def _table(block: Block, until: Until, results: dict, states: dict[str, str]) -> pd.DataFrame:
    """One row a point: its values, how many of its runs are in each state, its mean."""
    axes = block.beside_seed
    shown = [axis for axis in axes if len(axis.points) > 1] or axes[:1]
    configuration = block.first.configuration
    units = "" if until.reference else configuration.module.layout[until.variable][1]
    values = {
        point: [results[run.id][0] for run in runs if run.id in results]
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
        counts = Counter(states[run.id] for run in runs)
        row |= {"runs": len(runs), **{name: counts[name] for name in STATES}}
        heads = f"{until.of} {units}".strip(), "±", "within %", f"for {until.until}"
        row |= zip(heads, _mean(means.get(point), moments(values[point])[0], until), strict=True)
        rows.append(row)
    frame = pd.DataFrame(rows)
    return frame.drop(columns=[name for name in STATES[1:] if not frame[name].any()])


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
