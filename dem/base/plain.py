"""Text of files on a terminal: shown, never obeyed."""

import unicodedata

# Controls (C0, C1, escape), formats (bidirectional overrides), halves of characters, line ends.
UNSEEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})


def plain(text: str) -> str:
    """The text without characters that a terminal obeys instead of showing; lines stay lines."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(c for c in text if c == "\n" or unicodedata.category(c) not in UNSEEN)
