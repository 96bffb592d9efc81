"""What pages about the paper's open questions state: the calibration, and the beds before a run."""

from functools import cached_property

import numpy as np
import yaml
from findings import DATA, Findings
from rich.table import Table

from dem.analysis.statistics import summarise


class Calibration:
    """The fitted Young's modulus, from docs/data/calibration.yaml."""

    @cached_property
    def _found(self) -> dict:
        return yaml.safe_load((DATA / "calibration.yaml").read_text(encoding="utf-8"))

    @property
    def modulus(self) -> str:
        """Young's modulus, in GPa."""
        return f"{1e-9 * self._found['young_modulus']:.1f} GPa"

    @property
    def interval(self) -> str:
        """Its 95 % interval."""
        low, high = self._found["interval"]
        return f"{1e-9 * low:.1f} to {1e-9 * high:.1f} GPa"

    @property
    def exponent(self) -> str:
        """p of drag ~ E^p."""
        return f"{self._found['exponent']:.2f}"

    @property
    def scatter(self) -> str:
        """Standard deviation of the mean drag of one run over the mean."""
        return f"{100 * self._found['scatter']:.0f} %"

    @property
    def runs(self) -> str:
        return str(self._found["runs"])

    @property
    def made(self) -> str:
        """Where the numbers come from."""
        found = self._found
        return (
            f"*Computed by `{found['command']}` at revision `{found['revision']}` on "
            f"{found['date']}; file `docs/data/calibration.yaml`.*"
        )


class Beds(Findings):
    """The beds of the paper's sweep before the cylinder moves, and what is seen along a run."""

    name, command = "drag", "snakemake -j2"

    def table(self) -> Table:
        """Means over the seeds, per case of one density."""
        table = Table()
        table.add_column("case", justify="left")
        for head in ("pressure on the walls (MPa)", "contacts per granule", "greatest overlap"):
            table.add_column(head, justify="right")
        beds = self.dataset.sel(case=[c for c in self.dataset["case"].values if len(c) == 2])
        for case in beds["case"].values:
            one = beds.sel(case=case)
            pressure = 1e-6 * float(one["packing_pressure"].mean())
            table.add_row(
                str(case),
                f"{pressure:.1f}" if pressure >= 0.001 else "below 0.001",
                f"{float(one['packing_coordination_number'].mean()):.2f}",
                f"{float(one['packing_max_overlap'].max()):.1g}",
            )
        return table

    def height(self) -> str:
        """Mean height of the boxes of c1, in mm."""
        return f"{1e3 * float(self.dataset['box_height'].sel(case='c1').mean()):.1f} mm"

    def scatter_along(self, case: str) -> str:
        """Standard deviation of the drag along a run over its mean."""
        one = summarise(self.dataset).sel(case=case)
        return f"{100 * float(one['sd_over_run'] / one['mean']):.0f} %"

    def scatter_of_mean(self, case: str) -> str:
        """The same of the mean of all runs at each displacement."""
        start, stop = self.dataset.attrs["window_start"], self.dataset.attrs["window_stop"]
        inside = self.dataset["drag"].sel(case=case, displacement=slice(start, stop))
        curve = inside.mean("seed")
        return f"{100 * float(curve.std('displacement', ddof=1) / curve.mean()):.0f} %"

    def scatter_between(self, case: str) -> str:
        """Standard deviation between the mean drags of the runs over their mean."""
        one = summarise(self.dataset).sel(case=case)
        return f"{100 * float(one['sd_between_runs'] / one['mean']):.0f} %"

    def step(self, case: str) -> str:
        """Median time step of a case, in ns."""
        return f"{1e9 * float(np.median(self.dataset['time_step'].sel(case=case))):.0f} ns"

    def steps(self, case: str) -> str:
        """Mean number of time steps of a run."""
        return f"{float(self.dataset['steps'].sel(case=case).mean()):,.0f}"


NAMES = {"calibration": Calibration(), "beds": Beds()}
