"""Error against run time."""

from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd
from rich.table import Table

from studies.accuracy.bias import Steps, steps_of
from studies.accuracy.replicates import TARGET, Replicates, cost, drift, expected, windows
from studies.common.findings import Findings, numbers, percent

__all__ = ["accuracy"]

COMPARISONS = Path(__file__).parent / "comparisons"
DEFAULT = "error at default"


class Accuracy(Findings):
    """Error against run time, accuracy.nc; and comparisons that decided how the code works."""

    name, command = "accuracy", "snakemake -j2 accuracy"
    needs = "trial_time_step", "replicate_drag"
    attributes = "window_start", "window_stop", "default_fraction"

    @cached_property
    def of_shapes(self) -> dict[str, Steps]:
        """By shape, what the step does."""
        return steps_of(self.dataset)

    @property
    def unbiased(self) -> bool:
        """Whether the intervals of all biases of the default step hold zero."""
        return all(abs(steps.bias.value) < steps.bias.half for steps in self.of_shapes.values())

    @property
    def none_fails(self) -> bool:
        """Whether all runs came to their end."""
        return bool((self.dataset["trial_status"] == "ran").all())

    @property
    def beds(self) -> int:
        """Replicates."""
        return self.dataset.sizes["replicate"]

    @cached_property
    def replicates(self) -> Replicates:
        """Scatter of one run over the mean, runs that the interval wanted takes, and time of one
        (s)."""
        return cost(self.dataset)

    target = TARGET

    @property
    def scatter_of_stroke(self) -> float:
        """Scatter of one run over the mean, over the whole stroke."""
        return windows(self.dataset)[1][-1]

    @property
    def drift(self) -> float:
        """Change of the mean from the window to the whole stroke."""
        return drift(self.dataset)

    def half(self, runs: int) -> float:
        """Half the interval of the mean of some runs, over the mean."""
        return expected(self.replicates.scatter, runs)

    def longer(self, shape: str, fraction: float) -> float:
        """Mean time step at a step fraction over that of the paper's."""
        return self.of_shapes[shape].lengths[fraction]

    def change(self, shape: str, fraction: float) -> tuple[float, float]:
        """Change of the mean drag at a step, over the bound, against the default, and half its
        interval."""
        return tuple(self.of_shapes[shape].changes.loc[fraction])

    def bias_table(self) -> Table:
        """One row per shape: bias of the default step and of half of it."""
        table = numbers("shape", "bias at step fraction 0.5", "of half that step", "beds")
        for shape, steps in self.of_shapes.items():
            value, half, _, seeds = steps.bias
            cells = (percent((x * value, x * half), 1) for x in (1.0, 0.5))
            table.add_row(shape, *cells, str(seeds))
        return table

    def steps(self) -> Table:
        """By shape and step fraction: change of the mean drag against the paper's step over the
        same beds."""
        table = numbers("shape", "step fraction", "beds", "change", "failed", "s per run")
        for shape, steps in self.of_shapes.items():
            for fraction, some in steps.runs.groupby("fraction"):
                value, half = (100 * number for number in self.change(shape, fraction))
                change = f"{value:+.1f} +- {half:.1f} %" if np.isfinite(value) else "-"
                failed = percent(steps.failed[fraction])
                cells = f"{fraction:g}", f"{len(some)}", change, failed, f"{some.time.median():.2f}"
                table.add_row(shape, *cells)
        return table

    def comparison(self, name: str, words: int = 1) -> Table:
        """A comparison of comparisons/: what was decided by it needs no further measurement."""
        rows = self._rows(name)
        return numbers(*rows.columns, words=words, rows=rows.fillna("").values)

    def _rows(self, name: str) -> pd.DataFrame:
        return pd.read_csv(COMPARISONS / f"{name}.csv", comment="#", dtype=str)

    def error(self, scene: str, integrator: str) -> float:
        """Of an integrator at the default step."""
        return float(self._integrator(scene, integrator)[DEFAULT])

    def order(self, scene: str) -> str:
        """Fitted order of velocity Verlet."""
        return self._integrator(scene, "Verlet")["order"].partition(" ")[0]

    def _integrator(self, scene: str, integrator: str) -> pd.Series:
        rows = self._rows("integrators")
        return rows[(rows.scene == scene) & (rows.integrator == integrator)].iloc[0]


accuracy = Accuracy()
