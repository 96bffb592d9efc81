"""Which figures there are, which of them runs or a file suffice for, and how they are drawn."""

from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base.declarations import described
from dem.base.errors import InputError
from dem.base.messages import check_known
from dem.io.dataset import BY_CASE, CHECK, LABELS
from dem.io.lazily import open_lazily, require_drag

VARIABLES = {"drag": ("drag",), "snapshots": ("granule_x",)}  # that files hold, for all figures


class FigureSpec(NamedTuple):
    """A figure as the constants of its file describe it, see __init__.py."""

    name: str
    module: str
    file: str
    caption: str
    cases: dict | None
    axes: dict
    variables: tuple

    def lack(self, held, axes: tuple, coordinates: dict, asked: bool = False) -> str:
        """What runs along axes lack for it, in words; "" where they suffice.

        held: variables of their file, or names of the files that they will give; coordinates:
        dimensions and values by name; asked: for by name, and not with all others
        """
        absent, file = [name for name in self.variables if name not in held], f"{self.file}.nc"
        if absent and file not in held:
            return f"it holds no {absent[0]}, and {self.name} is drawn from that; name {file}"
        by_case, shows = {*axes} in BY_CASE, f"{self.name} shows"
        if self.cases is None:
            if self.file == "drag" and by_case and not asked:
                return f"{shows} runs that differ in more than case, or shape, and seed"
            few = [axis for axis in self.axes.items() if not _varies(coordinates, *axis)]
            return f"{shows} {few[0][1]} values of {few[0][0]} or more" if few else ""
        if not by_case:
            return (
                f"{shows} runs that differ in case, or shape, and seed alone; these differ in "
                f"{', '.join(axes)}. Draw sweep"
            )
        labels, density = (np.asarray(coordinates[name][1]) for name in ("shape", "density"))
        shapes, least = {*labels[density == density[0]]}, self.cases.get("densities", 1)
        some, every = self.cases.get("any", shapes - {CHECK}), self.cases.get("all", ())
        if shapes.isdisjoint(some) or not shapes.issuperset(every):
            known = " and ".join(every) or " or ".join(some) or f"shapes but {CHECK}"
            return f"{shows} {known}, at the density of the first case"
        few = np.unique(labels, return_counts=True)[1].max() < least
        return f"{shows} a shape at {least} densities" if few else ""


def _varies(coordinates: dict, name: str, least: int) -> bool:
    """Whether a label has so many values, or a value that varies alone along an axis."""
    dims, values = coordinates.get(name, ((), ()))
    if name in LABELS:
        return np.unique(values).size >= least
    beside = {other for other, (over, _) in coordinates.items() if {*dims} & {*over} - {name}}
    return len(dims) == 1 and beside <= {name, *dims} and len(values) >= least


def figures_of(package: str, folder: Path) -> dict[str, FigureSpec]:
    """The figures of a package in a folder, by name."""
    return {
        name: FigureSpec(
            name,
            f"{package}.figures.{name}",
            says["FILE"],
            says["CAPTION"],
            says.get("CASES"),
            says.get("AXES", {}),
            says.get("VARIABLES", VARIABLES.get(says["FILE"], ("run_id",))),
        )
        for name, says in described(folder / "figures", "CAPTION").items()
    }


FIGURES = figures_of("dem", Path(__file__).parent.parent)


def wanted(block, names: list[str] | None, figures: dict[str, FigureSpec] = FIGURES) -> list[str]:
    """Those figures that a sweep names, or all that its runs will suffice for; raises
    InputError."""
    given = _of_block(block)
    for name in names or ():
        check_known("figures has", name, figures, "the figures")
        if lack := figures[name].lack(*given, asked=True):
            raise InputError(f"figures has {name!r}: {lack}.")
    return possible(block, figures) if names is None else names


def possible(block, figures: dict[str, FigureSpec] = FIGURES) -> list[str]:
    """Names of the figures that the runs of a block will suffice for."""
    given = _of_block(block)
    return [name for name, figure in figures.items() if not figure.lack(*given)]


def _of_block(block) -> tuple:
    coordinates = {axis.name: ((axis.name,), axis.coordinate) for axis in block.axes}
    coordinates |= {name: layout for name, (_, *layout) in block.labels().items()}
    files = [f"{name}.nc" for name in block.first.configuration.recorded]
    return files, block.dims, coordinates


def drawable_from(dataset, figures: dict[str, FigureSpec] = FIGURES) -> list[str]:
    """Names of the figures that can be drawn from a file."""
    given = of_file(dataset)
    return [name for name, figure in figures.items() if not figure.lack(*given)]


def of_file(dataset) -> tuple:
    """Variables, axes and coordinates of the runs of a file, as `FigureSpec.lack` takes them."""
    axes = dataset.get("run_id", dataset).dims  # a study may have no runs
    labels = {*dataset.coords, *LABELS} & {*dataset.variables}
    return dataset.variables, axes, {name: (dataset[name].dims, dataset[name]) for name in labels}


def draw(
    name: str,
    data: Path,
    folder: Path,
    figures: dict[str, FigureSpec] = FIGURES,
    of: str | None = None,
) -> list[Path]:
    """Draw a figure, or "all" that a file suffices for, into a folder; returns the files, SVG and
    PNG.

    of: the quantity of the figure sweep. Raises InputError if there is nothing to draw, or no such
    figure.
    """
    check_known("figure is", name, [*figures, "all"], "the figures")
    names = [name]
    if name == "all":
        with open_lazily(data) as dataset:
            names = drawable_from(dataset, figures)
        if not names:
            raise InputError(f"{data}: it holds nothing that a figure shows; name drag.nc.")
    if of and names != ["sweep"]:
        raise InputError(
            f"of is {of!r}; only the figure sweep shows another quantity, leave it out."
        )
    files, faults = [], []
    for chosen in names:
        try:
            files += _draw(figures[chosen], data, folder, {"of": of} if of else {})
        except InputError as error:
            faults.append(str(error))
    if not files:
        raise InputError("\n".join(faults))
    return files


def _draw(figure: FigureSpec, data: Path, folder: Path, options: dict) -> list[Path]:
    """Draw one figure; options: of its function."""
    from dem.figures.style import save

    with open_lazily(data) as dataset:
        if "drag" in {*figure.variables} & {*dataset.variables}:
            require_drag(dataset, data)
        if lack := figure.lack(*of_file(dataset), asked=True):
            raise InputError(f"{data}: {lack}.")
        from dem.analysis.drag import by_case

        runs = dataset if figure.cases is None else by_case(dataset)
        runs = runs if figure.file == "drag" else runs.load()
        try:
            drawing = import_module(figure.module).plot(runs, **options)
        except InputError as error:
            raise InputError(f"{data}: {figure.name} cannot be drawn: {error}") from None
    try:  # without the file, which is sound
        return save(drawing, Path(folder) / figure.name, figure.caption)
    except ValueError as error:  # of a name that is no formula, although it has $
        raise InputError(f"{data}: {figure.name} cannot be drawn: {error}") from None
