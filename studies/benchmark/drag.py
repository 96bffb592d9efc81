"""What a user pays: time for a stroke of the cylinder at equal error of the mean drag.

Chaos parts two runs of one bed, whatever their time steps, so the error of the drag shows only in
the mean over beds. That mean is level over small steps. Beyond some step contacts are unstable, and
it falls. A level and a straight line that leaves it give the largest step at which a code keeps the
drag within TOLERANCE of its own level: the models of friction and damping differ, and so do levels.
"""

import time
from functools import partial

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.errors import RunError
from dem.base.statistics import Estimate, bootstrap_interval
from dem.dynamics.simulation import STEP_FRACTION, Simulation
from dem.sweep.config import Sweep
from studies.benchmark.scenes import Case, packed
from studies.common.peers import lammps
from studies.common.results import first_seed

TOLERANCE = 0.01  # of the mean drag
KINKS = 200  # steps that are tried as the end of the level
DRAWS = 2000  # of the beds
SEED = 1
SAMPLED = 10  # steps from one look at the force in LAMMPS to the next


def our_drag(case: Case, time_step: float, window) -> tuple[float, float]:
    """Mean drag (N) between two displacements (m) of the cylinder, and processor time (s) up to
    there."""
    start, stop = (x / case.scene.solids[0].velocity[1] for x in window)
    run = Simulation(case.scene, case.state, time_step, allow_unstable=True)
    began = time.process_time()
    run.advance(start)
    record = run.record(stop - start, 1)
    drag = -float(record.normal_force[0, 0, 1] + record.tangential_force[0, 0, 1])
    return drag, time.process_time() - began


def lammps_drag(case: Case, time_step: float, window, same: bool = False) -> tuple[float, float]:
    """The same; see studies.common.peers.lammps.run."""
    start, stop = (round(x / case.scene.solids[0].velocity[1] / time_step) for x in window)
    legs = lammps.run(case.scene, case.state, time_step, (start, stop - start), same, SAMPLED)
    before, up_to = (leg.force[1] for leg in legs)
    spent = sum(leg.processor_time for leg in legs)
    return -float(stop * up_to - start * before) / (stop - start), spent


# By code, and the time steps over the bound on the critical one, at rest: about where its drag falls
WAYS = {
    "dem": (our_drag, (0.6, 1.0, 1.2, 1.4, 1.6)),
    "LAMMPS": (lammps_drag, (0.5, 0.65, 0.75, 0.85, 0.95)),
    "LAMMPS, our law": (partial(lammps_drag, same=True), (1.0, 1.5, 1.8, 2.1, 2.4)),
}


def compare_drag(sweep: Sweep, beds: int, ways=WAYS) -> dict:
    """Drag and processor time of strokes of the codes, in turns; NaN where a run fails or a code is
    missing."""
    fractions = np.array([steps for _, steps in ways.values()])
    drag, spent = np.full((2, *fractions.shape, beds), np.nan)
    bounds, window = np.empty(beds), sweep.record.window
    disc = next(label for label, shape in sweep.shapes.items() if shape.kind == "disc")
    for bed in range(beds):
        case = packed(sweep, disc, first_seed(sweep) + bed)
        bounds[bed] = case.time_step / STEP_FRACTION
        for code, (name, (way, steps)) in enumerate(ways.items()):
            for level, fraction in enumerate(steps):
                if name.startswith("LAMMPS") and lammps.available() is not None:
                    continue
                try:
                    values = way(case, fraction * bounds[bed], window)
                except RunError:
                    continue
                drag[code, level, bed], spent[code, level, bed] = values
    return {
        "drag_code": np.array(list(ways)),
        "drag_fraction": fractions,
        "drag_bound": bounds,
        "drag_stroke": window[1],
        "drag_speed": sweep.cylinder.velocity,
        "drag_mean": drag,
        "drag_time": spent,
    }


def largest_step(fractions, drag, tolerance: float = TOLERANCE) -> Estimate:
    """Largest time step that keeps the mean over the beds (level, bed) within a tolerance, over the
    bound; fractions (level,). Beds are drawn again for the interval; one with a failed run is left
    out."""
    drag = drag[:, np.isfinite(drag).all(axis=0)]
    beds = drag.shape[1]
    drawn = np.random.default_rng(SEED).integers(beds, size=(DRAWS, beds))
    means = np.vstack([drag.mean(axis=1), drag[:, drawn].mean(axis=2).T])
    kinks = np.linspace(fractions[1], fractions[-2], KINKS)
    beyond = np.maximum(0.0, fractions - kinks[:, None])
    x, y = (values - values.mean(axis=1, keepdims=True) for values in (beyond, means))
    products, squares = y @ x.T, np.sum(x * x, axis=1)
    best = np.argmax(products**2 / squares, axis=1)
    slope = products[np.arange(len(y)), best] / squares[best]
    level = means.mean(axis=1) - slope * beyond.mean(axis=1)[best]
    return bootstrap_interval(kinks[best] + tolerance * level / np.abs(slope), beds)


def at_equal_error(dataset: xr.Dataset) -> pd.DataFrame:
    """By code that ran: `largest` step with its interval `low`, `high`, over the bound; `time_step`
    (s); `rate`, steps a second; `cost`, processor time of a stroke (s/m)."""
    rows = {}
    for code in dataset["drag_code"].values.tolist():
        one = dataset.sel(drag_code=code)
        fractions, drag = one["drag_fraction"].values, one["drag_mean"].values
        if not np.isfinite(drag).any():
            continue
        largest = largest_step(fractions, drag)
        time_step = largest.value * float(one["drag_bound"].mean())
        steps = one["drag_stroke"] / one["drag_speed"] / (one["drag_fraction"] * one["drag_bound"])
        rates = (steps / one["drag_time"]).median("drag_bed").values
        rate = np.interp(largest.value, fractions, rates)
        cost = 1.0 / (time_step * rate * float(one["drag_speed"]))
        rows[code] = *largest, time_step, rate, cost
    names = ["largest", "low", "high", "time_step", "rate", "cost"]
    return pd.DataFrame.from_dict(rows, "index", columns=names)
