"""The packing of one bed as work: its threads, how far it is, and the file that keeps it."""

import time

import numpy as np

from dem.base.errors import InputError
from dem.base.files import arrays_of, check_output, write_arrays
from dem.dynamics.checkpoint import fingerprint, written

SAVED_EVERY = 60.0  # s between two times that a bed is kept
STAGE = "stage_"  # how names of arrays begin that are not the minimiser's


class Job:
    """The packing of one bed.

    Attributes
    ----------
    threads : int
        Number of threads; the bed does not depend on it.
    path : Path or None
        The file that keeps it.
    report : callable or None
        Called with the iterations so far and the greatest net force (E* R^2), after every piece.
    stage : dict of str to ndarray
        Where the packing is, but for the minimisation under way: the iterations of all so far, and
        numbers that follow from the last ones that were done.
    """

    def __init__(self, threads=1, path=None, report=None):
        self.path = None if path is None else check_output("checkpoint", path)
        self.threads, self.report = threads, report
        self.stage, self._saved, self._arrays = {"iterations": 0}, None, {}
        self._saved_at = time.monotonic()

    def begin(self, *bed):
        """Take up what the file has of a bed, which these values tell from others.

        Raises InputError where it is the file of another bed, or something else.
        """
        self._bed = fingerprint(*bed)
        if self.path is None or not self.path.is_file():
            return
        saved = arrays_of(self.path)
        if saved is None or not np.array_equal(saved.get("bed"), self._bed):
            raise InputError(
                f"{self.path}: it is damaged or of another bed; delete it, or name another file."
            )
        self.stage = {k.removeprefix(STAGE): v for k, v in saved.items() if k.startswith(STAGE)}
        self._saved = saved

    def stopped(self):
        """The arrays of a minimisation that was stopped, once: order, memory, left and a world; or
        None."""
        saved, self._saved, self._arrays = self._saved, None, {}
        return saved

    def reached(self, done, net_force, **arrays):
        """Where a minimisation is after some more iterations: it is reported, and kept now and then.

        net_force: greatest one (E* R^2); arrays: world, order, memory and left.
        """
        self.stage["iterations"] += done
        self._arrays = arrays
        if self.report:
            self.report(int(self.stage["iterations"]), net_force)
        if time.monotonic() - self._saved_at > SAVED_EVERY:
            self.save()

    def save(self, **changes):
        """Keep what is reached, but for some changes, whole or not at all."""
        if self.path is None or not self._arrays:
            return
        stage = {f"{STAGE}{name}": value for name, value in self.stage.items()}
        write_arrays(self.path, written(**self._arrays | changes, **stage, bed=self._bed))
        self._saved_at = time.monotonic()
