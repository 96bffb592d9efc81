"""The packing of one bed as work: its threads, how far it is, and the file that keeps it."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from dem.base.errors import InputError
from dem.base.files import atomic, check_output
from dem.dynamics.checkpoint import fingerprint, replaced, written
from dem.dynamics.world import World

SAVED_EVERY = 60.0  # s between two times that a bed is kept
STAGE = "stage_"  # how names of arrays begin that are not the minimiser's


def ignored(iterations: int, net_force: float) -> None:
    """Nobody is told how far a bed is."""


class Job:
    """The packing of one bed.

    Attributes
    ----------
    threads : int
        Number of threads; the bed does not depend on it.
    path : Path or None
        The file that keeps it.
    report : callable
        Called with the iterations so far and the greatest net force (E* R^2), after every piece.
    stage : dict of str to ndarray
        Where the packing is, but for the minimisation under way: numbers that follow from the last
        ones that were done.
    iterations : int
        Iterations of all minimisations so far.
    """

    def __init__(
        self,
        threads: int = 1,
        path: Path | None = None,
        report: Callable[[int, float], None] = ignored,
    ) -> None:
        self.path = None if path is None else check_output("checkpoint", path)
        self.threads, self.report = threads, report
        self.stage: dict[str, Any] = {}
        self.iterations = 0
        self._saved: dict[str, np.ndarray] | None = None
        self._arrays: dict[str, Any] = {}
        self._saved_at = time.monotonic()

    def begin(self, *bed: Any) -> None:
        """Take up what the file has of a bed, which these values tell from others.

        Raises InputError where it is the file of another bed, or something else.
        """
        self._bed = fingerprint(*bed)
        if self.path is None or not self.path.is_file():
            return
        try:
            with np.load(self.path) as file:
                saved = dict(file)
            if not np.array_equal(saved["bed"], self._bed):
                raise InputError("it is of another bed")
        except Exception as error:
            raise InputError(
                f"{self.path}: no packing can go on from it ({error}); delete it, or name another file."
            ) from None
        self.stage = {k.removeprefix(STAGE): v for k, v in saved.items() if k.startswith(STAGE)}
        self.iterations = int(self.stage.pop("iterations"))
        self._saved = saved

    # What the minimiser asks

    def order(self, compute: Callable[[], np.ndarray]) -> np.ndarray:
        """The order of granules in memory: that of a minimisation that was stopped, or a new one."""
        return compute() if self._saved is None else self._saved["order"]

    def take_up(self, world: World, memory: np.ndarray, left: int) -> tuple[World, np.ndarray, int]:
        """The arrays of a minimisation that was stopped, once; else as they are."""
        saved, self._saved, self._arrays = self._saved, None, {}
        if saved is None:
            return world, memory, left
        alone = world.force is world.constituent_force
        world = replaced(world, saved, "world")
        if alone:  # one array where a granule is its own only constituent
            world = world._replace(constituents=world.bodies, force=world.constituent_force)
        return world, saved["memory"], int(saved["left"])

    def reached(self, done: int, net_force: float, **arrays: Any) -> None:
        """Where a minimisation is after some more iterations: it is reported, and kept now and then.

        net_force: greatest one (E* R^2); arrays: world, order, memory and left.
        """
        self.iterations += done
        self._arrays = arrays
        self.report(self.iterations, net_force)
        if time.monotonic() - self._saved_at > SAVED_EVERY:
            self.save()

    def save(self, **changes: Any) -> None:
        """Keep what is reached, but for some changes, whole or not at all."""
        if self.path is None or not self._arrays:
            return
        self._arrays |= changes
        stage = self.stage | {"iterations": self.iterations}
        stage = {f"{STAGE}{name}": value for name, value in stage.items()}
        arrays = written(**self._arrays, **stage, bed=self._bed)
        with atomic(self.path) as part, part.open("wb") as file:
            np.savez(file, **arrays)
        self._saved_at = time.monotonic()
