"""Drag against the velocity of the cylinder."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.statistics import within
from dem.analysis.tables import numbers
from dem.analysis.velocity import Law, Rates, inertial_number, rates
from studies.common.findings import Findings, estimate

__all__ = ["velocity"]

PAPER = 2.0  # m/s


class Velocity(Findings):
    """Drag against velocity with friction (0.3) and without (0.0), velocity.nc."""

    name, command = "velocity", "snakemake -j2 --configfile studies/velocity/sweep.yaml"
    source = "velocity/drag.nc"

    @cached_property
    def rates(self) -> Rates:
        return rates(self.dataset)

    def _law(self, friction: str) -> Law:
        return self.rates.laws[(friction,)]

    def _means(self, friction: str, velocity: float) -> np.ndarray:
        return self.rates.means[(friction,)][:, self.rates.velocity.tolist().index(velocity)]

    def _told(self, samples: np.ndarray, unit: str = "", digits: int = 0) -> str:
        return estimate(self.rates.interval(samples), unit, digits)

    def beds(self) -> str:
        """Number of beds."""
        return f"{self.rates.beds}"

    def number(self, velocity: float) -> str:
        """Inertial number at a velocity."""
        return f"{velocity * inertial_number(self.dataset):.2g}"

    def pressure(self) -> str:
        """Mean pressure on the walls before the cylinder moves."""
        return f"{1e-6 * float(self.dataset['packing_pressure'].mean()):.0f} MPa"

    def limit(self, friction: str) -> str:
        """Quasi-static limit of the drag."""
        return self._told(self._law(friction).limit, "N")

    def above(self, friction: str, velocity: float = PAPER) -> str:
        """How far the drag is above its limit."""
        return self._told(100.0 * self._law(friction).above(velocity), "%")

    def change(self, friction: str, velocity: float = PAPER) -> str:
        """Change of the mean drag from the lowest velocity to another, beds paired, without a law."""
        slowest = self._means(friction, self.rates.velocity[0])
        return self._told(100.0 * (self._means(friction, velocity) / slowest - 1.0), "%")

    def within(self, friction: str, share: float, velocity: float = PAPER) -> bool:
        """Whether the drag at a velocity is within a share of its limit, interval included."""
        found = self.rates.interval(self._law(friction).above(velocity))
        return max(abs(found.low), abs(found.high)) < share

    def tenth(self, friction: str) -> str:
        """Velocity at which the drag is a tenth above its limit."""
        return self._told(self._law(friction).reaches(0.1), "m/s", 1)

    def risen(self, friction: str, velocity: float = PAPER) -> bool:
        """Whether the drag at a velocity is above its limit, interval included."""
        return self.rates.interval(self._law(friction).above(velocity)).low > 0.0

    def exponent(self, friction: str) -> str:
        """Exponent of the law."""
        return self._told(self._law(friction).exponent, digits=2)

    def share(self) -> str:
        """Share of the limit with friction that vanishes without."""
        return self._told(100.0 * self._share(), "%")

    def rest(self) -> str:
        """Limit without friction, over that with it."""
        return self._told(100.0 * (1.0 - self._share()), "%")

    def _share(self) -> np.ndarray:
        return 1.0 - self._law("0.0").limit / self._law("0.3").limit

    def falls(self) -> bool:
        """Whether drag with friction over that without is less at the highest than at the lowest
        velocity, interval included."""
        first, last = (
            self._means("0.3", v) / self._means("0.0", v) for v in self.rates.velocity[[0, -1]]
        )
        return self.rates.interval(last / first).high < 1.0

    def below(self, friction: str, exponent: float) -> bool:
        """Whether the exponent of the law is below a number, interval included."""
        return self.rates.interval(self._law(friction).exponent).high < exponent

    def yields(self, friction: str) -> bool:
        """Whether the limit is above zero, interval included."""
        return self.rates.interval(self._law(friction).limit).low > 0.0

    def tangential(self, velocity: float) -> str:
        """Share of tangential forces on the cylinder in the drag with friction."""
        runs = self.dataset.sel(friction="0.3", cylinder_velocity=velocity)
        window = self.dataset.attrs["window_start"], self.dataset.attrs["window_stop"]
        part, whole = (within(runs[name], *window) for name in ("drag_tangential", "drag"))
        return f"{100.0 * float(part.mean() / whole.mean()):.0f} %"

    def count(self) -> str:
        """Number of velocities."""
        return f"{len(self.rates.velocity)}"

    def slowest(self) -> str:
        """The lowest velocity."""
        return f"{self.rates.velocity[0]:.2g} m/s"

    def misses(self, friction: str) -> str:
        """By how much the law misses a mean at most."""
        law, means = self._law(friction), self.rates.means[(friction,)][0]
        found = np.array([law.drag(v)[0] for v in self.rates.velocity])
        return f"{100.0 * np.abs(found / means - 1.0).max():.0f} %"

    def laws(self) -> Table:
        """One row per friction: the law."""
        made = numbers(
            "friction",
            "limit, N",
            "exponent",
            f"above the limit at {PAPER:g} m/s, %",
            "10 % above it at, m/s",
        )
        for friction in ("0.0", "0.3"):
            law = self._law(friction)
            made.add_row(
                friction,
                self._told(law.limit),
                self._told(law.exponent, digits=2),
                self._told(100.0 * law.above(PAPER)),
                self._told(law.reaches(0.1), digits=1),
            )
        return made

    def table(self) -> Table:
        """One row per velocity: mean drags and their ratio, beds paired."""
        made = numbers(
            "velocity, m/s",
            "inertial number",
            "drag without friction, N",
            "with friction, N",
            "with over without",
            words=0,
        )
        for v in self.rates.velocity.tolist():
            smooth, rough = (self._means(friction, v) for friction in ("0.0", "0.3"))
            told = self._told(smooth), self._told(rough), self._told(rough / smooth, digits=2)
            made.add_row(f"{v:g}", self.number(v), *told)
        return made


velocity = Velocity()
