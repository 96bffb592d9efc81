"""Types of values that a configuration may hold, and the sentences that refuse others."""

import re
from typing import Annotated

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
)


def _number(value):
    """A number, also one like 3.9e3 that YAML 1.1 takes for text; not a truth value."""
    if isinstance(value, str):
        try:
            return float(value)
        except ValueError:
            pass
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("it must be a number")
    return value


def _label(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,31}", value):
        raise ValueError("a label is a letter followed by letters, digits, - and _")
    return value


def _folder(value: str) -> str:
    if not re.fullmatch(r"results(/[A-Za-z0-9][A-Za-z0-9._-]*)*", value):
        raise ValueError("it must be results or a folder below it, such as results/mine")
    return value


# the bounds keep squares and products of values finite
Number = Annotated[float, BeforeValidator(_number), Field(allow_inf_nan=False, ge=-1e15, le=1e15)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Whole = Annotated[int, Field(strict=True)]
Label = Annotated[str, AfterValidator(_label)]
Folder = Annotated[str, AfterValidator(_folder)]
Seed = Annotated[Whole, Field(ge=0, lt=2**31)]


class Section(BaseModel):
    """Part of a configuration: unknown keys are errors, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, validate_default=True)


def sentences(source: str, error: ValidationError) -> str:
    """One sentence a fault of what a file holds."""
    return "\n".join(dict.fromkeys(_sentence(source, e) for e in error.errors()))


_WORDS = {
    "input should be": "it must be",
    "a valid tuple": "a list",
    "a valid list": "a list",
    "a valid integer": "a whole number",
    "a valid string": "text",
    "a valid dictionary": "a group of keys",
    "tuple should have at least 1 item after validation, not 0": "it must not be empty",
}


def _sentence(source, error) -> str:
    parts = [str(part) for part in error["loc"]]
    key = ".".join(part for part in parts if not part.startswith(("function-", "[key]")))
    message = error["msg"].removeprefix("Value error, ").rstrip(".")
    if error["type"] == "missing":
        return f"{source}: {key} is missing."
    if error["type"] == "extra_forbidden":
        return f"{source}: {key} is not a known key."
    if error["type"] == "value_error" and isinstance(error["input"], dict | BaseModel):
        return f"{source}: {key + ': ' if key else ''}{message}."
    shown = repr(error["input"])
    shown = shown if len(shown) <= 60 else shown[:57] + "..."
    message = message[0].lower() + message[1:].split(" or instance of")[0]
    for theirs, ours in _WORDS.items():
        message = message.replace(theirs, ours)
    return f"{source}: {key} is {shown}; {message}."
