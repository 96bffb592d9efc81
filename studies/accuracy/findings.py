"""Error against run time."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.tables import numbers
from studies.accuracy import bias, replicates
from studies.accuracy.contacts import in_the_beds
from studies.common.findings import Findings, clock, interval

__all__ = ["accuracy"]


class Accuracy(Findings):
    """Error against run time, accuracy.nc."""

    name, command = "accuracy", "snakemake -j2 accuracy"
    needs = "trial_time_step", "contact_method", "integrator", "replicate_drag"
    attributes = "window_start", "window_stop", "default_fraction"

    @cached_property
    def biases(self) -> dict:
        return {shape: bias.bias(self.dataset, shape) for shape in bias.shapes_of(self.dataset)}

    def steps(self) -> Table:
        """By shape and step fraction: change of the mean drag against the paper's step over the same beds."""
        made = numbers("shape", "step fraction", "beds", "change", "failed", "s a run")
        for shape in bias.shapes_of(self.dataset):
            failed, grid = bias.failures(self.dataset, shape), bias.table(self.dataset, shape)
            found = bias.change(grid, self._default)
            for fraction in found["fraction"].values:
                here = found.sel(fraction=fraction)
                mine = self.dataset["trial_shape"] == shape
                mine &= self.dataset["trial_fraction"] == fraction
                time = float(self.dataset["trial_time"].where(mine).median())
                value, half = 100 * float(here["value"]), 100 * float(here["half"])
                made.add_row(
                    shape, f"{fraction:g}", str(int(mine.sum())),
                    f"{value:+.1f} +- {half:.1f} %" if np.isfinite(value) else "-",
                    f"{100 * failed[float(fraction)]:.0f} %", f"{time:.2f}",
                )  # fmt: skip
        return made

    @property
    def _default(self) -> float:
        """The default step over the bound."""
        return float(self.dataset.attrs["default_fraction"])

    def bias_table(self) -> Table:
        """One row per shape: bias of the default step and of half of it."""
        made = numbers("shape", "bias at step fraction 0.5", "of half that step", "beds")
        for shape, each in self.biases.items():
            cells = [
                interval(100 * x * each.value, 100 * x * each.half, "%", 1) for x in (1.0, 0.5)
            ]
            made.add_row(shape, *cells, str(each.seeds))
        return made

    def unbiased(self) -> bool:
        """Whether the intervals of all biases hold zero."""
        return all(abs(each.value) < each.half for each in self.biases.values())

    def longer(self, shape: str, fraction: float) -> str:
        """Mean time step at a step fraction over that of the paper's."""
        return f"{bias.lengths(self.dataset, shape)[fraction] / self._default:.2f}"

    def none_fails(self) -> bool:
        """Whether all runs came to their end."""
        return bool((self.dataset["trial_status"] == "ran").all())

    def change(self, shape: str, fraction: float) -> str:
        """Change of the mean drag at a step, over the bound, against the default."""
        grid = bias.table(self.dataset, shape)
        found = bias.change(grid, self._default).sel(fraction=fraction)
        return interval(100 * float(found["value"]), 100 * float(found["half"]), "%")

    @cached_property
    def replicates(self) -> replicates.Replicates:
        return replicates.replicates(self.dataset)

    def beds(self) -> int:
        """Replicates."""
        return self.dataset.sizes["replicate"]

    def scatter(self) -> str:
        """Scatter of one run about the mean."""
        return f"{100 * self.replicates.scatter:.1f} %"

    def half(self, runs: int) -> str:
        """Half the interval of the mean of some runs, over the mean."""
        return f"± {100 * replicates.expected(self.replicates.scatter, runs):.0f} %"

    def needed(self) -> str:
        """Runs that `target` takes, and their processor time."""
        found = self.replicates
        return f"{found.needed} runs ({clock(found.needed * found.time)} of processor time)"

    def target(self) -> str:
        """Half the interval of the mean that is wanted."""
        return f"± {100 * replicates.TARGET:.0f} %"

    def long_stroke(self) -> tuple[str, str]:
        """Scatter of one run over the whole stroke, and the change of its mean."""
        scatter = replicates.windows(self.dataset)[1][-1]
        return f"{100 * scatter:.1f} %", f"{100 * replicates.drift(self.dataset):+.0f} %"

    def integrators(self) -> Table:
        """By scene and integrator: rms error at the default step, its time, the fitted order."""
        made = numbers("scene", "integrator", "error at default", "time, µs", "order", words=2)
        for scene in self.dataset["step_scene"].values:
            here = self._at_default(scene)
            for integrator in here["integrator"].values:
                one = here.sel(integrator=integrator)
                made.add_row(
                    str(scene), str(integrator), f"{float(one['step_error']):.1e}",
                    f"{1e6 * float(one['step_time'].median()):.3g}",
                    f"{float(one['step_order']):.2f} +- {float(one['step_order_error']):.2f}",
                )  # fmt: skip
        return made

    def _at_default(self, scene: str) -> xr.Dataset:
        """A scene at the default step."""
        here = self.dataset.sel(step_scene=scene)
        away = abs(here["step_fraction"].values - float(self.dataset["step_default"]))
        return here.isel(step_level=int(np.nanargmin(away)))

    def error(self, scene: str, integrator: str) -> float:
        """Of an integrator at the default step."""
        return float(self._at_default(scene)["step_error"].sel(integrator=integrator))

    def order(self, scene: str) -> str:
        """Fitted order of velocity Verlet."""
        one = self.dataset["step_order"].sel(step_scene=scene, integrator="Verlet")
        return f"{float(one):.2f}"

    def methods(self) -> Table:
        """One row per method whose first guess is off by 1e-4 rad, as in a run."""
        made = numbers(
            "contact of two ellipses", "ns", "error of the overlap", "of the normal, rad"
        )
        full = self.contacts()
        for row in zip(*(column.cells for column in full.columns), strict=True):
            method, start, time, overlap, normal, by_definition, tilt, _ = row
            if start in ("any", "0.0001 rad"):
                made.add_row(
                    method,
                    time,
                    max(overlap, by_definition, key=float),
                    max(normal, tilt, key=float),
                )
        return made

    def contacts(self) -> Table:
        """By method and start, worst of all ellipses in the beds: solver against its own definition,
        and definition against the common normal."""
        made = numbers(
            "contact of two ellipses", "start", "ns", "overlap,\nsolver", "normal,\nsolver",
            "overlap,\ndefinition", "normal,\ndefinition", "failures", words=2,
        )  # fmt: skip
        beds = in_the_beds(self.dataset)
        for method in beds["contact_method"].values:
            for start in beds["contact_start"].values:
                here = beds.sel(contact_method=method, contact_start=start)
                carries = bool(here["contact_remembers"])
                if not (carries or start == beds["contact_start"].values[0]):
                    continue
                made.add_row(
                    str(method), str(start) if carries else "any",
                    f"{1e9 * float(here['contact_time'].median()):.1f}",
                    *(f"{float(here[f'contact_{name}_error'].max()):.1e}" for name in (
                        "solver_overlap", "solver_normal", "definition_overlap", "definition_normal",
                    )),
                    f"{100 * float(here['contact_failures'].max()):.1f} %",
                )  # fmt: skip
        return made

    def bounces(self) -> Table:
        """One row per method: greatest change of the energy over all bounces, by aspect ratio."""
        ratios = self.dataset["bounce_aspect_ratio"].values
        made = numbers("contact", *(f"{ratio:g}:1" for ratio in ratios))
        for method in self.dataset["bounce_method"].values:
            here = self.dataset.sel(bounce_method=method)
            cells = []
            for ratio in ratios:
                one = here.sel(bounce_aspect_ratio=ratio)
                worst = float(abs(one["bounce_energy"] - 1.0).max())
                burst = bool(np.isfinite(one["bounce_burst"]).any())
                cells.append("diverges" if burst else f"{worst:.1e}" if np.isfinite(worst) else "")
            made.add_row(str(method), *cells)
        return made

    def bounce_steps(self) -> int:
        """Time steps in a collision at the first speed."""
        return int(self.dataset["bounce_steps"])

    def bounced(self) -> str:
        """Bounces."""
        return f"{int(self.dataset['bounce_number'].max()):,}"

    def lammps_ran(self) -> bool:
        """Whether LAMMPS was there when the file was made."""
        return bool(np.isfinite(self.dataset["peer_error"].isel(peer=1)).any())

    def peers(self) -> Table:
        """One row per scene: error and time of this code and of LAMMPS at the default step."""
        made = numbers("scene", "error", "error, LAMMPS", "time over LAMMPS's")
        for scene in self.dataset["peer_scene"].values:
            here = self._at_default(scene).sel(peer_scene=scene)
            errors = here["peer_error"].values
            times = here["peer_time"].median("step_repeat").values
            if np.isfinite(errors).all():
                made.add_row(
                    str(scene), *(f"{x:.2e}" for x in errors), f"{times[0] / times[1]:.2f}"
                )
        return made


accuracy = Accuracy()
