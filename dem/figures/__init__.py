"""One file per figure: `plot(Dataset) -> Figure`, no physics. A new figure is a file and a line."""

import json
from importlib import import_module
from pathlib import Path

import lazy_loader

from dem.base.errors import InputError

__getattr__ = lazy_loader.attach(__name__, ["plot"])[0]  # dem.plot of ../__init__.pyi


def _some_shape(cases):
    return any(shape != "e0" and density == cases[0][1] for shape, density in cases)


def _both_codes(cases):
    return {("c1", cases[0][1]), ("e0", cases[0][1])} <= set(cases)


def _two_densities(cases):
    shapes = [shape for shape, _ in cases]
    return len(set(shapes)) < len(shapes)


def _one_of(*shapes):
    return lambda cases: any(shape in shapes and density == cases[0][1] for shape, density in cases)


# name: (what it shows, whether cases, a list of (shape label, density), suffice for it)
FIGURES = {
    "figure07": ("Drag against displacement for every shape", _some_shape),
    "figure08": ("Ellipse code at aspect ratio 1 against the disc code", _both_codes),
    "figure13": ("Mean drag by shape", _some_shape),
    "figure14": ("Mean drag by density of the granules", _two_densities),
}

# shapes whose beds the figures of FLOW show, by what they are together: a part of flow.nc suffices
BEDS = {"round": ("c1", "d1", "c2"), "ellipses": ("e1", "e2", "e3")}
BEDS_OF = {"figure09": "round", "figure10": "round", "figure11": "ellipses", "figure12": "ellipses"}

# the same, drawn from flow.nc
FLOW = {
    "figure09": ("Beds of discs, dumbbells and small discs, the granules ahead of the cylinder shaded", _one_of(*BEDS["round"])),
    "figure10": ("Beds of discs, dumbbells and small discs in layers", _one_of(*BEDS["round"])),
    "figure11": ("Beds of ellipses, the granules ahead of the cylinder shaded", _one_of(*BEDS["ellipses"])),
    "figure12": ("Beds of ellipses in layers", _one_of(*BEDS["ellipses"])),
    "irregularity": ("How irregular the flow is, by shape: four measures against displacement", _some_shape),
}  # fmt: skip

# from drag.nc too, where runs differ in more than case, or shape, and seed: (what it shows, how many
# values of which axes suffice for it)
SWEPT = {
    "sweep": ("Mean drag over what was varied", {}),
    "velocity": (
        "Drag against the velocity of the cylinder, and its quasi-static limit",
        {"cylinder_velocity": 4, "seed": 3},  # LEAST of dem.analysis.velocity, which loads xarray
    ),
    "pressure": (
        "Drag of shapes against the width of the box, at equal pressure and at equal packing fraction",
        {"box": 3, "shape": 2, "seed": 2},  # LEAST of studies.pressure.widths
    ),
    "preparation": (
        "Drag of shapes in beds that were made in several ways",
        {"packing_preparation": 2, "shape": 2, "seed": 2},
    ),
}

# from shear.nc, of the experiment shear: (what it shows, how many values of which axes suffice for it)
SHEAR = {
    "shear": (
        "Friction and packing fraction of sheared beds against their inertial number",
        {"shear_inertial_number": 2},  # LEAST of dem.analysis.shear, which loads xarray
    ),
}

# from onset.nc: (what it shows, variables that the file must hold)
ONSET = {"onset": ("Where beds jam and on how many contacts, against aspect ratio", ("onset_fraction", "onset_contacts"))}  # fmt: skip
ONSET_LEAST = 3  # numbers of granules, and seeds: LEAST of dem.analysis.onset, which loads xarray

# drawn from a study's own file: (what it shows, variables that the file must hold)
ACCURACY = {
    "accuracy_contacts": ("Contacts of ellipses: error against time, and energy over many bounces", ("contact_method",)),
    "accuracy_steps": ("Time integrators: error against processor time", ("integrator",)),
    "accuracy_drag": ("What the time step costs in mean drag and in processor time", ("trial_drag",)),
    "accuracy_replicates": ("What replicates and a longer stroke buy", ("replicate_drag",)),
}  # fmt: skip
STABILITY = {
    "stability_catalogue": ("Stiff and extreme cases, each against its limits", ("check_value", "paper_residual")),
    "stability_map": ("Where energy stops adding up: time step, restitution, stiffness, shape", ("map_residual",)),
}  # fmt: skip
CLAIMS = {
    "claims_verdicts": ("Which of the paper's claims hold", ("run_drag", "jam_fraction")),
    "claims_sensitivity": ("What decides the drag, and in how much of the plausible space claims hold", ("run_factor",)),
    "claims_jamming": ("Shapes at equal packing fraction, at equal distance from jamming and at equal load", ("run_drag", "jam_fraction")),
    "claims_ratio": ("Ellipses from round to twice as long as wide: drag and alignment with the flow", ("run_alignment", "jam_fraction")),
    "claims_scaling": ("Drag against the sizes of cylinder and box and against velocity", ("run_setting", "run_curve")),
}  # fmt: skip
BENCHMARK = {"benchmark": ("Speed beside other codes", ("granule_steps_per_second", "variant_step_time"))}  # fmt: skip
STUDIES = (
    {name: (words, ("non_affine",) if name == "irregularity" else ("bed_x",)) for name, (words, _) in FLOW.items()}
    | ACCURACY | STABILITY | CLAIMS | BENCHMARK | ONSET
)  # fmt: skip


STUDY_FIGURES = {
    "claims": CLAIMS,
    "accuracy": ACCURACY,
    "stability": STABILITY,
    "benchmark": BENCHMARK,
}  # by file
FILES = {
    "drag": FIGURES | SWEPT,
    "flow": FLOW,
    "onset": ONSET,
    "shear": SHEAR,
} | STUDY_FIGURES  # by file of results, without .nc
FILE_OF = {name: file for file, figures in FILES.items() for name in figures}


def captions() -> dict[str, str]:
    """What each figure shows, by name, in the order of the paper, studies last."""
    paper = dict(sorted((FIGURES | FLOW).items()))
    return {name: words for name, (words, _) in (SWEPT | SHEAR | paper | STUDIES).items()}


def possible(block, figures=FIGURES) -> list[str]:
    """Names of the figures of FIGURES or FLOW that the runs of a block suffice for."""
    own = block.runs[0].replicate.configuration
    sizes = _sizes(
        dict(zip(block.dims, block.shape, strict=True)),
        {name: dims for name, (_, dims, _) in block.labels().items()},
    )
    if own.experiment == "shear" and figures is FIGURES:
        return _enough(sizes, SHEAR)
    if own.experiment == "onset" and figures is FIGURES:
        varied = [(run.replicate.shape.granules, run.replicate.seed) for run in block.runs]
        enough = all(len(set(values)) >= ONSET_LEAST for values in zip(*varied, strict=True))
        return list(ONSET) if enough else []
    if own.experiment != "drag":
        return []
    held = set(own.record.observables)
    if figures is FIGURES and "drag" not in held:
        return []
    runs = [run.replicate for run in block.runs]
    cases = list(dict.fromkeys((run.label, run.density) for run in runs))
    found = _suffices(block.dims, sizes, cases, figures)
    if figures is FLOW and "snapshots" not in held:  # the measures alone
        return [name for name in found if name == "irregularity" and "flow" in held]
    return found


def _sizes(axes: dict[str, int], labels: dict[str, tuple]) -> dict[str, int]:
    """Sizes of axes, and of each value in which alone the points of an axis differ; labels: names
    of values beside the axes, and the dimensions of each."""
    found = dict(axes)
    for axis, size in axes.items():
        own = [name for name, dims in labels.items() if axis in dims and name != axis]
        if len(own) == 1:
            found[own[0]] = size
    return found


def _sizes_in(dataset) -> dict[str, int]:
    """The same of a file."""
    labels = {str(name): values.dims for name, values in dataset.coords.items()}
    return _sizes(dict(dataset["run_id"].sizes), labels)


def _suffices(dims, sizes: dict[str, int], cases: list, figures: dict) -> list[str]:
    """Names of the figures that runs over some axes, of some sizes, suffice for."""
    if set(dims) not in ({"case", "seed"}, {"shape", "seed"}):
        return _enough(sizes, SWEPT) if figures is FIGURES else []
    return [name for name, (_, suffices) in figures.items() if suffices(cases)]


def _enough(sizes: dict[str, int], swept: dict) -> list[str]:
    """Names of the figures that axes of some sizes suffice for."""
    return [
        name for name, (_, least) in swept.items()
        if all(sizes.get(dim, 0) >= number for dim, number in least.items())
    ]  # fmt: skip


def drawable(folder: Path) -> list[str]:
    """Names of the figures that can be drawn from the results in a folder.

    Raises InputError where drag.nc is absent, or where a file of results is damaged.
    """
    from dem.io.lazily import open_lazily

    found = []
    for file, figures in FILES.items():
        data = Path(folder) / f"{file}.nc"
        if not data.is_file():
            others = [Path(folder) / f"{name}.nc" for name in ("onset", "shear")]
            if file == "drag" and not any(other.is_file() for other in others):
                raise InputError(
                    f"{data}: it is not there to draw from; make it first: snakemake -j2"
                )
            continue
        with open_lazily(data) as dataset:
            if file in ("drag", "flow"):
                found += drawn_from(data, dataset, FIGURES if file == "drag" else FLOW)
            elif file == "shear":
                found += _enough(_sizes_in(dataset), SHEAR)
            else:
                held = set(dataset.variables)
                found += [name for name, (_, needs) in figures.items() if held.issuperset(needs)]
    return found


def drawn_from(data: Path, dataset, figures: dict) -> list[str]:
    """Names of those of FIGURES or FLOW that drag.nc or flow.nc suffices for."""
    from dem.analysis.statistics import by_case
    from dem.io.lazily import require

    require(dataset, data, {}, ("run_id",))
    found = by_case(dataset)
    if found is None:
        return _suffices(dataset["run_id"].dims, _sizes_in(dataset), [], figures)
    require(found, data, {}, ("shape", "density"))
    shapes, densities = (found[key].values.tolist() for key in ("shape", "density"))
    cases = list(zip(shapes, densities, strict=True))
    names = _suffices(found["run_id"].dims, {}, cases, figures)
    held = set(found.variables)
    return [name for name in names if figures is FIGURES or held.issuperset(STUDIES[name][1])]


def draw(name: str, data: Path, folder: Path) -> list[Path]:
    """Draw a figure, or "all", into a folder; returns the files, SVG and PNG.

    All are those from drag.nc that its runs suffice for; a figure of STUDIES is drawn from the
    file of its study. Raises InputError if there is nothing to draw.
    """
    from dem.analysis.statistics import by_case
    from dem.figures.style import save
    from dem.sweep.combine import open_combined

    if name in STUDIES:
        return _draw_study(name, data, Path(folder))
    if name in SHEAR:
        return _draw_shear(name, data, Path(folder))
    if name not in ("all", *FIGURES, *SWEPT):
        names = ", ".join([*FIGURES, *SWEPT, *SHEAR, *STUDIES])
        raise InputError(f"figure is {name!r}; there are {names} and all.")
    files, faults = [], []
    require_drag(data)
    with open_combined(data) as dataset:
        cases = by_case(dataset)
        every = SWEPT if cases is None else FIGURES
        for each in every if name == "all" else (name,):
            if each in FIGURES and cases is None:
                _refuse(each, data, dataset)
            try:
                whole = dataset if each in SWEPT else cases
                _check_axes(each, dataset)
                figure = import_module(f"dem.figures.{each}").plot(whole)
            except InputError as error:
                faults.append(f"{data}: {each} cannot be drawn: {error}")
                continue
            files += save(figure, Path(folder) / each)
    if not files:
        raise InputError("\n".join(faults))
    return files


def require_drag(data: Path) -> None:
    """Raise InputError for runs of an experiment that records no drag, with the figures they have."""
    from dem.io.lazily import open_lazily

    with open_lazily(data) as dataset:
        if "drag" in dataset.variables:
            return
        experiment = json.loads(dataset.attrs.get("configuration", "{}")).get("experiment", "drag")
        if experiment == "drag":
            raise InputError(f"{data}: it holds no drag; {_name_instead(data, 'drag')}.")
        verbs = [f"dem figure {name} {data}" for name in FILES.get(experiment, ())]
        hint = f"; draw them with {' or '.join(verbs)}" if verbs else ""
        raise InputError(f"{data}: runs of the experiment {experiment} have no drag{hint}.")


def _name_instead(data: Path, file: str) -> str:
    """Which file to name in place of another; the one beside it, if it is there."""
    beside = Path(data).with_name(f"{file}.nc")
    return f"name {beside if beside.is_file() else beside.name} instead"


def _check_file(name: str, data: Path, variables) -> None:
    """Raise InputError for a file of results of which a figure is not drawn."""
    file = FILE_OF[name]
    if Path(data).stem != file and not set(STUDIES.get(name, ("", ()))[1]) <= set(variables):
        raise InputError(f"{data}: {name} is drawn from {file}.nc; {_name_instead(data, file)}.")


def _check_axes(name, dataset):
    """Raise InputError if the runs have too few values of an axis that a figure of SWEPT needs."""
    from dem.analysis.values import along

    for dim, least in SWEPT.get(name, ("", {}))[1].items():
        sizes = along(dataset, dim)["run_id"].sizes
        if sizes.get(dim, 0) < least:
            raise InputError(
                f"the runs have {sizes.get(dim, 0)} values of {dim}; it takes {least} or more."
            )


def _refuse(name, data, dataset):
    dims = ", ".join(map(str, dataset["run_id"].dims))
    raise InputError(
        f"{data}: {name} shows runs that differ in case, or shape, and seed alone; these differ in "
        f"{dims}. Draw sweep."
    )


def _draw_shear(name, data, folder):
    from dem.figures.style import save
    from dem.io.lazily import open_lazily, require

    with open_lazily(data) as dataset:
        require(dataset, data, {}, ("run_id", "lid_shear_stress"), ("configuration",))
        try:
            figure = import_module(f"dem.figures.{name}").plot(dataset.load())
        except InputError as error:
            raise InputError(f"{data}: {name} cannot be drawn: {error}") from None
        return save(figure, folder / name)


def _draw_study(name, data, folder):
    from dem.analysis.statistics import by_case
    from dem.figures.style import save
    from dem.io.lazily import open_lazily, require

    if name in ONSET:  # its variables lie over the axes of any sweep
        layout = {}
    else:
        package = "dem.analysis.flow" if name in FLOW else f"studies.{FILE_OF[name]}"
        layout = import_module(f"{package}.layout").VARIABLES
    with open_lazily(data) as dataset:
        whole = dataset
        _check_file(name, data, dataset.variables)
        if name in FLOW:
            require(dataset, data, {}, ("run_id",))
            whole = by_case(dataset)
            if whole is None:
                _refuse(name, data, dataset)
        require(whole, data, layout, STUDIES[name][1])
        try:
            figure = import_module(f"dem.figures.{name}").plot(whole.load())
        except InputError as error:
            raise InputError(f"{data}: {name} cannot be drawn: {error}") from None
        return save(figure, folder / name)
