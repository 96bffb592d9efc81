"""The sentence that refuses a value: not in its range, of another type, missing, an unknown key.

No number depends on this file, so an edit of a sentence makes no run again.
"""

import functools
import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from dem.base.errors import InputError
from dem.base.messages import did_you_mean

LEAST = (
    1e-20  # of what must be positive, so that products and quotients of several numbers stay finite
)
LISTED = 20  # sentences of one error; the rest are counted


@dataclass(frozen=True)
class Unit:
    """Unit of a number, as in files of results; "1" of a pure number."""

    symbol: str


def section_of(annotation: Any) -> Any:
    """The section that an annotation is, or has in it; None where there is none."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(section_of, get_args(annotation))), None)


def unit_of(annotation: Any) -> str | None:
    """Unit of a type, "1" of a pure number; None of what is no number."""
    if isinstance(annotation, Unit):
        return annotation.symbol
    return next(filter(None, map(unit_of, reversed(get_args(annotation)))), None)


def shown(value: Any) -> str:
    """A value in a sentence: short, and in one line."""
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return f"an array of {value.dtype} with shape {value.shape}"
    try:
        words = " ".join(repr(value).split())
    except Exception:  # a whole number of too many digits, for one
        return f"a value of type {type(value).__name__}"
    return words if len(words) <= 60 else words[:57] + "..."


def written(value: Any) -> str:
    """A value in a sentence, as a file has it."""
    if value is None or isinstance(value, bool | date):
        return str(value).lower().replace("none", "null")
    return shown(value)


adapter = functools.lru_cache(1000)(TypeAdapter)  # which takes longer to make than to use


def parsed(
    annotation: Any,
    value: Any,
    key: str = "",
    source: str = "",
    show: Callable[[Any], str] = written,
) -> Any:
    """The value as a type or a section takes it; raises InputError with one sentence per fault.

    source: the file that the value is from, which goes before each sentence; show: the value in a
    sentence, as a file has it if absent.
    """
    try:
        return adapter(annotation).validate_python(value)
    except ValidationError as error:
        faults = [
            fault  # but for a list or group that is too short only because what it holds is wrong
            for fault in error.errors()
            if fault["type"] != "too_short" or len(fault["input"]) < fault["ctx"]["min_length"]
        ]
    field = FieldInfo.from_annotation(annotation)
    sentences = [f"{_sentence(fault, key, field, show)}." for fault in faults]
    if more := len(sentences[LISTED:]):
        sentences[LISTED:] = [f"and {more} more."]
    raise InputError("\n".join(f"{source}: {words}" if source else words for words in sentences))


BOUNDS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
WORDS = {
    "model_type": "be a group of keys",
    "dict_type": "be a group of keys",
    "tuple_type": "be a list",
    "list_type": "be a list",
    "string_type": "be text",
    "bool_type": "be true or false",
    "bool_parsing": "be true or false",
}


def _sentence(fault: Any, key: str, field: FieldInfo, show: Callable[[Any], str]) -> str:
    """What is wrong, and what to write instead, from an error of pydantic."""
    kind, value, context = fault["type"], fault["input"], fault.get("ctx", {})
    names = [name for name in map(str, fault["loc"]) if not name.startswith(("function-", "[key]"))]
    if fault["loc"][-1:] == ("[key]",) or kind == "invalid_key":
        names[-1] = value if isinstance(value, str) else written(value)
    section: Any = None
    for name in names:
        section = section_of(field.annotation)
        field = getattr(section, "model_fields", {}).get(name, field)
    key = ".".join(filter(None, (key, *(n if n.isprintable() else repr(n) for n in names))))
    unit, error = unit_of(field.rebuild_annotation()), context.get("error")
    if kind == "missing":
        about = f"; it is the {field.description}" if field.description else ""
        return f"{key} is missing{about}{f', in {unit}' if about and unit else ''}"
    if kind in ("extra_forbidden", "invalid_key"):
        return f"{key} is not a known key{did_you_mean(names[-1], section.model_fields)}"
    if isinstance(error, InputError):
        return str(error).removesuffix(".")
    if error and isinstance(value, dict | BaseModel) and section_of(field.annotation):
        return f"{key}: {error}".removeprefix(": ")
    if error:
        words = str(error)
    elif bound := next((name for name in BOUNDS if name in context), None):
        positive = "positive, " if context[bound] == LEAST else ""
        words = f"it must be {positive}{BOUNDS[bound]} {context[bound]:.10g}"
    else:
        usual = re.split(" after| or instance", fault["msg"].partition("should ")[2])[0]
        words = f"it must {WORDS.get(kind, usual)}"
        if kind == "model_type":
            words += f"; its keys are {', '.join(section_of(field.annotation).model_fields)}"
    return f"{key} is {show(value)}; {words}{f', in {unit}' if unit not in (None, '1') else ''}"
