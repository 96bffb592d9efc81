"""Types of values with their units, and the sentence that refuses others.

Arguments of the library and values of configurations are of these types, by pydantic. A public
class or function names them in its annotations and is `checked`; sections of a configuration are
models.
"""

import functools
import inspect
import math
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from typing import Annotated, Any, NoReturn, TypeVar, get_args, get_type_hints

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    PlainValidator,
    TypeAdapter,
    ValidationError,
    WrapValidator,
)
from pydantic.fields import FieldInfo

from dem.base.errors import InputError
from dem.base.messages import did_you_mean

# Sizes of numbers: products and quotients of several of them stay finite.
LEAST, MOST = 1e-20, 1e20
LISTED = 20  # sentences of one error; the rest are counted

Target = TypeVar("Target", bound=Callable[..., Any])


@dataclass(frozen=True)
class Unit:
    """Unit of a number, as in files of results; "1" of a pure number."""

    symbol: str


def real(value: Any, words: str = "a number") -> float:
    """A number, also in a text, because a command line has 3.9e3 as text."""
    if type(value) is np.ndarray and value.ndim == 0:
        value = value[()]
    is_number = isinstance(value, str | int | float | np.integer | np.floating)
    if not is_number or isinstance(value, bool | np.timedelta64):
        raise ValueError(f"it must be {words}")
    try:
        number = float(value)
    except ValueError:
        raise ValueError(f"it must be {words}") from None
    except OverflowError:
        number = math.inf
    if not abs(number) <= MOST:
        raise ValueError(f"it must be finite, at most {MOST:g} in size")
    return number + 0.0  # -0.0 is 0.0


def whole(value: Any) -> int:
    """A whole number, also in a text."""
    number = real(value, "a whole number")
    if not number.is_integer():
        raise ValueError("it must be a whole number")
    return int(number if isinstance(value, str) else value)


def must(words: str, holds: Callable[[Any], Any] = lambda value: True) -> WrapValidator:
    """One sentence for all that a type refuses: what a value must do. holds: asked of the rest."""

    def check(value: Any, take: Callable[[Any], Any]) -> Any:
        with suppress(ValueError):
            taken = take(value)
            if holds(taken):
                return taken
        raise ValueError(f"it must {words}")

    return WrapValidator(check)


def array(
    *shape: int | None, low: float = -np.inf, high: float = np.inf, gaps: bool = False
) -> PlainValidator:
    """Real numbers in a list or an array of a shape, None for any length but zero.

    They become a float64 array, a copy of what is given. low, high: the range of its
    numbers; without them NaN is taken too. gaps: rows of NaN are taken.
    """
    axes = str(tuple("n" if n is None else n for n in shape)).replace("'", "")
    ranged = max(low, -high) > -np.inf

    def take(value: Any) -> np.ndarray:
        rows = real_array(value)
        fits = all(n in (None, size) and size for n, size in zip(shape, rows.shape, strict=False))
        if rows.ndim != len(shape) or not fits:
            raise ValueError(f"it must have shape {axes}, not {rows.shape}")
        wrong = ~((rows >= low) & (rows <= high))
        if gaps:
            wrong[np.isnan(rows).reshape(len(rows), -1).all(axis=1)] = False
        if ranged and wrong.any():
            at = tuple(np.argwhere(wrong)[0].tolist())
            raise ValueError(
                f"all must be from {low:g} to {high:g}, and {rows[at]:g} is at {list(at)}"
            )
        return rows

    return PlainValidator(take)


def real_array(value: Any) -> np.ndarray:
    """Real numbers as a float64 array, a copy; raises ValueError."""
    try:
        rows = np.asarray(value)
    except Exception:  # of any object in a list, or of its own conversion to an array
        rows = np.empty(0, object)
    if isinstance(value, np.ma.MaskedArray) or rows.dtype.kind not in "iuf" or not rows.ndim:
        raise ValueError("it must hold real numbers in a list or an array")
    return np.array(rows, np.float64, order="C")


Number = Annotated[float, BeforeValidator(real)]
Positive = Annotated[Number, Field(ge=LEAST)]
NotNegative = Annotated[Number, Field(ge=0)]
Count = Annotated[int, BeforeValidator(whole), Unit("1")]

Ratio = Annotated[Positive, Unit("1")]
Coefficient = Annotated[NotNegative, Unit("1")]
Length = Annotated[Positive, Unit("m")]
Speed = Annotated[Positive, Unit("m s-1")]
Time = Annotated[Positive, Unit("s")]
Mass = Annotated[Positive, Unit("kg")]
Density = Annotated[Positive, Unit("kg m-3")]
Pressure = Annotated[Positive, Unit("Pa")]
Stiffness = Annotated[Positive, Unit("N m-1")]
Force = Annotated[Positive, Unit("N")]
PoissonRatio = Annotated[Number, Field(gt=-1, le=0.5), Unit("1")]
Restitution = Annotated[Number, Field(ge=1e-3, le=1), Unit("1")]
AspectRatio = Annotated[Number, Field(ge=1, le=1e6), Unit("1")]
SEEDS = 2**31  # beyond all seeds
Seed = Annotated[Count, Field(ge=0, lt=SEEDS)]
Label = Annotated[
    str,
    Field(pattern="^[A-Za-z][A-Za-z0-9_-]{0,31}$"),
    must("be a label: a letter from A to Z, then letters, digits, - and _, at most 32 in all"),
]

PAIR = must("be two finite numbers (x, y)")
Position = Annotated[tuple[Number, Number], PAIR, Unit("m")]
Velocity = Annotated[tuple[Number, Number], PAIR, Unit("m s-1")]
Acceleration = Annotated[tuple[Number, Number], PAIR, Unit("m s-2")]
SIZES = array(None, low=LEAST, high=MOST)  # (m), one per granule
OutlinePoints = Annotated[Count, Field(ge=2, le=1_000_000)]


class Section(BaseModel):
    """Part of a configuration: unknown keys are errors, values do not change."""

    model_config = {
        "extra": "forbid",
        "frozen": True,
        "json_schema_extra": lambda schema: schema.pop("required", None),  # for files that extend
        "use_attribute_docstrings": True,
        "validate_default": True,
    }


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


def checked(target: Target) -> Target:
    """Decorator of a class or a function: its arguments are of the types in its annotations.

    It gets the values that these types return, and raises InputError for others.
    """
    if not isinstance(target, type):
        return _checked(target, "")
    maker = "__new__" if issubclass(target, tuple) else "__init__"
    setattr(target, maker, _checked(getattr(target, maker), f"{target.__name__}."))
    if issubclass(target, tuple):  # a copy has what is kept in place of a text, which no user may
        setattr(target, "__reduce__", lambda self: (type(self)._make, (tuple(self),)))  # noqa: B010  # mypy
    return target


def _checked(function: Any, head: str) -> Any:
    signature, plain = inspect.signature(function), get_type_hints(function)
    parameters, types = signature.parameters, function.__annotations__
    names = [name for name, p in parameters.items() if p.kind is p.POSITIONAL_OR_KEYWORD]

    @functools.cache  # because a bed asks often
    def validate(name: str) -> Callable[[Any], Any]:
        return adapter(types[name]).validator.validate_python

    def taken(name: str, value: Any) -> Any:
        if name not in types:
            return value
        try:
            return validate(name)(value)
        except ValidationError:
            return parsed(types[name], value, head + name, show=shown)

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        first, rest = map(taken, names, args), args[len(names) :]
        return function(*first, *rest, **{name: taken(name, kwargs[name]) for name in kwargs})

    call.__signature__ = signature.replace(  # type: ignore[attr-defined]  # for help()
        parameters=[
            p.replace(annotation=plain.get(p.name, p.annotation)) for p in parameters.values()
        ]
    )
    return call


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


def refuse(key: str, value: Any, words: str) -> NoReturn:
    """Raise InputError: what the value is, and what it must do."""
    raise InputError(f"{key} is {shown(value)}; it must {words}.")


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
