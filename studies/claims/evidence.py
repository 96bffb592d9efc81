"""The runs that claims are tested on, from claims.nc or from the drag.nc of any sweep."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.drag import summarise, within
from studies.claims import IRREGULARITY
from studies.claims.compare import Comparison
from studies.claims.irregularity import in_window

NOTHING = xr.Dataset(coords={"case": [], "seed": []})
NAMES = {"run_factor": "at"}  # values of the design are not those of its axis
LABELS = "run_seed", "run_density"
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
    mask = dataset["run_part"] == part
    if setting is not None:
        mask &= dataset["run_setting"] == setting
    return dataset.isel(run=mask.values)


def with_case(runs: xr.Dataset, *cases: str) -> xr.Dataset:
    """Of some runs those of these cases."""
    return runs.isel(run=runs["run_case"].isin(cases).values)


def table(runs: xr.Dataset, column: str = "run_case", along: str = "run_seed") -> xr.Dataset:
    """Runs in a row as measures over (case, seed); column: what names a case; along: what takes
    the place of a seed. A quantity along the motion counts as its mean within the averaging
    window."""
    if not runs.sizes["run"]:
        return NOTHING
    moved = runs["moment"]
    inside = (moved >= runs.attrs["window_start"]) & (moved <= runs.attrs["window_stop"])
    names = {
        name: NAMES.get(name, name.removeprefix("run_"))
        for name, values in runs.data_vars.items()
        if values.dims[:1] == ("run",) and values.dtype.kind in "if" and name not in LABELS
    }
    measures = runs[list(names)].rename(names).isel(moment=inside.values)
    keys = {"case": ("run", runs[column].values), "seed": ("run", runs[along].values)}
    measures = measures.mean("moment", keep_attrs=True).assign_coords(keys)
    measures = (
        measures.set_index(run=["case", "seed"]).unstack("run").transpose("case", "seed", ...)
    )
    first = np.sort(np.unique(runs[column], return_index=True)[1])
    about = {name: ("case", runs[f"run_{name}"].values[first]) for name in ("shape", "density")}
    return measures.sel(case=runs[column].values[first]).sortby("seed").assign_coords(about)


def reference(dataset: xr.Dataset) -> tuple[str, float, float]:
    """Case to which others are compared, its density (kg/m3) and packing fraction."""
    shape, density = str(dataset["reference_shape"].values), float(dataset["reference_density"])
    runs = rows(dataset, "replicates")
    mask = (runs["run_shape"].values == shape) & (runs["run_density"].values == density)
    cases = runs["run_case"].values[mask]
    return (str(cases[0]) if len(cases) else shape), density, float(dataset["reference_packing"])


def first_come(runs: xr.Dataset, case: str) -> xr.Dataset:
    """A table whose first case is the reference, as dem.analysis.drag expects it."""
    cases = runs["case"].values.tolist()
    return runs.sel(case=sorted(cases, key=lambda name: name != case)) if case in cases else runs


def scaled(dataset: xr.Dataset, setting: str, shape: str) -> xr.Dataset:
    """Runs of a shape by the factor on one of the sweep's values; the replicates are at 1."""
    _, density, _ = reference(dataset)
    part, mine = dataset["run_part"], dataset["run_shape"] == shape
    changed = mine & (part == "scaling") & (dataset["run_setting"] == setting)
    base = mine & (part == "replicates")
    densities = dataset["run_density"].values[base.values]
    if not (changed.any() and len(densities)):
        return NOTHING
    base &= dataset["run_density"] == (density if density in densities else densities[0])
    runs = dataset.assign(run_x=dataset["run_x"].where(part != "replicates", 1.0))
    return table(runs.isel(run=(base | changed).values), "run_x").sortby("case")


def scaled_ratios(dataset: xr.Dataset, setting: str, shape: str) -> dict[float, Comparison]:
    """Drag over that at factor 1, by factor; only runs that differ in velocity are on the same
    beds."""
    drag = scaled(dataset, setting, shape).get("drag")
    ratios = {}
    for x in [] if drag is None else drag["case"].values.tolist():
        a, b = (drag.sel(case=factor).values for factor in (x, 1.0))
        ratio = Comparison(words="drag", a=a, b=b, paired=setting == "velocity")
        if x != 1.0 and ratio.runs > 1:
            ratios[x] = ratio
    return ratios


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
        runs |= {name: in_window(flow, name) for name in IRREGULARITY}
    return Evidence(runs, margin=margin)


def curves(runs: xr.Dataset, case: str) -> np.ndarray:
    """Drag (runs, place) in N along the averaging window, of runs that did not fail."""
    low, high = runs.attrs["window_start"], runs.attrs["window_stop"]
    some = runs["curve"].sel(case=case)
    drag = within(some.rename(place="displacement"), low, high).values
    return drag[np.isfinite(drag).all(axis=1)]
