"""All claims against the same runs, at intervals that hold together."""

from pathlib import Path
from typing import NamedTuple

import xarray as xr

from dem.claims.compare import LEVEL, UNTESTED, Comparison, simultaneous, together
from dem.claims.evidence import Evidence, from_study, from_sweep
from dem.claims.influence import Share, share_of_space
from dem.claims.sentences import CLAIMS, Claim


class Verdict(NamedTuple):
    """A claim, its comparisons, what they say, and in how much of the plausible space it holds."""

    claim: Claim
    comparisons: list[Comparison]
    verdict: str
    level: float
    share: Share | None


def judge(found: Evidence) -> list[Verdict]:
    """Every claim; the level of the intervals grows with the number of comparisons."""
    compared = [claim.compare(found) for claim in CLAIMS]
    compared = [each if all(c.runs >= 2 for c in each) else [] for each in compared]
    level = simultaneous(sum(map(len, compared)))
    return [
        Verdict(claim, each, together(each, level), level, share_of_space(found, claim))
        for claim, each in zip(CLAIMS, compared, strict=True)
    ]


def evidence_in(path: Path) -> Evidence:
    """Runs in claims.nc, or in drag.nc with the flow.nc beside it; raises InputError."""
    from dem.combine import open_combined, open_lazily

    with open_lazily(path) as dataset:
        if "run_part" in dataset:
            return from_study(dataset.load())
    flow = Path(path).parent / "flow.nc"
    with open_combined(path) as dataset:
        if not flow.is_file():
            return from_sweep(dataset)
        with open_lazily(flow) as moves:
            return from_sweep(dataset, _same(moves.load(), dataset))


def _same(flow: xr.Dataset, drag: xr.Dataset) -> xr.Dataset | None:
    """flow.nc if it is of the same cases and seeds."""
    alike = all(
        flow[name].values.tolist() == drag[name].values.tolist() for name in ("case", "seed")
    )
    return flow if alike else None


def tested(found: list[Verdict]) -> list[Verdict]:
    """Those for which there were runs."""
    return [each for each in found if each.verdict != UNTESTED]


__all__ = ["LEVEL", "Verdict", "evidence_in", "judge", "tested"]
