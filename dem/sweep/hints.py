"""What a user probably meant by a key or a value of a configuration: ends of sentences.

The schema says what is wrong (dem.base.schema). Here the sentence gets its remedy, from the fields
of the schema and from a table of what users write by mistake.
"""

import math
import re
from collections.abc import Iterable
from contextlib import contextmanager
from difflib import get_close_matches
from types import SimpleNamespace
from typing import get_args, get_origin

import numpy as np
from pydantic import BaseModel, ValidationError

from dem.base.errors import InputError
from dem.base.remedy import of_value
from dem.base.schema import number, sentences
from dem.experiment.config import entries, nearest, section_of

SHOWN = 4  # names that a hint lists of those that are near
LISTED = 20  # and of all
PRINTED = 6  # digits of a number as a dry run prints it
SYNONYMS = {"speed": "velocity", "count": "granules", "number": "granules", "radius": "diameter"}
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


def choice(word: object, words: Iterable[str]) -> str:
    """A hint at the names that were probably meant, or at those that there are."""
    known = list(map(str, words))
    more = ", ..." if len(known) > LISTED else ""
    listed = f"; there are {', '.join(known[:LISTED])}{more}" if known else ""
    return meant(word, known) or listed


def meant(word: object, words: Iterable[str]) -> str:
    """A hint at the names that were probably meant: "; the nearest is ...", or ""."""
    text, known = str(word), list(map(str, words))
    text = re.sub("[A-Za-z]+", lambda part: SYNONYMS.get(part[0].lower(), part[0]), text)

    def plain(name: str) -> str:
        return name.lower().replace("_", ".")

    one = plain(text).removesuffix("s")  # cases is case
    found = (
        [name for name in known if plain(name) in (plain(text), one)]
        or [name for name in known if name.startswith(f"{text}.")]
        or [name for name in known if len(text) > 1 and name.endswith(text)]
        or _in_its_group(text, known)
    )[:SHOWN]
    if len(found) > 1:
        return f"; the nearest are {', '.join(found)}"
    hint = f"; the nearest is {found[0]}" if found else nearest(text, known)
    if not hint and "." not in text:  # near the last part of a path
        last = {name.rpartition(".")[2]: name for name in reversed(known)}
        close = get_close_matches(text, last, 1, 0.7)
        hint = f"; the nearest is {last[close[0]]}" if close else ""
    twice = "radius" in str(word) and "radius" not in hint and hint.endswith("diameter")
    return f"{hint}, which is twice the radius" if twice else hint


def _in_its_group(text: str, known: list[str]) -> list[str]:
    """The names in the group of a path: the one whose last part is near, or all."""
    group, _, last = text.rpartition(".")
    inside = {name[len(group) + 1 :]: name for name in known if name.startswith(f"{group}.")}
    return [inside[each] for each in get_close_matches(last, inside, 1, 0.5)] or list(
        inside.values()
    )


def is_number(text: str) -> bool:
    """Whether a text is one number."""
    try:
        return np.isfinite(float(text))
    except ValueError:
        return False


def is_written(value: float, text: str) -> bool:
    """Whether a number is what a text says, with the digits of the text and at least PRINTED."""
    try:
        wanted = float(text)
    except ValueError:
        return False
    if isinstance(value, int | np.integer) or not np.isfinite(wanted):
        return wanted == value
    digits = len(re.sub(r"[eE].*|\D", "", text).lstrip("0"))
    return wanted == value or wanted == float(f"{value:.{max(digits, PRINTED)}g}")


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
        text = isinstance(value, str) and value.isprintable()
        return f"; write [{value}]" if text else f": {about}"
    if kind == "int_type":
        return _of_whole(value)
    if kind == "less_than" and fault["ctx"]["lt"] == 1 < (share := _number(value)) <= 100:
        return f"; write {share / 100:.10g} for {share:g} %"
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


def _number(value) -> float:
    """What a schema takes for a number as one, text too; NaN for anything else."""
    try:
        return float(number(value))
    except ValueError:
        return math.nan


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
