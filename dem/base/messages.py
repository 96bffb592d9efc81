"""Sentences for the user: printed on standard error, with the likely name."""

import sys
from collections.abc import Iterable
from difflib import get_close_matches


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
