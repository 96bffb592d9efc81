"""Shapes at equal pressure and at equal packing fraction, in boxes of several widths."""

import json
from functools import cached_property
from types import SimpleNamespace

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.tables import numbers
from dem.experiment.box import sample_diameters
from studies.common.findings import Findings, estimate, span
from studies.pressure.widths import NEAR, Widths

__all__ = ["pressure"]

WAYS = "fraction", "pressure"
OTHERS = "high", "walls"  # boxes of the paper's width


class Pressure(Findings):
    """Drag at equal fraction and at equal pressure, pressure.nc."""

    name, command = "pressure", "snakemake -j2 --configfile studies/pressure/sweep.yaml"
    source = "pressure/drag.nc"

    @cached_property
    def widths(self) -> Widths:
        return Widths(self.dataset)

    @cached_property
    def widest(self) -> str:
        """Name of the widest box: its width over that of the first."""
        return self.widths.boxes[int(np.argmax(self.widths.width))]

    def asked(self) -> str:
        """Pressure on the top wall."""
        return f"{1e-6 * float(self.dataset['packing_pressure_swept'].max()):.0f} MPa"

    def seeds(self) -> str:
        """Beds of each kind."""
        return f"{self.dataset.sizes['seed']}"

    def held(self) -> str:
        """Mean normal stress on the top wall within the window, least and greatest of all runs."""
        found = 1e-6 * self._top()
        return f"{float(found.min()):.1f} to {float(found.max()):.1f} MPa"

    def near(self) -> str:
        """By how much a run's mean pressure misses what is asked, at most."""
        asked = float(self.dataset["packing_pressure_swept"].max())
        return f"{100.0 * float(np.abs(self._top() / asked - 1.0).max()):.1f} %"

    def _top(self, way: str = "pressure"):
        runs = self.dataset.sel(confinement=way)
        force = runs["wall_force"].sel(wall="top")
        inside = (runs["displacement"] >= runs.attrs["window_start"]) & (
            runs["displacement"] <= runs.attrs["window_stop"]
        )
        return force.where(inside).mean("displacement") / (runs["box_width"] * self._thickness)

    @property
    def _thickness(self) -> float:
        """Of all granules (m)."""
        return json.loads(self.dataset.attrs["configuration"])["material"]["thickness"]

    def thickness(self) -> str:
        """Of all granules."""
        return f"{1e3 * self._thickness:.3f} mm"

    def at_fraction(self) -> str:
        """Mean pressure on the top wall of c1 within the window, where the height is kept, in the
        first box."""
        found = self._top("fraction").isel(box=0).sel(shape="c1")
        return f"{1e-6 * float(found.mean()):.0f} MPa"

    def packed(self) -> Table:
        """One row per shape: packing fraction of the beds at rest under the pressure, in the widest
        box."""
        made = numbers("shape", "packing fraction at rest")
        for shape, fraction in self._packed.items():
            made.add_row(shape, f"{fraction:.3f}")
        return made

    def denser(self, one: str, other: str) -> bool:
        """Whether the beds of a shape are denser under the pressure than those of another."""
        return self._packed[one] > self._packed[other]

    @cached_property
    def _packed(self) -> dict[str, float]:
        runs = self.dataset.sel(confinement="pressure", box=self.widest)
        own = json.loads(self.dataset.attrs["configuration"])
        hole = 0.25 * np.pi * own["cylinder"]["diameter"] ** 2
        spread = own["packing"]["size_spread"]
        made = {}
        for shape in self.widths.shapes:
            one = runs.sel(shape=shape)
            sizes = SimpleNamespace(diameter=float(one["diameter"]), granules=int(one["granules"]))
            found = []
            for seed in one["seed"].values:
                area = 0.25 * np.pi * np.sum(sample_diameters(sizes, spread, int(seed)) ** 2)
                height = float(one["box_height"].sel(seed=seed))
                found.append(area / (float(one["box_width"]) * height - hole))
            made[shape] = float(np.mean(found))
        return made

    def lifted(self, shape: str, box: str) -> str:
        """Drag at equal pressure over the force on the top wall, in a box."""
        area = float(self.dataset["box_width"].sel(box=box)) * self._thickness
        force = float(self.dataset["packing_pressure_swept"].max()) * area
        return f"{100.0 * self.widths.drag(('pressure',), shape, box).value / force:.0f} %"

    def ratios(self, way: str) -> Table:
        """One row per shape: drag over that of the first, by box, and in one without end."""
        boxes = self.widths.series
        made = numbers("shape", *(f"box {box}" for box in boxes), "without end")
        for shape in self.widths.shapes[1:]:
            cells = [estimate(self.widths.ratio((way,), shape, box)) for box in boxes]
            made.add_row(shape, *cells, _or_none(self.widths.limit((way,), shape)))
        return made

    def others(self, way: str) -> Table:
        """One row per shape: drag in the other boxes of the paper's width over that in the first box,
        and over that of the first shape."""
        first, others = self.widths.boxes[0], [box for box in OTHERS if box in self.widths.boxes]
        made = numbers(
            "shape", *(f"{box} over box {first}" for box in others),
            *(f"over {self.widths.shapes[0]}, {box}" for box in (f"box {first}", *others)),
        )  # fmt: skip
        for shape in self.widths.shapes:
            made.add_row(
                shape, *(estimate(self.widths.change((way,), shape, box)) for box in others),
                *(estimate(self.widths.ratio((way,), shape, box)) if shape != self.widths.shapes[0] else "1"
                  for box in (first, *others)),
            )  # fmt: skip
        return made

    def change(self, way: str, shape: str, box: str) -> str:
        """Drag in a box over that in the first one."""
        return estimate(self.widths.change((way,), shape, box))

    def changes(self, way: str, box: str) -> str:
        """The least and the greatest of all shapes."""
        found = [self.widths.change((way,), shape, box).value for shape in self.widths.shapes]
        return span(min(found), max(found))

    def grows(self, way: str, box: str) -> bool:
        """Whether the drags of all shapes in a box are above those in the first one, intervals included."""
        return all(self.widths.change((way,), each, box).low > 1.0 for each in self.widths.shapes)

    def stays(self, way: str, box: str, share: float) -> bool:
        """Whether the drag of each shape in a box is that in the first one within a share, intervals included."""
        found = (self.widths.change((way,), each, box) for each in self.widths.shapes)
        return all(1.0 - share < low and high < 1.0 + share for _, low, high in found)

    def leads(self, way: str, box: str, *shapes: str) -> bool:
        """Whether some shapes drag more than the first one in a box, intervals included."""
        return all(self.widths.ratio((way,), shape, box).low > 1.0 for shape in shapes)

    def drags(self, way: str) -> Table:
        """One row per shape: drag by box, without end, and the width that is wide enough."""
        boxes = self.widths.series
        made = numbers(
            "shape", *(f"box {box}, N" for box in boxes), "without end, N", "wide enough, times"
        )
        for shape in self.widths.shapes:
            cells = [estimate(self.widths.drag((way,), shape, box), digits=0) for box in boxes]
            made.add_row(
                shape, *cells, _or_none(self.widths.drag_limit((way,), shape), digits=0),
                f"{wide:.0f}" if np.isfinite(wide := self.widths.enough((way,), shape)) else "-",
            )  # fmt: skip
        return made

    def share(self, way: str, shape: str, width: float) -> str:
        """Drag in a box of some width, by the line, over that in a box without end."""
        return estimate(self.widths.share((way,), shape, width))

    def enough(self, way: str) -> str:
        """Widths that are wide enough, over the paper's, from the least to the greatest."""
        found = [self.widths.enough((way,), shape) for shape in self.widths.shapes]
        return f"{min(found):.0f} to {max(found):.0f}"

    def vanishes(self, way: str, *shapes: str) -> bool:
        """Whether the lines of some shapes may leave no drag in a box without end."""
        return all(self.widths.drag_limit((way,), shape).low == 0.0 for shape in shapes)

    def nearer(self, way: str) -> str:
        """To what the line is fitted: the drag, or its inverse."""
        power = self.widths.powers[self.widths.places.index((way,))]
        return "the drag" if power > 0.0 else "the inverse of the drag"

    def ratio(self, way: str, shape: str, box: str) -> str:
        """Drag over that of the first shape."""
        return estimate(self.widths.ratio((way,), shape, box))

    def limit(self, way: str, shape: str) -> str:
        """Drag over that of the first shape in a box without end."""
        return estimate(self.widths.limit((way,), shape))

    def below(self, way: str, *shapes: str) -> bool:
        """Whether the limits of the ratios of some shapes are below one, intervals included."""
        return all(self.widths.limit((way,), shape).high < 1.0 for shape in shapes)

    def above(self, way: str, *shapes: str) -> bool:
        """Whether they are above one."""
        return all(self.widths.limit((way,), shape).low > 1.0 for shape in shapes)

    def tolerance(self) -> str:
        """What wide enough means."""
        return f"{100.0 * NEAR:.0f} %"

    def at(self, way: str) -> xr.Dataset:
        """Runs of one way in the widest box, over shape and seed."""
        return self.dataset.sel(confinement=way, box=self.widest)


def _or_none(found, digits: int = 2) -> str:
    """An estimate; "none" where it is zero, and its interval too."""
    return estimate(found, digits=digits) if found.high > 0.0 else "none"


pressure = Pressure()
