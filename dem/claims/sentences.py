"""The paper's sentences, one function each: from runs to what decides whether the sentence holds.

A function takes Evidence and returns Comparisons, none where the runs do not suffice. Its docstring
says how the sentence is read. A new claim is a function here; tables and figures find it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from dem.claims.compare import Comparison
from dem.claims.evidence import Evidence
from dem.statistics import densities, find

ALIKE = (
    0.18  # share of a drag: the larger of the scatters in section 3.2, by which the paper judges
)
INFINITE = float("inf")


class Claim(NamedTuple):
    """A sentence: name, place in the paper, quotation, what it takes to be tested."""

    name: str
    place: str
    quote: str
    compare: Callable[[Evidence], list[Comparison]]

    @property
    def reading(self) -> str:
        """How the sentence is read, in one line."""
        return " ".join(self.compare.__doc__.split())

    @property
    def title(self) -> str:
        """The name in words."""
        return self.name.replace("_", " ")


CLAIMS: list[Claim] = []


def claim(place: str, quote: str):
    """Decorator: the function decides this sentence of the paper."""

    def add(compare):
        CLAIMS.append(Claim(compare.__name__, place, quote, compare))
        return compare

    return add


def values(runs, measure: str, case) -> np.ndarray | None:
    """Values (seed,) of a case, NaN where a run failed; None if there are none."""
    if measure not in runs or case is None or case not in runs["case"].values:
        return None
    found = runs[measure].sel(case=case).values
    return found if np.isfinite(found).any() else None


def single(found: Evidence, measure: str, shape: str, low: float, high: float) -> list[Comparison]:
    """The mean of a measure of a shape at the density of the first case."""
    case = find(found.runs, shape) if found.runs["case"].size else None
    some = values(found.runs, measure, case)
    return [] if some is None else [Comparison(f"{measure} of {case}", some, None, low, high)]


def ratio(runs, measure, one, other, low=0.0, high=INFINITE, paired=False) -> list[Comparison]:
    """A measure of case `one` over that of case `other`, if there are both."""
    a, b = values(runs, measure, one), values(runs, measure, other)
    if a is None or b is None:
        return []
    words = f"{measure.replace('_', ' ')}, {one} over {other}"
    return [Comparison(words, a, b, low, high, paired)]


def shapes(found: Evidence, measure, one: str, other: str, low=0.0, high=INFINITE):
    """The same of two shapes at the density of the first case."""
    if not found.runs["case"].size:
        return []
    return ratio(found.runs, measure, find(found.runs, one), find(found.runs, other), low, high)


def all_of(*parts: list[Comparison]) -> list[Comparison]:
    """All parts of a claim; none if one of them can not be tested."""
    return [each for part in parts for each in part] if all(parts) else []


@claim(
    "abstract; 4",
    "the drag in dumbbell-shaped granules is higher than that in cylindrical granules",
)
def dumbbells_above_discs(found):
    """Mean drag of d1 over that of c1 is above 1."""
    return shapes(found, "drag", "d1", "c1", low=1.0)


@claim(
    "3.3",
    "dumbbell-shaped particles exhibit less drag than cylindrical particles of equal effective diameter",
)
def dumbbells_below_discs(found):
    """Mean drag of d1 over that of c1 is below 1: the opposite of the sentence before."""
    return shapes(found, "drag", "d1", "c1", high=1.0)


@claim("3.3; 4", "d1 and c2: dumbbell-shaped particles show significantly higher drag")
def dumbbells_above_small_discs(found):
    """Mean drag of d1 over that of c2, discs of the size of its halves, is above 1."""
    return shapes(found, "drag", "d1", "c2", low=1.0)


@claim("3.3", "a remarkable drop in drag force when the granules are made slightly elliptical")
def slight_ellipses_drop(found):
    """Mean drag of e1 over that of c1 is lower than the paper's own scatter of 18 % explains."""
    return shapes(found, "drag", "e1", "c1", high=1.0 - ALIKE)


@claim(
    "abstract; 3.3; 4",
    "further increases in aspect ratio for cases e2 and e3 result in further drops",
)
def longer_ellipses_drop(found):
    """Mean drag of e2 over that of e1, and of e3 over that of e2, are both below 1."""
    return all_of(
        shapes(found, "drag", "e2", "e1", high=1.0), shapes(found, "drag", "e3", "e2", high=1.0)
    )


@claim(
    "3.2",
    "the differences are within the standard deviation, confirming the validity of the elliptical code",
)
def codes_agree(found):
    """Mean drag of e0 over that of c1 is 1 to within 18 %."""
    return shapes(found, "drag", "e0", "c1", 1.0 - ALIKE, 1.0 + ALIKE)


@claim("3.2", "average drag and standard deviation: 1405 N and 17 %, 1295 N and 18 %")
def scatter_of_drag(found):
    """The standard deviation of the drag of c1 along a run, over its mean, rounds to 17 or 18 %."""
    return single(found, "scatter", "c1", 0.165, 0.185)


@claim("3.4", "density increased by a factor of 10, the maximum change in drag force is 21.8 %")
def density_changes_little(found):
    """For every shape, on the same beds, ten times the density changes the mean drag by less than 21.8 %."""
    return _densities(found, 0.218)


@claim(
    "3.4",
    "momentum effects are relatively insignificant relative to frictional and compaction forces",
)
def momentum_is_insignificant(found):
    """The same, within 18 %, the paper's own scatter."""
    return _densities(found, ALIKE)


def _densities(found, within):
    if not found.runs["case"].size:
        return []
    pairs = [(cases[-1], cases[0]) for cases in densities(found.runs).values()]
    parts = [
        ratio(found.runs, "drag", *pair, 1.0 - within, 1.0 + within, paired=True) for pair in pairs
    ]
    return all_of(*parts) if parts else []


@claim("3.4, of earlier work", "there is little effect of velocity on drag behavior")
def velocity_hardly_matters(found):
    """From a tenth or less of the paper's velocity to a few times it, on the same beds, the mean
    drag of c1 changes by less than 18 %: at the slowest velocity and at the least above the paper's."""
    speeds = sorted(float(case) for case in found.velocity["case"].values)
    wanted = [speeds[0]] if speeds and speeds[0] < 1.0 else []
    wanted += [speed for speed in speeds if speed > 1.0][:1]
    if 1.0 not in speeds or not wanted:
        return []
    parts = [
        ratio(found.velocity, "drag", speed, 1.0, 1.0 - ALIKE, 1.0 + ALIKE, paired=True)
        for speed in wanted
    ]
    return [each._replace(words=f"drag, {speed:g} times the velocity over c1")
            for speed, each in zip(wanted, all_of(*parts), strict=True)]  # fmt: skip


@claim("3.4, of earlier work", "friction contributes significantly to the drag force")
def friction_contributes(found):
    """Over the design, the mean drag of c1 with friction of the granules above the middle of its
    range, over that below, is above 1.18."""
    return _halves(found, "friction.granule")


@claim("3.4, of earlier work", "compaction contributes significantly to the drag force")
def compaction_contributes(found):
    """Over the design, the mean drag of c1 at packing fractions above the middle of the range, over
    that below, is above 1.18."""
    return _halves(found, "packing.fraction")


def _halves(found, path):
    """Drag of c1 in the upper half of a factor of the design over that in the lower."""
    points = found.points
    if not points["case"].size or path not in points["factor"].values:
        return []
    case = find(points, "c1")
    drag = values(points, "drag", case)
    if drag is None:
        return []
    place = points["at"].sel(case=case, factor=path).values
    upper = place > np.nanmedian(place)
    a, b = drag[upper], drag[~upper]
    return [Comparison(f"drag of c1, high over low {path}", a, b, 1.0 + ALIKE, INFINITE)]


@claim(
    "abstract; 4",
    "the flow pattern in elliptical granules of 1.375 is much more irregular than those of lower aspect ratios",
)
def long_ellipses_flow_irregularly(found):
    """Non-affine motion (D2min over the squared diameter) in e3 is above that in e1 and in c1."""
    return all_of(
        shapes(found, "non_affine", "e3", "e1", low=1.0),
        shapes(found, "non_affine", "e3", "c1", low=1.0),
    )


@claim("3.3", "case e3 shows a significantly large mixing zone")
def long_ellipses_mix(found):
    """Mixing of layers (share of neighbours of different layers, less that at the start) in e3 is
    above that in e1 and in c1."""
    return all_of(
        shapes(found, "mixing", "e3", "e1", low=1.0), shapes(found, "mixing", "e3", "c1", low=1.0)
    )


@claim("3.3", "the ability of elongated particles to align with the particle flow direction")
def ellipses_align(found):
    """The long axes of e1, e2 and e3 near the cylinder lie along the motion of the granules: the
    mean of cos 2(angle - direction) is above 0, its value at random."""
    return all_of(
        *(single(found, "alignment", shape, 0.0, INFINITE) for shape in ("e1", "e2", "e3"))
    )


@claim("4", "the granule shape strongly influences the drag force")
def shape_matters(found):
    """Mean drags of d1, of e1 and of e3 over that of c1 differ from 1 by more than 18 %: the sense
    is that of our means, and packing fraction is equal, not distance from jamming."""
    parts = [
        shapes(found, "drag", "d1", "c1", low=1.0 + ALIKE),
        shapes(found, "drag", "e1", "c1", high=1.0 - ALIKE),
        shapes(found, "drag", "e3", "c1", high=1.0 - ALIKE),
    ]
    return all_of(*parts)
