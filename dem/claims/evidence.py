"""The runs that claims are tested on, from claims.nc or from the drag.nc of any sweep."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.flow.layout import MEASURES
from dem.statistics import summarise, within

NOTHING = xr.Dataset(coords={"case": [], "seed": []})
NAMES = {"run_factor": "at"}  # values of the design are not those of its axis
NO_MEASURES = (
    "run_part",
    "run_case",
    "run_shape",
    "run_setting",
    "run_status",
    "run_seed",
    "run_density",
)


class Evidence(NamedTuple):
    """Measures over (case, seed), SI units, NaN where a run failed.

    runs: of the sweep's cases; points: of cases at the points of the design, which stand for seeds,
    with `at` (case, seed, factor), where they lie; velocity: of the first shape, cases are factors on
    the sweep's velocity.
    """

    runs: xr.Dataset
    points: xr.Dataset = NOTHING
    velocity: xr.Dataset = NOTHING

    def at_points(self) -> "Evidence":
        """The points of the design in place of the runs: every seed is another world."""
        return Evidence(self.points)


def rows(dataset: xr.Dataset, part: str, setting: str | None = None) -> xr.Dataset:
    """Runs of one part of the study, and of one setting in it."""
    here = dataset["run_part"] == part
    if setting is not None:
        here &= dataset["run_setting"] == setting
    return dataset.isel(run=np.flatnonzero(here.values))


def table(runs: xr.Dataset, column: str = "run_case", along: str = "run_seed") -> xr.Dataset:
    """Runs in a row as measures over (case, seed); column: what names a case; along: what stands
    for a seed. `alignment` and `streaming` are means over the averaging window."""
    if not runs.sizes["run"]:
        return NOTHING
    keys, numbers = runs[column].values.tolist(), runs[along].values.tolist()
    cases, seeds = list(dict.fromkeys(keys)), sorted(set(numbers))
    at = [cases.index(key) for key in keys], [seeds.index(number) for number in numbers]
    found = {}
    for name in (n for n in runs.variables if "run" in runs[n].dims and n not in NO_MEASURES):
        values = _in_window(runs, name)
        room = np.full((len(cases), len(seeds), *values.shape[1:]), np.nan)
        room[at] = values
        found[NAMES.get(name, name.removeprefix("run_"))] = (
            ("case", "seed", *_others(runs, name)),
            room,
        )
    first = [keys.index(case) for case in cases]
    about = {n: ("case", runs[f"run_{n}"].values[first]) for n in ("shape", "density")}
    axes = {
        name: runs[name].values
        for name in ("factor", "place")
        if name in runs.coords or name in runs
    }
    return xr.Dataset(found, {"case": cases, "seed": seeds, **axes, **about}, runs.attrs)


def _others(runs, name):
    """Dimensions of a variable that its table keeps beside case and seed."""
    return [dim for dim in runs[name].dims[1:] if dim != "moment"]


def _in_window(runs, name):
    """Values (run, ...), along the motion their mean within the averaging window."""
    array = runs[name]
    if "moment" in array.dims:
        low, high = runs.attrs["window_start"], runs.attrs["window_stop"]
        inside = (runs["moment"] >= low) & (runs["moment"] <= high)
        array = array.isel(moment=np.flatnonzero(inside.values)).mean("moment")
    return array.values.astype(float)


def from_study(dataset: xr.Dataset) -> Evidence:
    """From claims.nc."""
    return Evidence(
        table(rows(dataset, "replicates")),
        table(rows(dataset, "sensitivity"), along="run_point"),
        table(rows(dataset, "scaling", "velocity"), "run_x"),
    )


def from_sweep(dataset: xr.Dataset, flow: xr.Dataset | None = None) -> Evidence:
    """From drag.nc and, for what is said of the flow, the flow.nc beside it."""
    drag = within(dataset["drag"], dataset.attrs["window_start"], dataset.attrs["window_stop"])
    mean = summarise(dataset)["run_mean"]
    runs = xr.Dataset({"drag": mean, "scatter": (drag.std("displacement") / mean).compute()})
    if flow is not None:
        from dem.flow.verdict import in_window

        for name in MEASURES:
            runs[name] = in_window(flow, name)
    return Evidence(runs)
