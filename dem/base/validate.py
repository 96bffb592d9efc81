"""What a user may hand over: kinds of values, and the sentences that refuse all others.

A kind is a function of a name and a value. It returns the value as the code wants it (float, int,
tuple of floats, float64 array) or raises InputError with one sentence that names the argument. A
public class or function names the kinds of its arguments once, in their annotations, and is `checked`.
"""

import functools
import inspect
import math
import warnings
from collections.abc import Callable
from typing import Any, NoReturn, TypeVar

import numpy as np

from dem.base.errors import InputError

Kind = Callable[[str, Any], Any]
Target = TypeVar("Target", bound=Callable[..., Any])

# Sizes of numbers: products and quotients of several of them stay finite.
LEAST, MOST = 1e-20, 1e20


def checked(prefix: str = "", /, **kinds: Kind) -> Callable[[Target], Target]:
    """Decorator of a class or a function: its arguments are of the kinds in their annotations, such as
    `Annotated[float, positive("m")]`, or of these kinds, by their names.

    The class or function gets the values that the kinds return. prefix: goes before names in
    sentences.
    """

    def check(target: Any) -> Any:
        if isinstance(target, type):
            maker = "__new__" if issubclass(target, tuple) else "__init__"
            setattr(target, maker, check(getattr(target, maker)))
            return target
        signature = inspect.signature(target)
        noted = {
            name: kind
            for name, each in signature.parameters.items()
            for kind in getattr(each.annotation, "__metadata__", ())
        } | kinds

        @functools.wraps(target)
        def call(*given: Any, **named: Any) -> Any:
            bound = signature.bind(*given, **named)
            values = bound.arguments
            for name, kind in noted.items():
                if name in values:
                    values[name] = kind(prefix + name, values[name])
            return target(*bound.args, **bound.kwargs)

        return call

    return check


def shown(value: Any) -> str:
    """A value in a sentence: short, and in one line."""
    if isinstance(value, np.ma.MaskedArray):
        return "a masked array"
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return f"an array of {value.dtype} with shape {value.shape}"
    try:
        words = " ".join(repr(value).split())
    except Exception:  # a whole number of too many digits, for one
        return f"a value of type {type(value).__name__}"
    return words if len(words) <= 60 else words[:57] + "..."


def refuse(name: str, value: Any, words: str) -> NoReturn:
    """Raise InputError: what the value is, and what it must do."""
    raise InputError(f"{name} is {shown(value)}; it must {words}.")


def _scalar(value: Any, types: tuple[type, ...]) -> Any:
    """A number of one of these types, also in an array without axes; None for anything else."""
    if type(value) is np.ndarray and value.ndim == 0 and value.dtype.kind in "iuf":
        value = value[()]
    if isinstance(value, bool | np.bool_ | np.timedelta64) or not isinstance(value, types):
        return None
    return value


def number(words: str, low: float = -MOST, high: float = MOST) -> Kind:
    """Kind: a real number from low to high."""

    def take(name: str, value: Any) -> Any:
        found = _scalar(value, (int, float, np.integer, np.floating))
        if found is None or not low <= found <= high:
            refuse(name, value, words)
        return float(found)

    return take


def positive(unit: str) -> Kind:
    """Kind: a positive number, in such a unit."""
    return number(f"be a positive number ({unit}), {LEAST:g} to {MOST:g}", LEAST)


def not_negative(unit: str = "") -> Kind:
    """Kind: zero or a positive number."""
    unit = f" ({unit})" if unit else ""
    return number(f"be zero or a positive number{unit}, up to {MOST:g}", 0.0)


def up_to(high: float) -> Kind:
    """Kind: a number above 0 and up to `high`."""
    return number(f"lie above 0 and up to {high:g}", math.nextafter(0.0, 1.0), high)


def whole(low: int, high: int) -> Kind:
    """Kind: a whole number from low to high."""

    def take(name: str, value: Any) -> Any:
        found = _scalar(value, (int, np.integer))
        if found is None or not low <= found <= high:
            refuse(name, value, f"be a whole number, {low} to {high:,}")
        return int(found)

    return take


def flag(name: str, value: Any) -> bool:
    """Kind: True or False."""
    if not isinstance(value, bool | np.bool_):
        refuse(name, value, "be True or False")
    return bool(value)


def one_of(*classes: type) -> Kind:
    """Kind: an instance of one of these classes."""

    def take(name: str, value: Any) -> Any:
        if not isinstance(value, classes):
            names = " or ".join(f"dem.{each.__name__}" for each in classes)
            refuse(name, value, f"be a {names}")
        return value

    return take


def named(choices: dict[str, Any], *classes: type) -> Kind:
    """Kind: one of these texts or the object it names, or an instance of these classes."""

    def take(name: str, value: Any) -> Any:
        known = value in choices if isinstance(value, str) else isinstance(value, classes)
        if not known and not any(value is each for each in choices.values()):
            texts = [*map(repr, choices), *(f"a dem.{each.__name__}" for each in classes)]
            refuse(name, value, "be " + " or ".join(texts))
        return value

    return take


def or_none(kind: Kind) -> Kind:
    """Kind: None, or what another kind takes."""
    return lambda name, value: None if value is None else kind(name, value)


def reals(*shape: int | None) -> Kind:
    """Kind: real numbers in an array of a shape, NaN among them; None: any length but zero.

    It returns a float64 array, the one that was given if that is one.
    """
    wanted = str(tuple("n" if n is None else n for n in shape)).replace("'", "")
    wanted += ", n at least 1" if None in shape else ""

    def take(name: str, value: Any) -> np.ndarray:
        found = _reals(value)
        if found is None:
            refuse(name, value, "hold real numbers in a list or an array")
        if found.ndim != len(shape) or any(
            have != want and (want or not have)
            for have, want in zip(found.shape, shape, strict=True)
        ):
            raise InputError(f"{name} has shape {found.shape}; it must have shape {wanted}.")
        return found

    return take


def array(
    words: str, *shape: int | None, low: float = -MOST, high: float = MOST, each: str = "granule"
) -> Kind:
    """Kind: real numbers from low to high in an array of a shape, as reals takes them.

    each: what one row describes.
    """
    take_reals = reals(*shape)

    def take(name: str, value: Any) -> np.ndarray:
        found: np.ndarray = take_reals(name, value)
        wrong = np.argwhere(~((found >= low) & (found <= high)))
        if len(wrong):
            at = tuple(wrong[0])
            raise InputError(f"{name} of {each} {at[0]} is {found[at]:g}; it must {words}.")
        return found

    return take


def vector(unit: str) -> Kind:
    """Kind: two finite numbers (x, y), in such a unit."""
    take_array = array("be finite", 2)

    def take(name: str, value: Any) -> Any:
        try:
            return tuple(take_array(name, value).tolist())
        except InputError:
            refuse(name, value, f"be two finite numbers ({unit}), up to {MOST:g} in size")

    return take


def _reals(value: Any) -> np.ndarray | None:
    """A float64 array of real numbers, not copied if it is one; None for anything else."""
    if not _holds_reals(value, 3):
        return None
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            found = np.asarray(value)
            if found.dtype.kind not in "iuf":
                return None
            return np.ascontiguousarray(found, np.float64) if found.ndim else None
        except Exception:  # any object in a list, or one with its own conversion to an array
            return None


def _holds_reals(value: Any, depth: int) -> bool:
    """Whether lists hold nothing that NumPy would take for a number, and is none: truth values,
    text, masked arrays."""
    if isinstance(value, list | tuple) and depth:
        return all(_holds_reals(each, depth - 1) for each in value)
    return not isinstance(value, bool | np.bool_ | str | bytes | np.ma.MaskedArray)


# Kinds for shapes are here because an edit of the shapes' files recompiles all kernels.
SIZES = array(
    f"be a positive number (m), {LEAST:g} to {MOST:g}", None, low=LEAST
)  # one per granule
RATIO = number("lie in 1 to 1e+06", 1.0, 1e6)  # of the axes
OUTLINE = whole(2, 1_000_000)  # points of an outline
