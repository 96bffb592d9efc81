"""The benchmark as tables for the terminal."""

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.tables import numbers
from studies.benchmark.drag import TOLERANCE, at_equal_error
from studies.benchmark.ratio import times_faster
from studies.benchmark.scenes import FULL

NEEDS = ("granule_steps_per_second",)  # variables of the file
ATTRIBUTES = ("history", "processor", "versions", "codes")

LEGEND = """\
medians of the turns; faster: ours over the other in each turn; contact: touching pair of parts of
granules. Damping of LAMMPS and LIGGGHTS has another form than ours, with the same restitution (LAMMPS:
at 1 m/s)."""
STAGES = """\
contacts held as they are; each part runs many times by itself, stages of a pair by leaving out the
later ones"""
SCENES = """\
contacts held as they are, by time steps a thousand times shorter; against full: median of what each
turn gave; code: machine code of one step"""
SIZES = """\
discs in motion, in a box without a cylinder, while one neighbour list holds; memory: all arrays.
Ratios: medians of what each repeat gave; separate: as many beds as threads at once, each on a thread"""
DRAG = f"""\
fixed time step at which the mean drag of a code leaves its level by {TOLERANCE:.0%}, over the bound on
the critical step at rest; processor time"""
MOTION = """\
greatest distance of a granule between ours and LAMMPS over the mean radius, undamped, from the same
start; with friction the arm and the unloading of the tangential spring differ"""


def summary(dataset: xr.Dataset) -> Group:
    """Renderable summary of benchmark.nc."""
    attrs = dataset.attrs
    lines = [f"{name}: {attrs[name]}" for name in ("history", "processor", "versions", "codes")]
    for code, status in zip(dataset["code"].values, dataset["code_status"].values, strict=True):
        if status != "run":
            lines.append(f"{code}: {status}")
    parts = [Text(attrs["title"], style="bold"), Text("\n".join(lines)), ""]
    tables = (
        (codes, LEGEND), (drag, DRAG), (stages, STAGES), (scenes, SCENES), (sizes, SIZES),
        (motion, MOTION),
    )  # fmt: skip
    for table, legend in tables:
        parts += [table(dataset), Text(legend, style="dim"), ""]
    return Group(*parts)


def codes(dataset: xr.Dataset) -> Table:
    """One row per bed and code that ran."""
    table = numbers(
        "bed", "code", "million granule-\nsteps a second", "lowest, highest", "ours faster,\ntimes",
        "ns a\ncontact", "contacts", "pairs\nlisted", words=2,
    )  # fmt: skip
    faster = times_faster(dataset)
    for scene in dataset["scene"].values:
        here = dataset.sel(scene=scene)
        for code in here["code"].values:
            rates = 1e-6 * here["granule_steps_per_second"].sel(code=code).values
            if np.isfinite(rates).all():
                table.add_row(
                    str(scene), str(code), f"{np.median(rates):.2f}",
                    f"{rates.min():.2f}, {rates.max():.2f}",
                    f"{float(faster.sel(scene=scene, code=code).median()):.2f}",
                    f"{1e9 * float(here['time_per_contact'].sel(code=code)):.1f}",
                    str(int(here["scene_contacts"])), str(int(here["scene_pairs"])),
                )  # fmt: skip
    return table


def stages(dataset: xr.Dataset) -> Table:
    """One row per bed and part of a step: what it takes, and over the pairs listed and granules."""
    table = numbers(
        "bed", "part of a step", "µs a step", "lowest, highest", "ns a pair", "ns a granule",
        words=2,
    )  # fmt: skip
    for scene in dataset["scene"].values:
        for stage in dataset["stage"].values:
            here = dataset.sel(scene=scene, stage=stage)
            times = 1e6 * here["stage_time"].values
            middle = 1e3 * float(np.median(times))
            table.add_row(
                str(scene), str(stage), f"{np.median(times):.2f}",
                f"{times.min():.2f}, {times.max():.2f}", f"{middle / float(here['scene_pairs']):.2f}",
                f"{middle / float(here['scene_granules']):.1f}",
            )  # fmt: skip
    return table


def scenes(dataset: xr.Dataset) -> Table:
    """One row per scene."""
    table = numbers("scene", "ns a granule-step", "lowest, highest", "against full", "code, bytes")
    full = dataset["variant_step_time"].sel(variant=FULL)
    for variant in dataset["variant"].values:
        here = dataset.sel(variant=variant)
        times = 1e9 * here["variant_step_time"].values
        table.add_row(
            str(variant), f"{np.median(times):.1f}", f"{times.min():.1f}, {times.max():.1f}",
            f"{float((here['variant_step_time'] / full).median()):.2f}", str(int(here["variant_code_size"])),
        )  # fmt: skip
    return table


def sizes(dataset: xr.Dataset) -> Table:
    """One row per size of bed and number of threads."""
    table = numbers(
        "discs", "threads", "ns a granule-step", "lowest, highest", "against\nsmallest",
        "against\none thread", "separate beds,\nagainst one", "LAMMPS on ranks,\nagainst one",
        "bytes a granule",
    )  # fmt: skip
    times = dataset["size_step_time"]
    ratios = [times / times.isel(size=0)] + [
        dataset[f"{name}_step_time"] / dataset[f"{name}_step_time"].isel(threads=0)
        for name in ("size", "apart", "ranks")
    ]
    for size in dataset["size"].values:
        for threads in dataset["threads"].values:
            here = {"size": size, "threads": threads}
            spent = 1e9 * times.sel(here).values
            found = [float(ratio.sel(here).median()) for ratio in ratios]
            table.add_row(
                f"{size:,}", str(threads), f"{np.median(spent):.1f}",
                f"{spent.min():.1f}, {spent.max():.1f}",
                *("" if np.isnan(ratio) else f"{ratio:.2f}" for ratio in found),
                f"{float(dataset['size_memory'].sel(size=size)):.0f}",
            )  # fmt: skip
    return table


def drag(dataset: xr.Dataset) -> Table:
    """One row per code: its largest time step, and what a stroke costs."""
    table = numbers(
        "code", "largest step", "95 % interval", "ns", "steps a second", "seconds a millimetre"
    )
    found = at_equal_error(dataset)
    for code in found["drag_code"].values:
        one = {name: float(value) for name, value in found.sel(drag_code=code).items()}
        table.add_row(
            str(code), f"{one['largest']:.2f}", f"{one['low']:.2f}, {one['high']:.2f}",
            f"{1e9 * one['time_step']:.0f}", f"{one['rate']:,.0f}", f"{1e-3 * one['cost']:.3f}",
        )  # fmt: skip
    return table


def motion(dataset: xr.Dataset) -> Table:
    """One row per comparison."""
    steps = dataset["comparison_steps"].values
    table = numbers("undamped bed", *(f"after {count} steps" for count in steps))
    for name in dataset["comparison"].values:
        apart = dataset["trajectory_difference"].sel(comparison=name).values
        table.add_row(str(name), *(f"{value:.1e}" for value in apart))
    return table
