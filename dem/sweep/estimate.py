"""What a sweep will cost, and what the store holds, in words and tables."""

import json
import math
import shlex
from contextlib import suppress
from itertools import islice
from math import prod

import numpy as np
from rich.table import Column, Table

from dem.base.errors import InputError
from dem.base.hints import is_number, is_written, meant
from dem.experiment.config import Replicate, entries, of_values
from dem.io.dataset import read
from dem.io.progress import span
from dem.sweep.axis import OWN
from dem.sweep.batch import retry
from dem.sweep.campaign import Campaign
from dem.sweep.explain import reasons
from dem.sweep.precision import outlook
from dem.sweep.prune import sweeps
from dem.sweep.store import Store

# s an effort, where no run was made yet: of a usual processor, by kind of granule
GUESS = {"disc": 3e-8, "dumbbell": 6e-8, "ellipse": 6e-8}
ITERATED = 6e-7  # the same of shapes whose contacts are found by iteration, as of superellipses
MEASURED = 2e-5  # s a granule and snapshot: to measure flow of snapshots
DAMPED = 30.0  # by how much damping bounds the step, over how much stiffness does, a damping ratio (study budget)
LISTED = 40  # runs, or batches, that are shown
# of the list of batches
COLUMNS = "batch", "runs", "failed", "shape", "density kg/m3", "seeds", "values", "needed by"


def summary(campaign: Campaign, jobs: int, again: bool = False) -> str:
    """Runs and beds of a sweep, how many there are already, and an estimate for the others.

    again: whether runs that failed are made again.
    """
    lines, coming, first = [], [], None
    for name in campaign.sweep.blocks:
        block = campaign.block(name)
        runs = list(block.unique())
        there, failed = made(campaign, name)
        left = [run for run in runs if run.id not in (there if again else there | failed)]
        beds = {run.bed_id for run in left if not campaign.store.file_of_bed(run).is_file()}
        coming += left
        axes = ", ".join(f"{axis.name} {len(axis.points)}" for axis in block.axes)
        first = first or (left or runs)[0]
        words = "these are made again" if again else "dem sweep --retry makes these again"
        lines.append(
            f"{campaign.folder_of(name)}: {len(block.runs)} places ({axes}), {len(runs)} runs, of which "
            f"{len(there)} are there{f' and {len(failed)} failed ({words})' if failed else ''}; "
            f"{len(beds)} beds to pack."
        )
        if block.until:
            lines.append(f"  {_outlook(campaign, block, runs, jobs)}")
        lines += [f"  {run.words()}{_values(block, run)}" for run in islice(left, LISTED)]
        if len(left) > LISTED:
            lines.append(f"  and {len(left) - LISTED} more.")
        lines += [
            f"  {n} because {why}." for why, n in reasons(campaign.store, left).most_common(LISTED)
        ]
    if coming:
        seconds, how = time_of(campaign, coming, jobs)
        lines.append(
            f"About {span(seconds)} with {jobs} processes ({how}) and "
            f"{1e-6 * sum(map(bytes_of, coming)):.1f} MB of disk, and some minutes where kernels are not "
            "compiled yet."
        )
    return "\n".join(lines)


def _outlook(campaign: Campaign, block, runs: list[Replicate], jobs: int) -> str:
    """What a precision takes, in words."""
    values = campaign.values(block)
    some, least, most = outlook(block, values)
    seconds = sum(costs(campaign, runs)[0]) / len(runs) / jobs  # a run
    if any(map(len, values.values())):
        said = f"some {some:,} runs in all by the scatter so far ({least:,} to {most:,}), {span(seconds * some)}"
    else:
        said = (
            f"{least:,} runs at least and {most:,} at most, {span(seconds * least)} to {span(seconds * most)}; "
            "the first round will tell"
        )
    return f"{block.until.words()} takes {said}."


def time_of(campaign: Campaign, runs: list[Replicate], processes: int) -> tuple[float, str]:
    """Time (s) in which some processes make some runs, and how that is known: at least that of the
    longest batch, which one process makes."""
    seconds, how = costs(campaign, runs)
    of_run = dict(zip((run.id for run in runs), seconds, strict=True))
    known = [name for name in campaign.sweep.blocks if campaign.is_known(name)]
    batches = (batch.runs for name in known for batch in campaign.batches(name))
    longest = max((sum(of_run.get(run, 0.0) for run in some) for some in batches), default=0.0)
    return max(sum(seconds) / processes, longest), how


def costs(campaign: Campaign, runs: list[Replicate]) -> tuple[list[float], str]:
    """Processor time (s) that each of some runs will take, and how that is known."""
    speeds = speeds_of(campaign)
    new = sorted({kind for run in runs if (kind := _kind(run)) not in speeds})
    how = f"a guess: no run of {' and '.join(new)} was made here yet" if new else "as runs like these took"
    speed = {
        run.shape.kind: speeds.get(_kind(run), GUESS.get(run.shape.kind, ITERATED)) for run in runs
    }
    return [_effort(run) * speed[run.shape.kind] + _measuring(run) for run in runs], how


def _measuring(replicate: Replicate) -> float:
    """Processor time (s) after a run in which its flow is measured from its snapshots."""
    record = replicate.configuration.record
    if "snapshots" not in record.observables or "flow" in record.observables:
        return 0.0
    return MEASURED * record.snapshots * replicate.shape.granules


def _values(block, replicate: Replicate) -> str:
    """What was varied of a run, beside shape, density and seed."""
    words = ""
    for path in (path for axis in block.axes for path in axis.paths if path not in OWN):
        if (at := replicate.at(path)) is not None:
            words += f", {path} {at:g}" if isinstance(at, float | int) else f", {path} {at}"
    return words


def made(campaign: Campaign, block: str) -> tuple[set[str], set[str]]:
    """Identities of the runs of a block that are in the store, and of those that failed."""
    store, wanted = campaign.store, set(campaign.block(block).places)
    there, failed = set(), set()
    for batch in store.complete().values():
        if here := wanted.intersection(batch.runs):
            bad = store.failed(batch.id)
            there |= here - bad
            failed |= here & bad
    for run in wanted - there - failed:
        if (row := store.kept(run)) is not None:
            (failed if row["failure"] else there).add(run)
    return there, failed - there


def kept(campaign: Campaign, how: str = "run the same command to go on") -> str:
    """What a sweep has that is stopped, and how it goes on."""
    (there, total), failed = campaign.counts(), campaign.failed()
    return (
        f"{there} of {total} runs are kept{f', {failed} of them failed' if failed else ''}; {how}"
    )


def outcome(campaign: Campaign, new: int | None = None, draws: str = "dem figure all {}") -> str:
    """Which file holds the runs of a sweep that is done, and what to do with it.

    new: how many of them were just made, None where that is unknown; draws: the command that draws
    a file of drag.
    """
    names = campaign.sweep.blocks
    first, *others = (
        f"{campaign.folder_of(name)}/{each}.nc" for name in names for each in campaign.observables(name)
    )
    failed = 0
    if campaign.sweep.failures:
        combined = map(campaign.first, campaign.sweep.blocks)
        failed = sum(int((read(path, ("failure",))[0]["failure"] != 0).sum()) for path in combined)
    more = f", as {len(others)} more files in {campaign.sweep.results} do" if others else ""
    said = f"{first} holds {campaign.counts()[1]} runs{more}"
    said += "" if new is None else f", {new} of them new"
    said += f"; {failed} of them failed." if failed else "."
    word = shlex.quote(first)
    after = [f"dem info {word}", *([draws.format(word)] if first.endswith("/drag.nc") else [])]
    return f"{said} Next: {' or '.join(after)}"


def _effort(replicate: Replicate) -> float:
    """How much there is to do, but for a factor: granules times steps, without their bed."""
    own, shape = replicate.configuration, replicate.shape
    if (duration := own.module.duration(replicate)) is None:
        return 1e5 * shape.granules
    speed, decay = np.sqrt(own.material.young_modulus / replicate.density), -np.log(own.material.restitution)
    damped = DAMPED * decay / np.sqrt(np.pi**2 + decay**2)  # (step / f)^2 + damped step = 1
    step = 2.0 / (np.sqrt(damped**2 + 4.0 / own.numerics.step_fraction**2) + damped)
    return shape.granules * duration * speed / shape.diameter / step


def speeds_of(campaign: Campaign) -> dict[str, float]:
    """Processor time (s) over effort, by kind of granule, of runs that are there: of the sweep, or else
    of some others."""
    found, others = {}, {}
    for name in campaign.sweep.blocks:
        block = campaign.block(name)
        spent = campaign.numbers("spent").of(block, kept=True)
        for run in block.unique():
            if math.isfinite(spent.get(run.id, math.nan)):
                found.setdefault(_kind(run), []).append(spent[run.id] / _effort(run))
    for path in islice(sorted((campaign.store.folder / "batches").glob("*.nc")), LISTED):
        try:
            values, attrs = read(path, ("spent", "failure"))
            runs = [of_values(each) for each in json.loads(attrs["values"])]
        except (InputError, KeyError, ValueError):
            continue
        for run, spent, failure in zip(runs, values["spent"], values["failure"], strict=True):
            if not failure:
                others.setdefault(_kind(run), []).append(float(spent) / _effort(run))
    return {kind: float(np.median(some)) for kind, some in (others | found).items()}


def _kind(replicate: Replicate) -> str:
    return f"{replicate.configuration.experiment} {replicate.shape.kind}"


def bytes_of(replicate: Replicate) -> int:
    """Bytes that a run takes in its batch; compressing gains a quarter."""
    own = replicate.configuration
    sizes, layout = own.module.sizes(replicate), own.module.layout(own)
    count = sum(prod(sizes[dim] for dim in dims) for dims, *_ in layout.values())
    return 6 * count + 24 * replicate.shape.granules


def retried(campaign: Campaign) -> int:
    """Let the failed runs of a sweep be made again; returns how many there are."""
    known = [block for block in campaign.sweep.blocks if campaign.is_known(block)]
    campaign.begin(*known)
    batches = dict.fromkeys(batch.id for block in known for batch in campaign.batches(block))
    store = campaign.store
    return sum(retry(store, batch, store.replicates(batch)) for batch in batches)


def listing(store: Store, wanted: list[tuple[str, str]]) -> Table:
    """Batches of the store: how many runs of which values, and which sweeps need them."""
    table = Table(*(Column(name, overflow="fold") for name in COLUMNS))
    users, unknown = [], "no sweep"
    try:
        users += sweeps(store)
    except InputError:  # a configuration whose files are away
        unknown = "not known"
    for batch in store.batches():
        try:
            runs = store.replicates(batch.id)
        except InputError:  # of another version of the code
            runs = None
        mine = [run for run in runs or () if all(_matches(run, *each) for each in wanted)]
        if not mine and (runs is not None or wanted):
            continue
        needed, failed = [str(folder) for folder, ids, _ in users if ids.intersection(batch.runs)], "not made"
        with suppress(InputError):
            failed = str(len(store.failed(batch.id)))
        table.add_row(
            batch.id, f"{len(mine)} of {len(batch.runs)}", failed,
            _few(run.label for run in mine), _few(f"{run.density:g}" for run in mine),
            _few(str(run.seed) for run in mine),
            differing(mine) if runs is not None else "of other code", ", ".join(needed) or unknown,
        )  # fmt: skip
    return table


def _few(words) -> str:
    """Words once each; of many the first and the last."""
    found = list(dict.fromkeys(words))
    return ", ".join(found) if len(found) <= 5 else f"{found[0]} to {found[-1]} ({len(found)})"


def wanted_of(word: str) -> tuple[str, str]:
    """Path and value of a word such as friction.granule=0.3; raises InputError."""
    path, equal, value = word.partition("=")
    shape = path.split(".")[1:2] if path.startswith("shapes.") else ()
    values = entries(shape)
    known = [*values, *OWN]
    if not equal or path not in known:
        hint = meant(path, known) or ", such as shape=c1 or friction.granule=0.3"
        raise InputError(f"{word!r} names no value of a run; write PATH=VALUE{hint}.")
    text = path == "shape" or (path in values and values[path].units is None)
    if not (text or value.lower() in ("none", "true", "false") or is_number(value)):
        raise InputError(f"{word!r}: {path} is a number; write it as the list of runs does.")
    return path, value


def _matches(replicate: Replicate, path: str, value: str) -> bool:
    """Whether a run has this value."""
    at = replicate.at(path)
    if isinstance(at, str | bool) or at is None:
        return value.lower() == str(at).lower()
    return is_written(at, value)


def differing(runs: list[Replicate]) -> str:
    """Values in which runs differ, beside shape, density and seed."""
    found = []
    for path in entries((), runs[0].configuration.read):
        values = dict.fromkeys(str(run.at(path)) for run in runs)
        if len(values) > 1:
            found.append(f"{path} {_few(values)}")
    return "; ".join(found)
