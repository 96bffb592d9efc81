"""How many runs a curve takes by a grid, by a Latin hypercube and by points that are refined."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.tables import numbers
from studies.common.findings import Findings, estimate
from studies.refinement.curves import (
    GRID,
    HYPERCUBE,
    INTERPOLATED,
    REFINED,
    SURROGATE,
    Curves,
    Error,
)

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

    def table(self) -> Table:
        """Root mean square error at the velocities held out, by design and number of runs."""
        made = numbers("design", "read by", "points", "runs", "error", words=2)
        for each in self.curves.errors:
            made.add_row(each.design, each.by, f"{len(each.velocity)}", f"{each.runs}", estimate(100.0 * each.error, "%", 1))
        return made

    def last(self) -> Error:
        """The refined curve, where it ended."""
        return self.curves.of(REFINED)[-1]

    def grid(self, by: str = SURROGATE) -> float:
        """Runs of a grid that is as far off as the refined curve, over those of that curve."""
        return self.curves.runs_for(self.last().error[0], GRID, by) / self.last().runs

    def gains(self) -> bool:
        """Whether a grid takes a quarter more runs for the error of the refined curve, or cannot have it."""
        return bool(self.grid() > 1.25)

    def alike(self) -> bool:
        """Whether the intervals of all curves of nine points or more, and of grids of five, have a part in common with that of the refined one."""
        last = self.last().error
        some = [each.error for each in self.curves.errors if each.design != HYPERCUBE or len(each.velocity) > 5]
        return all(low <= last[2] and high >= last[1] for _, low, high in some)

    def told(self, by: str = SURROGATE) -> str:
        """The same in words."""
        ratio = self.grid(by)
        if np.isinf(ratio):
            return f"more than {max(each.runs for each in self.curves.of(GRID, by)) / self.last().runs:.1f} times as many"
        return f"{ratio:.1f} times as many" if np.isfinite(ratio) else "fewer"

    def read(self) -> str:
        """Runs of a grid that is as far off as the refined curve, over those of that curve, where it is read by straight lines."""
        return self.told(INTERPOLATED)


refinement = Refinement()
