"""Shapes at equal pressure and at equal packing fraction, in boxes of several widths."""

import json
from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.experiment.bed_description import sample_diameters
from studies.common.findings import Findings, estimate, numbers
from studies.pressure.widths import Widths

__all__ = ["pressure"]

OTHERS = "high", "walls"  # boxes of the paper's width


class Pressure(Findings):
    """Drag at equal fraction and at equal pressure, pressure.nc."""

    name, command = "pressure", "snakemake -j2 --configfile studies/pressure/sweep.yaml"
    source = "pressure/drag.nc"

    @cached_property
    def widths(self) -> dict[str, Widths]:
        """By what is held while the cylinder moves: `fraction` or `pressure`."""
        ways = self.dataset["confinement"].values.tolist()
        return {way: Widths(self.dataset.sel(confinement=way)) for way in ways}

    @cached_property
    def widest(self) -> str:
        """Name of the widest box: its width over that of the first."""
        widths = self.widths["pressure"]
        return widths.boxes[int(np.argmax(widths.width))]

    @cached_property
    def top_pressure(self) -> float:
        """Pressure on the top wall (Pa), as the sweep asks for."""
        return float(self.dataset["packing_pressure_swept"].max())

    def on_top(self, way: str = "pressure") -> xr.DataArray:
        """Mean normal stress on the top wall (Pa) of each run, within the averaging window."""
        runs = self.dataset.sel(confinement=way)
        low, high = (runs.attrs[f"window_{end}"] for end in ("start", "stop"))
        inside = (runs["displacement"] >= low) & (runs["displacement"] <= high)
        force = runs["wall_force"].sel(wall="top").where(inside).mean("displacement")
        return force / (runs["box_width"] * self.thickness)

    @cached_property
    def configuration(self) -> dict:
        return json.loads(self.dataset.attrs["configuration"])

    @property
    def thickness(self) -> float:
        """Of all granules (m)."""
        return self.configuration["material"]["thickness"]

    def packed(self) -> Table:
        """One row per shape: packing fraction of the beds at rest under the pressure, in the widest
        box."""
        rows = ((shape, f"{fraction:.3f}") for shape, fraction in self.fractions.items())
        return numbers("shape", "packing fraction at rest", rows=rows)

    @cached_property
    def fractions(self) -> dict[str, float]:
        """Packing fraction at rest under the pressure, by shape, in the widest box."""
        runs = self.at("pressure")
        hole = 0.25 * np.pi * self.configuration["cylinder"]["diameter"] ** 2
        spread = self.configuration["packing"]["size_spread"]
        fractions = {}
        for shape in self.widths["pressure"].shapes:
            one = runs.sel(shape=shape)
            sizes = float(one["diameter"]), int(one["granules"]), spread
            diameters = [sample_diameters(*sizes, int(seed)) for seed in one["seed"].values]
            area = 0.25 * np.pi * np.sum(np.square(diameters), axis=1)
            room = float(one["box_width"]) * one["box_height"].values - hole
            fractions[shape] = float(np.mean(area / room))
        return fractions

    def lifted(self, shape: str, box: str) -> float:
        """Drag at equal pressure over the force on the top wall, in a box."""
        area = float(self.dataset["box_width"].sel(box=box)) * self.thickness
        return self.widths["pressure"].drag(shape, box).value / (self.top_pressure * area)

    def ratios(self, way: str) -> Table:
        """One row per shape: drag over that of the first, by box, and at infinite width."""
        widths = self.widths[way]
        rows = (
            (
                shape,
                *(estimate(widths.ratio(shape, box)) for box in widths.series),
                _limit(widths.limit(shape)),
            )
            for shape in widths.shapes[1:]
        )
        return numbers("shape", *(f"{box}x width" for box in widths.series), "infinite", rows=rows)

    def others(self, way: str) -> Table:
        """One row per shape: drag in the other boxes of the paper's width over that in the first box,
        and over that of the first shape."""
        widths = self.widths[way]
        first, base = widths.boxes[0], widths.shapes[0]
        others = [box for box in OTHERS if box in widths.boxes]
        heads = [f"{box} / box {first}" for box in others]
        heads += [f"{box}, relative to {base}" for box in (f"box {first}", *others)]
        rows = []
        for shape in widths.shapes:
            ratios = (widths.ratio(shape, box) for box in (first, *others))
            cells = [estimate(widths.change(shape, box)) for box in others]
            cells += [estimate(ratio) if shape != base else "1" for ratio in ratios]
            rows.append((shape, *cells))
        return numbers("shape", *heads, rows=rows)

    def drags(self, way: str) -> Table:
        """One row per shape: drag by box, at infinite width, the width that is wide enough, and what
        the line misses."""
        widths, rows = self.widths[way], []
        for shape in widths.shapes:
            cells = [estimate(widths.drag(shape, box), digits=0) for box in widths.series]
            wide = widths.enough(shape)
            cells += [
                _limit(widths.drag_limit(shape), digits=0),
                f"{wide:.0f}" if wide < np.inf else "-",
                f"{widths.misfit(shape):.1f}",
            ]
            rows.append((shape, *cells))
        heads = (
            *(f"{box}x width, N" for box in widths.series),
            "infinite, N",
            "width within 5 % of the limit, x the paper's",
            "reduced χ²",
        )
        return numbers("shape", *heads, rows=rows)

    def changes(self, way: str, box: str) -> np.ndarray:
        """Drags (shape, 3) in a box over those in the first one: values and ends of the intervals."""
        return np.array([self.widths[way].change(shape, box) for shape in self.widths[way].shapes])

    def enough(self, way: str) -> list[float]:
        """Widths that are wide enough, over the paper's, by shape."""
        return [self.widths[way].enough(shape) for shape in self.widths[way].shapes]

    def leads(self, way: str, box: str, *shapes: str) -> bool:
        """Whether some shapes drag more than the first one in a box, intervals included."""
        return all(self.widths[way].ratio(shape, box).low > 1.0 for shape in shapes)

    def below(self, way: str, *shapes: str) -> bool:
        """Whether some shapes drag less than the first one in the widest box, intervals included."""
        return all(self.widths[way].ratio(shape, self.widest).high < 1.0 for shape in shapes)

    def above(self, way: str, *shapes: str) -> bool:
        """Whether some shapes drag more than the first one in the widest box, intervals included."""
        return self.leads(way, self.widest, *shapes)

    def nearer(self, way: str) -> str:
        """To what the line is fitted: the drag, or its inverse."""
        return "the drag" if self.widths[way].power > 0.0 else "the inverse of the drag"

    def at(self, way: str) -> xr.Dataset:
        """Runs of one way in the widest box, over shape and seed."""
        return self.dataset.sel(confinement=way, box=self.widest)


def _limit(limit, digits: int = 2) -> str:
    """An estimate; a dash where there may be no drag, because the line does not hold that far."""
    return estimate(limit, digits=digits) if limit.low > 0.0 else "-"


pressure = Pressure()
