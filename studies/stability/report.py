"""The study of stability as tables for the terminal."""

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.tables import numbers

NEEDS = ("check_value", "map_residual", "paper_residual")  # variables of the file
ATTRIBUTES = ("default_fraction",)

OFF, BROKEN = 1e-2, 1e-1  # residual beyond which the energy balance fails, and with it the run


def summary(dataset: xr.Dataset) -> Group:
    """Renderable summary of stability.nc."""
    passed, total = int(dataset["check_passed"].sum()), dataset.sizes["check"]
    worst = dataset["paper_residual"].max("paper_displacement")
    each = zip(dataset["paper_case"].values, worst.values, strict=True)
    lines = [
        f"{passed} of {total} checks passed" + _known(dataset) + ".",
        "Worst residual of the energy ledger over the stroke, first seed, default step: "
        + ", ".join(f"{case} {float(value):.1e}" for case, value in each) + ".",
        f"Map: {edges(dataset)}.",
    ]  # fmt: skip
    title = Text(dataset.attrs["title"], style="bold")
    versions = Text(dataset.attrs.get("versions", ""))
    return Group(
        title, versions, catalogue(dataset), limits(dataset), Text("\n".join(lines))
    )  # fmt: skip


def _known(dataset: xr.Dataset) -> str:
    """How many of the others are known limits, and why."""
    columns = (dataset[f"check_{name}"].values for name in ("case", "known", "passed"))
    known = [(str(case), str(words)) for case, words, passed in zip(*columns, strict=True)
             if not passed and words]  # fmt: skip
    if not known:
        return ""
    why = "; ".join(f"{case}: {words}" for case, words in dict(known).items())
    return f", {len(known)} exceed a limit as is known ({why})"


def edge(dataset: xr.Dataset, level: float) -> float:
    """The least step of the map over the bound at which a residual exceeds a level, or infinity."""
    others = "map_shape", "map_stiffness", "map_restitution"
    sound = (dataset["map_residual"] <= level).all(others)
    return float(sound["map_fraction"].where(~sound).min().fillna(np.inf))


def edges(dataset: xr.Dataset) -> str:
    """Where runs break down and where energy is off, beside the default."""
    broken, off = edge(dataset, BROKEN), edge(dataset, OFF)
    default = float(dataset.attrs["default_fraction"])
    if not np.isfinite(off):
        return "Energy adds up at all of these steps"
    words = f"Energy is off by {OFF:.0%} from {off:g} of the bound, {off / default:.1f} times the default step"
    if not np.isfinite(broken):
        return words
    return (
        f"Runs break down or are stopped from {broken:g} of the bound, {broken / default:.1f} times the default; "
        + (f"energy is off by {OFF:.0%} from {off:g}")
    )


def catalogue(dataset: xr.Dataset) -> Table:
    """One row per case, shape and limit."""
    made = numbers("case", "shape", "quantity", "worst", "limit", "outcome", "verdict", words=3)
    names = "case", "shape", "quantity", "value", "limit", "outcome", "known", "passed"
    columns = (dataset[f"check_{name}"].values for name in names)
    for case, shape, quantity, value, limit, outcome, known, passed in zip(*columns, strict=True):
        made.add_row(
            str(case), str(shape), str(quantity),
            f"{value:.1e}" if np.isfinite(value) else "-",
            f"{limit:.0e}" if np.isfinite(limit) else "-", str(outcome),
            "passed" if passed else "known" if known else "FAILED",
        )  # fmt: skip
    return made


def limits(dataset: xr.Dataset) -> Table:
    """The bound beside the true limit of linearised beds."""
    made = numbers(
        "small bed of", "bound, ns", "true limit, ns", "limit over bound", "growth at bound",
        "at 0.95 limit", "at 1.05 limit",
    )  # fmt: skip
    for shape in dataset["limit_shape"].values:
        one = dataset.sel(limit_shape=shape)
        bound, limit = 1e9 * float(one["limit_bound"]), 1e9 * float(one["limit_limit"])
        made.add_row(
            str(shape), f"{bound:.1f}", f"{limit:.1f}", f"{limit / bound:.2f}",
            *(f"{float(one[f'limit_growth_{at}']) - 1.0:+.1e}" for at in ("bound", "below", "above")),
        )  # fmt: skip
    return made
