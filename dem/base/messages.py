"""Sentences for the user: printed on standard error, safe for a terminal, with the likely name."""

import sys
import unicodedata
from collections.abc import Iterable
from difflib import get_close_matches

LISTED = 20  # names that a hint lists
# Controls (C0, C1, escape), formats (bidirectional overrides), halves of characters, line ends.
CONTROLS = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})


def printable(text: str) -> str:
    """The text without characters that a terminal obeys instead of showing; lines stay lines."""
    return "".join(c for c in text if c == "\n" or unicodedata.category(c) not in CONTROLS)


def say(sentence: str) -> None:
    """Print a sentence on standard error, on a line of its own even beside a progress bar."""
    clear = "\r\x1b[2K" if sys.stderr.isatty() else ""
    print(f"{clear}{printable(sentence)}", file=sys.stderr, flush=True)


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
    more = f" and {len(known) - LISTED} more" if len(known) > LISTED else ""
    return f"; there are {', '.join(known[:LISTED]) or 'none'}{more}"
