"""Speed beside other codes."""

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.tables import numbers
from studies.benchmark import report as speed_report
from studies.benchmark.drag import at_equal_error
from studies.benchmark.ratio import times_faster
from studies.benchmark.scenes import FULL
from studies.common.findings import Findings, span

__all__ = ["processors", "speed"]

SMALL, MILLION = 400, 1_000_000  # discs
SMOOTH = "discs, no friction, no rotation"


class Speed(Findings):
    """Speed beside other codes, on one processor."""

    command = "snakemake -j1 benchmark"

    def __init__(self, name: str):
        self.name = name

    def codes(self) -> Table:
        """One row per bed and code that ran."""
        made = numbers(
            "bed", "code", "10⁶ granule-steps/s", "lowest to highest", "ns a contact", words=2
        )
        for scene in self.dataset["scene"].values:
            here = self.dataset.sel(scene=scene)
            for code in self.dataset["code"].values:
                rates = 1e-6 * here["granule_steps_per_second"].sel(code=code).values
                if np.isfinite(rates).all():
                    made.add_row(
                        str(scene), str(code), f"{np.median(rates):.1f}",
                        span(rates.min(), rates.max(), digits=1),
                        f"{1e9 * float(here['time_per_contact'].sel(code=code)):.0f}",
                    )  # fmt: skip
        return made

    def ran(self, code: str) -> bool:
        """Whether a code was there when the file was made."""
        return str(self.dataset["code_status"].sel(code=code).values) == "run"

    def faster(self, scene: str, code: str) -> str:
        """How many times as fast this code is as another: the median of what each turn gave."""
        found = times_faster(self.dataset).sel(scene=scene, code=code)
        return f"{float(found.median()):.1f}"

    def ratios(self) -> dict[str, xr.DataArray]:
        """What the table of processors compares, of every turn; NaN where a code was missing."""
        rates = self.dataset["granule_steps_per_second"]
        over = times_faster(self.dataset).sel(code="LAMMPS")
        pairs = self.dataset["scene_granules"] / rates.isel(code=0) / self.dataset["scene_pairs"]
        scenes, sizes, apart = (
            self.dataset[f"{name}_step_time"] for name in ("variant", "size", "apart")
        )
        large = {"size": MILLION}
        return {
            "speed over that of LAMMPS, discs": over.sel(scene="discs"),
            "the same, dumbbells": over.sel(scene="dumbbells"),
            "time of a listed pair, ellipses over discs": (
                pairs.sel(scene="ellipses") / pairs.sel(scene="discs")
            ),
            "time of a step, without friction and rotation over full": (
                scenes.sel(variant=SMOOTH) / scenes.sel(variant=FULL)
            ),
            "time of a granule-step, a million discs over 400": (
                (sizes.sel(large) / sizes.sel(size=SMALL)).sel(threads=1)
            ),
            "speed of a million discs, two threads over one": (
                (sizes.sel(threads=1) / sizes.sel(threads=2)).sel(large)
            ),
            "speed of two separate beds of a million over one": (
                (apart.sel(threads=1) / apart.sel(threads=2)).sel(large)
            ),
        }

    def strokes(self) -> Table:
        """One row per code: the largest time step at equal error, and what a millimetre costs."""
        return speed_report.drag(self.dataset)

    def beds(self) -> int:
        """Through how many beds each code draws the cylinder, at each time step."""
        return self.dataset.sizes["drag_bed"]

    def longer(self, code: str) -> bool:
        """Whether the largest step of a code is clearly longer than that of this one."""
        found = at_equal_error(self.dataset)
        return float(found["low"].sel(drag_code=code)) > float(found["high"][0])

    def dearer(self, code: str) -> str:
        """Processor time of a stroke in a code over that in this one."""
        cost = at_equal_error(self.dataset)["cost"]
        return f"{float(cost.sel(drag_code=code) / cost[0]):.1f}"

    def stages(self) -> Table:
        """One row per bed and part of a step."""
        return speed_report.stages(self.dataset)

    def slow(self) -> str:
        """Time of a square root and of a division."""
        root, division = (
            1e9 * float(self.dataset[name].median()) for name in ("root_time", "division_time")
        )
        return f"{root:.2f} ns and a division {division:.2f} ns"

    def vectors(self) -> int:
        """Width of the vector registers (bits)."""
        return int(self.dataset["variant_vector_bits"][0])

    def load(self) -> str:
        """Load average of the computer before anything was timed."""
        return f"{float(self.dataset['load_average']):.1f}"

    def scenes(self) -> Table:
        """One row per scene: what it costs."""
        return speed_report.scenes(self.dataset)

    def sizes(self) -> Table:
        """One row per size of bed and number of threads."""
        return speed_report.sizes(self.dataset)

    def motion(self) -> Table:
        """One row per bed: how far this code and LAMMPS part."""
        return speed_report.motion(self.dataset)

    def machine(self) -> str:
        """The processor."""
        return str(self.dataset.attrs["processor"])

    def repeats(self) -> int:
        """How often each code runs."""
        return self.dataset.sizes["repeat"]


def processors() -> Table:
    """One column per processor on which the benchmark ran: its ratios."""
    files = speed, *elsewhere
    made = numbers("", *(each.machine() for each in files))
    found = [each.ratios() for each in files]
    for ratio in found[0]:
        made.add_row(ratio, *(_with_range(each[ratio].values) for each in found))
    made.add_row("turns", *(str(each.repeats()) for each in files))
    made.add_row("bits of vectors", *(str(each.vectors()) for each in files))
    made.add_row("load average before", *(each.load() for each in files))
    made.add_row("revision", *(f"`{each.revision}`" for each in files))
    return made


def _with_range(values) -> str:
    """Median, lowest and highest; nothing where the values are not known."""
    if np.isnan(values).any():
        return ""
    return f"{np.median(values):.2f} ({span(values.min(), values.max())})"


speed = Speed("benchmark")
# Each an earlier benchmark.nc, renamed by its processor: one of today's revision can be made only there.
elsewhere = [Speed("benchmark_family26_model2"), Speed("benchmark_family6_model207")]
