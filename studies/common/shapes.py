"""The paper's shapes in words and in looks, for files that hold their labels alone."""

from dem.figures import style

WORDS = {
    "c1": "disc",
    "d1": "dumbbell",
    "c2": "small disc",
    "e1": "ellipse 1.125:1",
    "e2": "ellipse 1.25:1",
    "e3": "ellipse 1.375:1",
}


def name(label: str, separator: str = " ") -> str:
    """Label of a shape, and what it is."""
    return separator.join((label, WORDS[label])) if label in WORDS else label


def look(label: str) -> dict[str, str]:
    """Colour and marker of a shape, the same in each figure."""
    return style.numbered([*WORDS, label].index(label))
