"""Sentences for the user: printed on standard error, with the likely name."""

import sys
from collections.abc import Iterable
from difflib import get_close_matches

from dem.base.errors import InputError


def say(sentence: str) -> None:
    """Print a sentence on standard error, on a line of its own even beside a progress bar."""
    clear = "\r\x1b[2K" if sys.stderr.isatty() else ""
    print(f"{clear}{printable(sentence)}", file=sys.stderr, flush=True)


def printable(text: str) -> str:
    """Lines of text whose control characters a terminal shows as escapes, and does not obey."""
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text)


def did_you_mean(word: object, names: Iterable[object], otherwise: str | None = None) -> str:
    """End of a sentence that refuses a name: the nearest of the right names.

    Where none is near, it is `otherwise`, or the list of all names.
    """
    known = list(map(str, names))
    by_letters = {name.lower(): name for name in known}
    if near := get_close_matches(str(word).lower(), by_letters, 1, 0.6):
        return f"; the nearest is {by_letters[near[0]]}"
    if otherwise is not None:
        return otherwise
    return f"; there are {', '.join(known) or 'none'}"


def check_known(words: str, name: object, known: Iterable[object], table: str) -> None:
    """Raise InputError where a name is none of those known, which a table has.

    words: the key and its verb, such as "shape is".
    """
    if name not in known:
        raise InputError(
            f"{words} {name!r}, which is not one of {table}{did_you_mean(name, known)}."
        )
