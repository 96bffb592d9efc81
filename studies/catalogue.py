"""Which figures and which files of results the studies have."""

from dem.figures.catalogue import FIGURES, figures_of
from studies import HERE, NAMES


def figures() -> dict:
    """The figures of the library and of all studies, by name."""
    found = dict(FIGURES)
    for name in NAMES:
        found |= figures_of(f"studies.{name}", HERE / name)
    return found


def reported() -> tuple[str, ...]:
    """The studies with a file of results of their own, in a layout of their own."""
    return tuple(name for name in NAMES if (HERE / name / "layout.py").is_file())
