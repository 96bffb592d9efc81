"""Which figures there are, which of them runs or a file suffice for, and how they are drawn."""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from dem.base.constants import described
from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.io.lazily import open_combined, open_lazily, require

CHECK = "e0"  # ellipse code at aspect ratio 1: a check, and no shape of its own


class FigureSpec(NamedTuple):
    """A figure as the constants of its file describe it, see __init__.py."""

    name: str
    package: str  # that has the folder of figures
    file: str
    caption: str
    cases: dict | None
    axes: dict
    variables: tuple

    @property
    def module(self) -> str:
        return f"{self.package}.figures.{self.name}"

    def enough(self, sizes: dict[str, int], cases: list | None) -> bool:
        """Whether runs suffice.

        sizes: numbers of values by axis
        cases: (shape label, density) by case, None where runs differ in more than case, or shape,
        and seed
        """
        if self.cases is None:
            several = self.file != "drag" or cases is None
            return several and all(sizes.get(dim, 0) >= n for dim, n in self.axes.items())
        if not cases:
            return False
        first = {shape for shape, density in cases if density == cases[0][1]}
        shapes = [shape for shape, _ in cases]
        return (
            bool(first & set(self.cases.get("any", first - {CHECK})))
            and first >= set(self.cases.get("all", ()))
            and len(shapes) - len(set(shapes)) >= self.cases.get("densities", 1) - 1
        )


def figures_of(package: str, folder: Path) -> dict[str, FigureSpec]:
    """The figures of a package in a folder, by name."""
    return {
        name: FigureSpec(
            name,
            package,
            says["FILE"],
            says["CAPTION"],
            says.get("CASES"),
            says.get("AXES", {}),
            says.get("VARIABLES", ("drag",) if says["FILE"] == "drag" else ()),
        )
        for name, says in described(Path(folder) / "figures", "CAPTION").items()
    }


FIGURES = figures_of("dem", Path(__file__).parent.parent)


def wanted(block, names: list[str] | None, figures: dict[str, FigureSpec] = FIGURES) -> list[str]:
    """Those figures that a sweep names, or all that its runs will suffice for; raises
    InputError."""
    found = possible(block, figures)
    for name in names or ():
        if name not in found:
            hint = did_you_mean(name, found)
            raise InputError(f"figures has {name!r}, for which these runs do not suffice{hint}.")
    return found if names is None else names


def possible(block, figures: dict[str, FigureSpec] = FIGURES) -> list[str]:
    """Names of the figures that the runs of a block will suffice for."""
    labels = {name: dims for name, (_, dims, _) in block.labels().items()}
    sizes = _sizes(dict(zip(block.dims, block.shape, strict=True)), labels)
    sizes["granules"] = len({run.shape.granules for run in block.runs.values()})
    cases = list(dict.fromkeys((run.label, run.density) for run in block.runs.values()))
    return [
        name
        for name, figure in figures.items()
        if figure.file in block.first.configuration.recorded
        and figure.enough(sizes, cases if block.is_by_case else None)
    ]


def _sizes(axes: dict[str, int], labels: dict[str, tuple]) -> dict[str, int]:
    """Sizes of axes, and of each value in which alone the points of an axis differ. labels: names
    of values beside the axes, and the dimensions of each."""
    sizes = dict(axes)
    for axis, size in axes.items():
        names = [name for name, dims in labels.items() if axis in dims and name != axis]
        if len(names) == 1:
            sizes[names[0]] = size
    return sizes


def drawable_from(data: Path, dataset, figures: dict[str, FigureSpec] = FIGURES) -> list[str]:
    """Names of those of some figures that a file suffices for."""
    from dem.analysis.drag import by_case, cases_of

    variables, sizes, cases = set(dataset.variables), {}, None
    if any(figure.cases is not None or figure.axes for figure in figures.values()):
        require(dataset, data, {}, ("run_id",))
        labels = {str(name): values.dims for name, values in dataset.coords.items()}
        sizes = _sizes(dict(dataset["run_id"].sizes), labels)
        if (cased := by_case(dataset)) is not None:
            require(cased, data, {}, ("shape", "density"))
            cases = [case for _, *case in cases_of(cased)]
        if "granules" in variables:
            sizes["granules"] = len(set(dataset["granules"].values.ravel().tolist()))
    return [
        name
        for name, figure in figures.items()
        if variables.issuperset(figure.variables) and figure.enough(sizes, cases)
    ]


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
    if name not in (known := [*sorted(figures), "all"]):
        raise InputError(f"figure is {name!r}; there is no such figure{did_you_mean(name, known)}.")
    names = [name]
    if name == "all":
        of_drag = {name: figure for name, figure in figures.items() if figure.file == "drag"}
        with open_lazily(data) as dataset:
            names = drawable_from(data, dataset, of_drag)
        if not names:
            raise InputError(f"{data}: it holds no drag that a figure shows; name drag.nc.")
    if of and names != ["sweep"]:
        raise InputError(
            f"of is {of!r}; only the figure sweep shows another quantity, leave it out."
        )
    files, faults = [], []
    for each in names:
        try:
            files += _draw(figures[each], data, folder, {"of": of} if of else {})
        except InputError as error:
            faults.append(str(error))
    if not files:
        raise InputError("\n".join(faults))
    return files


def _draw(figure: FigureSpec, data: Path, folder: Path, options: dict) -> list[Path]:
    """Draw one figure; options: of its function."""
    from dem.analysis.drag import by_case
    from dem.figures.style import save

    with open_lazily(data) as dataset:
        for name in figure.variables:
            if name not in dataset.variables:
                raise InputError(
                    f"{data}: it holds no {name}, and {figure.name} is drawn from that; name "
                    f"{figure.file}.nc."
                )
    with (open_combined if "drag" in figure.variables else open_lazily)(data) as dataset:
        if figure.cases is not None or figure.axes:
            require(dataset, data, {}, ("run_id",))
        whole = dataset if figure.cases is None else by_case(dataset)
        if whole is None:
            dims = ", ".join(map(str, dataset["run_id"].dims))
            raise InputError(
                f"{data}: {figure.name} shows runs that differ in case, or shape, and seed alone; "
                f"these differ in {dims}. Draw sweep."
            )
        if figure.package != "dem" and find_spec(f"{figure.package}.results"):  # a study's own file
            require(whole, data, import_module(f"{figure.package}.results").VARIABLES, ())
        try:
            drawn = import_module(figure.module).plot(
                whole if figure.file == "drag" else whole.load(), **options
            )
        except InputError as error:
            raise InputError(f"{data}: {figure.name} cannot be drawn: {error}") from None
        return save(drawn, Path(folder) / figure.name, figure.caption)
