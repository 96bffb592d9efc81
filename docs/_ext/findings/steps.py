"""What the held time step changed: docs/data/steps.yaml."""

from functools import cached_property
from pathlib import Path

import yaml
from rich.table import Table

from dem.analysis.tables import numbers
from studies.common.findings import estimate, interval

__all__ = ["steps"]


class Steps:
    """Collisions and gases before and now, steps.yaml: measured by hand, with revision and date."""

    path = Path(__file__).parents[2] / "data/steps.yaml"

    @cached_property
    def content(self) -> dict:
        return yaml.safe_load(self.path.read_text(encoding="utf-8"))

    def restitution(self) -> Table:
        """Excess of the measured restitution over the one asked for, a row per restitution."""
        made = numbers(
            "restitution", "before, at 0.5, %", "now, at 0.5, %", "now, at 0.3, %",
            "change of its definition", words=0,
        )  # fmt: skip
        for asked, found in self.content["restitution"].items():
            cells = (estimate(found[name]) for name in ("before", "half", "now"))
            made.add_row(f"{asked}", *cells, "none")
        return made

    def worst(self, name: str, least: float = 0.0) -> str:
        """Greatest excess of any phase, either way, in %; of restitutions from `least` on."""
        rows = (row[name] for e, row in self.content["restitution"].items() if e >= least)
        return f"{max(max(abs(low), abs(high)) for _, low, high in rows):.1f}"

    def gas(self) -> Table:
        """Change of the energy of an elastic gas, a row per modulus."""
        sides = self.content["gas"]["sides"]
        made = numbers("Young's modulus", *(f"{each}, 10⁻³" for each in sides))
        for modulus, found in self.content["gas"].items():
            if modulus != "sides":
                made.add_row(modulus, *map(str, found))
        return made

    def greatest(self) -> str:
        """Greatest change of the energy of any of these gases, relative."""
        return f"{self.content['greatest']:g}\N{NO-BREAK SPACE}·\N{NO-BREAK SPACE}10⁻³"

    def keeps_gas(self, limit: float) -> bool:
        """Whether no gas is farther off its first energy than a limit, relative."""
        return self.content["greatest"] * 1e-3 <= limit

    def first(self) -> Table:
        """Change of the energy of a small gas and run time, a row per modulus."""
        made = numbers(
            "Young's modulus", "energy before, %", "energy now, %", "run time before, s", "run time now, s",
        )  # fmt: skip
        for modulus, found in self.content["first"].items():
            before, now = found["before"], found["now"]
            energy = (f"{each[0]:+g}".replace("-", "\N{MINUS SIGN}") for each in (before, now))
            made.add_row(modulus, *energy, f"{before[1]:.2f}", f"{now[1]:.2f}")
        return made

    def drag(self) -> Table:
        """Change of the mean drag, a row per shape."""
        made = numbers("shape", "change of the mean drag", "runs")
        for shape, (value, half, runs) in self.content["drag"].items():
            made.add_row(shape, interval(value, half, "%", 1), str(runs))
        return made

    def small(self, name: str) -> str:
        """Root mean square or greatest change of the energy of nine more small gases, in %."""
        return f"{self.content['small'][name]:.1f}"

    @cached_property
    def made(self) -> str:
        """Where the numbers come from, as a line under a table."""
        about = self.content
        return (
            f"*Measured on {about['date']}, {about['machine']}; before is revision `{about['before']}`; "
            f"file `docs/data/{self.path.name}`.*"
        )


steps = Steps()
