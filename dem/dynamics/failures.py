"""Why a run stopped, in a sentence.

Between two neighbour lists nothing moves by more than half the skin. A check at each new list
therefore sees every overlap before it has grown by more than the skin.
"""

import numpy as np

from dem.base.errors import InputError, OverlapError, RunError, StateError
from dem.dynamics.stepping import (
    COLLAPSE,
    COLLAPSED,
    LOST,
    MOST_STEPS,
    MOST_WORK,
    OUTSIDE,
    TOO_DEEP,
    TOO_LONG,
    UNSTABLE,
    Progress,
    StepControl,
)
from dem.dynamics.world import World

NOT_A_NUMBER = -1
WHEN = "at step {steps}, time {time:.6g} s"
LESS = "take a smaller time step, a stiffer material or a lower packing fraction"
SENTENCES = {
    NOT_A_NUMBER: f"the motion of granule {{granule}} is not a number {WHEN}: take a smaller time "
    "step.",
    LOST: f"{{what}} moved {{value:.3g}} m before its contacts were listed again {WHEN}; it may "
    "move {reach:.3g} m: take a smaller time step.",
    TOO_LONG: f"the time step has shrunk to {{value:.3g}} s {WHEN}, and what remains would take "
    f"more than {MOST_STEPS:.0e}: granules are too fast for a run of this duration.",
    COLLAPSED: f"the time step has shrunk too far {WHEN}: {{value:.3g}} s is less than "
    f"{COLLAPSE:g} of the first one, and what remains would take more than {{most:.0e}} steps: "
    "granules are too fast.",
    UNSTABLE: "time_step is {time_step:.4g} s, longer than the critical one, {value:.4g} s, "
    f"{WHEN}: make it shorter, leave it out, or set allow_unstable.",
    OUTSIDE: f"granule {{granule}} has its centre {{far:.3g}} m behind wall {{wall}} {WHEN}: "
    "put it inside, or take a smaller time step.",
    TOO_DEEP: f"granule {{granule}} overlaps by {{value:.3g}} of the smaller radius {WHEN}; the "
    "limit is {max_overlap:g}: {remedy}.",
}


@np.errstate(all="ignore")
def failure(report: Progress, rules: StepControl, world: World, order: np.ndarray) -> RunError:
    """The error of a run that a Progress says has stopped; order (n,): numbers of the granules."""
    outcome, granule, what, beyond = report.outcome, report.granule, "a boundary", np.zeros(1)
    finite = np.isfinite(world.bodies).all(axis=1)
    if not finite.all():
        outcome, granule = NOT_A_NUMBER, finite.argmin()
    elif outcome == LOST:
        moved = np.linalg.norm(world.constituents[:, :2] - world.reference, axis=1)
        if moved.max() >= report.value:
            what = f"granule {order[world.shape.owner[moved.argmax()]]}"
    elif outcome == OUTSIDE:
        beyond = world.walls.planes[:, :2] @ world.bodies[granule, :2] - world.walls.planes[:, 2]
    words = SENTENCES[outcome].format(
        **rules._asdict(),
        **report._replace(granule=order[granule])._asdict(),
        most=MOST_WORK / len(order),
        what=what,
        far=beyond.max(),
        wall=beyond.argmax(),
        remedy=LESS if report.steps else "place the granules farther apart",
    )
    return (OverlapError if outcome == TOO_DEEP else StateError)(words)


def endless(name: str, duration: float, step: float) -> InputError:
    """The error of a duration (s) of too many time steps (s), of an argument of that name."""
    return InputError(
        f"{name} is {duration:g} s, more than {MOST_STEPS:.0e} time steps of {step:.3g} s: "
        "granules are too small, stiff, light or fast for it."
    )
