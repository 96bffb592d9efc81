"""The study of error against run time as tables for the terminal."""

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.tables import numbers
from studies.accuracy import replicates
from studies.accuracy.bias import LARGEST, bias, change, failures, shapes_of, table
from studies.accuracy.contacts import BED_OVERLAPS, BED_RATIO, in_the_beds

NEEDS = ("trial_drag", "contact_method", "integrator", "replicate_drag")  # variables of the file
ATTRIBUTES = ("window_start", "window_stop", "default_fraction")

LEGENDS = {
    "contacts": f"""\
ellipses of aspect ratio 1 to {BED_RATIO:g}, overlaps {BED_OVERLAPS[0]:g} to {BED_OVERLAPS[1]:g} b; median time; worst errors over all
these: of the overlap over the overlap, of the normal (rad), of the contact point over b; by the
solver against its own definition, and by the definition against the common normal""",
    "steps": """\
rms error at the default step: of the velocities after a collision over the speed of impact, of the
displacements in a bed over that of the cylinder; fitted order of convergence""",
    "drag": f"""\
change of the mean drag against the default step over the same beds, with its 95 % interval; bias of
the default: slope of a straight line through the steps up to {LARGEST:g}, times the default""",
}


def summary(dataset: xr.Dataset) -> Group:
    """Renderable summary of accuracy.nc."""
    parts = [
        Text(dataset.attrs["title"], style="bold"),
        Text(dataset.attrs.get("versions", "")),
        "",
    ]
    for name, make in (("contacts", contacts), ("steps", steps), ("drag", drag)):
        parts += [make(dataset), Text(LEGENDS[name], style="dim"), ""]
    return Group(*parts, Text("\n".join([*biases(dataset), *runs(dataset)])))


def contacts(dataset: xr.Dataset) -> Table:
    """One row per method and start."""
    made = numbers(
        "contact of two ellipses", "start", "ns", "overlap,\nsolver", "normal,\nsolver",
        "overlap,\ndefinition", "normal,\ndefinition", "failures", words=2,
    )  # fmt: skip
    beds = in_the_beds(dataset)
    for method in beds["contact_method"].values:
        for start in beds["contact_start"].values:
            here = beds.sel(contact_method=method, contact_start=start)
            time = 1e9 * float(here["contact_time"].median())
            carries = bool(here["contact_remembers"])
            if not np.isfinite(time) or not (carries or start == beds["contact_start"].values[0]):
                continue
            made.add_row(
                str(method), str(start) if carries else "any", f"{time:.1f}",
                *(f"{float(here[f'contact_{name}'].max()):.1e}" for name in (
                    "solver_overlap_error", "solver_normal_error",
                    "definition_overlap_error", "definition_normal_error",
                )),
                f"{100 * float(here['contact_failures'].max()):.1f} %",
            )  # fmt: skip
    return made


def steps(dataset: xr.Dataset) -> Table:
    """One row per scene and integrator."""
    made = numbers("scene", "integrator", "error at default", "time, µs", "order", words=2)
    default = float(dataset["step_default"])
    for scene in dataset["step_scene"].values:
        here = dataset.sel(step_scene=scene)
        level = int(np.nanargmin(np.abs(here["step_fraction"].values - default)))
        for integrator in here["integrator"].values:
            one = here.sel(integrator=integrator)
            time = 1e6 * float(one["step_time"].isel(step_level=level).median())
            made.add_row(
                str(scene), str(integrator), f"{float(one['step_error'][level]):.1e}", f"{time:.3g}",
                f"{float(one['step_order']):.2f} +- {float(one['step_order_error']):.2f}",
            )  # fmt: skip
    return made


def drag(dataset: xr.Dataset) -> Table:
    """One row per shape and step."""
    made = numbers("shape", "step over critical", "beds", "change", "failed", "s a run")
    default = float(dataset.attrs["default_fraction"])
    for shape in shapes_of(dataset):
        found, failed = change(table(dataset, shape), default), failures(dataset, shape)
        for fraction in found["fraction"].values:
            here = found.sel(fraction=fraction)
            mine = (dataset["trial_shape"] == shape) & (dataset["trial_fraction"] == fraction)
            time = float(dataset["trial_time"].where(mine).median())
            value, half = 100 * float(here["value"]), 100 * float(here["half"])
            made.add_row(
                shape, f"{fraction:g}", str(int(mine.sum())),
                f"{value:+.1f} +- {half:.1f} %" if np.isfinite(value) else "-",
                f"{100 * failed[float(fraction)]:.0f} %", f"{time:.2f}",
            )  # fmt: skip
    return made


def biases(dataset: xr.Dataset) -> list[str]:
    """One sentence per shape."""
    found = {shape: bias(dataset, shape) for shape in shapes_of(dataset)}
    return [
        f"{shape}: bias of the default step {100 * b.value:+.2f} +- {100 * b.half:.2f} %, "
        f"half the step {50 * b.value:+.2f} % ({b.seeds} beds)."
        for shape, b in found.items()
    ]


def runs(dataset: xr.Dataset) -> list[str]:
    """What replicates buy, in sentences."""
    found = replicates.replicates(dataset)
    length = replicates.correlation_length(dataset)
    five = replicates.expected(found.scatter, 5)
    covered = ""
    if dataset.sizes["replicate"] > 10:
        share = 100 * replicates.subsets(dataset, 5)[1]
        covered = f" (it holds the mean of all in {share:.0f} % of random fives)"
    lengths, scatter = replicates.windows(dataset)
    return [
        f"Replicates: mean {found.mean:.0f} N, scatter of one run {100 * found.scatter:.1f} % "
        f"({dataset.sizes['replicate']} runs, {found.time:.2f} s each).",
        f"Half the 95 % interval: {100 * five:.1f} % from 5 runs{covered}, "
        f"{100 * replicates.TARGET:.0f} % from {found.needed} runs, "
        f"{found.needed * found.time:.0f} s of processor time.",
        f"One independent value every {1e3 * length:.2f} mm of stroke; scatter of one run "
        f"{100 * scatter[-1]:.1f} % over a window of {1e3 * lengths[-1]:.1f} mm, whose mean differs by "
        f"{100 * replicates.drift(dataset):+.0f} %.",
    ]
