"""Forces on outlines that no coefficient was fitted to: measured, and by resistive force theory.

Theory sums over the sides of an outline: with the nine coefficients, or with plates as they were measured, between
angles by lines. The first fails by its form too, the second by locality alone. Plates of two lengths L have a stress
over depth of a + E / L. Then a acts on sides, and E, which is common to all angles of a direction, once on each
outline, as on a plate without length.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.rft import BEGIN, Plates, fitted, measured, mirrored
from dem.base.statistics import student
from dem.experiment.intruders import intruder_of
from dem.io.dataset import read
from dem.sweep.state import SweepState
from studies.common.results import ORIGIN, runs

HERE = Path(__file__).parent
NAMES = "solid_force_x", "solid_force_y", "surface_height", "run_time"
LABELS = "outline", "direction", "speed"


class Cell(NamedTuple):
    """An outline in a direction, with its velocity (2,) in m/s, the forces (s, 2) of s runs in N, the outline (k, 2)
    about its position (m), its depth (m) while it is measured, the thickness (m) and the processor time (s)."""

    outline: str
    direction: str
    velocity: np.ndarray
    force: np.ndarray
    ring: np.ndarray
    depth: float
    thickness: float
    time: float = 0.0

    @property
    def speed(self) -> float:
        """In m/s."""
        return float(np.hypot(*self.velocity))


def cells(state: SweepState) -> list[Cell]:
    """All of a sweep, from its runs."""
    found: dict[tuple, list] = {}
    for block, point, run, values in runs(state, NAMES):
        at = zip(block.axes, point, strict=True)
        labels = {axis.name: axis.coordinate[number] for axis, number in at}
        key = labels["outline"], labels["way"], labels["solids_body_y"], block.name
        found.setdefault(key, []).append((run, values))
    return [cell_of(*labels, group) for (*labels, _, _), group in found.items()]


def cell_of(outline: str, direction: str, group: list) -> Cell:
    """One of runs that differ in their seeds, with their values."""
    configuration = group[0][0].configuration
    body, phase = configuration.solids["body"], configuration.phases["pull"]
    motion = phase.motion["body"]
    velocity = motion.velocity * np.array(motion.ahead)
    force = np.array([[values[name][0] for name in NAMES[:2]] for _, values in group])
    share = (np.arange(force.shape[2]) + 0.5) / force.shape[2]
    late = share >= BEGIN
    surface = np.mean([np.median(values["surface_height"][0]) for _, values in group])
    intruder = intruder_of(body)
    return Cell(
        outline,
        direction,
        velocity,
        force[..., late].mean(axis=2),
        intruder.solid(0.0).placed((0.0, 0.0), intruder.angle, 257),
        surface - body.y - velocity[1] * phase.time * share[late].mean(),
        configuration.material.thickness,
        sum(float(values["run_time"]) for _, values in group),
    )


def about(value: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Value and the ends of its interval (3, ...)."""
    return np.array([value, value - half, value + half])


def seen(alike: list[Cell]) -> list[np.ndarray]:
    """Mean force (3, 2) along x and y in N of each, with the interval of what forces of all of them scatter by,
    relative to the length of their means."""
    means = [cell.force.mean(axis=0) for cell in alike]
    off = [(c.force - mean) / np.hypot(*mean) for c, mean in zip(alike, means, strict=True)]
    freedom = sum(each.size - 2 for each in off)
    scatter = student(np.sqrt(sum((each**2).sum() for each in off) / freedom), freedom)
    return [
        about(m, scatter * np.hypot(*m) / np.sqrt(len(x))) for m, x in zip(means, off, strict=True)
    ]


def by_plates(plates: dict[float, Plates], cell: Cell, ends: bool = True) -> np.ndarray:
    """Force (3, 2) along x and y in N as the sum of plates, by their length (m), with the interval of their seeds;
    ends: False to leave out what acts on the ends of plates of two lengths."""
    side, middle = np.diff(cell.ring, axis=0), 0.5 * (cell.ring[1:] + cell.ring[:-1])
    size = np.hypot(*side.T)
    ahead = (side[:, 1] * cell.velocity[0] - side[:, 0] * cell.velocity[1]) / (size * cell.speed)
    # a side along the motion rubs on one face, a plate on two
    faces = np.where(np.abs(ahead) < 1e-3, 0.5, ahead > 0.0)
    depth = cell.depth - middle[:, 1]
    beta, gamma, sign = mirrored(
        np.arctan2(side[:, 1], side[:, 0]), np.tile(cell.velocity, (len(side), 1))
    )
    rows, alpha, two = [], [], len(plates) > 1
    for length, each in plates.items():
        here = np.flatnonzero(np.abs(each.direction - gamma[0]) < 1e-3)
        here = here[np.argsort(each.angle[here])]
        angles = np.eye(len(here))
        rows.append(np.column_stack([angles, *[np.full(len(here), 1.0 / length)] * two]))
        alpha.append(each.alpha[here])
    share = [np.interp(beta, each.angle[here], row, period=np.pi) for row in angles]
    acts = np.array(share) @ (faces * depth * size)
    acts = np.append(acts, [cell.depth * ends] * two)
    weight = cell.thickness * acts @ np.linalg.pinv(np.concatenate(rows))
    stress = np.concatenate(alpha)
    count = stress.shape[1]
    noise = np.nanvar(stress, axis=1, ddof=1).mean(axis=0) / count
    half = student(np.sqrt((weight**2).sum() * noise), (count - 1) * len(stress))
    return about(weight @ np.nanmean(stress, axis=1) * [-sign[0], 1.0], half)


def dataset_of(maps: xr.Dataset, sweeps: Iterable[str]) -> xr.Dataset:
    """Forces on the outlines of sweeps of this folder with their intervals, by each way; maps: plates of two lengths,
    scene.nc of lengths.yaml."""
    lengths = maps["solids_plate_diameter"].values
    plates = {
        length: measured(maps.isel(solids_plate_diameter=[at])) for at, length in enumerate(lengths)
    }
    short, long = ({length: plates[length]} for length in lengths)
    resistance = fitted(plates[lengths[1]])
    states = [SweepState.of(HERE / f"{name}.yaml") for name in sweeps]
    alike: dict[tuple, list] = {}
    for cell in (cell for state in states for cell in cells(state)):
        alike.setdefault((cell.direction, cell.speed), []).append(cell)
    rows, force = [], []
    for group in alike.values():
        for cell, mean in zip(group, seen(group), strict=True):
            loads = resistance.loads(cell.ring, (0.0, -cell.depth), cell.velocity, cell.thickness)
            sums = [by_plates(each, cell) for each in (plates, short, long)]
            force.append(
                [mean, np.transpose(loads[:2]), *sums, by_plates(plates, cell, ends=False)]
            )
            rows.append(cell)
    ways = "measured", "theory", "plates", "short", "long", "sides"
    words = "force and its 95 % interval: measured; by coefficients; by plates of two lengths, and without their ends; by plates of each length"
    tables = {
        "force": (("cell", "by", "end", "axis"), force, "N", words),
        "depth": ("cell", [cell.depth for cell in rows], "m", "depth while it is measured"),
        "run_time": ("cell", [cell.time for cell in rows], "s", "processor time of the runs"),
    }
    files = {
        file for state in states for block in state.sweep.blocks for file in state.files(block)
    }
    sources = [read(file, ())[1] for file in sorted(files)]
    told = {key: "; ".join(dict.fromkeys(source[key] for source in sources)) for key in ORIGIN}
    more = {
        "title": "Forces on outlines, measured and by theory",
        "revision_of_plates": maps.attrs["git_revision"],
    }
    return xr.Dataset(
        {
            name: (dims, values, {"units": units, "long_name": about})
            for name, (dims, values, units, about) in tables.items()
        },
        {name: ("cell", [getattr(cell, name) for cell in rows]) for name in LABELS}
        | {"by": list(ways), "axis": ["x", "y"]},
        maps.attrs | told | more,
    )
