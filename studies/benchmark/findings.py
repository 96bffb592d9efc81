"""Speed beside other codes."""

import numpy as np
import xarray as xr
from rich.table import Table

from dem.base.statistics import mean_interval
from studies.benchmark.drag import at_equal_error
from studies.benchmark.scenes import FULL
from studies.common.findings import Findings, estimate, numbers, span

__all__ = ["speed"]


def times_faster(dataset: xr.Dataset) -> xr.DataArray:
    """Median speed of this code over that of each; NaN where a code did not run."""
    rates = dataset["granule_steps_per_second"].median("repeat", skipna=False)
    return rates.isel(code=0, drop=True) / rates


def middle(values, digits: int = 1) -> tuple[str, str]:
    """Median, and the range of the middle half of the turns."""
    low, median, high = np.percentile(values, (25, 50, 75))
    return f"{median:.{digits}f}", span(low, high, digits=digits)


class Speed(Findings):
    """Speed beside other codes, on one processor."""

    command = "snakemake -j1 benchmark"
    needs, attributes = ("granule_steps_per_second",), ("processor", "codes")

    def __init__(self, name: str):
        self.name = name

    def codes(self) -> Table:
        """By bed and code that ran: speed, with the middle half of the turns, and processor time of a
        step over the contacts."""
        heads = "bed", "code", "10⁶ granule-steps/s", "middle half", "ns a contact"
        table = numbers(*heads, words=2)
        every = 1e-6 * self.dataset["granule_steps_per_second"].stack(bed=("scene", "code"))
        for scene, code in every.dropna("bed")["bed"].values:
            contact = 1e9 * float(self.dataset["time_per_contact"].sel(scene=scene, code=code))
            rates = every.sel(bed=(scene, code)).values
            table.add_row(scene, code, *middle(rates, 2), f"{contact:.0f}")
        return table

    def faster(self, scene: str, code: str) -> str:
        """How many times as fast this code is as the fastest of those whose names begin so: the ratio
        of the medians."""
        ratios = times_faster(self.dataset).sel(scene=scene)
        every = [name for name in ratios["code"].values if name.startswith(code)]
        return f"{float(ratios.sel(code=every).min()):.1f}"

    def over(self, code: str, other: str) -> str:
        """How many times as fast a code is as another on the bed of discs."""
        ratios = times_faster(self.dataset).sel(scene="discs")
        return f"{float(ratios.sel(code=other) / ratios.sel(code=code)):.2f}"

    @property
    def lammps_script(self) -> str:
        """The input of LAMMPS for the bed of discs, with our law."""
        return self.dataset.attrs["lammps_script"]

    def strokes(self) -> Table:
        """By code: the largest fixed time step that keeps the mean drag within 1 %, over the bound
        on the critical step at rest; processor time."""
        heads = "code", "largest step", "95 % interval", "ns", "steps a second"
        table = numbers(*heads, "seconds a millimetre", "mean drag at the shortest step, N")
        drags = self.dataset["drag_mean"].isel(drag_level=0)
        for code, one in at_equal_error(self.dataset).iterrows():
            table.add_row(
                code,
                f"{one.largest:.2f}",
                f"{one.low:.2f}, {one.high:.2f}",
                f"{1e9 * one.time_step:.0f}",
                f"{one.rate:,.0f}",
                f"{1e-3 * one.cost:.3f}",
                estimate(mean_interval(drags.sel(drag_code=code).values), digits=0),
            )
        return table

    def longer(self, code: str) -> bool:
        """Whether the largest step of a code is clearly longer than that of this one."""
        steps = at_equal_error(self.dataset)
        return bool(steps.low[code] > steps.high.iloc[0])

    def dearer(self, code: str) -> str:
        """Processor time of a stroke in a code over that in this one."""
        cost = at_equal_error(self.dataset).cost
        return f"{cost[code] / cost.iloc[0]:.1f}"

    def scenes(self) -> Table:
        """By scene, contacts held as they are by short time steps; against full: of what each turn
        gave; middle half of the turns; code: machine code of one step."""
        heads = "scene", "ns a granule-step", "relative to full", "middle half", "code, bytes"
        table = numbers(*heads)
        every = 1e9 * self.dataset["variant_step_time"]
        ratios = every / every.sel(variant=FULL)
        for variant, size in self.dataset["variant_code_size"].to_series().items():
            time, _ = middle(every.sel(variant=variant))
            table.add_row(variant, time, *middle(ratios.sel(variant=variant), 2), f"{size:.0f}")
        return table

    def sizes(self) -> Table:
        """By size of bed and number of threads, or of ranks of MPI: discs in motion in a box without a
        cylinder, while one list holds; time, not processor time, with the middle half of the turns."""
        heads = "discs", "threads", "ns a granule-step", "middle half"
        table = numbers(*heads, "LAMMPS on ranks", "middle half", "bytes a granule")
        every = [1e9 * self.dataset[f"{name}_step_time"] for name in ("size", "ranks")]
        for size, memory in self.dataset["size_memory"].to_series().items():
            for threads in self.dataset["threads"].values:
                ours, ranks = (times.sel(size=size, threads=threads).values for times in every)
                theirs = ("", "") if np.isnan(ranks).any() else middle(ranks)
                table.add_row(f"{size:,}", str(threads), *middle(ours), *theirs, f"{memory:.0f}")
        return table

    def motion(self) -> Table:
        """How far this code and LAMMPS part, from rest, while the cylinder moves: greatest distance of a
        granule over the mean radius, and difference of the impulses on the cylinder over ours."""
        stroke = 1e3 * self.dataset["comparison_stroke"].values
        heads = "bed", "what", *(f"after {length:.2g} mm" for length in stroke)
        table = numbers(*heads, words=2)
        for name in self.dataset["comparison"].values:
            for what, key in ("distance", "trajectory"), ("impulse", "impulse"):
                values = self.dataset[f"{key}_difference"].sel(comparison=name).values
                table.add_row(name, what, *(f"{value:.0e}" for value in values))
        return table


speed = Speed("benchmark")
