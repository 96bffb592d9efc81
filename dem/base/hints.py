"""What a user probably meant: ends of sentences that refuse a name or a file.

Every hint is words such as "; the nearest is gravity", or "" where nothing can be guessed.
"""

import math
from collections.abc import Iterable
from contextlib import suppress
from difflib import get_close_matches
from numbers import Integral
from pathlib import Path

LISTED = 20  # names that a hint lists
PRINTED = range(5, 17)  # digits of a number, as tables and files print it


def meant(word: object, words: Iterable[object]) -> str:
    """The name that was probably meant."""
    names = {str(each).lower(): each for each in words}
    close = get_close_matches(str(word).lower(), names, 1, 0.6)
    return f"; the nearest is {names[close[0]]}" if close else ""


def choice(word: object, words: Iterable[object]) -> str:
    """The name that was probably meant, or those that there are."""
    known = list(map(str, words))
    more = f" and {len(known) - LISTED} more" if len(known) > LISTED else ""
    return meant(word, known) or f"; there are {', '.join(known[:LISTED]) or 'none'}{more}"


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
    """Whether a number is what a text says, exactly or as it is printed with some number of digits."""
    printed = () if isinstance(value, Integral) else (float(f"{value:.{n}g}") for n in PRINTED)
    return is_number(text) and float(text) in (value, *printed)
