"""One file a figure: `plot(Dataset) -> Figure`, no physics. A new figure is a file and a line."""

from importlib import import_module
from pathlib import Path

from dem.errors import InputError

FIGURES = {
    "figure07": "Drag against displacement for every shape",
    "figure08": "Ellipse code at aspect ratio 1 against the disc code",
    "figure13": "Mean drag by shape",
    "figure14": "Mean drag by density of the granules",
}


def draw(name: str, data: Path, folder: Path) -> list[Path]:
    """Draw a figure, or "all", from drag.nc into a folder; returns the files, SVG and PNG.

    Of all, those that can be drawn are; raises InputError naming what could not.
    """
    from dem.combine import open_combined
    from dem.figures.style import save

    if name != "all" and name not in FIGURES:
        raise InputError(f"figure is {name!r}; there are {', '.join(FIGURES)} and all.")
    files, faults = [], []
    with open_combined(data) as dataset:
        for each in FIGURES if name == "all" else (name,):
            try:
                figure = import_module(f"dem.figures.{each}").plot(dataset)
            except InputError as error:
                faults.append(f"{data}: {each} can not be drawn: {error}")
                continue
            files += save(figure, Path(folder) / each)
    if faults:
        raise InputError("\n".join(faults))
    return files
