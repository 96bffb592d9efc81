"""Forces on outlines that no coefficient was fitted to: measured, and by resistive force theory.

Theory sums over the sides of an outline twice: with the nine coefficients, and with the stress on plates
as it was measured, between angles by lines. The first fails by its form too, the second by locality alone.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.rft import BEGIN, Plates, Resistance, fitted, mirrored
from dem.base.statistics import Estimate, student
from dem.experiment.intruders import intruder_of
from dem.io.dataset import read
from dem.sweep.state import SweepState
from studies.common.results import ORIGIN, runs

HERE = Path(__file__).parent
SWEEPS = "outlines", "half", "corner"
NAMES = "solid_force_x", "solid_force_y", "surface_height", "run_time"
BY = "measured", "theory", "plates"  # forces: of runs, by coefficients, by measured plates


class Cell(NamedTuple):
    """An outline in a direction, with the forces (s, 2) of s runs in N, an outline (k, 2) about its
    position (m), its depth (m) while it is measured, its velocity (m/s) and the thickness (m)."""

    outline: str
    way: str
    force: np.ndarray
    ring: np.ndarray
    depth: float
    velocity: np.ndarray
    thickness: float
    time: float


def cells(state: SweepState) -> Iterator[Cell]:
    """All of a sweep, from its runs."""
    found: dict[tuple, list] = {}
    for block, point, run, values in runs(state, NAMES):
        at = zip(block.axes, point, strict=True)
        labels = {axis.name: axis.coordinate[number] for axis, number in at}
        key = labels["outline"], labels["way"], labels["solids_body_y"]
        found.setdefault(key, []).append((run, values))
    for (outline, way, _), group in found.items():
        yield cell_of(outline, way, group)


def cell_of(outline: str, way: str, group: list) -> Cell:
    """One of runs that differ in their seeds, with their values."""
    configuration = group[0][0].configuration
    body, phase = configuration.solids["body"], configuration.phases["pull"]
    motion = phase.motion["body"]
    velocity = motion.velocity * np.array(motion.ahead)
    force = np.array([[values[name] for name in NAMES[:2]] for _, values in group])[:, :, 0]
    bins = force.shape[2]
    late = (np.arange(bins) + 0.5) / bins >= BEGIN
    surface = np.median([values["surface_height"][0] for _, values in group], axis=1).mean()
    intruder = intruder_of(body)
    height = body.y + velocity[1] * phase.time * (np.arange(bins) + 0.5)[late].mean() / bins
    return Cell(
        outline,
        way,
        force[..., late].mean(axis=2),
        intruder.solid(0.0).placed((0.0, 0.0), intruder.angle, 257),
        surface - height,
        velocity,
        configuration.material.thickness,
        sum(float(values["run_time"]) for _, values in group),
    )


def scatter_of(forces: list[np.ndarray]) -> tuple[float, int]:
    """How much the forces (s, 2) of runs scatter about the mean of their cell, relative to its length: standard
    deviation of a component, and its degrees of freedom."""
    means = [force.mean(axis=0) for force in forces]
    off = [(f - m) / np.hypot(*m) for f, m in zip(forces, means, strict=True)]
    freedom = 2 * sum(len(force) - 1 for force in forces)
    return float(np.sqrt(sum((x**2).sum() for x in off) / freedom)), freedom


def seen(cell: Cell, scatter: float, freedom: int) -> list[Estimate]:
    """Mean force along x and y (N), with the interval of what all cells of its direction scatter by."""
    mean = cell.force.mean(axis=0)
    half = float(student(scatter * np.hypot(*mean) / np.sqrt(len(cell.force)), freedom))
    return [Estimate(f, f - half, f + half) for f in mean]


def by_plates(plates: Plates, cell: Cell) -> list[Estimate]:
    """Force along x and y (N) as the sum of the plates that were measured, with the interval of their seeds."""
    side, middle = np.diff(cell.ring, axis=0), 0.5 * (cell.ring[1:] + cell.ring[:-1])
    leads = side[:, 1] * cell.velocity[0] - side[:, 0] * cell.velocity[1] > 0.0
    side, depth = side[leads], cell.depth - middle[leads, 1]
    beta, gamma, sign = mirrored(
        np.arctan2(side[:, 1], side[:, 0]), np.tile(cell.velocity, (len(side), 1))
    )
    here = np.flatnonzero(np.abs(plates.direction - gamma[0]) < 1e-3)
    here = here[np.argsort(plates.angle[here])]
    share = np.array(
        [np.interp(beta, plates.angle[here], row, period=np.pi) for row in np.eye(len(here))]
    )
    weight = share @ (depth * np.hypot(*side.T) * cell.thickness)
    alpha = plates.alpha
    free = alpha.shape[1] - 1
    noise = np.nanvar(alpha, axis=1, ddof=1).mean(axis=0) / alpha.shape[1]
    force = weight @ np.nanmean(alpha[here], axis=1) * [-sign[0], 1.0]
    half = student(np.sqrt((weight**2).sum() * noise), free * len(alpha))
    return [Estimate(f, f - h, f + h) for f, h in zip(force, half, strict=True)]


def loads(resistance: Resistance, cell: Cell) -> tuple[Estimate, Estimate]:
    """Force along x and y (N) by the coefficients."""
    found = resistance.loads(cell.ring, (0.0, -cell.depth), cell.velocity, cell.thickness)
    return found.force_x, found.force_y


def dataset_of(plates: Plates, attributes: dict) -> xr.Dataset:
    """Forces of all cells with their intervals, by each way; attributes: of the file of the plates."""
    states = [SweepState.of(HERE / f"{name}.yaml") for name in SWEEPS]
    resistance, found = fitted(plates), [cell for state in states for cell in cells(state)]
    scatter = {
        way: scatter_of([c.force for c in found if c.way == way]) for way in {c.way for c in found}
    }
    force = [
        [seen(cell, *scatter[cell.way]), loads(resistance, cell), by_plates(plates, cell)]
        for cell in found
    ]
    seeds = max(len(cell.force) for cell in found)
    single = np.full((len(found), seeds, 2), np.nan)
    for row, cell in zip(single, found, strict=True):
        row[: len(cell.force)] = cell.force
    words = "force and its 95 % interval: measured, by coefficients, by measured plates"
    variables = {
        "force": (("cell", "by", "axis", "end"), force, "N", words),
        "force_measured": (
            ("cell", "seed", "axis"),
            single,
            "N",
            "force on the outline",
        ),
        "depth": ("cell", [cell.depth for cell in found], "m", "depth while it is measured"),
        "run_time": ("cell", [cell.time for cell in found], "s", "processor time of the runs"),
    }
    tables = {
        name: (dims, values, {"units": units, "long_name": about})
        for name, (dims, values, units, about) in variables.items()
    }
    labels = {
        "outline": ("cell", [cell.outline for cell in found]),
        "direction": ("cell", [cell.way for cell in found]),
        "by": list(BY),
        "axis": ["x", "y"],
    }
    sources = [read(file, ())[1] for state in states for file in state.files("drag")]
    told = {key: "; ".join(dict.fromkeys(source[key] for source in sources)) for key in ORIGIN}
    title = {"title": "Forces on outlines, measured and by theory"}
    return xr.Dataset(
        tables,
        labels,
        attributes | told | title | {"revision_of_plates": attributes["git_revision"]},
    )
