"""Text of files on a terminal: shown, never obeyed."""

import unicodedata

from rich.console import Console
from rich.segment import Segment

# Controls (C0, C1, escape), formats (bidirectional overrides), halves of characters, line ends.
UNSEEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})


def plain(text: str) -> str:
    """The text without characters that a terminal obeys instead of showing; lines stay lines."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(c for c in text if c == "\n" or unicodedata.category(c) not in UNSEEN)


class PlainConsole(Console):
    """A console that takes no text for markup and shows no control characters of it.

    Colours stay: rich keeps them apart from the text.
    """

    def __init__(self, **options):
        super().__init__(markup=False, emoji=False, **options)

    def render(self, renderable, options=None):
        """Segments of what is shown, their text made plain."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else plain(text), style, control)
