"""What a user probably meant: ends of sentences that refuse a name or a file.

Every hint is words such as "; the nearest is gravity", or "" where nothing can be guessed.
"""

import math
import re
from collections.abc import Iterable
from contextlib import suppress
from difflib import get_close_matches
from numbers import Integral
from pathlib import Path

NO_BITS = "words sentences"

LISTED = 20  # names that a hint lists
PRINTED = 6  # digits of a number as a dry run prints it


def meant(word: object, words: Iterable[object]) -> str:
    """The name that was probably meant, of a path also by its group or its last part."""
    names, text = list(map(str, words)), _plain(word)
    group, _, last = text.rpartition(".")
    inside = {
        _plain(name).rpartition(".")[2]: name
        for name in names
        if "." in str(word) and _plain(name).startswith(f"{group}.")
    }
    if inside:
        close = get_close_matches(last, inside, 1, 0.6)
        return f"; the nearest is {inside[close[0]]}" if close else _listed(inside.values())
    known = {}
    for part in (2, 0):  # the last part, the group
        known |= {_plain(name).rpartition(".")[part]: name for name in reversed(names)}
    known |= {_plain(name): name for name in names}
    close = get_close_matches(text, known, 1, 0.6)
    return f"; the nearest is {known[close[0]]}" if close else ""


def _plain(name: object) -> str:
    return str(name).lower().replace("_", ".")


def _listed(names: Iterable[str]) -> str:
    known = list(names)
    more = f" and {len(known) - LISTED} more" if len(known) > LISTED else ""
    return f"; there are {', '.join(known[:LISTED])}{more}" if known else ""


def choice(word: object, words: Iterable[object]) -> str:
    """The name that was probably meant, or those that there are."""
    known = list(map(str, words))
    return meant(word, known) or _listed(known)


def of_missing_file(path: Path) -> str:
    """The file of that folder whose name is nearest to one that is not there."""
    folder, there = Path(path).parent, {}  # by name without suffix
    if not folder.is_dir():
        return f"; there is no folder {folder}"
    with suppress(OSError):
        there = {each.stem: each for each in folder.iterdir() if each.is_file()}
    close = get_close_matches(Path(path).stem, there, 1, 0.6)
    return f"; the nearest is {there[close[0]]}" if close else ""


def is_number(text: str) -> bool:
    """Whether a text is one number."""
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def is_written(value: float, text: str) -> bool:
    """Whether a number is what a text says, with the digits of the text and at least PRINTED."""
    if not is_number(text) or isinstance(value, Integral):
        return is_number(text) and float(text) == value
    digits = len(re.sub(r"[eE].*|\D", "", text).lstrip("0"))
    return float(text) in (value, float(f"{value:.{max(digits, PRINTED)}g}"))
