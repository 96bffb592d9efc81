"""Which figures there are, which of them runs or a file suffice for, and how they are drawn."""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from dem.base.constants import described
from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.io.lazily import open_lazily, require

BY_CASE = {"case", "seed"}, {"shape", "seed"}  # axes of runs that make cases
# by file: observables one of which runs must record, and what the file must hold, if a figure says neither
USUAL = {"flow": ("snapshots",)}
HELD = {"drag": ("drag",), "flow": ("bed_x",)}
CHECK = "e0"  # ellipse code at aspect ratio 1: a check, and no shape of its own


class Drawn(NamedTuple):
    """A figure as its file describes it, see __init__.py; package: what holds the folder of figures."""

    name: str
    package: str
    file: str
    caption: str
    cases: dict | None
    axes: dict
    recorded: tuple
    variables: tuple

    @property
    def module(self) -> str:
        return f"{self.package}.figures.{self.name}"

    def enough(self, sizes: dict[str, int], cases: list | None) -> bool:
        """Whether runs suffice: numbers of values by axis, and (shape label, density) by case, None
        where they differ in more than case, or shape, and seed."""
        if self.cases is None:
            several = self.file != "drag" or cases is None
            return several and all(sizes.get(dim, 0) >= n for dim, n in self.axes.items())
        if not cases:
            return False
        first = {shape for shape, density in cases if density == cases[0][1]}
        shapes = [shape for shape, _ in cases]
        return (
            first & set(self.cases.get("any", first - {CHECK}))
            and first >= set(self.cases.get("all", ()))
            and len(shapes) - len(set(shapes)) >= self.cases.get("densities", 1) - 1
        )


def figures_of(package: str, folder: Path) -> dict[str, Drawn]:
    """The figures of a package in a folder, by name."""
    return {
        name: Drawn(
            name, package, own["FILE"], own["CAPTION"], own.get("CASES"), own.get("AXES", {}),
            own.get("RECORDED", USUAL.get(own["FILE"], (own["FILE"],))),
            own.get("VARIABLES", HELD.get(own["FILE"], ())),
        )
        for name, own in described(Path(folder) / "figures", "CAPTION").items()
    }  # fmt: skip


FIGURES = figures_of("dem", Path(__file__).parent.parent)


def wanted(block, names: list[str] | None, figures: dict[str, Drawn] = FIGURES) -> list[str]:
    """Those figures that a sweep names, or all that its runs will suffice for; raises InputError."""
    found = possible(block, figures)
    for name in names or ():
        if name not in found:
            hint = did_you_mean(name, found)
            raise InputError(f"figures has {name!r}, for which these runs do not suffice{hint}.")
    return found if names is None else names


def possible(block, figures: dict[str, Drawn] = FIGURES) -> list[str]:
    """Names of the figures that the runs of a block will suffice for."""
    runs = [run.replicate for run in block.runs]
    labels = {name: dims for name, (_, dims, _) in block.labels().items()}
    sizes = _sizes(dict(zip(block.dims, block.shape, strict=True)), labels)
    cases = list(dict.fromkeys((run.label, run.density) for run in runs))
    cases = cases if set(block.dims) in BY_CASE else None
    sizes |= {"granules": len({run.shape.granules for run in runs})}
    recorded = set(runs[0].configuration.recorded)
    return [
        name for name, each in figures.items()
        if recorded & set(each.recorded) and each.enough(sizes, cases)
    ]  # fmt: skip


def _sizes(axes: dict[str, int], labels: dict[str, tuple]) -> dict[str, int]:
    """Sizes of axes, and of each value in which alone the points of an axis differ. labels: names of values
    beside the axes, and the dimensions of each."""
    found = dict(axes)
    for axis, size in axes.items():
        own = [name for name, dims in labels.items() if axis in dims and name != axis]
        if len(own) == 1:
            found[own[0]] = size
    return found


def drawable_from(data: Path, dataset, figures: dict[str, Drawn] = FIGURES) -> list[str]:
    """Names of those of some figures that a file suffices for."""
    from dem.analysis.statistics import by_case, cases_of

    held, sizes, cases = set(dataset.variables), {}, None
    if any(each.cases is not None or each.axes for each in figures.values()):
        require(dataset, data, {}, ("run_id",))
        axes = dict(dataset["run_id"].sizes)
        labels = {str(name): values.dims for name, values in dataset.coords.items()}
        sizes = _sizes(axes, labels)
        if (found := by_case(dataset)) is not None:
            require(found, data, {}, ("shape", "density"))
            cases = [case for _, *case in cases_of(found)]
        if "granules" in held:
            sizes["granules"] = len(set(dataset["granules"].values.ravel().tolist()))
    return [
        name for name, each in figures.items()
        if held.issuperset(each.variables) and each.enough(sizes, cases)
    ]  # fmt: skip


def draw(
    name: str, data: Path, folder: Path, figures: dict[str, Drawn] = FIGURES, of: str | None = None
) -> list[Path]:
    """Draw a figure, or "all" that a file suffices for, into a folder; returns the files, SVG and PNG.

    of: the quantity of the figure sweep. Raises InputError if there is nothing to draw, or no such
    figure.
    """
    if name not in (known := [*sorted(figures), "all"]):
        raise InputError(f"figure is {name!r}; there is no such figure{did_you_mean(name, known)}.")
    names = [name]
    if name == "all":
        own = {name: each for name, each in figures.items() if each.file == "drag"}
        with open_lazily(data) as dataset:
            names = drawable_from(data, dataset, own)
        if not names:
            require_drag(data)
            names = list(own)
    if of and names != ["sweep"]:
        raise InputError(f"of is {of!r}; only the figure sweep shows another quantity, leave it out.")
    files, faults = [], []
    for each in names:
        try:
            files += _drawn(figures[each], data, folder, {"of": of} if of else {})
        except InputError as error:
            faults.append(str(error))
    if not files:
        raise InputError("\n".join(faults))
    return files


def _drawn(each: Drawn, data: Path, folder: Path, options: dict) -> list[Path]:
    """Draw one figure; options: of its function."""
    from dem.analysis.statistics import by_case
    from dem.figures.style import save
    from dem.sweep.combine import open_combined

    of_drag = "drag" in each.variables
    with open_lazily(data) as dataset:
        if absent := [name for name in each.variables if name not in dataset.variables]:
            raise InputError(
                f"{data}: it holds no {absent[0]}, and {each.name} is drawn from that; name {each.file}.nc."
            )
    with (open_combined if of_drag else open_lazily)(data) as dataset:
        if each.cases is not None or each.axes:
            require(dataset, data, {}, ("run_id",))
        whole = dataset if each.cases is None else by_case(dataset)
        if whole is None:
            dims = ", ".join(map(str, dataset["run_id"].dims))
            raise InputError(
                f"{data}: {each.name} shows runs that differ in case, or shape, and seed alone; these "
                f"differ in {dims}. Draw sweep."
            )
        require(whole, data, _layout_of(each), ())
        try:
            figure = import_module(each.module).plot(
                whole if each.file == "drag" else whole.load(), **options
            )
        except InputError as error:
            raise InputError(f"{data}: {each.name} cannot be drawn: {error}") from None
        return save(figure, Path(folder) / each.name, each.caption)


def _layout_of(each: Drawn) -> dict:
    """What the file of a figure must look like: that of flow.nc, or of a study's own file."""
    package = "dem.analysis.flow" if each.file == "flow" else each.package
    own = package != "dem" and find_spec(f"{package}.layout")
    return import_module(f"{package}.layout").VARIABLES if own else {}


def require_drag(data: Path) -> None:
    """Raise InputError for a file without drag."""
    with open_lazily(data) as dataset:
        if "drag" not in dataset.variables:
            raise InputError(f"{data}: it holds no drag; name drag.nc.")
