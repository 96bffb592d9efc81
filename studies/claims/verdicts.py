"""All claims against the same runs, at intervals that hold together, and verdicts in words."""

from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

from dem.base.statistics import LEVEL
from studies.claims.compare import CONTRADICTED, SUPPORTED, UNDECIDED
from studies.claims.evidence import Evidence
from studies.claims.sentences import CLAIMS, Claim

UNTESTED = "not tested"


class Share(NamedTuple):
    """In what share of realisations, one bed of each case, a claim holds, with its interval.

    points: Realisations without a failed run.
    failed: Realisations with a failed run, which do not count.
    """

    share: float
    low: float
    high: float
    points: int
    failed: int

    @property
    def per_cent(self) -> str:
        """In words."""
        return f"{100 * self.share:.0f} ({100 * self.low:.0f}\N{EN DASH}{100 * self.high:.0f})"


class Verdict(NamedTuple):
    """A claim on some runs.

    comparisons: Numbers that decide. verdict: What they say at intervals of `level`. space, paper:
    Shares of the plausible space, and of realisations at the paper's values, where it holds.
    """

    claim: Claim
    comparisons: list
    verdict: str
    level: float
    space: Share | None
    paper: Share | None


def judge(evidence: Evidence) -> list[Verdict]:
    """Every claim; the level of the intervals grows with the number of comparisons (Bonferroni)."""
    compared = [claim.compare(evidence) for claim in CLAIMS]
    compared = [
        comparisons if all(c.runs >= 2 for c in comparisons) else [] for comparisons in compared
    ]
    distinct = {comparison.words for comparisons in compared for comparison in comparisons}
    level = 1.0 - (1.0 - LEVEL) / max(len(distinct), 1)  # a number of several claims counts once
    points, runs = (evidence.one_by_one(part) for part in (evidence.points, evidence.runs))
    return [
        Verdict(
            claim,
            comparisons,
            together(comparisons, level),
            level,
            share(claim, points),
            share(claim, runs),
        )
        for claim, comparisons in zip(CLAIMS, compared, strict=True)
    ]


def together(comparisons: list, level: float) -> str:
    """Verdict on a claim of several parts: supported if all are, contradicted if one is."""
    verdicts = {comparison.verdict(level) for comparison in comparisons}
    if not verdicts:
        return UNTESTED
    if CONTRADICTED in verdicts:
        return CONTRADICTED
    return SUPPORTED if verdicts == {SUPPORTED} else UNDECIDED


def share(claim: Claim, evidence: Evidence) -> Share | None:
    """In what share of realisations a claim holds, by Wilson's interval; None where it is not
    tested.

    Where an effect is small, the scatter of single beds counts as well.
    """
    comparisons = claim.compare(evidence) if evidence.runs["case"].size else []
    if not comparisons or not all(hasattr(comparison, "holds") for comparison in comparisons):
        return None
    every = np.array([comparison.holds() for comparison in comparisons])
    good = np.isfinite(every).all(axis=0)
    count, points = int((every[:, good] == 1.0).all(axis=0).sum()), int(good.sum())
    if not points:
        return None
    interval = binomtest(count, points).proportion_ci(LEVEL, method="wilson")
    return Share(count / points, interval.low, interval.high, points, int((~good).sum()))


def span(number, level: float = LEVEL) -> str:
    """A number with its interval."""
    low, high = number.interval(level)
    return f"{number.estimate:.3g} ({low:.3g} to {high:.3g})"


def claimed(number) -> str:
    """The range that a claim gives for a number."""
    if number.high == np.inf:
        return f"above {number.low:.3g}"
    if number.low == 0.0 and number.is_ratio:
        return f"below {number.high:.3g}"
    low, high = f"{number.low:.4g}", f"{number.high:.4g}"
    if low == high:
        return low
    return f"{'not ' if number.outside else ''}{low} to {high}"
