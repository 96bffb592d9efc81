"""The paper's experiment: draw a cylinder through a bed at rest and record it."""

import numpy as np

from dem.experiment.config import Configuration
from dem.experiment.replicate import Replicate
from dem.io.dataset import WALLS

SECTIONS = {"cylinder": True, "record": True}
RECORD = ("window",)
OBSERVED = ("drag", "snapshots")
AXIS = {
    "displacement": (("displacement",), "m", "displacement of the cylinder, middle of the bin"),
    "displacement_bounds": (("displacement", "bound"), None, None),
    "wall": (("wall",), None, "wall of the box"),
    "snapshot_displacement": (("snapshot",), "m", "displacement of the cylinder at the snapshot"),
}
SIZES = {"displacement": "record.bins", "snapshot": "record.snapshots", "bound": 2, "wall": 4}


def check(configuration: Configuration) -> None:
    """Raise ValueError where there is no averaging window, or none within the stroke."""
    record, stroke = configuration.record, configuration.cylinder.stroke
    if not record.window:
        raise ValueError("record.window is missing; give the displacements of the mean drag")
    if record.window[1] > stroke:
        raise ValueError(
            f"record.window ends at {record.window[1]:g} m, beyond cylinder.stroke, {stroke:g} m"
        )
    if not in_window(configuration).any():
        raise ValueError(
            f"record.window {list(record.window)} holds no bin; each is "
            f"{stroke / record.bins:.3g} m wide"
        )


def in_window(configuration: Configuration) -> np.ndarray:
    """Which bins (bins,) of a run have their middle in the averaging window."""
    record = configuration.record
    middle = (np.arange(record.bins) + 0.5) / record.bins * configuration.cylinder.stroke
    return (middle >= record.window[0]) & (middle <= record.window[1])


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs of a configuration share, by the names of AXIS."""
    stroke, record = configuration.cylinder.stroke, configuration.record
    edges = np.linspace(0.0, stroke, record.bins + 1)
    return {
        "displacement": 0.5 * (edges[1:] + edges[:-1]),
        "displacement_bounds": np.column_stack([edges[:-1], edges[1:]]),
        "wall": np.array(WALLS),
        "snapshot_displacement": np.linspace(0.0, stroke, record.snapshots),
    }


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates."""
    return replicate.configuration.scene.duration
