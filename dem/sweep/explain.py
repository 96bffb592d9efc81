"""Explain why runs must be made again whose values are in the store.

The code of some file has changed, or the version of a package.
"""

import json
from collections import Counter
from collections.abc import Iterable

from dem.base.errors import InputError
from dem.base.provenance import versions
from dem.base.sources import run_codes
from dem.experiment.config import Replicate, of_values
from dem.io.dataset import read
from dem.sweep.store import Store

SAMPLE = 200  # runs to be made, and files of the store, that are compared
FEW = 3  # names of files in a sentence


def reasons(store: Store, runs: Iterable[Replicate]) -> Counter:
    """Reasons, in words, why runs are not in the store, with how many runs have each."""
    files = sorted((store.folder / "batches").glob("*.nc"), key=lambda path: path.stat().st_mtime)
    stored, counts = {}, Counter()  # attributes of the file of a run, by its values
    for path in files[-SAMPLE:]:
        try:
            _, attrs = read(path, ())
            stored |= {of_values(run).run_key(): attrs for run in json.loads(attrs["values"])}
        except (InputError, KeyError, ValueError):  # of a version with other values
            continue
    for run in list(runs)[:SAMPLE]:
        if attrs := stored.get(run.run_key()):
            counts[_reason(run, attrs)] += 1
    return counts


def _reason(run: Replicate, attrs: dict) -> str:
    then, now = json.loads(attrs["code"]), run_codes(*run.files)
    names = sorted(name for name in now | then if now.get(name) != then.get(name))
    if not names:
        return f"it was made with {attrs['versions']}, which is now {versions()}"
    more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
    return f"the code has changed since it was made: {', '.join(names[:FEW])}{more}"
