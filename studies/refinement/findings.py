"""How many runs a curve takes by a grid, by a Latin hypercube and by points that are refined."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.tables import numbers
from studies.common.findings import Findings, estimate
from studies.refinement.curves import GRID, INTERPOLATED, REFINED, SURROGATE, Curves, Error

__all__ = ["refinement"]


class Refinement(Findings):
    """Error of drag against velocity by design and number of runs, refinement.nc."""

    name, command, needs = "refinement", "snakemake -j2 refinement", ("run_drag", "run_round")

    @cached_property
    def curves(self) -> Curves:
        return Curves(self.dataset)

    def held(self) -> str:
        """Runs that are held out, at how many velocities."""
        return f"{self.curves.held.size} runs at {len(self.curves.held)} velocities"

    def own(self) -> str:
        """What the held-out means scatter themselves, over them, at most."""
        held = self.curves.held
        return f"{100.0 * float((held.std(axis=1) / held.mean(axis=1)).max()) / held.shape[1] ** 0.5:.1f} %"

    def table(self) -> Table:
        """Root mean square error of the curve at the held-out velocities, by design and number of runs."""
        made = numbers("design", "read by", "points", "runs", "error", words=2)
        for each in self.curves.errors:
            made.add_row(each.design, each.by, f"{each.points}", f"{each.runs}", estimate(100.0 * each.error, "%", 1))
        return made

    def most(self, design: str, by: str = SURROGATE) -> Error:
        """The curve of most runs of a design."""
        return max(self.curves.of(design, by), key=lambda each: each.runs)

    def share(self, by: str = INTERPOLATED) -> float:
        """Runs of the refined curve over those of the finest grid, for the error of that grid."""
        grid = self.most(GRID, by)
        return self.curves.runs_for(grid.error[0], REFINED) / grid.runs

    def told(self, by: str = INTERPOLATED) -> str:
        """The same in words."""
        share = self.share(by)
        return f"{share:.2f} times" if np.isfinite(share) else "no number of times"


refinement = Refinement()
