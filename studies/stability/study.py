"""Run the catalogue and the linearised beds: variables by the names of layout.py."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from dem.base.errors import InputError, RunError
from dem.sweep.config import Sweep
from studies.stability import beds, bodies, linear
from studies.stability.catalogue import QUANTITIES, RAN, Case, Catalogue, Changes
from studies.stability.scenes import start

# what an experiment may change of the sweep, and what it needs
FREE = {"stiffness", "density", "restitution", "aspect_ratio", "step"}
BED = FREE | {"velocity", "fraction", "friction"}


class Experiment(NamedTuple):
    """A function of beds.py or bodies.py, the changes that it takes, and those that it needs."""

    work: Callable
    takes: set[str]
    needs: set[str] = frozenset()


EXPERIMENTS = {
    each.work.__name__: each for each in (
        Experiment(beds.draw, BED | {"displacement"}),
        Experiment(beds.rest, BED | {"steps"}),
        Experiment(beds.accelerate, BED | {"displacement"}),
        Experiment(beds.follow, {"stiffness", "density"}),
        Experiment(beds.restart, BED | {"displacement"}),
        Experiment(beds.round_off, BED | {"steps"}, {"aspect_ratio"}),
        Experiment(bodies.gas, FREE | {"collisions"}),
        Experiment(bodies.cluster, FREE),
        Experiment(bodies.sizes, FREE),
        Experiment(bodies.overlapped, FREE | {"overlap"}, {"overlap"}),
        Experiment(bodies.concentric, FREE),
        Experiment(bodies.impact, FREE | {"overlap"}, {"overlap"}),
        Experiment(bodies.pinch, FREE | {"overlap"}, {"overlap"}),
        Experiment(bodies.graze, FREE),
    )
}  # fmt: skip
GROWN = 1.0 + 1e-6  # growth of a small motion in a step that counts as such


def check(sweep: Sweep, catalogue: Catalogue) -> None:
    """Raise InputError where a case names an experiment, a change or a shape that is not there."""
    for name, case in catalogue.cases.items():
        if case.experiment not in EXPERIMENTS:
            raise InputError(
                f"cases.{name}.experiment is {case.experiment!r}; there are {', '.join(EXPERIMENTS)}."
            )
        experiment, told = EXPERIMENTS[case.experiment], case.change.model_fields_set
        for word, wrong in (
            ("takes no", told - experiment.takes),
            ("needs", experiment.needs - told),
        ):
            if wrong:
                raise InputError(
                    f"cases.{name}.change: the experiment {case.experiment} {word} {min(wrong)}."
                )
    unknown = {*catalogue.shapes, *catalogue.limits.shapes} - set(sweep.shapes)
    if unknown:
        raise InputError(
            f"the catalogue has the shape {min(unknown)!r}, which is not one of shapes: "
            f"{', '.join(sweep.shapes)}."
        )


def perform(sweep: Sweep, shape: str, case: Case) -> tuple[dict, str, str]:
    """What was measured, outcome (RAN or the name of the error) and what the error said."""
    try:
        return EXPERIMENTS[case.experiment].work(sweep, shape, case.change), RAN, ""
    except (InputError, RunError) as error:
        return {}, type(error).__name__, str(error)


def verdicts(sweep: Sweep, shape: str, name: str, case: Case) -> list[tuple]:
    """Rows of the catalogue for one case: one per limit, or one for a refusal."""
    found, outcome, message = perform(sweep, shape, case)
    rows = []
    for quantity, limit in (case.limits or {"refusal": math.nan}).items():
        value = float(found.get(quantity, math.nan))
        passed = outcome == case.expect and (outcome != RAN or value <= limit)
        listed = case.known and outcome == case.expect and value <= case.known.limit
        known = case.known.why if listed else ""
        words = QUANTITIES.get(quantity, f"refused with {case.expect}")
        rows.append(
            (
                name,
                shape,
                words,
                value,
                limit,
                case.expect,
                outcome,
                message,
                known,
                int(passed),
            )
        )
    return rows


def run_catalogue(sweep: Sweep, catalogue: Catalogue, shape: str, progress=lambda done: None):
    """One row per case and limit, of one shape."""
    rows, cases = [], {n: c for n, c in catalogue.cases.items() if shape in c.shapes}
    for done, (name, case) in enumerate(cases.items()):
        rows += verdicts(sweep, shape, name, case)
        progress((done + 1) / len(cases))
    names = (
        "case", "shape", "quantity", "value", "limit", "expected", "outcome", "message",
        "known", "passed",
    )  # fmt: skip
    columns = zip(*rows, strict=True)
    return {f"check_{name}": np.array(c) for name, c in zip(names, columns, strict=True)}


def run_limits(sweep: Sweep, catalogue: Catalogue, shape: str) -> dict:
    """The bound of the critical step beside the true limit, of a small bed, linearised."""
    wanted = catalogue.limits
    change = Changes(fraction=wanted.fraction.get(shape))
    simulation = start(linear.small(sweep, shape, wanted.granules, change), still=True)
    bound = simulation.diagnose().critical_time_step
    matrices = linear.matrices(simulation)
    limit = linear.limit(*matrices, bound, GROWN)
    return {
        "limit_shape": np.array([shape]),
        "limit_bound": np.array([bound]),
        "limit_limit": np.array([limit]),
        "limit_growth_bound": np.array([linear.growth(*matrices, bound)]),
        "limit_growth_below": np.array([linear.growth(*matrices, 0.95 * limit)]),
        "limit_growth_above": np.array([linear.growth(*matrices, 1.05 * limit)]),
    }
