"""The runs that claims are tested on, from claims.nc or from the drag.nc of any sweep."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.compare import Comparison
from dem.analysis.drag import summarise, within
from studies.claims import MEASURES
from studies.claims.irregularity import in_window

NOTHING = xr.Dataset(coords={"case": [], "seed": []})
NAMES = {"run_factor": "at"}  # values of the design are not those of its axis
LABELS = {
    f"run_{name}" for name in ("part", "case", "shape", "setting", "status", "seed", "density")
}
MARGIN = 0.18  # the larger scatter of section 3.2, by which the paper itself judges two drags


class Evidence(NamedTuple):
    """Measures over (case, seed), SI units, NaN where a run failed.

    runs: Of the sweep's cases.
    points: Of cases at the points of the design, which take the place of seeds; `at` (case, seed,
        factor) are their coordinates.
    velocity: Of the reference; cases are factors on the sweep's velocity.
    ratios: Of ellipses at equal packing fraction; cases are aspect ratios.
    margin: By how much more than nothing a word such as "significantly" means, as a share.
    single: Each seed is an independent realisation.
    """

    runs: xr.Dataset
    points: xr.Dataset = NOTHING
    velocity: xr.Dataset = NOTHING
    ratios: xr.Dataset = NOTHING
    margin: float = MARGIN
    single: bool = False

    def one_by_one(self, runs: xr.Dataset) -> "Evidence":
        """Single runs: of the points of the design, or of the sweep."""
        return Evidence(runs, margin=self.margin, single=True)


def rows(dataset: xr.Dataset, part: str, setting: str | None = None) -> xr.Dataset:
    """Runs of one part of the study, and of one setting in it."""
    here = dataset["run_part"] == part
    if setting is not None:
        here &= dataset["run_setting"] == setting
    return dataset.isel(run=np.flatnonzero(here.values))


def with_case(runs: xr.Dataset, *cases: str) -> xr.Dataset:
    """Of some runs those of these cases."""
    return runs.isel(run=np.flatnonzero(np.isin(runs["run_case"].values, cases)))


def table(runs: xr.Dataset, column: str = "run_case", along: str = "run_seed") -> xr.Dataset:
    """Runs in a row as measures over (case, seed); column: what names a case; along: what takes
    the place of a seed. A quantity along the motion counts as its mean within the averaging
    window."""
    if not runs.sizes["run"]:
        return NOTHING
    keys, numbers = runs[column].values.tolist(), runs[along].values.tolist()
    cases, seeds = list(dict.fromkeys(keys)), sorted(set(numbers))
    at = [cases.index(key) for key in keys], [seeds.index(number) for number in numbers]
    found = {}
    for name, array in runs.variables.items():
        if array.dims[:1] != ("run",) or name in LABELS:
            continue
        values, others = _in_window(runs, name)
        room = np.full((len(cases), len(seeds), *values.shape[1:]), np.nan)
        room[at] = values
        found[NAMES.get(name, name.removeprefix("run_"))] = (("case", "seed", *others), room)
    first = [keys.index(case) for case in cases]
    about = {name: ("case", runs[f"run_{name}"].values[first]) for name in ("shape", "density")}
    axes = {name: runs[name].values for name in ("factor", "place")}
    return xr.Dataset(found, {"case": cases, "seed": seeds, **axes, **about}, runs.attrs)


def _in_window(runs, name):
    """Values (run, ...) as numbers, and the names of their further dimensions."""
    array = runs[name]
    if "moment" in array.dims:
        low, high = runs.attrs["window_start"], runs.attrs["window_stop"]
        inside = (runs["moment"] >= low) & (runs["moment"] <= high)
        array = array.isel(moment=np.flatnonzero(inside.values)).mean("moment")
    return array.values.astype(float), array.dims[1:]


def reference(dataset: xr.Dataset) -> tuple[str, float, float]:
    """Case to which others are compared, its density (kg/m3) and packing fraction."""
    shape, density = str(dataset["reference_shape"].values), float(dataset["reference_density"])
    runs = rows(dataset, "replicates")
    here = (runs["run_shape"].values == shape) & (runs["run_density"].values == density)
    cases = runs["run_case"].values[here]
    return (str(cases[0]) if len(cases) else shape), density, float(dataset["reference_packing"])


def first_come(runs: xr.Dataset, case: str) -> xr.Dataset:
    """A table whose first case is the reference, as dem.analysis.drag expects it."""
    cases = runs["case"].values.tolist()
    return runs.sel(case=sorted(cases, key=lambda each: each != case)) if case in cases else runs


def scaled(dataset: xr.Dataset, setting: str, shape: str) -> xr.Dataset:
    """Runs of a shape by the factor on one of the sweep's values; the replicates are at 1."""
    _, density, _ = reference(dataset)
    changed = rows(dataset, "scaling", setting)
    changed = changed.isel(run=np.flatnonzero(changed["run_shape"].values == shape))
    base = rows(dataset, "replicates")
    base = base.isel(run=np.flatnonzero(base["run_shape"].values == shape))
    densities = base["run_density"].values
    if not (changed.sizes["run"] and len(densities)):
        return NOTHING
    density = density if density in densities else densities[0]
    base = base.isel(run=np.flatnonzero(densities == density))
    base = base.assign(run_x=("run", np.ones(base.sizes["run"])))
    how = {"data_vars": "minimal", "coords": "minimal", "compat": "override", "join": "override"}
    found = table(xr.concat([base, changed], "run", **how), "run_x")
    return found.sel(case=sorted(found["case"].values.tolist()))


def scaled_ratios(dataset: xr.Dataset, setting: str, shape: str) -> dict[float, Comparison]:
    """Drag over that at factor 1, by factor; only runs that differ in velocity are on the same
    beds."""
    drag = scaled(dataset, setting, shape).get("drag")
    found = {}
    for x in [] if drag is None else drag["case"].values.tolist():
        a, b = (drag.sel(case=each).values for each in (x, 1.0))
        ratio = Comparison("drag", a, b, 0.0, np.inf, paired=setting == "velocity")
        if x != 1.0 and ratio.runs > 1:
            found[x] = ratio
    return found


def from_study(dataset: xr.Dataset, margin: float = MARGIN) -> Evidence:
    """From claims.nc."""
    case, _, _ = reference(dataset)
    shape = str(dataset["reference_shape"].values)
    return Evidence(
        first_come(table(rows(dataset, "replicates")), case),
        first_come(table(rows(dataset, "sensitivity"), along="run_point"), case),
        scaled(dataset, "velocity", shape),
        table(rows(dataset, "ratios", "equal fraction"), "run_x"),
        margin,
    )


def from_sweep(dataset: xr.Dataset, flow: xr.Dataset | None = None, margin=MARGIN) -> Evidence:
    """From drag.nc and, for what is said of the flow, the flow.nc beside it."""
    curve = dataset["drag"].rename(displacement="place")
    runs = xr.Dataset({"drag": summarise(dataset)["run_mean"], "curve": curve})
    runs.attrs |= {name: dataset.attrs[name] for name in ("window_start", "window_stop")}
    if flow is not None:
        runs |= {name: in_window(flow, name) for name in MEASURES}
    return Evidence(runs, margin=margin)


def curves(runs: xr.Dataset, case: str) -> np.ndarray:
    """Drag (runs, place) in N along the averaging window, of runs that did not fail."""
    low, high = runs.attrs["window_start"], runs.attrs["window_stop"]
    some = runs["curve"].sel(case=case)
    found = within(some.rename(place="displacement"), low, high).values
    return found[np.isfinite(found).all(axis=1)]
