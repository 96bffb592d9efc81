"""Any scene: granules around solids that have names and move in phases. The last phase is recorded.

A phase takes a time, or lasts until the granules are at rest; solids that it does not name move on.
"""

from pathlib import Path

import numpy as np

from dem.experiment.config import Configuration
from dem.experiment.run import Replicate

SECTIONS = {"solids": True, "phases": True, "record": True}
OBSERVED = ("scene",)
AXIS = {
    "time": (("time",), "s", "time since the last phase began, middle of the bin"),
    "snapshot_time": (("snapshot",), "s", "time since the last phase began at the snapshot"),
}
SIZES = {"time": "record.bins", "snapshot": "record.snapshots"}


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs share."""
    record, duration = configuration.record, configuration.duration
    return {
        "time": duration * (np.arange(record.bins) + 0.5) / record.bins,
        "snapshot_time": np.linspace(0.0, duration, record.snapshots),
    }


def run(
    replicate: Replicate,
    bed=None,
    progress=lambda done: None,
    checkpoint: Path | None = None,
) -> dict:
    """Make one run; all is as of `dem.experiment.recording.recorded`."""
    from dem.experiment.bed import make_bed
    from dem.experiment.recording import recorded

    return recorded(replicate, bed or make_bed(replicate.bed_description), progress, checkpoint)


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates, but for what it takes to come to rest."""
    return sum(phase.time or 0.0 for phase in replicate.configuration.phases.values())
