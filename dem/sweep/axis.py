"""What varies in a file: from a key and its values to a dimension and the changes of its points.

A path of the configuration, `shape`, `case`, `density` or `seed` takes a list. `{times: [...]}`
gives factors on the file's own value. Any other name takes named points, each a group of values
that change together, or a design over ranges.
"""

import re
from contextlib import suppress
from typing import Any, NamedTuple

from dem.base.errors import InputError
from dem.base.remedy import of_value
from dem.base.schema import SEEDS, label, number, seeds_of
from dem.experiment.config import Configuration, Entry, entries
from dem.experiment.observables import OBSERVABLES, variables_of
from dem.io.dataset import AXES, LABELS, OF_RUN, OF_STORE
from dem.sweep import derive, design
from dem.sweep.hints import choice, meant

OWN = ("shape", "density", "seed")  # of a run, beside the values of its configuration
POINT = "point of the design"  # long name of an axis that is a design


class Axis(NamedTuple):
    """A dimension: name, units and words, coordinate, and the changes of every point by path."""

    name: str
    entry: Entry
    coordinate: list
    points: list[dict]


class Place(NamedTuple):
    """A place in a file: its sweep, the values that may vary by path, and the key."""

    sweep: Any  # dem.sweep.config.Sweep, or a Configuration
    paths: dict[str, Entry]
    where: str

    def at(self, key) -> "Place":
        """One group deeper."""
        return self._replace(where=f"{self.where}.{key}")

    def refuse(self, words: str):
        """Raise InputError with the key."""
        raise InputError(f"{self.where} {words}.")


def place_in(sweep: Configuration, where: str) -> Place:
    """The top of what a file says of a sweep."""
    paths = entries(sweep.shapes)
    if sweep.cylinder is None:
        paths = {path: entry for path, entry in paths.items() if not path.startswith("cylinder.")}
    return Place(sweep, paths, where)


def axis_of(key: str, spec, place: Place) -> Axis:
    """The dimension of a key; raises InputError with the key and the value at fault."""
    here = place.at(key)
    if key in READERS:
        return READERS[key](spec, here)
    if key in place.paths:
        found = [_converted(value, place.paths[key], here) for value in _values(key, spec, here)]
        _once(found, here)
        return Axis(name_of(key), place.paths[key], found, [{key: each} for each in found])
    if isinstance(spec, dict) and spec and "design" in spec:
        return _design(key, spec, here)
    if isinstance(spec, dict) and spec and all(isinstance(point, dict) for point in spec.values()):
        points = [changes(point, here.at(name)) for name, point in spec.items()]
        names = list(map(str, spec))
        _once(names, here)
        about = Entry(key, None, "values that go together")
        return Axis(_own_name(key, here), about, names, points)
    shared = "; all runs of a file share it, use another file"
    hint = shared if _is_shared(key, place) else meant(key, [*place.paths, *READERS])
    raise InputError(f"{place.where}: {key} is no value that can vary{hint}.")


def _is_shared(key: str, place: Place) -> bool:
    """Whether there is a value of this key, but one that all runs of a file share."""
    at = place.sweep.values()
    for name in str(key).split("."):
        at = at.get(name) if isinstance(at, dict) else None
    return at is not None and not isinstance(at, dict)


def _cases(spec, here: Place) -> Axis:
    labels = _labels(spec, here.sweep.cases, here)
    cases = [here.sweep.cases[each] for each in labels]
    points = [{"shape": case.shape, "density": case.density} for case in cases]
    return Axis("case", Entry("case", None, ""), labels, points)


def _shapes(spec, here: Place) -> Axis:
    labels = _labels(spec, here.sweep.shapes, here)
    return Axis("shape", Entry("shape", None, ""), labels, [{"shape": each} for each in labels])


def _labels(spec, known: dict, here: Place) -> list[str]:
    """Rows of a table of the file."""
    labels = list(known) if spec == "all" else _listed(spec, here)
    _once(labels, here)
    for each in labels:
        if each not in known:
            table = f"{here.where.rpartition('.')[2]}s"
            here.refuse(f"names {each!r}, which is not one of {table}{choice(each, known)}")
    return labels


def _densities(spec, here: Place) -> Axis:
    found = [float(_number(value, here, "kg m-3")) for value in _listed(spec, here)]
    for each in found:
        if not each > 0.0:
            here.refuse(f"has {each:g}; it must be positive")
    _once(found, here)
    points = [{"density": each} for each in found]
    return Axis("density", Entry("density", "kg m-3", ""), found, points)


def _seeds(spec, here: Place) -> Axis:
    seeds = _listed(spec, here)
    try:
        seeds = list(seeds_of(spec)) if isinstance(spec, str) else seeds
    except ValueError as error:
        here.refuse(f"is {spec!r}; {error}{_seed_words(spec)}")
    for seed in seeds:
        if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < SEEDS:
            here.refuse(f"has {seed!r}; a seed is a whole number from 0 to {SEEDS - 1}")
    _once(seeds, here)
    seeds = sorted(seeds)
    return Axis("seed", Entry("seed", "1", ""), seeds, [{"seed": seed} for seed in seeds])


def _seed_words(spec: str) -> str:
    """What a range of seeds is as words: 1-5, 1..5 and 1:5 are 1 to 5."""
    words = re.sub(r"(?<=\d)\s*(?:-|\u2013|\.\.+|:)\s*(?=\d)", " to ", spec)
    try:
        return f"; write {words}" if seeds_of(words) else ""
    except ValueError:
        return ""


READERS = {"case": _cases, "shape": _shapes, "density": _densities, "seed": _seeds}


def _design(key: str, spec: dict, here: Place) -> Axis:
    """Points that fill a space of values, each with a seed if the design has a first one."""
    wanted = design.parse(spec, here.where)
    for path in wanted.over:
        if path not in here.paths:
            hint = meant(path, here.paths)
            raise InputError(f"{here.where}.over: {path} is no value that can vary{hint}.")
    points = design.points(wanted)
    if wanted.first_seed is not None:
        points = [point | {"seed": wanted.first_seed + k} for k, point in enumerate(points)]
    return Axis(_own_name(key, here), Entry(key, "1", POINT), list(range(len(points))), points)


def _own_name(key: str, here: Place) -> str:
    """The name of a dimension, with a suffix if a variable has that name."""
    check_label(key, here.where.rpartition(".")[0])
    return name_of(key)


def name_of(path: str) -> str:
    """The name of a value in files of results, with a suffix if what runs record has that name."""
    name = path.replace(".", "_")
    taken = {"run", "bound", "snapshot", "granule", "shear_strain", *OBSERVABLES}
    for table in (AXES, LABELS, OF_RUN, OF_STORE, *map(variables_of, OBSERVABLES)):
        taken |= set(table)
    return f"{name}_swept" if name in taken else name


def changes(values, place: Place) -> dict:
    """Values by path, checked; a group is a factor or a derived value."""
    if not isinstance(values, dict):
        place.refuse(f"is {values!r}; it must be values by path")
    found = {}
    for path, value in values.items():
        if path not in place.paths and path not in OWN:
            hint = meant(path, [*place.paths, *OWN])
            raise InputError(f"{place.where}: {path} is no value that can vary{hint}.")
        here = place.at(path)
        if isinstance(value, dict) and set(value) == {"times"} and path in place.paths:
            value = _values(path, {"times": [value["times"]]}, here)[0]
        if isinstance(value, dict) and path in place.paths:
            if "derive" not in value:
                here.refuse(f"is {value!r}; a group must have derive or times")
            derive.check(value, path, place.where, place.sweep.shapes)
        elif path in place.paths:
            value = _converted(value, place.paths[path], here)
        else:  # of the run: as an axis of this one value
            value = READERS[path]([value], here).coordinate[0]
        found[path] = value
    return found


def changes_of_words(configuration: Configuration, words: list[str]) -> dict:
    """Values by path from words such as friction.granule=0.3; raises InputError."""
    found, place = {}, place_in(configuration, "values")
    for word in words:
        path, equal, value = word.partition("=")
        if not equal or not value:
            raise InputError(f"{word!r} is no value; write PATH=VALUE, such as box_width=0.02.")
        if path in OWN:
            raise InputError(f"{word!r} is said by an option; write --{path} {value}.")
        if path not in place.paths:
            hint = (
                "set it in a configuration, and name that by --config" if _is_shared(path, place)
                else f"there is no such value{meant(path, place.paths)}"
            )  # fmt: skip
            raise InputError(f"{path} is {value!r}; {hint}.")
        with suppress(ValueError):
            value = int(value)
        found[path] = value
    return changes(found, place)


def is_derived(value) -> bool:
    """Whether a value follows from another result."""
    return isinstance(value, dict)


def _values(path: str, spec, here: Place) -> list:
    """A list of values, also where it is written as factors on the file's value."""
    if not (isinstance(spec, dict) and set(spec) == {"times"}):
        return _listed(spec, here)
    base = here.sweep.values()
    for name in path.split("."):
        base = base.get(name) if isinstance(base, dict) else None
    if isinstance(base, str | bool) or base is None:
        here.refuse(f"is {base!r}, which has no multiples")
    return [_number(factor, here) * base for factor in _listed(spec["times"], here)]


def _converted(value, entry: Entry, here: Place):
    """A value as the schema has it: YAML takes 15e-3 for text."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, list | dict):
        here.refuse(f"is {value!r}; it must be one value: name a point for each")
    return value if entry.units is None else _number(value, here, entry.units) + 0  # -0.0 is 0.0


def _number(value, here: Place, units: str = "1"):
    try:
        return number(value)
    except ValueError as error:
        hint = of_value(value, units)
        raise InputError(f"{here.where} has {value!r}; {error}{hint}.") from None


def check_label(name, where: str) -> None:
    """Raise InputError for a name that no dimension or folder can have."""
    try:
        label(name if isinstance(name, str) else "")
    except ValueError as error:
        raise InputError(f"{where} has the name {name!r}; {error}.") from None


def _listed(spec, here: Place) -> list:
    """A list that is not empty; one value is a list of one."""
    found = spec if isinstance(spec, list) else [spec]
    if not found or isinstance(spec, dict):
        path = here.where.rpartition(".")[2]
        factors = ", or factors: {times: [0.5, 2]}" if spec and path not in READERS else ""
        here.refuse(f"is {spec!r}; it must be a list of values{factors}")
    return found


def _once(values: list, here: Place) -> None:
    seen = set()
    for value in values:
        if not isinstance(value, int | float | str | None):
            here.refuse(f"has {value!r}; it must be numbers or texts")
        if value in seen:
            here.refuse(f"has {value!r} twice; list each once")
        seen.add(value)
