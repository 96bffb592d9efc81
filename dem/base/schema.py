"""Types of values that a configuration may hold, and the sentences that refuse others."""

import math
import re
from contextlib import suppress
from numbers import Integral
from typing import Annotated, Any, get_args

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.base.validate import shown

# the bounds keep products of values, and of their squares, finite and above zero
MOST_NUMBER, LEAST_POSITIVE = 1e15, 1e-15
MOST = 1_000_000  # seeds of a list, and runs of a block
SEEDS = 2**31  # beyond all seeds
NEEDED = object()
LIMITS = {
    "ge": "minimum",
    "gt": "exclusiveMinimum",
    "le": "maximum",
    "lt": "exclusiveMaximum",
}  # of values, and their words in a schema


def value(units: str | None, about: str, default: Any = ..., before=NEEDED, **limits) -> Any:
    """Description of a value: its units (None: text), what it is, and what it is if it is not given.

    before: of a key that is younger than the first runs, the value at which all is as it was. Runs with
    it are known by the same name as runs from before. It stays what it is when a default changes.
    """
    extra = {"units": units} | ({} if before is NEEDED else {"before": before})
    return Field(default, description=about, json_schema_extra=extra, **limits)


def number(value):
    """A number, also one like 3.9e3 that YAML 1.1 takes for text; not a truth value."""
    if isinstance(value, str):
        with suppress(ValueError):
            value = float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        decimal = str(value).replace(",", ".")
        raise ValueError(
            f"it must be a number{f', such as {decimal}' if as_number(decimal) is not None else ''}"
        )
    if not abs(value) < math.inf:
        raise ValueError("it must be a finite number")
    if not abs(value) <= MOST_NUMBER:  # before an integer of any size is made a float
        raise ValueError(f"its magnitude must be at most {MOST_NUMBER:g}")
    return value + 0  # -0.0 is 0.0


def as_number(text: str) -> float | None:
    """The finite number that a text says, if any."""
    with suppress(ValueError):
        if math.isfinite(said := float(text)):
            return said
    return None


def is_written(value: float, text: str) -> bool:
    """Whether a number is what a text says, exactly or as tables print it, with five digits."""
    said = as_number(text)
    if said is None or isinstance(value, Integral):
        return said == value
    return math.isclose(value, said, rel_tol=5e-5)


def whole(value):
    """A whole number, also in a text, as Snakemake's --config hands it over."""
    if isinstance(value, str):
        with suppress(ValueError):
            return int(value)
    return value


def written(value) -> str:
    """A value in a sentence, as a file has it."""
    return "null" if value is None else shown(value)


def _label(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,31}", value):
        raise ValueError(
            "it must be a label: a letter from A to Z, then letters, digits, - and _, at most 32 in all"
        )
    return value


def seeds_of(value):
    """A list as it is; words such as "1 to 100, 205" as the seeds that they name."""
    if not isinstance(value, str):
        return value if isinstance(value, list) else [value]
    found = []
    for words in value.split(","):
        ends = re.fullmatch(r"\s*0*(\d+)(?:\s+to\s+0*(\d+))?\s*", words)
        if not ends:
            raise ValueError("it must be a list of whole numbers, or words such as 1 to 100, 205")
        first, last = (int(end[: len(str(SEEDS)) + 1]) for end in (ends[1], ends[2] or ends[1]))
        if not first <= last < SEEDS or last - first >= MOST - len(found):
            raise ValueError(
                f"each part must run from less to more, below {SEEDS}, and all name at most {MOST:,} seeds"
            )
        found += range(first, last + 1)
    return found


def seed_words(seeds) -> str:
    """Seeds as words that a configuration may hold: 1 to 5, 7."""
    runs = np.split(seeds, 1 + np.flatnonzero(np.diff(seeds) != 1))
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)


Number = Annotated[float, BeforeValidator(number)]
Factor = Annotated[int | float, BeforeValidator(number)]  # a whole number stays one
Positive = Annotated[Number, Field(ge=LEAST_POSITIVE)]
NotNegative = Annotated[Number, Field(ge=0)]
Whole = Annotated[int, BeforeValidator(whole), Field(strict=True)]
Seed = Annotated[Whole, Field(ge=0, lt=SEEDS)]
Label = Annotated[str, AfterValidator(_label)]


class Section(BaseModel):
    """Part of a configuration: unknown keys are errors, values do not change."""

    model_config = {"extra": "forbid", "frozen": True, "validate_default": True}


def known_by(section: BaseModel, fields: dict[str, FieldInfo], head: str = "") -> dict[str, Any]:
    """Values by path that a run is known by: all but those that are as before there was the key."""
    found = {}
    for name, field in fields.items():
        own, extra = getattr(section, name), field.json_schema_extra or {}
        if isinstance(own, BaseModel):
            found |= known_by(own, type(own).model_fields, f"{head}{name}.")
        elif own != extra.get("before", NEEDED):
            found[head + name] = own
    return found


def section_of(annotation) -> type[BaseModel] | None:
    """The section that an annotation is, or has in it."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(section_of, get_args(annotation))), None)


MOST_SENTENCES = 20
# by pydantic's type of error: what a value must do
MUST = {
    "greater_than": "be greater than {gt:.10g}",
    "greater_than_equal": "be at least {ge:.10g}",
    "less_than": "be less than {lt:.10g}",
    "less_than_equal": "be at most {le:.10g}",
    "too_short": "have {min_length} or more",
    "too_long": "have {max_length} or fewer",
    "int_type": "be a whole number without a point",
    "string_type": "be text",
    "literal_error": "be {expected}",
    **dict.fromkeys(("tuple_type", "list_type"), "be a list"),
    **dict.fromkeys(("dict_type", "model_type"), "be a group of keys"),
}


def validated(kind: Any, data, source: str = "", at: str = "", field: FieldInfo | None = None):
    """Data as a section, or another type, takes them; raises InputError with one sentence a fault.

    source: goes before each sentence; at: the key of the data; field: describes them.
    """
    one = kind if hasattr(kind, "validate_python") else TypeAdapter(kind)
    try:
        return one.validate_python(data)
    except ValidationError as error:
        faults = error.errors()
    told = [_sentence(each, at, kind, field) for each in faults if not _follows(each)]
    told = [f"{source}: {each}" if source else each for each in dict.fromkeys(told)]
    if more := len(told[MOST_SENTENCES:]):
        told[MOST_SENTENCES:] = [f"{source}: and {more} more fault{'s' * (more > 1)}."]
    raise InputError("\n".join(told))


def _follows(fault) -> bool:
    """Whether a list or group is called too short only because what it holds is wrong."""
    return fault["type"] == "too_short" and len(fault["input"]) >= fault["ctx"]["min_length"]


def _sentence(fault, at: str, section, field: FieldInfo | None) -> str:
    """What is wrong, and what to write instead, from an error of pydantic."""
    kind, given, limits = fault["type"], fault["input"], fault.get("ctx", {})
    place = [each for each in map(str, fault["loc"]) if not each.startswith(("function-", "[key]"))]
    for name in place:
        section = section_of(field.annotation) or section if field else section
        field = getattr(section, "model_fields", {}).get(name, field)
    inner = section_of(field.annotation) if field else section
    key = ".".join(filter(None, (at, *(p if p.isprintable() else repr(p) for p in place))))
    if kind == "missing":
        return f"{key} is missing{_about(field)}."
    if kind == "extra_forbidden":
        return f"{key} is not a known key{did_you_mean(place[-1], section.model_fields)}."
    if kind == "value_error" and isinstance(given, dict | BaseModel) and inner:
        return f"{key + ': ' if key else ''}{limits['error']}."
    said = f"{key or 'the whole'} is {written(given)}"
    if kind == "value_error":
        units = units_of(field) if field else None
        return f"{said}; {limits['error']}{f', in {units}' if units not in (None, '1') else ''}."
    if kind in MUST:
        must = MUST[kind].format(**limits)
    else:
        must = fault["msg"].partition("should ")[2].partition(" or instance of")[0]
    hint = ""
    if kind == "too_short" and limits["min_length"] == 1:
        must = "not be empty"
    elif kind == "greater_than_equal" and limits["ge"] == LEAST_POSITIVE:
        must = f"be positive, at least {LEAST_POSITIVE:g}"
    elif kind == "model_type" and inner:
        hint = f"; its keys are {', '.join(inner.model_fields)}"
    return f"{said}; it must {must}{hint}."


def _about(field: FieldInfo | None) -> str:
    """What a value is."""
    if not field or not field.description:
        return ""
    units = units_of(field)
    return f"; it is the {field.description}{f' ({units})' if units else ''}"


def units_of(field: FieldInfo) -> str | None:
    """Units of a value, "1" for none; None of what is no number."""
    return (field.json_schema_extra or {}).get("units")
