"""The table of `dem store`: runs by their values, and which sweeps need them."""

import math
from collections.abc import Iterable
from contextlib import suppress
from numbers import Integral

from rich.table import Column, Table

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.experiment.config import Replicate, entries
from dem.sweep.axis import OWN
from dem.sweep.prune import sweeps
from dem.sweep.store import Store

COLUMNS = "batch", "runs", "failed", "shape", "density kg/m3", "seeds", "values", "needed by"
FEW = 5  # values that are listed one by one


def listing(store: Store, wanted: dict[str, str]) -> Table:
    """One row a batch with runs of the wanted values, by path."""
    table = Table(*(Column(name, overflow="fold") for name in COLUMNS))
    users, unknown = [], "no sweep"
    try:
        users += sweeps(store)
    except InputError:  # a configuration whose files are away
        unknown = "not known"
    for batch in store.batches():
        failed, needed = "not made", [str(f) for f, ids, _ in users if ids & {*batch.runs}]
        with suppress(InputError):
            failed = str(len(store.failed(batch.id)))
        try:
            runs = [
                run
                for run in store.replicates(batch.id)
                if all(has_value(run, *item) for item in wanted.items())
            ]
            values = differing(runs) if runs else ""
        except InputError:
            runs, values = [], "of other code"
        if runs or (values and not wanted):
            table.add_row(
                batch.id,
                f"{len(runs)} of {len(batch.runs)}",
                failed,
                few(run.label for run in runs),
                few(f"{run.density:g}" for run in runs),
                few(str(run.seed) for run in runs),
                values,
                ", ".join(needed) or unknown,
            )
    return table


def few(words: Iterable[str]) -> str:
    """Words once each; of many the first and the last."""
    unique = list(dict.fromkeys(words))
    return (
        ", ".join(unique) if len(unique) <= FEW else f"{unique[0]} to {unique[-1]} ({len(unique)})"
    )


def wanted_values(words: Iterable[str]) -> dict[str, str]:
    """Values by path from words such as friction.granule=0.3; raises InputError."""
    wanted = {}
    for word in words:
        path, equal, value = word.partition("=")
        shape = path.split(".")[1:2] if path.startswith("shapes.") else ()
        values = entries(shape)
        known = [*values, *OWN]
        if not equal or path not in known:
            hint = did_you_mean(path, known, ", such as shape=c1 or friction.granule=0.3")
            raise InputError(f"{word!r} names no value of a run; write PATH=VALUE{hint}.")
        text = path == "shape" or (path in values and values[path].units is None)
        if not (text or value.lower() in ("none", "true", "false") or as_number(value) is not None):
            raise InputError(f"{word!r}: {path} is a number; write it as the list of runs does.")
        wanted[path] = value
    return wanted


def has_value(run: Replicate, path: str, text: str) -> bool:
    """Whether a run has the value at a path that a text says."""
    value = run.at(path)
    if isinstance(value, str | bool) or value is None:
        return text.lower() == str(value).lower()
    return is_written(value, text)


def as_number(text: str) -> float | None:
    """The finite number that a text says, if any."""
    with suppress(ValueError):
        if math.isfinite(said := float(text)):
            return said
    return None


def is_written(value: float, text: str) -> bool:
    """Whether a number is what a text says, exactly or as tables print it, with five digits."""
    said = as_number(text)
    if said is None or isinstance(value, Integral):
        return said == value
    return math.isclose(value, said, rel_tol=5e-5)


def differing(runs: list[Replicate]) -> str:
    """Values in which runs differ, beside shape, density and seed."""
    values = {
        path: dict.fromkeys(str(run.at(path)) for run in runs)
        for path in entries((), runs[0].configuration.read)
    }
    return "; ".join(f"{path} {few(some)}" for path, some in values.items() if len(some) > 1)
