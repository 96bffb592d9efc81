"""Types of values that a configuration may hold, and the sentences that refuse others."""

import re
from typing import Annotated

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
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


MOST = 10_000_000  # seeds of a sweep
SEEDS = 2**31  # beyond all seeds


def _seeds(value):
    """A list as it is; words such as "1 to 100, 205" as the seeds that they name."""
    if not isinstance(value, str):
        return value
    found = []
    for words in value.split(","):
        ends = re.fullmatch(r"\s*(\d{1,10})(?:\s+to\s+(\d{1,10}))?\s*", words)
        if not ends:
            raise ValueError("it must be a list of whole numbers, or words such as 1 to 100, 205")
        first, last = int(ends[1]), int(ends[2] or ends[1])
        if not 0 <= last - first < MOST - len(found):
            raise ValueError(f"each part must run from less to more, all to at most {MOST:,} seeds")
        if last >= SEEDS:
            raise ValueError(f"each must be less than {SEEDS}")
        found += range(first, last + 1)
    return found


def seed_words(seeds) -> str:
    """Seeds as words that can stand in a configuration: 1 to 5, 7."""
    parts = []
    for seed in seeds:
        if parts and seed == parts[-1][1] + 1:
            parts[-1][1] = seed
        else:
            parts.append([seed, seed])
    return ", ".join(f"{a} to {b}" if b > a else str(a) for a, b in parts)


# the bounds keep squares and products of values finite
Number = Annotated[float, BeforeValidator(_number), Field(allow_inf_nan=False, ge=-1e15, le=1e15)]
Positive = Annotated[Number, Field(gt=0)]
NotNegative = Annotated[Number, Field(ge=0)]
Whole = Annotated[int, Field(strict=True)]
Label = Annotated[str, AfterValidator(_label)]
Folder = Annotated[str, AfterValidator(_folder)]
Seed = Annotated[Whole, Field(ge=0, lt=SEEDS)]
Seeds = Annotated[
    tuple[Seed, ...],
    Field(min_length=1),
    BeforeValidator(_seeds),
    PlainSerializer(seed_words, return_type=str),
]


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
