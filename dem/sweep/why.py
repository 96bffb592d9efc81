"""Why runs will be made that look like runs that are there: which room of code differs, or which value."""

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from dem.base.errors import InputError
from dem.base.provenance import versions
from dem.base.sources import codes
from dem.experiment.config import Replicate, of_values
from dem.io.dataset import read
from dem.sweep.store import Store

LOOKED_AT = 200  # runs to be made, and files of the store
FEW = 3  # values in which a run may differ and still be like another


class Made(NamedTuple):
    """A run that is there: its values by path, and what it was made with."""

    key: str
    values: dict
    code: dict[str, str]
    versions: str


def reasons(store: Store, runs: Iterable[Replicate]) -> Counter:
    """How many of some runs that are not there have which reason, in words."""
    there = {each.key: each for each in made(store)}
    runs = list(runs)[:LOOKED_AT]
    return Counter(_reason(there, run) for run in runs) if there else Counter()


def made(store: Store) -> Iterator[Made]:
    """The runs that the newest files of the store hold."""
    files = sorted((store.folder / "batches").glob("*.nc"), key=lambda path: path.stat().st_mtime)
    for path in files[-LOOKED_AT:]:
        try:
            _, attrs = read(path, ())
            code = json.loads(attrs["code"])
            for values in json.loads(attrs["values"]):
                key = of_values(values).run_key()
                yield Made(key, dict(flat(values)), code, attrs["versions"])
        except (InputError, KeyError, ValueError):  # of another schema: like nothing of today
            continue


def _reason(there: dict[str, Made], run: Replicate) -> str:
    if (same := there.get(run.run_key())) is not None:
        now = codes(*run.modules, bits=True)
        rooms = sorted(name for name in now | same.code if now.get(name) != same.code.get(name))
        if rooms:
            return f"the code has changed since it was made: {', '.join(rooms[:FEW])}" + (
                f" and {len(rooms) - FEW} more" if len(rooms) > FEW else ""
            )
        return f"it was made with {same.versions}, which is now {versions()}"
    own = dict(flat(run.values(beside=False)))
    differing = [
        {
            path: (each.values.get(path), own.get(path))
            for path in own | each.values
            if each.values.get(path) != own.get(path)
        }
        for each in there.values()
    ]
    nearest = min(differing, key=len)
    if len(nearest) > FEW:
        return "no run like it is there"
    words = (f"{path} is {new}, not {old}" for path, (old, new) in nearest.items())
    return f"the nearest differs: {', '.join(words)}"


def flat(values: dict, head: str = "") -> Iterator[tuple[str, object]]:
    """Values of groups by path; lists as tuples."""
    for name, value in values.items():
        if isinstance(value, dict):
            yield from flat(value, f"{head}{name}.")
        else:
            yield f"{head}{name}", tuple(value) if isinstance(value, list) else value
