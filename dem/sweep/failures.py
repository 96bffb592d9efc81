"""Runs of a large sweep that cannot be made: what is kept of each, and how many there may be.

A small file beside the place of the replicate says which run it was, what went wrong and with which
sources, so that it is not tried again before something changes.
"""

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dem.base.errors import OverlapError, PackingError, RunError, StateError
from dem.base.files import atomic
from dem.experiment.config import Replicate, Sweep

# Runs that failed, each with what is kept of it.
Failed = Sequence[tuple[Replicate, dict]]

_KINDS = ("none", PackingError.__name__, OverlapError.__name__, StateError.__name__, "other")
# Attributes of the variable `failure` of drag.nc (CF, section 3.5).
FLAGS = {
    "flag_values": np.arange(len(_KINDS), dtype="i1"),
    "flag_meanings": " ".join(_KINDS),
}


def _place(path: Path) -> Path:
    return Path(path).with_suffix(".failed")


def note(path: Path, replicate: Replicate, error: RunError) -> None:
    """Keep that the replicate with this path failed."""
    about = {
        "run_key": replicate.run_key(),
        "source_hash": replicate.source_hash,
        "error": type(error).__name__,
        "sentence": str(error),
    }
    with atomic(_place(path)) as part:
        part.write_text(json.dumps(about, indent=1), encoding="utf-8")


def forget(path: Path) -> None:
    """The replicate with this path has been made."""
    _place(path).unlink(missing_ok=True)


def found(path: Path, replicate: Replicate) -> dict | None:
    """What is kept of the failure of this very run, None if there is nothing."""
    try:
        about = json.loads(_place(path).read_text(encoding="utf-8"))
        return about if about["run_key"] == replicate.run_key() else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def flag(about: dict) -> int:
    """What went wrong, as one of FLAGS."""
    return _KINDS.index(about.get("error") if about.get("error") in _KINDS else "other")


def sort_out(sweep: Sweep, folder: Path) -> tuple[list[Path], list[tuple[Replicate, dict]]]:
    """Files of the replicates below a folder, and the runs that failed instead."""
    paths, failed = [], []
    for replicate in sweep.replicates():
        path = folder / replicate.path
        if sweep.failures and (about := found(path, replicate)):
            failed.append((replicate, about))
        else:
            paths.append(path)
    return paths, failed


def check(sweep: Sweep, failed: Failed) -> None:
    """Raise RunError where more runs failed than the sweep allows, or all of a case."""
    count = len(sweep.cases) * len(sweep.seeds)
    of_case = Counter(replicate.key[:2] for replicate, _ in failed)
    for (shape, density), fails in of_case.items():
        if fails == len(sweep.seeds):
            raise RunError(
                f"{shape} at {density} kg/m3: none of its {fails} replicates could be made; take the case out "
                "of the configuration, or change its values."
            )
    if len(failed) > sweep.failures * count + 1e-9:  # 0.29 * 100 is a little less than 29
        replicate, about = failed[0]
        raise RunError(
            f"{len(failed)} of {count} replicates could not be made; failures allows "
            f"{sweep.failures:g} of them. The first is {replicate.path}: {about.get('sentence')}"
        )
