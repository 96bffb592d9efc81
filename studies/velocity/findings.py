"""Drag against the velocity of the cylinder."""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.drag import within
from dem.analysis.velocity import Law, Rates, inertial_number, rates
from dem.base.statistics import Estimate, mean_interval
from studies.common.findings import Findings, estimate, numbers

__all__ = ["velocity"]

PAPER = 2.0  # m/s


class Velocity(Findings):
    """Drag against velocity with friction (0.3) and without (0.0), velocity.nc.

    What a friction has is by its label: `limit["0.3"]`.
    """

    name, command = "velocity", "snakemake -j2 --configfile studies/velocity/sweep.yaml"
    source = "velocity/drag.nc"

    @cached_property
    def rates(self) -> Rates:
        """Mean drags and the laws fitted to them."""
        return rates(self.dataset)

    def _of_laws(self, number: Callable[[Law], np.ndarray]) -> dict[str, Estimate]:
        laws = self.rates.laws.items()
        return {friction: self.rates.interval(number(law)) for (friction,), law in laws}

    def _means(self, friction: str, velocity: float) -> np.ndarray:
        return self.rates.means[(friction,)][:, self.rates.velocity.tolist().index(velocity)]

    @property
    def pressure(self) -> float:
        """Mean pressure (Pa) on the walls before the cylinder moves."""
        return float(self.dataset["packing_pressure"].mean())

    @cached_property
    def limit(self) -> dict[str, Estimate]:
        """Quasi-static limit of the drag (N)."""
        return self._of_laws(lambda law: law.limit)

    @cached_property
    def above(self) -> dict[str, Estimate]:
        """How far the drag at the paper's velocity is above its limit, in %."""
        return self._of_laws(lambda law: 100.0 * (law.rise * PAPER**law.exponent))

    @cached_property
    def tenth(self) -> dict[str, Estimate]:
        """Velocity (m/s) at which the drag is a tenth above its limit; infinite where it never is."""

        def reached(law: Law) -> np.ndarray:
            with np.errstate(divide="ignore"):
                return (0.1 / np.fmax(law.rise, 0.0)) ** (1.0 / law.exponent)

        return self._of_laws(reached)

    @cached_property
    def exponent(self) -> dict[str, Estimate]:
        """Exponent of the law."""
        return self._of_laws(lambda law: law.exponent)

    @property
    def rest(self) -> Estimate:
        """Limit without friction over that with it, in %."""
        smooth, rough = (self.rates.laws[(friction,)].limit for friction in ("0.0", "0.3"))
        return self.rates.interval(100.0 * smooth / rough)

    @property
    def share(self) -> Estimate:
        """Share of the limit with friction that vanishes without, in %."""
        value, low, high = (100.0 - part for part in self.rest)
        return Estimate(value, high, low)

    @property
    def falls(self) -> bool:
        """Whether drag with friction over that without is less at the highest than at the lowest
        velocity, interval included."""
        first, last = (
            self._means("0.3", v) / self._means("0.0", v) for v in self.rates.velocity[[0, -1]]
        )
        return self.rates.interval(last / first).high < 1.0

    def within(self, friction: str, share: float) -> bool:
        """Whether the drag at the paper's velocity is within a share of its limit, interval
        included."""
        _, low, high = self.above[friction]
        return max(abs(low), abs(high)) < 100.0 * share

    def number(self, velocity: float) -> float:
        """Inertial number at a velocity."""
        return velocity * inertial_number(self.dataset)

    def change(self, friction: str) -> Estimate:
        """Change of the mean drag from the lowest velocity to the paper's, beds paired, without
        a law, in %."""
        slowest = self._means(friction, self.rates.velocity[0])
        return self.rates.interval(100.0 * (self._means(friction, PAPER) / slowest - 1.0))

    def tangential(self, velocity: float) -> tuple[float, float]:
        """Share of tangential forces on the cylinder in the drag with friction, mean over the beds
        and half its interval."""
        runs = self.dataset.sel(friction="0.3", cylinder_velocity=velocity)
        window = self.dataset.attrs["window_start"], self.dataset.attrs["window_stop"]
        part, whole = (within(runs[name], *window) for name in ("drag_tangential", "drag"))
        mean = mean_interval(part / whole)
        return mean.value, mean.half

    def misses(self, friction: str) -> float:
        """By how much the law misses a mean at most, over the mean."""
        law, means = self.rates.laws[(friction,)], self.rates.means[(friction,)][0]
        drags = np.array([law.drag(v)[0] for v in self.rates.velocity])
        return np.abs(drags / means - 1.0).max()

    def laws(self) -> Table:
        """One row per friction: the law."""
        above = f"above the limit at {PAPER:g} m/s, %"
        heads = {"limit, N": 0, "exponent": 2, above: 0, "10 % above it at, m/s": 1}
        columns = self.limit, self.exponent, self.above, self.tenth
        table = numbers("friction", *heads)
        for friction in ("0.0", "0.3"):
            cells = zip(columns, heads.values(), strict=True)
            table.add_row(friction, *(estimate(of[friction], "", n) for of, n in cells))
        return table

    def table(self) -> Table:
        """One row per velocity: mean drags and their ratio, beds paired."""
        heads = "drag without friction, N", "with friction, N", "with / without"
        table = numbers("velocity, m/s", "inertial number", *heads, words=0)
        for v in self.rates.velocity.tolist():
            smooth, rough = (self._means(friction, v) for friction in ("0.0", "0.3"))
            columns = zip((smooth, rough, rough / smooth), (0, 0, 2), strict=True)
            cells = (estimate(self.rates.interval(values), "", n) for values, n in columns)
            table.add_row(f"{v:g}", f"{self.number(v):.2g}", *cells)
        return table


velocity = Velocity()
