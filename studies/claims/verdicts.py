"""All claims against the same runs, at intervals that hold together."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

from dem.base.errors import InputError
from dem.base.intervals import LEVEL
from studies.claims.evidence import MARGIN, Evidence, from_study, from_sweep
from studies.claims.layout import MEASURES, VARIABLES
from studies.claims.numbers import simultaneous, together
from studies.claims.sentences import CLAIMS, Claim


class Share(NamedTuple):
    """In how many of how many single worlds a claim holds, with its interval; failed: worlds of which
    a run failed, which do not count."""

    share: float
    low: float
    high: float
    points: int
    failed: int


class Verdict(NamedTuple):
    """A claim, what it is compared by, what that says at `level`, and in how much of the plausible
    space, and of the runs at the paper's values, it holds bed by bed."""

    claim: Claim
    comparisons: list
    verdict: str
    level: float
    space: Share | None
    paper: Share | None


def judge(found: Evidence) -> list[Verdict]:
    """Every claim; the level of the intervals grows with the number of comparisons."""
    compared = [claim.compare(found) for claim in CLAIMS]
    compared = [each if all(c.runs >= 2 for c in each) else [] for each in compared]
    level = simultaneous(compared)
    return [
        Verdict(
            claim, each, together(each, level), level,
            share(claim, found.one_by_one(found.points)), share(claim, found.one_by_one(found.runs)),
        )
        for claim, each in zip(CLAIMS, compared, strict=True)
    ]  # fmt: skip


def share(claim: Claim, found: Evidence) -> Share | None:
    """Share of the worlds, one bed each, in which a claim holds, by Wilson's interval; None where it is
    not tested. Where an effect is small, the scatter of single beds counts as well."""
    comparisons = claim.compare(found) if found.runs["case"].size else []
    if not comparisons or not all(hasattr(each, "holds") for each in comparisons):
        return None
    every = np.array([each.holds() for each in comparisons])
    good = np.isfinite(every).all(axis=0)
    count, points = int((every[:, good] == 1.0).all(axis=0).sum()), int(good.sum())
    if not points:
        return None
    interval = binomtest(count, points).proportion_ci(LEVEL, method="wilson")
    return Share(count / points, interval.low, interval.high, points, int((~good).sum()))


def evidence_in(path: Path, margin: float = MARGIN) -> Evidence:
    """Runs in claims.nc, or in drag.nc with the flow.nc beside it; raises InputError."""
    from dem.io.dataset import content_of
    from dem.io.lazily import open_lazily, require
    from dem.sweep.combine import open_combined

    with open_lazily(path) as dataset:
        if "run_part" in dataset:
            require(dataset, path, VARIABLES, ("run_drag",), ("window_start", "window_stop"))
            return from_study(dataset.load(), margin)
        if "drag" not in dataset:
            raise InputError(f"{path}: it holds no drag; name drag.nc.")
    flow = Path(path).parent / "flow.nc"
    with open_combined(path) as dataset:
        dims = dataset["run_id"].dims
        if set(dims) != {"case", "seed"}:
            raise InputError(f"{path}: its runs are over {', '.join(dims)}; claims compare cases.")
        drag = dataset.load()
    same = None
    if flow.is_file():
        with open_lazily(flow) as moves:
            own, others = moves.indexes, drag.indexes
            if all(name in own and own[name].equals(others[name]) for name in ("case", "seed")):
                require(moves, flow, {}, MEASURES, ("window_start", "window_stop"))
                same = moves.load()
    with content_of(path):
        return from_sweep(drag, same, margin)
