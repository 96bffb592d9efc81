"""What a user probably meant by a key or a value of a configuration: ends of sentences.

The schema says what is wrong (dem.base.schema). Here the sentence gets its remedy, from the fields
of the schema and from a table of what users write by mistake.
"""

import re
from collections.abc import Iterable
from contextlib import contextmanager
from types import SimpleNamespace
from typing import get_args, get_origin

from pydantic import BaseModel, ValidationError

from dem.base.errors import InputError
from dem.base.remedy import of_value
from dem.base.schema import sentences
from dem.experiment.config import entries, nearest, section_of

SHOWN = 4  # names that a hint lists
# keys that people look for, and what to write instead
ELSEWHERE = {
    "seeds": "; write `seed: 1 to 5` under `sweep:`",
    "seed": "; write `seed: 1 to 5` under `sweep:`",
    "density": "; write it in a case, or `density: [3900]` under `sweep:`",
    "radius": "; write diameter, which is twice the radius",
    "min": "; write low",
    "max": "; write high",
    "box_height": "; leave it out: the height follows from packing.fraction or packing.pressure",
}


def meant(word: object, words: Iterable[str]) -> str:
    """A hint at the names that were probably meant: "; the nearest is ...", or ""."""
    text, known = str(word), list(map(str, words))

    def plain(name: str) -> str:
        return name.lower().replace("_", ".")

    one = plain(text).removesuffix("s")  # cases is case
    found = (
        [name for name in known if plain(name) in (plain(text), one)]
        or [name for name in known if name.startswith(f"{text}.")]
        or [name for name in known if len(text) > 1 and name.endswith(text)]
    )[:SHOWN]
    if len(found) > 1:
        return f"; the nearest are {', '.join(found)}"
    return f"; the nearest is {found[0]}" if found else nearest(text, known)


@contextmanager
def remedies(source: str, model: type[BaseModel], *more: str):
    """Faults that a schema finds in a file get their remedies. more: other keys that there are."""
    try:
        yield
    except InputError as error:
        fault = error.__context__
        if not isinstance(fault, ValidationError):
            raise
        raise InputError(told(source, fault, model, more)) from None


def told(source: str, error: ValidationError, model: type[BaseModel], more=()) -> str:
    """One sentence per fault that a schema finds, with its remedy."""
    ends = {}
    for fault in error.errors():
        one = SimpleNamespace(errors=lambda fault=fault: [fault])
        ends[sentences(source, one)] = _remedy(fault, model, more)
    text = sentences(source, error)
    for sentence, end in ends.items():
        if end:
            text = text.replace(sentence, f"{sentence[:-1]}{end}.")
    lines = text.splitlines()  # one fault may take several, of which only the first has the name
    return "\n".join(each if each.startswith(source) else f"{source}: {each}" for each in lines)


def _remedy(fault, model: type[BaseModel], more) -> str:
    """What to do about one fault, as pydantic tells it."""
    kind, value, last = fault["type"], fault["input"], str(fault["loc"][-1:] and fault["loc"][-1])
    section, field = _at(model, fault["loc"])
    units = ((field and field.json_schema_extra) or {}).get("units")
    about = f"{field.description}{f' ({units})' if units else ''}" if field else ""
    if kind == "missing":
        return f"; it is the {about}" if field and field.description else ""
    if kind == "extra_forbidden":
        return _of_key(last, section, more)
    if kind == "literal_error":
        return meant(value, re.findall("'([^']+)'", fault["ctx"]["expected"]))
    if kind == "model_type" and fault["ctx"]["class_name"] == "Range":
        return "; write a range, {low: 0.1, high: 0.5}"
    if kind == "model_type" and section:
        return f"; its keys are {', '.join(section.model_fields)}"
    if isinstance(value, dict) and units:
        return "; a group with derive or times belongs under `sweep:`"
    if kind == "tuple_type":
        return f"; write [{value}]" if isinstance(value, str) else f": {about}"
    if kind == "int_type":
        return _of_whole(value)
    if kind == "less_than" and fault["ctx"]["lt"] == 1 < value <= 100:
        return f"; write {value / 100:.10g} for {value:g} %"
    path = ".".join(map(str, fault["loc"]))
    if isinstance(value, list) and units and kind in ("value_error", "int_type"):
        return f"; to vary it, write `{path}: {value}` under `sweep:`"
    return of_value(value, units)


def _of_key(key: str, section: type[BaseModel] | None, more) -> str:
    paths = entries(())
    if key in paths and "." in key:
        group, _, last = key.rpartition(".")
        return f"; write it in its group, `{group}: {{{last}: ...}}`"
    known = [*(section.model_fields if section else ()), *more]
    if hint := meant(key, known) if more or key not in ELSEWHERE else "":
        return hint
    return ELSEWHERE.get(key) or meant(key, paths)


def _of_whole(value) -> str:
    try:
        number = float(value)
        return f"; write {int(number)}" if number == int(number) else ""
    except (TypeError, ValueError, OverflowError):
        return ""


def _at(model: type[BaseModel] | None, place: tuple):
    """The section of the schema at a place or around it, and the field there, each or None."""
    field = None
    for name in place:
        if model is None:  # an item of a list
            break
        if isinstance(model, dict):  # a group with names of the user's own
            model, field = model["section"], None
        elif name in model.model_fields:
            field = model.model_fields[name]
            model = _inside(field.annotation) or model
        else:
            field = None
            break
    return (model if isinstance(model, type) else None), field


def _inside(annotation):
    """The section that an annotation is of; {"section": it or None} for a group by name."""
    if get_origin(annotation) is not dict:
        return section_of(annotation)
    of = get_args(annotation)[1]
    return {"section": section_of(of)}
