"""What beds remember of how they were made."""

from functools import cached_property

import numpy as np
import yaml
from scipy.stats import t

from .common import DATA, heads, interval

BOXES = {"paper": "the paper's", "wide": "twice the width"}


class Preparation:
    """Mean drags of relaxed and of grown beds, from docs/data/preparation.yaml."""

    @cached_property
    def _found(self) -> dict:
        return yaml.safe_load((DATA / "preparation.yaml").read_text(encoding="utf-8"))

    def _sample(self, box: str, shape: str, way: str) -> np.ndarray:
        return np.array(self._found["drag"][box][shape][way], float)

    def mean(self, box: str, shape: str, way: str) -> str:
        """Mean drag with its 95 % interval."""
        sample = self._sample(box, shape, way)
        half = t.ppf(0.975, len(sample) - 1) * sample.std(ddof=1) / np.sqrt(len(sample))
        return interval(sample.mean(), half, "N")

    def ratio(self, box: str, shape: str) -> float:
        """Mean drag of grown beds over that of relaxed ones."""
        return float(self._sample(box, shape, "grown").mean() / self._sample(box, shape, "relaxed").mean())  # fmt: skip

    def shrinks(self, shape: str, way: str) -> float:
        """Mean drag in the wide box over that in the paper's."""
        return float(self._sample("wide", shape, way).mean() / self._sample("paper", shape, way).mean())  # fmt: skip

    def table(self):
        """Drags of both ways, by box and shape."""
        made = heads(2, "box", "shape", "beds", "relaxed", "grown", "grown over relaxed")
        for box, shapes in self._found["drag"].items():
            for shape in shapes:
                ways = [self.mean(box, shape, way) for way in ("relaxed", "grown")]
                beds = str(len(self._sample(box, shape, "grown")))
                made.add_row(BOXES[box], shape, beds, *ways, f"{self.ratio(box, shape):.2f}")
        return made

    @property
    def made(self) -> str:
        """Where the numbers come from."""
        found = self._found
        return (
            f"*Runs of `{found['command']}`, computed at revision `{found['revision']}` on "
            f"{found['date']}; file `docs/data/preparation.yaml`. Intervals are 95 %.*"
        )


preparation = Preparation()
