"""The paper's sweep: the drag, how the beds flow, and the beds before the cylinder moves."""

import json
from functools import cached_property
from io import StringIO
from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Console
from rich.table import Table

from dem.analysis.drag import change, summarise
from dem.analysis.tables import TextTable
from dem.base.statistics import Estimate, half_interval, ratio_interval
from dem.report.info import drag_table
from studies.common.findings import Findings, estimate, interval, numbers, span

__all__ = ["drag", "flow", "precise", "scene", "snapshots"]

DATA = Path(__file__).parents[2] / "data"
PAPER = {"c1": "1295", "e0": "1405"}  # N, section 3.2
DENSER = "2"  # case c12 is c1 at ten times the density
MEASURES = {
    "non_affine": "non-affine displacement (D²min)",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing of layers",
    "contacts_lost": "contacts lost over 0.5 mm",
}


class Drag(Findings):
    """The paper's sweep, drag.nc: means over 1 mm to 5 mm, 95 % intervals over five seeds."""

    name, command, folder = "drag", "snakemake -j2", DATA

    @cached_property
    def summary(self) -> xr.Dataset:
        return summarise(self.dataset)

    def mean(self, case: str) -> str:
        """Mean drag of a case and half its interval, in N."""
        return interval(*self._mean(case), "N")

    def _mean(self, case: str) -> tuple[float, float]:
        one = self.summary.sel(case=case)
        return float(one["mean"]), float(one["half_interval"])

    def printed(self, rows: int) -> str:
        """The first rows of the table that `dem info` prints."""
        console = Console(width=80, file=StringIO())  # of a usual terminal
        console.print(TextTable(drag_table(self.dataset).iloc[:rows]))
        return "\n".join(line.rstrip() for line in console.file.getvalue().splitlines())

    def cases(self) -> Table:
        """One row per shape: mean drag, the paper's value, mean drag at ten times the density."""
        made = numbers(
            "case", "granules", "mean drag, N", "paper, N", "ten times as dense, N", words=2
        )
        labels = self.dataset["case"].values.tolist()
        for case in labels:
            denser = f"{case}{DENSER}"
            if not case.endswith(DENSER) or case[:-1] not in labels:
                dense = interval(*self._mean(denser)) if denser in labels else ""
                mean = interval(*self._mean(case))
                made.add_row(case, self.granules(case), mean, PAPER.get(case, ""), dense)
        return made

    def granules(self, case: str) -> str:
        """Shape, aspect ratio of an ellipse, and volume diameter."""
        one = self.dataset.sel(case=case)
        kind, ratio = str(one["kind"].values), float(one["aspect_ratio"])
        ratio = f" {ratio:g}:1" if kind == "ellipse" else ""
        return f"{kind}{ratio}, {1e6 * float(one['diameter']):.0f} µm"

    def change(self, case: str, other: str) -> tuple[float, float]:
        """How much the mean of `other` differs from that of `case`, beds paired, and half the
        interval."""
        return change(self.summary["run_mean"], case, other)

    def density(self) -> str:
        """Range over the shapes of what ten times the density does to the mean drag."""
        found = [
            100 * self.change(case, case + DENSER)[0]
            for case in self.dataset["case"].values.tolist()
            if case + DENSER in self.dataset["case"].values
        ]
        return span(min(found), max(found), "%", 0)

    def falls(self, *cases: str) -> bool:
        """Whether the mean falls from case to case."""
        return bool(np.all(np.diff([self._mean(case)[0] for case in cases]) < 0.0))

    def apart(self, case: str, other: str) -> bool:
        """Whether the interval of `case` is above that of `other`."""
        (high, a), (low, b) = self._mean(case), self._mean(other)
        return high - a > low + b

    def parts(self, case: str, other: str, share: float) -> str:
        """Displacements, over the seeds, at which two drags first differ by a share."""
        a, b = (self.dataset["drag"].sel(case=each) for each in (case, other))
        first = (abs(a - b) > share * abs(b)).argmax("displacement")
        found = 1e3 * self.dataset["displacement"].values[first.values]
        return span(found.min(), found.max(), "mm", 1)

    def scatter(self, case: str, of: str = "over_run") -> float:
        """Standard deviation `over_run` or of the means `between_runs`, over the mean."""
        one = self.summary.sel(case=case)
        return float(one[f"sd_{of}"] / one["mean"])

    def pressure(self, *cases: str) -> float:
        """Mean pressure (Pa) on the walls of the packed beds of some cases."""
        return float(self.dataset["packing_pressure"].sel(case=list(cases)).mean())

    @cached_property
    def _along(self) -> xr.DataArray:
        """Mean drag of a run over each millimetre of the stroke, N."""
        edges = np.arange(0.0, 6.5e-3, 1e-3)
        return self.dataset["drag"].groupby_bins("displacement", edges).mean()

    def along(self, *cases: str) -> Table:
        """One row per case: mean drag over each millimetre of the stroke."""
        means = self._along.sel(case=list(cases)).mean("seed")
        spans = [
            f"{1e3 * each.left:.0f} to {1e3 * each.right:.0f} mm"
            for each in means[means.dims[-1]].values
        ]
        made = numbers("case, N", *spans)
        for case in cases:
            made.add_row(case, *(f"{value:.0f}" for value in means.sel(case=case).values))
        return made

    def growing(self, *cases: str) -> str:
        """Those cases whose drag at 4 to 5 mm is above that at 1 to 2 mm, interval included."""
        rise = (self._along[..., 4] - self._along[..., 1]).sel(case=list(cases))
        grows = rise.mean("seed") > half_interval(rise)
        return ", ".join(grows["case"].values[grows.values].tolist())

    def largest_overlap(self, *cases: str) -> float:
        """Greatest overlap of some cases, over the smaller radius."""
        return float(self.dataset["max_overlap"].sel(case=list(cases)).max())

    @property
    def run_time(self) -> float:
        """Median processor time (s) of a run."""
        return float(np.nanmedian(self.dataset["run_time"]))

    def beds(self) -> Table:
        """Means over the seeds before the cylinder moves, per case of one density."""
        made = numbers(
            "case", "pressure on the walls, MPa", "contacts per granule", "greatest overlap"
        )
        beds = self.dataset.sel(case=[c for c in self.dataset["case"].values if len(c) == 2])
        for case in beds["case"].values:
            one = beds.sel(case=case)
            pressure = 1e-6 * float(one["packing_pressure"].mean())
            made.add_row(
                str(case),
                f"{pressure:.1f}" if pressure >= 0.001 else "below 0.001",
                f"{float(one['packing_coordination_number'].mean()):.2f}",
                f"{float(one['packing_max_overlap'].max()):.1g}",
            )
        return made

    @property
    def height(self) -> float:
        """Mean height (m) of the boxes of c1."""
        return float(self.dataset["box_height"].sel(case="c1").mean())

    def scatter_of_mean(self, case: str) -> float:
        """Scatter along the window, over the mean, of the mean of all runs at each displacement."""
        start, stop = self.dataset.attrs["window_start"], self.dataset.attrs["window_stop"]
        inside = self.dataset["drag"].sel(case=case, displacement=slice(start, stop))
        curve = inside.mean("seed")
        return float(curve.std("displacement", ddof=1) / curve.mean())

    def step(self, case: str) -> float:
        """Median time step (s) of a case."""
        return float(np.median(self.dataset["time_step"].sel(case=case)))

    def steps(self, case: str) -> float:
        """Mean number of time steps of a run."""
        return float(self.dataset["steps"].sel(case=case).mean())


class Precise(Drag):
    """The same means of as many beds as they take."""

    name, command = "precise", "dem sweep config/precise.yaml"
    source = "precise/drag.nc"

    def beds_of(self, *cases: str) -> str:
        """How many beds some cases have."""
        found = [int(self.dataset["replicates"].sel(case=case)) for case in cases]
        return f"{min(found)} to {max(found)}" if len(set(found)) > 1 else f"{found[0]}"

    def runs(self) -> str:
        """How many runs there are."""
        return f"{int(self.dataset['replicates'].sum()):,}"

    def over(self, case: str, other: str = "c1") -> str:
        """Mean drag of a case over that of another, with Fieller's 95 % interval."""
        return estimate(self._over(case, other))

    def _over(self, case: str, other: str) -> Estimate:
        runs = self.summary["run_mean"]
        return ratio_interval(runs.sel(case=case).values, runs.sel(case=other).values)

    def widest(self) -> str:
        """The least well known of all ratios to c1: half its interval, over itself."""
        others = [case for case in self.dataset["case"].values.tolist() if case != "c1"]
        found = (self._over(case, "c1") for case in others)
        return f"{max(100.0 * each.half / each.value for each in found):.1f} %"

    def cases(self) -> Table:
        """One row per case: mean drag, the same relative to c1, and the number of beds."""
        heads = "case", "granules", "mean drag, N", "relative to c1", "beds"
        made = numbers(*heads, words=2)
        for case in self.dataset["case"].values.tolist():
            over = "" if case == "c1" else self.over(case)
            row = self.granules(case), interval(*self._mean(case)), over, self.beds_of(case)
            made.add_row(case, *row)
        return made


class Flow(Findings):
    """Measures of the flow of the paper's sweep, flow.nc."""

    name, command, folder = "flow", "snakemake -j2", DATA

    def measures(self) -> Table:
        """One row per measure: mean of e3 over that of c1."""
        made = numbers("measure of irregularity", "e3 relative to c1")
        for name, words in MEASURES.items():
            found = self._compared(name)
            made.add_row(words, interval(found.ratio, found.half, digits=2))
        return made

    def _compared(self, name: str):
        from studies.claims.irregularity import compared  # the pages that ask need this study

        return compared(self.dataset, name)

    @property
    def more_irregular(self) -> bool:
        """Whether any measure of e3 is above that of c1, interval included."""
        found = [self._compared(name) for name in MEASURES]
        return any(each.ratio - each.half > 1.0 for each in found)


class Snapshots(Findings):
    """Beds of the paper's sweep, snapshots.nc: the first seed of each case."""

    name, command, folder = "snapshots", "snakemake -j2", DATA

    @cached_property
    def _ahead(self) -> np.ndarray:
        """Overlaps of discs over the smaller radius, ahead of the cylinder, at the snapshots of the
        window.

        Of one bed of c1: contacts in the path of the cylinder, up to one diameter before its
        surface.
        """
        own, values = (
            self.dataset.sel(case="c1").isel(seed=0),
            json.loads(self.dataset.attrs["configuration"]),
        )
        reach = values["cylinder"]["diameter"]
        diameter = own["granule_diameter"].dropna("granule").values
        one, two = np.triu_indices(len(diameter), 1)
        small = 0.5 * np.minimum(diameter[one], diameter[two])
        found = []
        for each in np.flatnonzero(self._in_window):
            x, y = (
                own[name].values[each, : len(diameter)].astype(float)
                for name in ("granule_x", "granule_y")
            )
            apart = np.hypot(x[one] - x[two], y[one] - y[two])
            overlap = (0.5 * (diameter[one] + diameter[two]) - apart) / small
            aside = 0.5 * (x[one] + x[two]) - 0.5 * values["box_width"]
            above = 0.5 * (y[one] + y[two]) - float(own["cylinder_y"][each])
            near = (np.abs(aside) < 0.5 * reach) & (above > 0.0) & (above < 1.5 * reach)
            found.append(overlap[(overlap > 0.0) & near])
        return np.concatenate(found)

    @property
    def _in_window(self) -> np.ndarray:
        """Which snapshots are of the averaging window."""
        at, attrs = self.dataset["snapshot_displacement"].values, self.dataset.attrs
        rounding = 1e-9  # m
        return (at >= attrs["window_start"] - rounding) & (at <= attrs["window_stop"] + rounding)

    @property
    def overlap_ahead(self) -> float:
        """Mean overlap of discs ahead of the cylinder, over the smaller radius."""
        return float(self._ahead.mean())


class Scene(Findings):
    """A drum with a blade, of the page about scenes."""

    name, command, folder = "scene", "dem sweep config/scenes/drum.yaml -j1", DATA
    source = "drum/scene.nc"


drag, precise, flow, snapshots = Drag(), Precise(), Flow(), Snapshots()
scene = Scene()
