"""Which beds are grown until they jam."""

from dem.claims.changes import changed
from dem.claims.trials import ellipse_label, reference, seeds
from dem.config import Replicate, Sweep
from dem.errors import InputError

RATIOS = "ratios"


def shapes(sweep: Sweep) -> list[str]:
    """Shapes whose jamming fraction is asked for, and "ratios" for ellipses of all ratios."""
    first, _ = reference(sweep)
    return list(dict.fromkeys([first, *sweep.claims.matched.shapes])) + [RATIOS]


def frictions(sweep: Sweep) -> list[float]:
    """Coefficients with which beds are grown: none, and that of the run."""
    return sorted({0.0, sweep.friction.granule})


def beds_of(sweep: Sweep, label: str) -> dict[str, list[Replicate]]:
    """Runs by label, whose beds are grown; raises InputError for a label that is not asked for."""
    if label not in shapes(sweep):
        raise InputError(f"shape is {label!r}; there are {', '.join(shapes(sweep))}.")
    _, density = reference(sweep)
    some = seeds(sweep, sweep.claims.jamming.seeds)
    if label != RATIOS:
        return {label: [changed(sweep, {}, label, density, seed) for seed in some]}
    shape, ratios = sweep.claims.ratios.shape, sweep.claims.ratios.ratios
    return {
        ellipse_label(ratio): [
            changed(sweep, {f"shapes.{shape}.aspect_ratio": ratio}, shape, density, seed)
            for seed in some
        ]
        for ratio in ratios
    }
