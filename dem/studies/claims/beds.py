"""Which beds are grown until they jam."""

from dem.base.errors import InputError
from dem.experiment.config import Replicate, Sweep
from dem.studies.claims.changes import changed
from dem.studies.claims.trials import BOXES as SIDES
from dem.studies.claims.trials import box_label, ellipse_label, reference, scaled, seeds

RATIOS = "ratios"  # in place of a shape: ellipses of all aspect ratios
BOXES = "boxes"  # in place of a shape: boxes of other sizes


def shapes(sweep: Sweep) -> list[str]:
    """Shapes whose jamming fraction is asked for, and the two names above."""
    first, _ = reference(sweep)
    plan = sweep.claims
    return [*dict.fromkeys([first, *plan.matched.shapes, *plan.scaling.shapes]), RATIOS, BOXES]


def frictions(sweep: Sweep, label: str) -> list[float]:
    """Coefficients with which beds are grown: none, and, in the sweep's own box, that of the run."""
    return [0.0] if label == BOXES else sorted({0.0, sweep.friction.granule})


def beds_of(sweep: Sweep, label: str) -> dict[str, list[Replicate]]:
    """Runs by label, whose beds are grown; raises InputError for a label that is not asked for."""
    if label not in shapes(sweep):
        raise InputError(f"shape is {label!r}; there are {', '.join(shapes(sweep))}.")
    found, plan = {label: (label, {})}, sweep.claims
    if label == RATIOS:
        path = f"shapes.{plan.ratios.shape}.aspect_ratio"
        found = {
            ellipse_label(ratio): (plan.ratios.shape, {path: ratio}) for ratio in plan.ratios.ratios
        }
    if label == BOXES:
        found = {
            box_label(shape, setting, x): (shape, scaled(sweep, shape, setting, x))
            for shape in plan.scaling.shapes
            for setting in SIDES
            for x in getattr(plan.scaling, setting)
        }
    some = seeds(sweep, plan.jamming.seeds)
    return {
        name: [changed(sweep, changes, shape, sweep.density_of(shape), seed) for seed in some]
        for name, (shape, changes) in found.items()
    }
