"""Types of values with their units; `refusals.py` words the sentence that refuses others.

Arguments of the library and values of configurations are of these types, by pydantic. A public
class or function names them in its annotations and is `checked`; sections of a configuration are
models.
"""

import functools
import inspect
import math
from collections.abc import Callable
from contextlib import suppress
from typing import Annotated, Any, NoReturn, TypeVar, get_type_hints

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    PlainValidator,
    ValidationError,
    WrapValidator,
)

from dem.base.errors import InputError
from dem.base.refusals import LEAST, Unit, adapter, parsed, shown

MOST = 1e20  # size of a number: products and quotients of several of them stay finite

Target = TypeVar("Target", bound=Callable[..., Any])


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
    """Validator with one sentence for all refusals: what a value must do. holds: an extra test."""

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


def refuse(key: str, value: Any, words: str) -> NoReturn:
    """Raise InputError: what the value is, and what it must do."""
    raise InputError(f"{key} is {shown(value)}; it must {words}.")
