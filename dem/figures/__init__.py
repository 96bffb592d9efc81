"""One file a figure: `plot(Dataset) -> Figure`, no physics. A new figure is a file and a line."""

from importlib import import_module
from pathlib import Path

from dem.errors import InputError


def _some_shape(cases):
    return any(shape != "e0" and density == cases[0][1] for shape, density in cases)


def _both_codes(cases):
    return {("c1", cases[0][1]), ("e0", cases[0][1])} <= set(cases)


def _two_densities(cases):
    shapes = [shape for shape, _ in cases]
    return len(set(shapes)) < len(shapes)


# name: (what it shows, whether cases, a list of (shape label, density), suffice for it)
FIGURES = {
    "figure07": ("Drag against displacement for every shape", _some_shape),
    "figure08": ("Ellipse code at aspect ratio 1 against the disc code", _both_codes),
    "figure13": ("Mean drag by shape", _some_shape),
    "figure14": ("Mean drag by density of the granules", _two_densities),
}

# drawn from a study's own file, each with variables that the file must hold
ACCURACY = {
    "accuracy_contacts": ("contact_method",),
    "accuracy_steps": ("integrator",),
    "accuracy_drag": ("trial_drag",),
    "accuracy_replicates": ("replicate_drag",),
}
STUDIES = {"benchmark": ("granule_steps_per_second", "variant_step_time")} | ACCURACY


def possible(sweep) -> list[str]:
    """Names of the figures that the cases of a sweep suffice for."""
    cases = [(case.shape, case.density) for case in sweep.cases.values()]
    return [name for name, (_, suffices) in FIGURES.items() if suffices(cases)]


def draw(name: str, data: Path, folder: Path) -> list[Path]:
    """Draw a figure, or "all", into a folder; returns the files, SVG and PNG.

    All are those from drag.nc that its cases suffice for; a figure of STUDIES is drawn from the
    file of its study. Raises InputError if there is nothing to draw.
    """
    from dem.combine import open_combined
    from dem.figures.style import save

    if name in STUDIES:
        return _draw_study(name, data, Path(folder))
    if name != "all" and name not in FIGURES:
        names = ", ".join([*FIGURES, *STUDIES])
        raise InputError(f"figure is {name!r}; there are {names} and all.")
    files, faults = [], []
    with open_combined(data) as dataset:
        for each in FIGURES if name == "all" else (name,):
            try:
                figure = import_module(f"dem.figures.{each}").plot(dataset)
            except InputError as error:
                faults.append(f"{data}: {each} can not be drawn: {error}")
                continue
            files += save(figure, Path(folder) / each)
    if not files:
        raise InputError("\n".join(faults))
    return files


def _draw_study(name, data, folder):
    from dem.combine import open_lazily, require
    from dem.figures.style import save

    with open_lazily(data) as dataset:
        require(dataset, data, STUDIES[name])
        return save(import_module(f"dem.figures.{name}").plot(dataset.load()), folder / name)
