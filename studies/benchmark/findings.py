"""Speed beside other codes."""

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.tables import numbers
from studies.benchmark.drag import at_equal_error
from studies.benchmark.scenes import FULL
from studies.common.findings import Findings, span

__all__ = ["processors", "speed"]

SMALL, MILLION = 400, 1_000_000  # discs
SMOOTH = "discs, no friction, no rotation"


def times_faster(dataset: xr.Dataset) -> xr.DataArray:
    """Speed of this code over that of each, of every turn; NaN where a code did not run."""
    rates = dataset["granule_steps_per_second"]
    return rates.isel(code=0, drop=True) / rates


class Speed(Findings):
    """Speed beside other codes, on one processor."""

    command = "snakemake -j1 benchmark"
    needs, attributes = ("granule_steps_per_second",), ("processor", "codes")

    def __init__(self, name: str):
        self.name = name

    def codes(self) -> Table:
        """By bed and code that ran; damping of LAMMPS and LIGGGHTS has another form, with the same restitution."""
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
        """By code: the largest fixed time step that keeps the mean drag within 1 %, over the bound on the
        critical step at rest; processor time."""
        made = numbers(
            "code", "largest step", "95 % interval", "ns", "steps a second", "seconds a millimetre"
        )
        found = at_equal_error(self.dataset)
        for code in found["drag_code"].values:
            one = {name: float(value) for name, value in found.sel(drag_code=code).items()}
            made.add_row(
                str(code), f"{one['largest']:.2f}", f"{one['low']:.2f}, {one['high']:.2f}",
                f"{1e9 * one['time_step']:.0f}", f"{one['rate']:,.0f}", f"{1e-3 * one['cost']:.3f}",
            )  # fmt: skip
        return made

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
        """By bed and part of a step, contacts held as they are: each part runs many times by itself, stages of a
        pair by leaving out the later ones."""
        made = numbers(
            "bed", "part of a step", "µs a step", "lowest, highest", "ns a pair", "ns a granule",
            words=2,
        )  # fmt: skip
        for scene in self.dataset["scene"].values:
            for stage in self.dataset["stage"].values:
                here = self.dataset.sel(scene=scene, stage=stage)
                times = 1e6 * here["stage_time"].values
                middle = 1e3 * float(np.median(times))
                made.add_row(
                    str(scene), str(stage), f"{np.median(times):.2f}",
                    f"{times.min():.2f}, {times.max():.2f}", f"{middle / float(here['scene_pairs']):.2f}",
                    f"{middle / float(here['scene_granules']):.1f}",
                )  # fmt: skip
        return made

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
        """By scene, contacts held as they are by short time steps; against full: median of what each turn gave;
        code: machine code of one step."""
        made = numbers(
            "scene", "ns a granule-step", "lowest, highest", "against full", "code, bytes"
        )
        full = self.dataset["variant_step_time"].sel(variant=FULL)
        for variant in self.dataset["variant"].values:
            here = self.dataset.sel(variant=variant)
            times = 1e9 * here["variant_step_time"].values
            made.add_row(
                str(variant), f"{np.median(times):.1f}", f"{times.min():.1f}, {times.max():.1f}",
                f"{float((here['variant_step_time'] / full).median()):.2f}", str(int(here["variant_code_size"])),
            )  # fmt: skip
        return made

    def sizes(self) -> Table:
        """By size of bed and number of threads: discs in motion in a box without a cylinder, while one list holds.

        Ratios are medians of what each repeat gave; memory is that of all arrays.
        """
        made = numbers(
            "discs", "threads", "ns a granule-step", "lowest, highest", "against\nsmallest",
            "against\none thread", "separate beds,\nagainst one", "LAMMPS on ranks,\nagainst one",
            "bytes a granule",
        )  # fmt: skip
        times = self.dataset["size_step_time"]
        ratios = [times / times.isel(size=0)] + [
            self.dataset[f"{name}_step_time"] / self.dataset[f"{name}_step_time"].isel(threads=0)
            for name in ("size", "apart", "ranks")
        ]
        for size in self.dataset["size"].values:
            for threads in self.dataset["threads"].values:
                here = {"size": size, "threads": threads}
                spent = 1e9 * times.sel(here).values
                found = [float(ratio.sel(here).median()) for ratio in ratios]
                made.add_row(
                    f"{size:,}", str(threads), f"{np.median(spent):.1f}",
                    f"{spent.min():.1f}, {spent.max():.1f}",
                    *("" if np.isnan(ratio) else f"{ratio:.2f}" for ratio in found),
                    f"{float(self.dataset['size_memory'].sel(size=size)):.0f}",
                )  # fmt: skip
        return made

    def motion(self) -> Table:
        """How far this code and LAMMPS part: greatest distance of a granule over the mean radius, undamped, from
        the same start; with friction the arm and the unloading of the tangential spring differ."""
        steps = self.dataset["comparison_steps"].values
        made = numbers("undamped bed", *(f"after {count} steps" for count in steps))
        for name in self.dataset["comparison"].values:
            apart = self.dataset["trajectory_difference"].sel(comparison=name).values
            made.add_row(str(name), *(f"{value:.1e}" for value in apart))
        return made

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
