"""claims.nc: one row per run of the sweep, and one per bed that grows until it jams.

The first word of a block's name is the part of the study.
"""

import numpy as np

from dem.base.errors import InputError
from dem.base.refusals import parsed
from dem.experiment.kinds import drag
from dem.experiment.observables.alignment import VARIABLES as ALONG
from dem.experiment.replicate import Replicate
from dem.io.dataset import FAILURES
from dem.sweep.design import Choice, Design, Range
from dem.sweep.expand import Block
from dem.sweep.precision import GridPoint
from studies.claims import IRREGULARITY
from studies.common.results import along, columns, runs

TITLE = "which claims hold"
VARIABLES = (
    along(
        "run",
        part=(None, "part of the study: replicates, sensitivity, matched, ratios or scaling"),
        case=(None, "case, or shape where there is no case"),
        shape=(None, "label of the shape"),
        setting=(None, "what is equal or varied"),
        x=(
            "1",
            "what varies: packing fraction (matched), aspect ratio (ratios), factor on the sweep's value (scaling)",
        ),
        point=("1", "point of the design, -1 for runs of other parts"),
        seed=("1", "seed of the replicate"),
        density=("kg m-3", "density of the granules"),
        packing=("1", "packing fraction"),
        status=(None, "ran, or the error that stopped the run"),
        drag=("N", "mean drag in the window, NaN where the run failed"),
        spent=(
            "s",
            "processor time of bed, run and measures, with compiling where it was the first",
        ),
        non_affine=("1", "mean of D2min over the squared diameter in the window"),
        fluctuation=(
            "1",
            "mean distance of a granule from the motion of its neighbours, over that of the cylinder, in the window",
        ),
        mixing=(
            "1",
            "share of pairs side by side that are of different layers, less that at the start, mean in the window",
        ),
        contacts_lost=("1", "share of contacts lost in a lag, mean in the window"),
        factor=(
            "1",
            "values of the design, SI units; of a choice, its number; NaN for other parts",
            "factor",
        ),
        curve=("N", "drag along the displacement", "place"),
        alignment=(
            "1",
            "mean of cos 2(angle - direction of motion) of the granules near the cylinder",
            "moment",
        ),
        alignment_start=(
            "1",
            "the same with the angles that these granules had at the start",
            "moment",
        ),
        streaming=(
            "1",
            "mean of cos 2(angle - direction of motion past the cylinder) of the granules near it",
            "moment",
        ),
        streaming_start=(
            "1",
            "the same with the angles that these granules had at the start",
            "moment",
        ),
    )
    | {
        "reference_shape": (
            (),
            None,
            "shape to which others are compared: that of the sweep's first case",
        ),
        "reference_density": ((), "kg m-3", "density of the sweep's first case"),
        "reference_packing": ((), "1", "packing fraction of the sweep"),
        "factor": (("factor",), None, "value of the configuration, by its path"),
        "place": (("place",), "m", "displacement of the cylinder"),
        "moment": (("moment",), "m", "displacement of the cylinder at the end of the motion"),
    }
    | along(
        "jam",
        shape=(None, "label of the shape, or aspect ratio of an ellipse"),
        diameter=("m", "mean volume diameter of the granules"),
        seed=("1", "seed of the bed"),
        friction=("1", "coefficient of friction while the granules grow"),
        fraction=("1", "packing fraction at which the bed jams"),
        slope=("1", "slope of load^(2/3) against packing fraction"),
    )
)
PARTS = ("replicates", "sensitivity", "jamming")  # without which there is no study
PLACES = 500  # of the drag along the displacement, at most


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    sweep = state.sweep
    for part in PARTS:
        if part not in sweep.blocks:
            raise InputError(f"sweep.blocks has no {part}; see studies/claims/sweep.yaml.")
    spec = sweep.blocks["sensitivity"].get("point")
    factors = parsed(Design, spec, "sweep.blocks.sensitivity.point").over
    beds = [name for name in sweep.blocks if name.partition("_")[0] == "jamming"]
    others = [name for name in sweep.blocks if name not in beds]
    of_beds = runs(state, ("jam_fraction", "jam_slope", "failure"), beds)
    names = "drag", *IRREGULARITY, *ALONG, "spent", "failure"
    of_runs = runs(state, names, others, progress)
    first = next(iter(sweep.cases.values()))
    return {
        **columns("run", [row_of_run(*run, factors) for run in of_runs]),
        **columns("jam", [row_of_bed(*bed) for bed in of_beds]),
        "factor": np.array(list(factors)),
        "place": coarse(drag.axes(sweep)["displacement"]),
        "moment": drag.axes(sweep)["snapshot_displacement"],
        "reference_shape": np.array(first.shape),
        "reference_density": first.density,
        "reference_packing": sweep.packing.fraction or np.nan,  # none under a pressure
    }, {}


def row_of_run(
    block: Block, point: GridPoint, run: Replicate, values: dict, factors: dict[str, Range | Choice]
) -> dict:
    """What a run is and what came out; NaN and the name of the error where it failed."""
    part, at = block.name.partition("_")[0], coordinates(block, point)
    configuration = run.configuration
    packing, (low, high) = configuration.packing.fraction or np.nan, configuration.record.window
    moved = np.linspace(0.0, configuration.cylinder.stroke, configuration.record.snapshots)
    inside = (moved >= low) & (moved <= high)
    varied = {"matched": packing, "ratios": run.shape.ratio}
    return {
        "part": part,
        "case": at.get("case", "ellipse" if part == "ratios" else run.label),
        "shape": run.label,
        "setting": at.get("setting", ""),
        "x": varied.get(part, float(at.get("factor", np.nan))),
        "point": at.get("point", -1),
        "seed": run.seed,
        "density": run.density,
        "packing": packing,
        "status": FAILURES[int(values["failure"])] if values["failure"] else "ran",
        "drag": values["drag"][drag.in_window(configuration)].mean(),
        "spent": values["spent"],
        "factor": in_design(block, point, factors),
        "curve": coarse(values["drag"]),
        **{name: finite_mean(values[name][inside]) for name in IRREGULARITY},
        **{name: values[name] for name in ALONG},
    }


def row_of_bed(block: Block, point: GridPoint, run: Replicate, values: dict) -> dict:
    """A bed: a shape, ellipses of an aspect ratio, or a shape in another box; and where it jams."""
    at, label = coordinates(block, point), run.label
    if "factor" in at:
        label = f"{label} {block.name.partition('_')[2]} {float(at['factor']):g}"
    elif any(name.endswith("_aspect_ratio") for name in at):
        label = f"{run.shape.ratio:g}:1"
    return {
        "shape": label,
        "diameter": run.shape.diameter,
        "seed": run.seed,
        "friction": run.configuration.packing.friction,
        "fraction": values["jam_fraction"],
        "slope": values["jam_slope"],
    }


def coordinates(block: Block, point: GridPoint) -> dict:
    """Where a run is on the axes of its block, by their names."""
    return {axis.name: axis.coordinate[at] for axis, at in zip(block.axes, point, strict=True)}


def in_design(block: Block, point: GridPoint, factors: dict[str, Range | Choice]) -> np.ndarray:
    """Where a run is in the design (factors,): of a choice its number; NaN for other blocks."""
    if "point" not in block.dims:
        return np.full(len(factors), np.nan)
    at = block.dims.index("point")
    values = block.axes[at].points[point[at]]
    return np.array(
        [
            list(dict.fromkeys(factor.choices)).index(values[path])
            if isinstance(factor, Choice)
            else values[path]
            for path, factor in factors.items()
        ],
        float,
    )


def finite_mean(values: np.ndarray) -> float:
    """Mean of what is a number; NaN where nothing is."""
    good = values[np.isfinite(values)]
    return float(good.mean()) if len(good) else np.nan


def coarse(values: np.ndarray) -> np.ndarray:
    """Means of neighbouring bins, PLACES of them if there are as many."""
    size = max(1, len(values) // PLACES)
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)
