"""Run the catalogue and the linearised beds: variables by the names of layout.py."""

import math

import numpy as np

from dem.base.errors import InputError, RunError
from dem.sweep.config import Sweep
from studies.stability import beds, bodies, linear
from studies.stability.catalogue import QUANTITIES, RAN, Case, Catalogue, Changes
from studies.stability.scenes import start

EXPERIMENTS = {
    each.__name__: each for each in (
        beds.draw, beds.rest, beds.accelerate, beds.follow, beds.restart, beds.round_off,
        bodies.gas, bodies.cluster, bodies.sizes, bodies.overlapped, bodies.concentric,
        bodies.impact, bodies.pinch, bodies.graze,
    )
}  # fmt: skip
GROWN = 1.0 + 1e-6  # growth of a small motion in a step that counts as such


def check(sweep: Sweep, catalogue: Catalogue) -> None:
    """Raise InputError where a case names an experiment or a shape that is not there."""
    for name, case in catalogue.cases.items():
        if case.experiment not in EXPERIMENTS:
            raise InputError(
                f"cases.{name}.experiment is {case.experiment!r}; there are {', '.join(EXPERIMENTS)}."
            )
    unknown = {*catalogue.shapes, *catalogue.limits.shapes} - set(sweep.shapes)
    if unknown:
        raise InputError(
            f"the catalogue has the shape {min(unknown)!r}, which is not one of shapes: "
            f"{', '.join(sweep.shapes)}."
        )


def verdicts(sweep: Sweep, shape: str, name: str, case: Case) -> list[dict]:
    """Rows of the catalogue for one case: one per limit, or one for a refusal."""
    found, outcome, message = {}, RAN, ""
    try:
        found = EXPERIMENTS[case.experiment](sweep, shape, case.change)
    except (InputError, RunError) as error:
        outcome, message = type(error).__name__, str(error)
    rows, right = [], outcome == case.expect
    for quantity, limit in (case.limits or {"refusal": math.nan}).items():
        value = float(found.get(quantity, math.nan))
        known = case.known and right and value <= case.known.limit
        rows.append({
            "case": name, "shape": shape, "value": value, "limit": limit,
            "quantity": QUANTITIES.get(quantity, f"refused with {case.expect}"),
            "expected": case.expect, "outcome": outcome, "message": message,
            "known": case.known.why if known else "",
            "passed": int(right and (outcome != RAN or value <= limit)),
        })  # fmt: skip
    return rows


def run_catalogue(sweep: Sweep, catalogue: Catalogue, shape: str, progress=lambda done: None):
    """One row per case and limit, of one shape."""
    rows, cases = [], {n: c for n, c in catalogue.cases.items() if shape in c.shapes}
    for done, (name, case) in enumerate(cases.items()):
        rows += verdicts(sweep, shape, name, case)
        progress((done + 1) / len(cases))
    return {f"check_{name}": np.array([row[name] for row in rows]) for name in rows[0]}


def run_limits(sweep: Sweep, catalogue: Catalogue, shape: str, progress=lambda done: None) -> dict:
    """The bound of the critical step beside the true limit, of a small bed, linearised."""
    wanted = catalogue.limits
    change = Changes(fraction=wanted.fraction.get(shape))
    simulation = start(linear.small(sweep, shape, wanted.granules, change), still=True)
    bound = simulation.diagnose().critical_time_step
    limit = linear.limit(*linear.matrices(simulation), bound, GROWN)
    found = {"limit_shape": shape, "limit_bound": bound, "limit_limit": limit}
    return {name: np.array([value]) for name, value in found.items()}
