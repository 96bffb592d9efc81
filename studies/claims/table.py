"""claims.nc: one row per run of the sweep, and one per bed that was grown until it jams.

In: the batches of all blocks of the sweep, read one after another. Out: what claims are about, by
the names of layout.py. The first word of a block's name is the part of the study.
"""

from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.base.schema import validated
from dem.experiment.config import Replicate
from dem.experiment.kinds import drag
from dem.experiment.observables.alignment import VARIABLES as ALONG
from dem.io.dataset import FAILURES, global_attributes, write
from dem.sweep.design import Choice, Design, Range
from dem.sweep.expand import Block
from dem.sweep.precision import GridPoint
from dem.sweep.state import SweepState
from studies.claims.layout import MEASURES, VARIABLES
from studies.common.table import origin, rows, wanted_of

PARTS = ("replicates", "sensitivity", "jamming")  # without which there is no study
PLACES = 500  # of the drag along the displacement, at most
OF_RUNS = ("drag", *MEASURES, *ALONG)
OF_BEDS = ("jam_fraction", "jam_slope")


def make(state: SweepState, output: Path, progress=lambda share: None) -> None:
    """Write claims.nc; raises InputError for a sweep that is none of this study, and for runs that
    are not made yet."""
    sweep = state.sweep
    for part in PARTS:
        if part not in sweep.blocks:
            raise InputError(f"sweep.blocks has no {part}; see studies/claims/sweep.yaml.")
    factors = factors_of(sweep)
    runs, beds, every = [], [], []
    for done, name in enumerate(sweep.blocks):
        files, block = state.files(name), state.block(name)
        every += files
        if block.first.configuration.experiment == "jamming":
            found = gather(block, files, OF_BEDS, kept)
            beds += [labels_of_bed(block, *item) | found[item[1].id] for item in block.runs.items()]
        else:
            found = gather(block, files, OF_RUNS, measured)
            runs += [labels(block, *item, factors) | found[item[1].id] for item in block.runs.items()]
        progress((done + 1) / len(sweep.blocks))
    low, high = sweep.record.window
    attrs = global_attributes(
        f"{sweep.title}: which claims hold",
        "python -m studies claims table",
        **origin(every),
        default_fraction=sweep.numerics.step_fraction,
        window_start=low,
        window_stop=high,
    )
    values = columns("run", runs) | columns("jam", beds) | shared(sweep, list(factors))
    write(output, values, attrs, VARIABLES)


def columns(dim: str, rows: list[dict]) -> dict:
    """Rows as variables over a dimension."""
    return {f"{dim}_{name}": np.array([row[name] for row in rows]) for name in rows[0]}


def shared(sweep, factors: list[str]) -> dict:
    """Axes, and to what runs are compared."""
    first, axes = next(iter(sweep.cases.values())), drag.axes(sweep)
    return {
        "factor": np.array(factors),
        "place": coarse(axes["displacement"]),
        "moment": axes["snapshot_displacement"],
        "reference_shape": np.array(first.shape),
        "reference_density": first.density,
        "reference_packing": sweep.packing.fraction or np.nan,  # none under a pressure
    }


def gather(block: Block, files: list[Path], names, reduced) -> dict[str, dict]:
    """What all runs of a block gave, by their identity: reduced(replicate, values, by name)."""
    wanted, found = wanted_of([block]), {}
    for ids, values in rows(files, (*names, "spent", "failure"), wanted):
        for row, run in enumerate(ids):
            one = {name: array[row] for name, array in values.items()}
            found[run] = reduced(wanted[run], one)
    return found


# Runs


def measured(replicate: Replicate, values: dict) -> dict:
    """The numbers of one run, by name; NaN and the name of the error where it failed."""
    own = replicate.configuration
    low, high = own.record.window
    moved = np.linspace(0.0, own.cylinder.stroke, own.record.snapshots)
    seen = (moved >= low) & (moved <= high)
    return {
        "status": FAILURES[int(values["failure"])] if values["failure"] else "ran",
        "drag": values["drag"][own.in_window].mean(),
        "spent": values["spent"],
        **{name: finite_mean(values[name][seen]) for name in MEASURES},
        "curve": coarse(values["drag"]),
        **{name: values[name] for name in ALONG},
    }


def finite_mean(values: np.ndarray) -> float:
    """Mean of what is a number; NaN where nothing is."""
    good = values[np.isfinite(values)]
    return float(good.mean()) if len(good) else np.nan


def coarse(values: np.ndarray) -> np.ndarray:
    """Means of neighbouring bins, PLACES of them if there are as many."""
    size = max(1, len(values) // PLACES)
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)


def labels(
    block: Block, point: GridPoint, own: Replicate, factors: dict[str, Range | Choice]
) -> dict:
    """What a run is."""
    part, at = block.name.partition("_")[0], coordinates(block, point)
    packing = own.configuration.packing.fraction or np.nan
    alone = "ellipse" if part == "ratios" else own.label
    return {
        "part": part,
        "case": at.get("case", alone),
        "shape": own.label,
        "setting": at.get("setting", ""),
        "x": {"matched": packing, "ratios": own.shape.ratio}.get(
            part, float(at.get("factor", np.nan))
        ),
        "point": at.get("point", -1),
        "seed": own.seed,
        "density": own.density,
        "packing": packing,
        "factor": place_of(block, point, factors),
    }


def coordinates(block: Block, point: GridPoint) -> dict:
    """Where a run is on the axes of its block, by their names."""
    return {axis.name: axis.coordinate[i] for axis, i in zip(block.axes, point, strict=True)}


# The design


def factors_of(sweep) -> dict[str, Range | Choice]:
    """What the design varies, by path; raises InputError where there is no design."""
    spec = sweep.blocks["sensitivity"].get("point")
    return validated(Design, spec, at="sweep.blocks.sensitivity.point").over


def place_of(block: Block, point: GridPoint, factors: dict[str, Range | Choice]) -> np.ndarray:
    """Where in the design a run is (factors,): of a choice its number; NaN for other blocks."""
    names = list(block.dims)
    if "point" not in names:
        return np.full(len(factors), np.nan)
    at = names.index("point")
    values = block.axes[at].points[point[at]]
    return np.array([number_of(factor, values[path]) for path, factor in factors.items()])


def number_of(factor: Range | Choice, value) -> float:
    """A value as a number: of a choice, which one it is."""
    different = list(dict.fromkeys(factor.choices)) if isinstance(factor, Choice) else None
    return float(value if different is None else different.index(value))


# Beds that jam


def kept(replicate: Replicate, values: dict) -> dict:
    """Of a bed the variables of the layout."""
    return {name.removeprefix("jam_"): values[name] for name in OF_BEDS}


def labels_of_bed(block: Block, point: GridPoint, own: Replicate) -> dict:
    """What a bed is: a shape, ellipses of an aspect ratio, or a shape in another box."""
    at = coordinates(block, point)
    words = own.label
    if "factor" in at:
        setting = block.name.partition("_")[2]
        words = f"{own.label} {setting} {float(at['factor']):g}"
    elif any(name.endswith("_aspect_ratio") for name in at):
        words = f"{own.shape.ratio:g}:1"
    return {
        "shape": words,
        "diameter": own.shape.diameter,
        "seed": own.seed,
        "friction": own.configuration.packing.friction,
    }
