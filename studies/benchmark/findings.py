"""Speed beside other codes."""

import numpy as np
import xarray as xr
from rich.table import Table

from dem.base.statistics import mean_interval
from studies.benchmark.drag import at_equal_error
from studies.benchmark.scenes import FULL
from studies.common.findings import Findings, estimate, numbers, span

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
        """By bed and code that ran; the damping of LAMMPS has another form, with the same
        restitution at one speed."""
        heads = "bed", "code", "10⁶ granule-steps/s", "lowest to highest", "ns a contact"
        table = numbers(*heads, words=2)
        every = 1e-6 * self.dataset["granule_steps_per_second"].stack(bed=("scene", "code"))
        for scene, code in every.dropna("bed")["bed"].values:
            rates = every.sel(bed=(scene, code)).values
            contact = 1e9 * float(self.dataset["time_per_contact"].sel(scene=scene, code=code))
            spread = span(rates.min(), rates.max(), digits=1)
            table.add_row(scene, code, f"{np.median(rates):.1f}", spread, f"{contact:.0f}")
        return table

    def ran(self, code: str) -> bool:
        """Whether a code was there when the file was made."""
        return self.dataset["code_status"].sel(code=code).item() == "run"

    def faster(self, scene: str, code: str) -> str:
        """How many times as fast this code is as another: the median of what each turn gave."""
        ratios = times_faster(self.dataset).sel(scene=scene, code=code)
        return f"{float(ratios.median()):.1f}"

    def ratios(self) -> dict[str, xr.DataArray]:
        """What the table of processors compares, of every turn; NaN where a code was missing."""
        dataset = self.dataset
        over = times_faster(dataset).sel(code="LAMMPS")
        pairs = dataset["scene_granules"] / dataset["granule_steps_per_second"].isel(code=0)
        pairs = pairs / dataset["scene_pairs"]
        scenes = dataset["variant_step_time"]
        sizes, apart = (
            dataset[f"{name}_step_time"].sel(size=MILLION) for name in ("size", "apart")
        )
        small = dataset["size_step_time"].sel(size=SMALL, threads=1)
        return {
            "speed relative to LAMMPS, discs": over.sel(scene="discs"),
            "the same, dumbbells": over.sel(scene="dumbbells"),
            "time of a listed pair, ellipses / discs": pairs.sel(scene="ellipses")
            / pairs.sel(scene="discs"),
            "time of a step, without friction and rotation / full": scenes.sel(variant=SMOOTH)
            / scenes.sel(variant=FULL),
            "time of a granule-step, a million discs / 400": sizes.sel(threads=1) / small,
            "speed of a million discs, two threads / one": sizes.sel(threads=1)
            / sizes.sel(threads=2),
            "speed of two separate beds of a million / one": apart.sel(threads=1)
            / apart.sel(threads=2),
        }

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

    def stages(self) -> Table:
        """By bed and part of a step, contacts held as they are: each part runs many times by itself,
        stages of a pair by leaving out the later ones."""
        heads = "bed", "part of a step", "µs a step", "lowest, highest", "ns a pair", "ns a granule"
        table = numbers(*heads, words=2)
        for scene in self.dataset["scene"].values:
            bed = self.dataset.sel(scene=scene)
            pairs, granules = float(bed["scene_pairs"]), float(bed["scene_granules"])
            for stage in self.dataset["stage"].values:
                times = 1e6 * bed["stage_time"].sel(stage=stage).values
                middle, ends = np.median(times), f"{times.min():.2f}, {times.max():.2f}"
                ratios = f"{1e3 * middle / pairs:.2f}", f"{1e3 * middle / granules:.1f}"
                table.add_row(str(scene), str(stage), f"{middle:.2f}", ends, *ratios)
        return table

    def scenes(self) -> Table:
        """By scene, contacts held as they are by short time steps; against full: median of what each
        turn gave; code: machine code of one step."""
        heads = "scene", "ns a granule-step", "lowest, highest", "relative to full", "code, bytes"
        table = numbers(*heads)
        every = 1e9 * self.dataset["variant_step_time"]
        full = every.sel(variant=FULL)
        for variant, size in self.dataset["variant_code_size"].to_series().items():
            times = every.sel(variant=variant)
            ends = f"{float(times.min()):.1f}, {float(times.max()):.1f}"
            against = f"{float((times / full).median()):.2f}"
            table.add_row(variant, f"{float(times.median()):.1f}", ends, against, f"{size:.0f}")
        return table

    def sizes(self) -> Table:
        """By size of bed and number of threads: discs in motion in a box without a cylinder, while
        one list holds.

        Ratios are medians of what each repeat gave; memory is that of all arrays.
        """
        table = numbers(
            "discs",
            "threads",
            "ns a granule-step",
            "lowest, highest",
            "relative to\nsmallest",
            "relative to\none thread",
            "separate beds,\nrelative to one",
            "LAMMPS on ranks,\nrelative to one",
            "bytes a granule",
        )
        every = [self.dataset[f"{name}_step_time"] for name in ("size", "apart", "ranks")]
        ratios = [
            every[0] / every[0].isel(size=0),
            *(times / times.isel(threads=0) for times in every),
        ]
        for size, memory in self.dataset["size_memory"].to_series().items():
            for threads in self.dataset["threads"].values:
                point = {"size": size, "threads": threads}
                times = 1e9 * every[0].sel(point).values
                medians = [float(ratio.sel(point).median()) for ratio in ratios]
                table.add_row(
                    f"{size:,}",
                    str(threads),
                    f"{np.median(times):.1f}",
                    f"{times.min():.1f}, {times.max():.1f}",
                    *("" if np.isnan(ratio) else f"{ratio:.2f}" for ratio in medians),
                    f"{memory:.0f}",
                )
        return table

    def motion(self) -> Table:
        """How far this code and LAMMPS part: greatest distance of a granule over the mean radius,
        undamped, from the same start; with friction the arm and the unloading of the tangential
        spring differ."""
        steps = self.dataset["comparison_steps"].values
        apart = self.dataset["trajectory_difference"].to_series().unstack(sort=False)
        rows = ((name, *(f"{value:.1e}" for value in row)) for name, *row in apart.itertuples())
        return numbers("undamped bed", *(f"after {count} steps" for count in steps), rows=rows)


def processors() -> Table:
    """One column per processor on which the benchmark ran: its ratios."""
    files = speed, *elsewhere
    ratios = [findings.ratios() for findings in files]
    rows = [(name, *(_with_range(values[name].values) for values in ratios)) for name in ratios[0]]
    for name, cell in {
        "turns": lambda findings: findings.dataset.sizes["repeat"],
        "bits of vectors": lambda findings: int(findings.dataset["variant_vector_bits"][0]),
        "load average before": lambda findings: f"{float(findings.dataset['load_average']):.1f}",
        "revision": lambda findings: f"`{findings.revision}`",
    }.items():
        rows.append((name, *(str(cell(findings)) for findings in files)))
    heads = (findings.dataset.attrs["processor"] for findings in files)
    return numbers("", *heads, rows=rows)


def _with_range(values) -> str:
    """Median, lowest and highest; nothing where the values are not known."""
    if np.isnan(values).any():
        return ""
    return f"{np.median(values):.2f} ({span(values.min(), values.max())})"


speed = Speed("benchmark")
# Each an earlier benchmark.nc, renamed by its processor: one of today's revision can be made only there.
elsewhere = [Speed("benchmark_family25_model17"), Speed("benchmark_family26_model2")]
