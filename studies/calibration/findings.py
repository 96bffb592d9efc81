"""The calibration of Young's modulus."""

from functools import cached_property
from pathlib import Path

import yaml

__all__ = ["calibration"]


class Calibration:
    """The fitted Young's modulus, from studies/calibration/calibration.yaml."""

    @cached_property
    def _found(self) -> dict:
        return yaml.safe_load(
            Path(__file__).with_name("calibration.yaml").read_text(encoding="utf-8")
        )

    @property
    def modulus(self) -> str:
        """Young's modulus, in GPa."""
        return f"{1e-9 * self._found['young_modulus']:.1f} GPa"

    @property
    def interval(self) -> str:
        """Its 95 % interval."""
        low, high = self._found["interval"]
        return f"{1e-9 * low:.1f} to {1e-9 * high:.1f} GPa"

    @property
    def exponent(self) -> str:
        """p of drag ~ E^p."""
        return f"{self._found['exponent']:.2f}"

    @property
    def scatter(self) -> str:
        """Standard deviation of the mean drag of one run over the mean."""
        return f"{100 * self._found['scatter']:.0f} %"

    @property
    def runs(self) -> str:
        return str(self._found["runs"])

    @property
    def made(self) -> str:
        """Where the numbers come from."""
        found = self._found
        return (
            f"*Computed by `{found['command']}` at revision `{found['revision']}` on "
            f"{found['date']}; file `studies/calibration/calibration.yaml`.*"
        )


calibration = Calibration()
