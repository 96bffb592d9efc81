"""How many runs a curve takes by a grid, by a Latin hypercube and by points that are refined."""

from functools import cached_property

from rich.table import Table

from dem.analysis.tables import numbers
from studies.common.findings import Findings, estimate
from studies.refinement.curves import GRID, REFINED, Curves, Error, interval

__all__ = ["refinement"]


class Refinement(Findings):
    """Error of drag against velocity by design and number of runs, refinement.nc."""

    name, command, needs = "refinement", "snakemake -j2 refinement", ("run_drag", "run_round")

    @cached_property
    def curves(self) -> Curves:
        return Curves(self.dataset)

    def beds(self) -> str:
        """Beds, the same of all designs."""
        return f"{self.curves.held.shape[1]}"

    def held(self) -> str:
        """Velocities that no design has."""
        return f"{len(self.curves.held)}"

    def own(self) -> str:
        """Scatter of the means held out."""
        return f"{100.0 * self.curves.own():.1f} %"

    def table(self) -> Table:
        """Root mean square error at the velocities held out, by design and number of runs, and over that of the refined curve."""
        made = numbers("design", "read by", "points", "runs", "error", "over that of refined points", words=2)
        for each in self.curves.errors:
            made.add_row(
                each.design, each.by, f"{len(each.velocity)}", f"{each.runs}", estimate(100.0 * each.error, "%", 1),
                estimate(interval(each.draws / self.last().draws)),
            )  # fmt: skip
        return made

    def last(self) -> Error:
        """The refined curve, where it ended."""
        return self.curves.of(REFINED)[-1]

    def points(self) -> str:
        """Velocities where refining placed points."""
        first, last = (set(self.curves.of(REFINED)[k].velocity) for k in (0, -1))
        return " and ".join(f"{each:.3g}" for each in sorted(last - first))

    def better(self) -> list[str]:
        """Designs that are nearer than the refined curve, or further off, with the whole interval of the ratio."""
        ratios = {f"{e.design} {len(e.velocity)}": interval(e.draws / self.last().draws) for e in self.curves.errors if e.design != REFINED}
        return [name for name, (_, low, high) in ratios.items() if not low <= 1.0 <= high]

    def least(self) -> int:
        """Runs of the smallest grid."""
        return self.curves.of(GRID)[0].runs

    def risen(self) -> str:
        """By how much drag rises from the lowest velocity to the highest, with the finest grid."""
        mean = self.curves.designs[GRID][-1].mean(axis=1)
        return f"{100.0 * (mean.iloc[-1] / mean.iloc[0] - 1.0):.0f} %"


refinement = Refinement()
