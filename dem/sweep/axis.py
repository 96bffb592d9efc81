"""What varies in a file: from a key and its values to a dimension and the changes of its points.

A path of the configuration, `shape`, `case`, `density` or `seed` takes a list. `{times: [...]}`
gives factors on the file's own value. Any other name takes named points, each a group of values
that change together, or a design over ranges.
"""

import json
import math
import re
from typing import NamedTuple

from dem.base.errors import InputError
from dem.base.messages import check_known, did_you_mean
from dem.base.refusals import parsed, written
from dem.base.types import SEEDS, Label, Number
from dem.experiment.config import Configuration
from dem.experiment.entries import Entry, entries
from dem.experiment.kinds import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.experiment.sections import RunSection
from dem.io.dataset import LABELS, OF_RUN, OF_STORE, OF_SWEEP
from dem.sweep import design
from dem.sweep.derive import Derive
from dem.sweep.precision import MOST_RUNS, Until

RUN_KEYS = tuple(RunSection.model_fields)  # of a run, beside the values of its configuration
RUNS = {
    name: entry._replace(about="")  # which dem.io.dataset says
    for name, entry in entries(RunSection.model_fields).items()
}
RUNS["case"] = RUNS["shape"]._replace(path="case")  # a row of the table
TABLES = {"case": "cases", "shape": "shapes"}  # of labels
POINT = "point of the design"  # long name of an axis that is a design


class Axis(NamedTuple):
    """A dimension: name, units and words, coordinate, and the changes of every point by path.

    until: of seeds without an end.
    """

    name: str
    entry: Entry
    coordinate: list
    points: list[dict]
    until: Until | None = None

    @property
    def paths(self) -> list[str]:
        """What varies along it."""
        return list(dict.fromkeys(path for point in self.points for path in point))


def axis_of(
    name: str, spec, sweep: Configuration, where: str, replicates: int | None = None
) -> Axis:
    """The dimension of a name in the group `where`; raises InputError with the key and the value at
    fault. replicates: of seeds without an end, of the first round if absent."""
    key, entry = f"{where}.{name}", RUNS.get(name) or sweep.entries.get(name)
    if name == "seed" and isinstance(spec, dict):
        until = parsed(Until, spec, key)
        seeds = list(range(until.first, until.first + (replicates or until.least)))
        return Axis(name, entry, seeds, [{"seed": seed} for seed in seeds], until)
    if entry:
        values = _values(spec, entry, sweep, key)
        if name == "case":
            points = [dict(sweep.cases[value]) for value in values]
        else:
            points = [{name: value} for value in values]
        if any(value is None or isinstance(value, tuple) for value in values):
            entry = entry._replace(units=None)
            values = list(map(text_of, values))  # a coordinate has neither gaps nor rows
        return Axis(name if name in RUNS else name_of(name), entry, values, points)
    points = spec.values() if isinstance(spec, dict) and "design" not in spec else ()
    if not isinstance(spec, dict) or not spec or not all(isinstance(p, dict) for p in points):
        _check_known(name, [*sweep.entries, *RUNS], where)
    parsed(Label, name, f"a name in {where}")
    if "design" in spec:
        return _design(name, spec, sweep, key)
    names = list(map(str, spec))
    if None in spec or not all(map(str.strip, names)):
        raise InputError(f"{key} has a point without a name; give it one, such as a, or a number.")
    _check_once(names, key)
    points = [changes(point, sweep, f"{key}.{point_name}") for point_name, point in spec.items()]
    return Axis(name_of(name), Entry(name, None, "values that go together"), names, points)


def _design(name: str, spec: dict, sweep: Configuration, key: str) -> Axis:
    """Points that fill a space of values, each with a seed if the design has a first one."""
    wanted = parsed(design.Design, spec, key)
    for path in wanted.over:
        _check_known(path, sweep.entries, f"{key}.over")
    points = design.points(wanted)
    if wanted.first_seed is not None:
        points = [point | {"seed": wanted.first_seed + k} for k, point in enumerate(points)]
    return Axis(name_of(name), Entry(name, "1", POINT), list(range(len(points))), points)


TAKEN = {"run", "bound", "snapshot", "granule", "shear_strain", *OBSERVABLES}.union(
    *(header["VARIABLES"] for header in OBSERVABLES.values()),
    *(EXPERIMENTS["drag"]["AXIS"], LABELS, OF_RUN, OF_STORE, OF_SWEEP),
)


def name_of(path: str) -> str:
    """The name of a value in files of results, with a suffix if what runs record has that name."""
    name = path.replace(".", "_")
    return f"{name}_swept" if name in TAKEN else name


def text_of(value) -> str:
    """A value as a text, from which `dem.analysis.one_run` has it again."""
    return value if isinstance(value, str) else json.dumps(value)


def changes(values, sweep: Configuration, where: str) -> dict:
    """Values by path, checked; a group is a factor or a derived value."""
    if not isinstance(values, dict):
        raise InputError(f"{where} is {written(values)}; it must be values by path.")
    changed = {}
    for path, value in values.items():
        _check_known(path, [*sweep.entries, *RUN_KEYS], where)
        key, entry = f"{where}.{path}", RUNS.get(path) or sweep.entries[path]
        if isinstance(value, dict) and "derive" in value and path in sweep.entries:
            changed[path] = Derive(key, value)
        else:
            spec = value if isinstance(value, dict) else [value]
            changed[path] = _values(spec, entry, sweep, key)[0]
    return changed


def _check_known(path, paths, where: str) -> None:
    if path not in paths:
        path = path if isinstance(path, str) else written(path)
        raise InputError(
            f"{where}: {path} is not a value that can vary{did_you_mean(path, paths, '')}."
        )


def changes_of_words(configuration: Configuration, words: list[str]) -> dict:
    """Values by path from words such as friction.granule=0.3; raises InputError."""
    texts = {}
    for word in words:
        path, equal, text = word.partition("=")
        if not equal or not text:
            raise InputError(f"{word!r} is no value; write PATH=VALUE, such as box_width=0.02.")
        if path in RUN_KEYS:
            raise InputError(f"{word!r} is an option; write --{path} {text}.")
        texts[path] = text
    return changes(texts, configuration, "values")


def is_written(value, text: str) -> bool:
    """Whether a value is what a text says; a real number also as tables print it, with five
    digits."""
    try:
        return math.isclose(value, float(text), rel_tol=5e-5 * isinstance(value, float))
    except (TypeError, ValueError):
        return text in (str(value), str(value).lower())  # files have true and none


def _values(spec, entry: Entry, sweep: Configuration, key: str) -> list:
    """The values of a list, of one value, of words for seeds, or of factors on the file's value."""
    path, labels = entry.path, getattr(sweep, TABLES.get(entry.path, ""), None)
    if labels is not None and spec == "all":
        return list(labels)
    listed = spec if isinstance(spec, list) else [spec]
    if isinstance(spec, dict) and set(spec) == {"times"} and path in sweep.entries:
        base, factors = sweep.at(path), spec["times"]
        if isinstance(base, str | bool | tuple) or base is None:
            raise InputError(f"{key} is {written(base)}, which has no multiples.")
        factors = factors if isinstance(factors, list) else [factors]
        listed = [parsed(Number, factor, key) * base for factor in factors]
    elif path == "seed" and isinstance(spec, str):
        listed = seeds_of(spec, key)
    elif not listed or isinstance(spec, dict):
        factors = ", or factors: {times: [0.5, 2]}" if path in sweep.entries else ""
        raise InputError(f"{key} is {written(spec)}; it must be a list of values{factors}.")
    kind = entry.field.rebuild_annotation()
    values = [parsed(kind, value, key) for value in listed]
    for label in values if labels is not None else ():
        check_known(f"{key} is", label, labels, TABLES[path])
    _check_once(values, key)
    return sorted(values) if path == "seed" else values


def seeds_of(words: str, key: str) -> list[int]:
    """The seeds that words such as "1 to 100, 205" name; raises InputError."""
    seeds = []
    for part in words.split(","):
        ends = re.fullmatch(r"\s*(\d{1,20})(?:\s+to\s+(\d{1,20}))?\s*", part)
        first, last = (int(ends[1]), int(ends[2] or ends[1])) if ends else (1, 0)
        if not first <= last < SEEDS or len(seeds) + last - first >= MOST_RUNS:
            raise InputError(
                f"{key} is {written(words)}; it must be a list of whole numbers, or words such as 1 "
                f"to 100, 205: each part from less to more, below {SEEDS}, at most {MOST_RUNS:,} in "
                "all."
            )
        seeds += range(first, last + 1)
    return seeds


def _check_once(values: list, key: str) -> None:
    words = [f"{v:.10g}" if isinstance(v, float) else v for v in values]  # as tables print them
    if len(set(words)) < len(words):
        twice = next(v for v, word in zip(values, words, strict=True) if words.count(word) > 1)
        raise InputError(f"{key} has {written(twice)} twice; list each once.")
