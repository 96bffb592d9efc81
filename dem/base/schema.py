"""Types of values that a configuration may hold, and the sentences that refuse others."""

import math
import re
from contextlib import suppress
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

NO_BITS = "checks values, which are part of what a run is known by"

# the bounds keep products of values, and of their squares, finite and above zero
MOST_NUMBER, LEAST_POSITIVE = 1e15, 1e-15


def number(value):
    """A number, also one like 3.9e3 that YAML 1.1 takes for text; not a truth value."""
    if isinstance(value, str):
        with suppress(ValueError):
            value = float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("it must be a number")
    if not abs(value) < math.inf:
        raise ValueError("it must be a finite number")
    if not abs(value) <= MOST_NUMBER:  # before an integer of any size is made a float
        raise ValueError(f"its magnitude must be at most {MOST_NUMBER:g}")
    return value


def label(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,31}", value):
        raise ValueError(
            "it must be a label: a letter from A to Z, then letters, digits, - and _, at most 32 in all"
        )
    return value


LONGEST_FOLDER = 200  # characters: systems take 255 for a name, some 260 for a whole path


def _folder(value: str) -> str:
    if not re.fullmatch(r"results(/[A-Za-z0-9][A-Za-z0-9._-]*)*", value):
        raise ValueError(
            "it must be results or a folder below it, such as results/mine, named by letters from A to Z, "
            "digits, ., _ and -"
        )
    if len(value) > LONGEST_FOLDER:
        raise ValueError(f"it must have at most {LONGEST_FOLDER} characters")
    return value


MOST = 1_000_000  # seeds of a list, and runs of a block
SEEDS = 2**31  # beyond all seeds


def seeds_of(value):
    """A list as it is; words such as "1 to 100, 205" as the seeds that they name."""
    if not isinstance(value, str):
        return value
    found = []
    for words in value.split(","):
        ends = re.fullmatch(r"\s*0*(\d+)(?:\s+to\s+0*(\d+))?\s*", words)
        if not ends:
            raise ValueError("it must be a list of whole numbers, or words such as 1 to 100, 205")
        first, last = (int(end[: len(str(SEEDS)) + 1]) for end in (ends[1], ends[2] or ends[1]))
        if max(first, last) >= SEEDS:
            raise ValueError(f"each must be less than {SEEDS}")
        if first > last:
            raise ValueError("each part must run from less to more")
        if last - first >= MOST - len(found):
            raise ValueError(f"it must name at most {MOST:,} seeds")
        found += range(first, last + 1)
    return found


def seed_words(seeds) -> str:
    """Seeds as words that a configuration may hold: 1 to 5, 7."""
    parts = []
    for seed in seeds:
        if parts and seed == parts[-1][1] + 1:
            parts[-1][1] = seed
        else:
            parts.append([seed, seed])
    return ", ".join(f"{a} to {b}" if b > a else str(a) for a, b in parts)


Number = Annotated[float, BeforeValidator(number)]
Positive = Annotated[Number, Field(ge=LEAST_POSITIVE)]
NotNegative = Annotated[Number, Field(ge=0)]
Whole = Annotated[int, Field(strict=True)]
Label = Annotated[str, AfterValidator(label)]
Folder = Annotated[str, AfterValidator(_folder)]
Seed = Annotated[Whole, Field(ge=0, lt=SEEDS)]
Seeds = Annotated[
    tuple[Seed, ...],
    Field(min_length=1),
    BeforeValidator(seeds_of),
    PlainSerializer(seed_words, return_type=str),
]


class Section(BaseModel):
    """Part of a configuration: unknown keys are errors, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, validate_default=True)


MOST_SENTENCES = 20


def sentences(source: str, error: ValidationError) -> str:
    """One sentence a fault of what a file holds, of very many the first and how many more there are."""
    faults = list(dict.fromkeys(_sentence(source, e) for e in error.errors() if not _follows(e)))
    if len(faults) > MOST_SENTENCES:
        more = len(faults) - MOST_SENTENCES
        faults[MOST_SENTENCES:] = [f"{source}: and {more} more fault{'s' * (more > 1)}."]
    return "\n".join(faults)


def _follows(error) -> bool:
    """Whether a list or group is called too short only because what it holds is wrong."""
    return error["type"] == "too_short" and len(error["input"]) >= error["ctx"]["min_length"]


_WORDS = {
    "input should be": "it must be",
    "a valid tuple": "a list",
    "a valid list": "a list",
    "a valid integer": "a whole number without a point",
    "a valid string": "text",
    "a valid dictionary": "a group of keys",
}
# by pydantic's type of error: words that hold for every type of value
_BOUNDS = {
    "greater_than": "it must be greater than {gt:.10g}",
    "greater_than_equal": "it must be at least {ge:.10g}",
    "less_than": "it must be less than {lt:.10g}",
    "less_than_equal": "it must be at most {le:.10g}",
    "too_short": "it must have at least {min_length} items",
    "too_long": "it must have at most {max_length} items",
    "dict_type": "it must be a group of keys",
    "model_type": "it must be a group of keys",
}
_PLAINER = {
    "it must be at least 0": "it must be zero or positive",
    f"it must be at least {LEAST_POSITIVE:g}": f"it must be positive, at least {LEAST_POSITIVE:g}",
    "it must have at least 1 items": "it must not be empty",
}


def _sentence(source, error) -> str:
    parts = [text if text.isprintable() else repr(text) for text in map(str, error["loc"])]
    key = ".".join(part for part in parts if not part.startswith(("function-", "[key]")))
    message = error["msg"].removeprefix("Value error, ").rstrip(".")
    if error["type"] == "missing":
        return f"{source}: {key} is missing."
    if error["type"] == "extra_forbidden":
        return f"{source}: {key} is not a known key."
    if error["type"] == "value_error" and isinstance(error["input"], dict | BaseModel):
        return f"{source}: {key + ': ' if key else ''}{message}."
    if error["type"] in _BOUNDS:
        message = _BOUNDS[error["type"]].format(**error.get("ctx", {}))
        message = _PLAINER.get(message, message)
    else:
        message = message[0].lower() + message[1:].split(" or instance of")[0]
        for theirs, ours in _WORDS.items():
            message = message.replace(theirs, ours)
    return f"{source}: {key or 'the whole'} is {_shown(error['input'])}; {message}."


def _shown(value) -> str:
    """A value as text that fits into a sentence."""
    try:
        text = repr(value)
    except ValueError:  # Python writes no integer of more than 4,300 digits
        return "a number of thousands of digits"
    return text if len(text) <= 60 else text[:57] + "..."
