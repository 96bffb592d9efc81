"""Which figures and which files of results the studies have."""

from dem.base.declarations import constants
from dem.figures.catalogue import FIGURES, figures_of
from studies import FOLDERS, package_of


def figures() -> dict:
    """The figures of the library and of all studies, by name."""
    catalogue = dict(FIGURES)
    for name, folder in FOLDERS.items():
        catalogue |= figures_of(package_of(name), folder)
    return catalogue


def reported() -> dict[str, dict]:
    """The studies with a file of results of their own, and the constants of their results.py."""
    files = {name: folder / "results.py" for name, folder in FOLDERS.items()}
    return {name: constants(file) for name, file in files.items() if file.is_file()}
