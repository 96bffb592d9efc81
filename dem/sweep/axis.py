"""What varies in a file: from a key and its values to a dimension and the changes of its points.

A path of the configuration, `shape`, `case`, `density` or `seed` takes a list. `{times: [...]}`
gives factors on the file's own value. Any other name takes named points, each a group of values
that change together, or a design over ranges.
"""

from typing import Annotated, Any, Literal, NamedTuple, NoReturn

from pydantic import BeforeValidator, TypeAdapter

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.base.schema import (
    Factor,
    Label,
    NotNegative,
    Section,
    seeds_of,
    units_of,
    validated,
    value,
    written,
)
from dem.experiment.config import Configuration, Entry, entries
from dem.experiment.observables import OBSERVABLES, variables_of
from dem.experiment.sections import OwnSection
from dem.io.dataset import AXES, LABELS, OF_RUN, OF_STORE, OF_SWEEP
from dem.sweep import design
from dem.sweep.precision import Until

OWN = tuple(OwnSection.model_fields)  # of a run, beside the values of its configuration
RUNS = {name: Entry(name, units_of(f), "", f) for name, f in OwnSection.model_fields.items()}
RUNS["case"] = RUNS["shape"]._replace(path="case")  # a row of the table
POINT = "point of the design"  # long name of an axis that is a design


class Derive(Section):
    """A value that follows from another block's result: the fraction as far from jamming as that of
    another shape, or the one at its load."""

    derive: Literal["equal_distance", "equal_load"]
    shape: str | None = None  # that is compared with; the run's own if absent
    friction: NotNegative = value("1", "friction of beds that were grown", 0.0)


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


class Place(NamedTuple):
    """A place in a file: its sweep, the values that may vary by path, and the key."""

    sweep: Any  # dem.sweep.config.Sweep, or a Configuration
    paths: dict[str, Entry]
    where: str

    def at(self, key) -> "Place":
        """One group deeper."""
        return self._replace(where=f"{self.where}.{key}")

    def refuse(self, words: str) -> NoReturn:
        """Raise InputError with the key."""
        raise InputError(f"{self.where} {words}.")


def place_in(sweep: Configuration, where: str) -> Place:
    """The top of what a file says of a sweep."""
    return Place(sweep, entries(sweep.shapes, sweep.read), where)


def axis_of(key: str, spec, place: Place, replicates: int | None = None) -> Axis:
    """The dimension of a key; raises InputError with the key and the value at fault. replicates: of seeds
    without an end, of the first round if absent."""
    here, entry = place.at(key), RUNS.get(key) or place.paths.get(key)
    if key == "seed" and isinstance(spec, dict):
        until = validated(Until, spec, at=here.where)
        found = list(range(until.first, until.first + (replicates or until.least)))
        return Axis(key, entry, found, [{"seed": each} for each in found], until)
    if entry:
        found = _values(spec, entry, here)
        if key == "case":
            points = [dict(place.sweep.cases[each]) for each in found]
        else:
            points = [{key: each} for each in found]
        if None in found:  # texts, because a coordinate has no gaps
            entry, found = entry._replace(units=None), list(map(written, found))
        return Axis(key if key in RUNS else name_of(key), entry, found, points)
    points = spec.values() if isinstance(spec, dict) and "design" not in spec else ()
    if not isinstance(spec, dict) or not spec or not all(isinstance(p, dict) for p in points):
        _known(key, [*place.paths, *RUNS], place)
    validated(Label, key, at=f"a name in {place.where}")
    if "design" in spec:
        return _design(key, spec, here)
    names = list(map(str, spec))
    _once(names, here)
    points = [changes(point, here.at(name)) for name, point in spec.items()]
    return Axis(name_of(key), Entry(key, None, "values that go together"), names, points)


def _design(key: str, spec: dict, here: Place) -> Axis:
    """Points that fill a space of values, each with a seed if the design has a first one."""
    wanted = validated(design.Design, spec, at=here.where)
    for path in wanted.over:
        _known(path, here.paths, here.at("over"))
    points = design.points(wanted)
    if wanted.first_seed is not None:
        points = [point | {"seed": wanted.first_seed + k} for k, point in enumerate(points)]
    return Axis(name_of(key), Entry(key, "1", POINT), list(range(len(points))), points)


def name_of(path: str) -> str:
    """The name of a value in files of results, with a suffix if what runs record has that name."""
    name = path.replace(".", "_")
    taken = {"run", "bound", "snapshot", "granule", "shear_strain", *OBSERVABLES}
    for table in (AXES, LABELS, OF_RUN, OF_STORE, OF_SWEEP, *map(variables_of, OBSERVABLES)):
        taken |= set(table)
    return f"{name}_swept" if name in taken else name


def changes(values, place: Place) -> dict:
    """Values by path, checked; a group is a factor or a derived value."""
    if not isinstance(values, dict):
        place.refuse(f"is {written(values)}; it must be values by path")
    found = {}
    for path, each in values.items():
        here = place.at(path)
        if path in OWN:  # of the run: as an axis of this one value
            found[path] = axis_of(path, [each], place).coordinate[0]
            continue
        _known(path, [*place.paths, *OWN], place)
        if isinstance(each, dict) and set(each) != {"times"}:
            found[path] = _derived(path, each, here)
        else:
            several = isinstance(each, list)
            found[path] = _values([each] if several else each, place.paths[path], here)[0]
    return found


def _known(path, paths, place: Place) -> None:
    if path not in paths:
        hint = did_you_mean(path, paths, "")
        raise InputError(f"{place.where}: {path} is no value that can vary{hint}.")


def _derived(path: str, asked: dict, here: Place) -> Derive:
    """How a value follows from another result."""
    if path != "packing.fraction":
        here.refuse("cannot be derived, only packing.fraction")
    found = validated(Derive, asked, at=here.where)
    if found.derive == "equal_load" and found.friction:
        here.refuse(
            "has a friction; equal_load holds for beds without friction, leave friction out"
        )
    if found.shape not in (None, *here.sweep.shapes):
        here.refuse(f"has the shape {found.shape!r}{did_you_mean(found.shape, here.sweep.shapes)}")
    return found


def changes_of_words(configuration: Configuration, words: list[str]) -> dict:
    """Values by path from words such as friction.granule=0.3; raises InputError."""
    found = {}
    for word in words:
        path, equal, text = word.partition("=")
        if not equal or not text:
            raise InputError(f"{word!r} is no value; write PATH=VALUE, such as box_width=0.02.")
        if path in OWN:
            raise InputError(f"{word!r} is said by an option; write --{path} {text}.")
        found[path] = text
    return changes(found, place_in(configuration, "values"))


def _values(spec, entry: Entry, here: Place) -> list:
    """The values of a list, of one value, of words for seeds, or of factors on the file's value."""
    tables = {"case": "cases", "shape": "shapes"}
    known = getattr(here.sweep, tables[entry.path]) if entry.path in tables else None
    if known is not None and spec == "all":
        return list(known)
    if isinstance(spec, dict) and set(spec) == {"times"} and entry.path in here.paths:
        base, factors = here.sweep.at(entry.path), TypeAdapter(Factor)
        if isinstance(base, str | bool) or base is None:
            here.refuse(f"is {written(base)}, which has no multiples")
        given = spec["times"] if isinstance(spec["times"], list) else [spec["times"]]
        given = [validated(factors, each, at=here.where) * base for each in given]
    elif entry.path == "seed" and isinstance(spec, str):
        given = validated(Annotated[Any, BeforeValidator(seeds_of)], spec, at=here.where)
    else:
        given = spec if isinstance(spec, list) else [spec]
    if not given or (isinstance(spec, dict) and given == [spec]):
        factors = ", or factors: {times: [0.5, 2]}" if entry.path in here.paths else ""
        here.refuse(f"is {written(spec)}; it must be a list of values{factors}")
    field = entry.field
    one = TypeAdapter(Annotated[(field.annotation, field)])
    found = [validated(one, each, at=here.where, field=field) for each in given]
    for each in found if known is not None else ():
        if each not in known:
            here.refuse(
                f"is {each!r}, which is not one of {tables[entry.path]}{did_you_mean(each, known)}"
            )
    _once(found, here)
    return sorted(found) if entry.path == "seed" else found


def _once(values: list, here: Place) -> None:
    if len(set(values)) < len(values):
        twice = next(each for each in values if values.count(each) > 1)
        here.refuse(f"has {written(twice)} twice; list each once")
