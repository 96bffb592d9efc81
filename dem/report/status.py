"""How far a sweep is: place by place what is done, under way, waiting and failed, and how well its mean
is known. It only reads, so any terminal may ask while the sweep runs."""

import time
from collections import Counter
from math import ceil, isfinite

from rich.console import Group
from rich.text import Text

from dem.analysis.tables import digits, numbers
from dem.base.errors import InputError
from dem.io.progress import span
from dem.sweep.axis import POINT, Axis
from dem.sweep.estimate import time_of
from dem.sweep.expand import Block
from dem.sweep.precision import Until, all_known, expected, numbers_of
from dem.sweep.state import SweepState

ROWS = 60  # of a table, at most
VARIED = 4  # values of a design that are shown, at most
REASONS = 5  # failures that are told, at most
USUAL = "5 %"  # what is asked for where a sweep does not say


def status(state: SweepState) -> Group:
    """What a sweep has now, one table a block, and what is left of it."""
    under_way, parts, left, failed, made = state.store.under_way(), [], [], Counter(), set()
    for name in state.sweep.blocks:
        block = state.block(name)
        until = block.until or _usual(block)
        numbers = state.numbers(until.variable)
        there = numbers.of(block, kept=True)
        made |= there.keys()
        left += [run for run in block.unique() if under_way.get(run.id, 0.0) is not None and run.id not in there]
        failed.update(numbers.failed[run] for run in block.points if run in numbers.failed)
        parts += [Text(state.folder_of(name), style="bold"), _table(block, until, there, under_way, numbers.failed)]
    running = sum(run.id in under_way for run in left)
    verb = "run is" if running == 1 else "runs are"
    words = f"{running} {verb} under way and {len(left) - running} wait. " if left else "All runs are made. "
    if left:
        seconds, how = time_of(state.store, left, max(1, running))
        words += f"About {span(seconds)} left with {max(1, running)} processes ({how}). "
    files = (state.store.file_of(each.id) for each in state.store.sealed().values() if made.intersection(each.runs))
    words += f"{1e-6 * sum(path.stat().st_size for path in files if path.exists()):.1f} MB of disk are used."
    told = [Text(f"{count} failed: {why}") for why, count in failed.most_common(REASONS)]
    return Group(Text(words), *told, *parts)


def _usual(block: Block) -> Until:
    names = numbers_of(block.first.configuration)
    if not names:
        raise InputError(f"runs of {block.name} record no number, whose mean could be known.")
    return Until(until=USUAL, of="drag" if "drag" in names else names[0])


def _table(block: Block, until: Until, there: dict, under_way: dict, failed: dict):
    """One row a place: its values, its runs, its mean."""
    shown, now = [axis for axis in block.beside_seed if len(axis.points) > 1] or block.beside_seed[:1], time.time()
    own = block.first.configuration
    units = "" if until.reference else own.module.layout(own)[until.variable][1]
    values = {
        place: [there[run.id] for run in runs if run.id in there]
        for place, runs in block.replicates.items()
    }  # fmt: skip
    places = all_known(until, values, block.partners)
    headings = [name for axis in shown for name in _names(axis)]
    columns = [
        *headings, "runs", "done", "running", "waiting", "failed", f"{until.of}\n{units}",
        f"{until.confidence}\n±", "within", f"replicates\nfor {until.until}",
    ]  # fmt: skip
    rows = []
    for place, runs in list(block.replicates.items())[:ROWS]:
        cells = [cell for at, axis in zip(place, block.beside_seed, strict=True) if axis in shown for cell in _cells(axis, at)]
        begun = [under_way[run.id] for run in runs if under_way.get(run.id) and run.id not in there]
        done = sum(run.id in there or under_way.get(run.id, 0.0) is None for run in runs)
        running = f"{len(begun)}, {span(now - min(begun))}" if begun else "-"
        bad = sum(run.id in failed for run in runs)
        counts = len(runs), done - bad, running, len(runs) - done - len(begun), bad
        cells += [str(each or "-") for each in counts]
        rows.append(cells + _known(places.get(place), until))
    said = [n for n, cells in enumerate(zip(*rows, strict=True)) if set(cells) != {"-"}]
    rows = ((row[n] for n in said) for row in rows)
    table = numbers(*(columns[n] for n in said), words=len(headings), rows=rows)
    if (more := len(block.replicates) - ROWS) > 0:
        table.caption = f"and {more} places more"
    return table


def _known(found, until: Until) -> list[str]:
    """A mean, its interval, that as a share, and how many replicates what is asked for takes."""
    if found is None:
        return ["1"] + 3 * ["-"]
    if found.runs < 3 or not isfinite(found.half):
        return [f"{found.value:.4g}" if found.runs else "-", "-", "-", "too few runs"]
    if found.is_near_zero(until):
        return [f"{found.value:.4g}", f"{found.half:.3g}", "-", "near zero"]
    return [
        f"{found.value:.4g}", f"{found.half:.3g}", f"{100.0 * found.half / abs(found.value):.2g} %",
        str(ceil(expected(found, until))),
    ]  # fmt: skip


def _names(axis: Axis) -> list[str]:
    """Headings of an axis: its name, or of a design the values that vary."""
    return list(axis.points[0])[:VARIED] if axis.entry.about == POINT else [axis.name]


def _cells(axis: Axis, at: int) -> list[str]:
    values = list(axis.points[at].values())[:VARIED] if axis.entry.about == POINT else [axis.coordinate[at]]
    form = digits(axis.coordinate)
    return [format(each, form) if isinstance(each, float) else str(each) for each in values]
