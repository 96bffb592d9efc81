"""Error against run time."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.tables import numbers
from studies.accuracy import bias, replicates
from studies.accuracy import report as accuracy_report
from studies.common.findings import Findings, clock, interval

__all__ = ["accuracy"]


class Accuracy(Findings):
    """Error against run time, accuracy.nc."""

    name, command = "accuracy", "snakemake -j2 accuracy"
    SHAPES = "c1", "d1", "e3"

    @cached_property
    def biases(self) -> dict:
        return {shape: bias.bias(self.dataset, shape) for shape in bias.shapes_of(self.dataset)}

    def steps(self) -> Table:
        """One row per shape and time step: change of the mean drag."""
        return accuracy_report.drag(self.dataset)

    def bias(self, shape: str) -> str:
        """Bias of the mean drag at the default step."""
        found = self.biases[shape]
        return interval(100 * found.value, 100 * found.half, "%", 1)

    def bias_table(self) -> Table:
        """One row per shape: bias of the default step and of half of it."""
        made = numbers("shape", "bias of the default step", "of half the step", "beds")
        for shape, each in self.biases.items():
            cells = [
                interval(100 * x * each.value, 100 * x * each.half, "%", 1) for x in (1.0, 0.5)
            ]
            made.add_row(shape, *cells, str(each.seeds))
        return made

    def biased_less(self, share: float) -> bool:
        """Whether all biases are below a share of the mean drag, their intervals included."""
        return all(abs(each.value) + each.half < share for each in self.biases.values())

    def change(self, shape: str, fraction: float) -> str:
        """Change of the mean drag at a step, over the bound, against the default."""
        default = float(self.dataset.attrs["default_fraction"])
        found = bias.change(bias.table(self.dataset, shape), default).sel(fraction=fraction)
        return interval(100 * float(found["value"]), 100 * float(found["half"]), "%")

    def failed(self, shape: str, fraction: float) -> str:
        """Share of the runs at a step that failed."""
        return f"{100 * bias.failures(self.dataset, shape)[fraction]:.0f} %"

    @cached_property
    def replicates(self) -> replicates.Replicates:
        return replicates.replicates(self.dataset)

    def beds(self) -> int:
        """How many replicates there are."""
        return self.dataset.sizes["replicate"]

    def scatter(self) -> str:
        """Of one run about the mean."""
        return f"{100 * self.replicates.scatter:.1f} %"

    def half(self, runs: int) -> str:
        """Half the interval of the mean of some runs, over the mean."""
        return f"± {100 * replicates.expected(self.replicates.scatter, runs):.0f} %"

    def needed(self) -> str:
        """Runs for an interval of ± TARGET, and their processor time."""
        found = self.replicates
        return f"{found.needed} runs ({clock(found.needed * found.time)} of processor time)"

    def target(self) -> str:
        """Half the interval that `needed` is about."""
        return f"± {100 * replicates.TARGET:.0f} %"

    def long_stroke(self) -> tuple[str, str]:
        """Scatter of one run over the whole stroke, and the change of its mean."""
        scatter = replicates.windows(self.dataset)[1][-1]
        return f"{100 * scatter:.1f} %", f"{100 * replicates.drift(self.dataset):+.0f} %"

    def integrators(self) -> Table:
        """One row per scene and integrator: error at the default step, its time, the order."""
        return accuracy_report.steps(self.dataset)

    def error(self, scene: str, integrator: str) -> float:
        """Of an integrator at the default step."""
        one = self.dataset.sel(step_scene=scene, integrator=integrator)
        default = float(self.dataset["step_default"])
        level = int(np.nanargmin(abs(one["step_fraction"].values - default)))
        return float(one["step_error"][level])

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
        """One row per method and start: time and errors."""
        return accuracy_report.contacts(self.dataset)

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
        """How many bounces there are."""
        return f"{int(self.dataset['bounce_number'].max()):,}"

    def lammps_ran(self) -> bool:
        """Whether LAMMPS was there when the file was made."""
        return bool(np.isfinite(self.dataset["peer_error"].isel(peer=1)).any())

    def peers(self) -> Table:
        """One row per scene: error and time of this code and of LAMMPS at the default step."""
        made = numbers("scene", "error", "error, LAMMPS", "time over LAMMPS's")
        scenes = self.dataset["step_scene"].values.tolist()
        default = float(self.dataset["step_default"])
        for scene in self.dataset["peer_scene"].values:
            row = scenes.index(scene)
            level = int(np.nanargmin(abs(self.dataset["step_fraction"].values[row] - default)))
            here = self.dataset.sel(peer_scene=scene).isel(step_level=level)
            errors, times = (
                here["peer_error"].values,
                here["peer_time"].median("step_repeat").values,
            )
            if np.isfinite(errors).all():
                made.add_row(
                    str(scene), *(f"{x:.2e}" for x in errors), f"{times[0] / times[1]:.2f}"
                )
        return made


accuracy = Accuracy()
