"""The table of `dem store`: runs by their values, and which sweeps need them."""

import math
from collections.abc import Iterable
from contextlib import suppress

from rich.table import Column, Table

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.experiment.config import Replicate, entries
from dem.sweep.axis import OWN
from dem.sweep.prune import sweeps
from dem.sweep.store import Store

COLUMNS = "batch", "runs", "failed", "shape", "density kg/m3", "seeds", "values", "needed by"
PRINTED = 5e-5  # relative tolerance of a number that a table prints, with five digits
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
                if all(is_written(run.at(path), text) for path, text in wanted.items())
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
        path, equal, wanted[path] = word.partition("=")
        known = [*entries(path.split(".")[1:2]), *OWN]  # of the shape that it may name
        if not equal or path not in known:
            hint = did_you_mean(path, known, ", such as shape=c1 or friction.granule=0.3")
            raise InputError(f"{word!r} names no value of a run; write PATH=VALUE{hint}.")
    return wanted


def is_written(value, text: str, tolerance: float = PRINTED) -> bool:
    """Whether a value is what a text says; a real number also as tables print it, with five digits.

    tolerance: of real numbers, relative to their size.
    """
    try:
        return math.isclose(value, float(text), rel_tol=tolerance * isinstance(value, float))
    except (TypeError, ValueError):
        return text in (str(value), str(value).lower())  # files have true and none


def differing(runs: list[Replicate]) -> str:
    """Values in which runs differ, beside shape, density and seed."""
    values = {
        path: dict.fromkeys(str(run.at(path)) for run in runs)
        for path in entries((), runs[0].configuration.read)
    }
    return "; ".join(f"{path} {few(some)}" for path, some in values.items() if len(some) > 1)
