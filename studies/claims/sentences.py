"""The paper's sentences, one function each: from runs to what decides whether the sentence holds.

A function takes Evidence and returns numbers with intervals (compare.py), none where the
runs do not suffice. Its docstring says how the sentence is read: a plain comparative means any
difference; "significantly", "remarkable", "much" and "strongly" mean one beyond `margin`, and
"little" and "insignificant" one within it. A new claim is a function here; tables and figures find
it.

We do not test sentences that only describe appearance: "no dramatic differences in qualitative
particle flow behavior", "little qualitative difference in flow patterns" (3.3).
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dem.analysis.drag import densities, find
from studies.claims import IRREGULARITY
from studies.claims.compare import Comparison, Growth, Prediction
from studies.claims.evidence import Evidence, curves
from studies.claims.influence import plane, slopes

INFINITE = math.inf
PAPERS_RUNS = 5
DRAWS = 4000
SLOW = 5.0  # times the paper's velocity: up to here a claim about slow drag is tested


class Claim(NamedTuple):
    """A sentence: name, place in the paper, quotation, what it takes to be tested."""

    name: str
    place: str
    quote: str
    compare: Callable[[Evidence], list]

    @property
    def reading(self) -> str:
        """How the sentence is read, in one line."""
        return " ".join(self.compare.__doc__.split())

    @property
    def title(self) -> str:
        """The name in words."""
        return self.name.replace("_", " ")

    @property
    def section(self) -> str:
        """Its place in words."""
        return self.place if self.place[0].isalpha() else f"section {self.place}"


CLAIMS: list[Claim] = []


def claim(place: str, quote: str):
    """Decorator: the function decides this sentence of the paper."""

    def add(compare):
        CLAIMS.append(Claim(compare.__name__, place, quote, compare))
        return compare

    return add


def case_of(evidence: Evidence, shape: str) -> str | None:
    """Case of a shape at the density of the first case."""
    return find(evidence.runs, shape) if evidence.runs["case"].size else None


def values(runs, measure: str, case) -> np.ndarray | None:
    """Values (seed,) of a case, NaN where a run failed; None if there are none."""
    if measure not in runs or case is None or case not in runs["case"].values:
        return None
    sample = runs[measure].sel(case=case).values
    return sample if np.isfinite(sample).any() else None


def ratio(runs, measure, one, other, low=0.0, high=INFINITE, **how) -> list[Comparison]:
    """Ratio of a measure between the cases `one` and `other`, if there are both."""
    a, b = values(runs, measure, one), values(runs, measure, other)
    if a is None or b is None:
        return []
    words = f"{IRREGULARITY.get(measure, measure)}, {one} / {other}"
    return [Comparison(words=words, a=a, b=b, low=low, high=high, **how)]


def shapes(evidence: Evidence, measure, one: str, *others: str, low=0.0, high=INFINITE, **how):
    """The same of a shape and of each of others, at the density of the first case."""
    case = case_of(evidence, one)
    parts = (
        ratio(evidence.runs, measure, case, case_of(evidence, other), low, high, **how)
        for other in others
    )
    return all_of(*parts)


def all_of(*parts: list) -> list:
    """All parts of a claim; none if one of them cannot be tested."""
    return [comparison for part in parts for comparison in part] if all(parts) else []


def near(share: float) -> dict[str, float]:
    """Bounds of a ratio that is 1 to within a share."""
    return {"low": 1.0 - share, "high": 1.0 + share}


@claim(
    "abstract", "the drag in dumbbell-shaped granules is higher than that in cylindrical granules"
)
def drag_higher_in_dumbbells_than_discs(evidence):
    """Mean drag in d1 relative to c1 is above 1."""
    return shapes(evidence, "drag", "d1", "c1", low=1.0)


@claim(
    "3.3",
    "dumbbell-shaped particles exhibit less drag than cylindrical particles of equal effective diameter",
)
def drag_lower_in_dumbbells_than_discs(evidence):
    """Mean drag in d1 relative to c1 is below 1: the opposite of the previous claim."""
    return shapes(evidence, "drag", "d1", "c1", high=1.0)


@claim(
    "3.3",
    "dumbbell-shaped particles show significantly higher drag than cylindrical particles if the diameter of the two sub-particles in the dumbbell is equal to the cylinder diameter",
)
def drag_higher_in_dumbbells_than_small_discs(evidence):
    """Mean drag in d1 relative to c2, discs of the size of its lobes, is above 1 by more than the
    margin."""
    return shapes(evidence, "drag", "d1", "c2", low=1.0 + evidence.margin)


@claim(
    "3.3", "there is a remarkable drop in drag force when the granules are made slightly elliptical"
)
def drag_falls_for_slightly_elongated_ellipses(evidence):
    """Mean drag in e1 relative to c1 is below 1 by more than the margin."""
    return shapes(evidence, "drag", "e1", "c1", high=1.0 - evidence.margin)


@claim(
    "3.3",
    "Further increases in aspect ratio for cases e2 and e3 result in further drops in the calculated drag force",
)
def drag_falls_further_for_longer_ellipses(evidence):
    """Mean drag in e2 relative to e1, and in e3 relative to e2, are both below 1."""
    return all_of(
        shapes(evidence, "drag", "e2", "e1", high=1.0),
        shapes(evidence, "drag", "e3", "e2", high=1.0),
    )


@claim("abstract", "the drag in elliptical granules decreases as the aspect ratio increases")
def drag_falls_with_aspect_ratio(evidence):
    """A line of the logarithm of the drag through all runs from round to 1.375 falls."""
    if not evidence.ratios["case"].size:
        return []
    ratios = evidence.ratios["case"].values
    drag = evidence.ratios["drag"].sel(case=ratios[ratios <= 1.375]).values
    x = np.repeat(ratios[ratios <= 1.375], drag.shape[1])
    good = np.isfinite(drag.ravel()) & (drag.ravel() > 0.0)
    if len(set(x[good])) < 2 or good.sum() < 4:
        return []
    slope, error, free = plane(x[good, None], np.log(drag.ravel()[good]))
    fitted = {"logarithm": 0.1 * slope[0], "error": 0.1 * error[0], "freedom": free}
    return [Growth(words="drag, each 0.1 of aspect ratio", **fitted, low=0.0, high=1.0)]


@claim(
    "3.2",
    "The differences in these drag force values are within the standard deviation of the drag force itself",
)
def codes_agree(evidence):
    """Mean drag in e0 relative to c1, on the same beds, is 1 to within the margin."""
    return shapes(evidence, "drag", "e0", "c1", **near(evidence.margin), paired=True)


@claim(
    "3.2",
    "The average drag forces and standard deviations for the elliptical and cylindrical codes are 1405 N and 17%, and 1295 N and 18%",
)
def means_and_scatter_as_reported(evidence):
    """What five runs give: the ratio of the means, and the standard deviation along the mean curve
    of five runs relative to its mean (3.1: all results are such averages); the report lies in their
    range."""
    cases = case_of(evidence, "e0"), case_of(evidence, "c1")
    if evidence.single or None in cases or "curve" not in evidence.runs:
        return []
    drawn = [fives(evidence.runs, case) for case in cases]
    if any(sample is None for sample in drawn):
        return []
    (e_mean, e_scatter), (c_mean, c_scatter) = drawn
    e0, c1 = cases
    reported = {
        f"drag, {e0} / {c1}": (e_mean / c_mean, 1.085, 0.0005),
        f"scatter of {e0}": (e_scatter, 0.17, 0.005),
        f"scatter of {c1}": (c_scatter, 0.18, 0.005),
    }
    how = {"runs": PAPERS_RUNS, "is_ratio": False}
    return [
        Prediction(words=f"five runs: {words}", draws=draws, low=at - off, high=at + off, **how)
        for words, (draws, at, off) in reported.items()
    ]


def fives(runs, case):
    """Mean (N) and scatter along the mean curve of five runs of a case, drawn many times; None with
    too few runs to draw from."""
    some = curves(runs, case)
    if len(some) < 2 * PAPERS_RUNS:
        return None
    rng = np.random.default_rng(sum(map(ord, str(case))))
    chosen = np.array([rng.choice(len(some), PAPERS_RUNS, replace=False) for _ in range(DRAWS)])
    weight = np.zeros((DRAWS, len(some)))
    np.put_along_axis(weight, chosen, 1.0 / PAPERS_RUNS, axis=1)
    curve = weight @ some
    return curve.mean(axis=1), curve.std(axis=1) / curve.mean(axis=1)


@claim(
    "3.4",
    "Although the density has increased by a factor of 10, the maximum change in drag force is 21.8%",
)
def density_changes_little(evidence):
    """For every shape, on the same beds, ten times the density changes the mean drag by less than
    21.8 %."""
    return _densities(evidence, 0.218)


@claim(
    "3.4",
    "momentum effects are relatively insignificant relative to frictional and compaction forces",
)
def momentum_is_insignificant(evidence):
    """The same, to within the margin."""
    return _densities(evidence, evidence.margin)


def _densities(evidence, within):
    if not evidence.runs["case"].size:
        return []
    pairs = [(cases[-1], cases[0]) for cases in densities(evidence.runs).values()]
    parts = (ratio(evidence.runs, "drag", *pair, **near(within), paired=True) for pair in pairs)
    return all_of(*parts)


@claim("3.4", "there is little effect of velocity on drag behavior")
def velocity_hardly_matters(evidence):
    """On the same beds, the mean drag of c1 at all other velocities, up to five times the paper's,
    is that at the paper's to within the margin."""
    speeds = [x for x in evidence.velocity["case"].values.tolist() if x <= SLOW and x != 1.0]
    allowed = near(evidence.margin)
    parts = (ratio(evidence.velocity, "drag", x, 1.0, **allowed, paired=True) for x in speeds)
    return [
        replace(comparison, words=f"drag, {x:g} / 1 times the velocity")
        for x, comparison in zip(speeds, all_of(*parts), strict=False)
    ]


@claim("3.4", "the compaction forces and friction contribute significantly to the drag force")
def compaction_and_friction_matter(evidence):
    """Over the design, from the lowest to the highest packing fraction, and friction between
    granules, the drag of c1 grows by more than the margin."""
    points = evidence.points
    drag = values(points, "drag", find(points, "c1")) if points["case"].size else None
    fitted = None if drag is None else slopes(points, drag)
    if fitted is None:
        return []
    names, _, _, (slope, error, free) = fitted
    low = 1.0 + evidence.margin
    growths = dict(zip(names, zip(slope, error, strict=True), strict=True))
    comparisons = []
    for path in filter(growths.get, ("packing.fraction", "friction.granule")):
        logarithm, scatter = growths[path]
        fitted = {"logarithm": logarithm, "error": scatter, "freedom": free}
        words = f"drag of c1, over the range of {path}"
        comparisons.append(Growth(words=words, **fitted, low=low, high=INFINITE))
    return comparisons


@claim(
    "abstract",
    "The flow pattern in elliptical granules is also shown to be much more irregular compared with that of cylindrical and dumbbell-shaped granules",
)
def ellipses_flow_irregularly(evidence):
    """Non-affine motion (D2min relative to the squared diameter) in e3, the longest, is above that in c1
    and in d1 by more than the margin."""
    return shapes(evidence, "non_affine", "e3", "c1", "d1", low=1.0 + evidence.margin)


@claim(
    "4",
    "the flow pattern in elliptical granules with an aspect ratio of 1.375 is much more irregular than those of lower aspect ratios",
)
def long_ellipses_flow_irregularly(evidence):
    """Non-affine motion in e3 is above that in e1 and in e2 by more than the margin."""
    return shapes(evidence, "non_affine", "e3", "e1", "e2", low=1.0 + evidence.margin)


@claim(
    "3.3",
    "shows a significantly large mixing zone, with more randomness imparted to the granular bed",
)
def long_ellipses_mix(evidence):
    """Mixing of layers (share of neighbours of different layers, less that at the start) in e3 is
    above that in c1, e1 and e2, the cases it is compared with, by more than the margin."""
    return shapes(evidence, "mixing", "e3", "c1", "e1", "e2", low=1.0 + evidence.margin)


@claim(
    "3.3",
    "This drop in drag force could result from the ability of elongated particles to align with the particle flow direction during drag",
)
def ellipses_align(evidence):
    """A necessary condition: near the cylinder the long axes of e1, e2 and e3 lie along the motion
    of the granules (mean of cos 2(angle - direction)) more than they would with their angles at the
    start."""
    parts = []
    for case in (case_of(evidence, shape) for shape in ("e1", "e2", "e3")):
        now, before = (
            values(evidence.runs, name, case) for name in ("alignment", "alignment_start")
        )
        known = now is not None and before is not None
        words = f"alignment gained, {case}"
        parts.append([Comparison(words=words, a=now - before, is_ratio=False)] if known else [])
    return all_of(*parts)


@claim("4", "the granule shape strongly influences the drag force")
def shape_matters(evidence):
    """Mean drags in d1, e1 and e3 relative to c1 differ from 1, in any sense, by more than the
    margin; at equal packing fraction, not at equal distance from jamming."""
    allowed = near(evidence.margin)
    parts = (
        shapes(evidence, "drag", one, "c1", **allowed, outside=True) for one in ("d1", "e1", "e3")
    )
    return all_of(*parts)
