"""Sinks and sources of a scene: granules that go and come, at an interval."""

import math
from itertools import pairwise

import numpy as np

from dem.dynamics.paths import shown
from dem.dynamics.record import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.replicate import Replicate
from dem.periodic import Periods, nearest_image, wrapped

SHARE = 0.25  # of the time in which a granule falls by half its diameter
PLACES = 100  # that are tried for a granule, before it waits
NEARLY = 1e-9  # of an interval: a moment is reached that is no farther off


class Exchange:
    """A simulation that sinks and sources act on at an interval.

    Attributes
    ----------
    simulation : Simulation
        The simulation.
    interval : float
        Time (s) between two moments at which they act; zero where there are none.
    kept : dict of str to ndarray
        What it goes on from. `moments`: how many of these there were; `waitingK`: granules that wait at
        source K, in the order in which they come; `due` (k,): granules that each source still owes by
        its rate, no more than wait; `moved` (s, 2): number and mass (kg) of granules so far, of each
        sink, then of each source; `bins` (b, s, 2): the same at the start of what is recorded, and at
        the end of each bin; `came` (n,): when each granule came last from a source (s), NaN for others; `ages` (f, n):
        how long ago that was at the snapshots (s).
    """

    def __init__(self, replicate: Replicate, simulation: Simulation, kept: dict):
        c = replicate.configuration
        self.simulation, self.seed, self.kept = simulation, replicate.seed, kept
        self.sinks, self.sources = c.sinks, c.sources
        self.interval = c.exchange_interval or 0.0
        if (c.sinks or c.sources) and not self.interval:
            gravity = c.gravity or c.base_plate.gravity
            self.interval = SHARE * math.sqrt(replicate.shape.diameter / gravity)
        counts = [source.count or 0 for source in c.sources.values()]
        ends = replicate.shape.granules + np.cumsum([0, *counts])
        starts = {f"waiting{k}": np.arange(*part) for k, part in enumerate(pairwise(ends))}
        starts |= {"moments": 0, "due": np.zeros(len(counts)), "bins": [], "ages": []}
        starts["came"] = np.full(replicate.granules, np.nan)
        starts["moved"] = np.zeros((len(c.sinks) + len(counts), 2))
        kept |= starts | kept

    @property
    def exchanged(self) -> np.ndarray:
        """Number and mass (kg) of granules in the bins (s, 2, bins)."""
        bins = self.kept["bins"] if self.interval else np.empty((1, 0, 2))
        return np.diff(bins, axis=0).transpose(1, 2, 0)

    @property
    def is_feeding(self) -> bool:
        """Whether a source has granules for which its rate alone, and no lack of room, is not due."""
        return any(
            source.rate is not None and len(self.kept[f"waiting{k}"]) and self.kept["due"][k] < 1.0
            for k, source in enumerate(self.sources.values())
        )

    def advance(self, duration: float) -> None:
        """Go on by a time (s)."""
        if not self.interval:
            self.simulation.advance(duration)
            return
        for length in self._pieces(self.simulation.time + duration):
            self.simulation.advance(length)

    def record(self, interval: float, count: int) -> Record:
        """As `Simulation.record`; the means of a bin are over all pieces between moments."""
        if not self.interval:
            return self.simulation.record(interval, count)
        begin, records = self.simulation.time, []
        if not len(self.kept["bins"]):
            self._note()
        for n in range(1, count + 1):
            pieces = [
                (length, self.simulation.record(length, 1))
                for length in self._pieces(begin + n * interval)
            ]
            records.append(_joined(*zip(*pieces, strict=True)))
            self._note()
        return Record(*map(np.concatenate, zip(*records, strict=True)))

    def look(self) -> None:
        """Note at a snapshot how long ago granules came."""
        if self.sources:
            self.kept["ages"] = [*self.kept["ages"], self.simulation.time - self.kept["came"]]

    def _note(self) -> None:
        self.kept["bins"] = [*self.kept["bins"], self.kept["moved"].copy()]

    def _pieces(self, end: float):
        """Lengths (s) of pieces up to a time (s); sinks and sources act after one, where they do."""
        while True:
            moment = (self.kept["moments"] + 1) * self.interval
            acts = moment <= end + NEARLY * self.interval
            if (length := min(moment, end) - self.simulation.time) > NEARLY * self.interval:
                yield length
            if not acts:
                return
            self._act()

    def _act(self) -> None:
        """Let granules go and come."""
        scene, kept, names = self.simulation.scene, self.kept, [*self.sources]
        kept["moments"] += 1
        for k, sink in enumerate(self.sinks.values()):
            state = self.simulation.state
            gone = np.flatnonzero(inside(state.position, sink.region, scene.periodic))
            gone = gone[: len(state.present) - 1]  # an engine has a granule
            if len(gone):
                self.simulation.remove_granules(gone)
                kept["came"][gone] = np.nan
                self._count(k, gone)
            if sink.to is not None:
                waiting = f"waiting{names.index(sink.to)}"
                kept[waiting] = np.append(kept[waiting], gone)
        for k, source in enumerate(self.sources.values()):
            self._feed(k, source)

    def _count(self, row: int, granules: np.ndarray) -> None:
        self.kept["moved"][row] += len(granules), self.simulation.scene.mass[granules].sum()

    def _feed(self, k: int, source) -> None:
        """Let granules of a source come, as many as are due and have room."""
        name, due, number = f"waiting{k}", self.kept["due"], int(self.kept["moments"])
        waiting, rng = self.kept[name], np.random.default_rng([self.seed, 3, number, k])
        if source.rate is not None:
            due[k] += source.rate * self.interval
            waiting = waiting[: int(due[k] + NEARLY)]
        places = self._places(waiting, source.region, rng) if len(waiting) else []
        come = waiting[: len(places)]
        if places:
            velocity = np.tile([source.velocity_x, source.velocity_y], (len(come), 1))
            angle = rng.uniform(0.0, 2.0 * np.pi, len(come))
            self.simulation.insert_granules(come, places, velocity, angle)
            self.kept["came"][come] = self.simulation.time
            self._count(len(self.sinks) + k, come)
        self.kept[name] = self.kept[name][len(come) :]
        if source.rate is not None:  # what had no room is still due, and no more than waits
            due[k] = min(due[k] - len(come), max(len(self.kept[name]), 1.0))

    def _places(self, granules: np.ndarray, region, rng) -> list[np.ndarray]:
        """Places (m) for the first of some granules, at random where there is room, until one finds
        none."""
        scene, state = self.simulation.scene, self.simulation.state
        radius, boundaries = scene.shape.bounding_radius, self.simulation.world.boundaries
        rows, walls = shown(boundaries), len(scene.walls)
        end = walls + len(scene.solids)
        solids = scene.moved(rows[walls:end, :2], rows[walls:end, 2], boundaries.planes).solids
        corners = np.reshape(region, (2, 2))
        middle, half = corners.mean(axis=0), 0.5 * np.diff(corners, axis=0)[0] + radius.max()
        away = np.abs(nearest_image(state.position - middle, scene.periodic))
        near = (away < half + radius[:, None]).all(axis=1)  # False for those that are not there
        taken, sizes, found = state.position[near], radius[near], []
        for granule in granules:
            size = radius[granule]
            tried = rng.uniform(corners[0] + size, corners[1] - size, (PLACES, 2))
            away = nearest_image(tried[:, None] - taken, scene.periodic)
            distance, planes = np.hypot(*away.T).T, boundaries.planes
            free = (distance > sizes + size).all(axis=1)
            free &= (tried @ planes[:, :2].T + size < planes[:, 2]).all(axis=1)
            for solid in solids:
                free &= solid.depth(tried, scene.periodic) < -size
            if not free.any():
                break
            found.append(tried[free.argmax()])
            taken, sizes = np.vstack([taken, found[-1]]), np.append(sizes, size)
        return found


def inside(position: np.ndarray, region: tuple, periodic: Periods = None) -> np.ndarray:
    """Which centres (n, 2) in m are in a region: left, bottom, right, top (m) of the box, None for a
    side that is open."""
    places, (low, high) = wrapped(position, periodic), np.array(region, float).reshape(2, 2)
    return np.isfinite(places[:, 0]) & ~((places < low) | (places > high)).any(axis=1)


def _joined(lengths: tuple[float, ...], pieces: tuple[Record, ...]) -> Record:
    """One interval of pieces of some lengths (s): means of forces, and all else at its end."""
    values = {}
    for name, *rows in zip(Record._fields, *pieces, strict=True):
        if name.endswith(("force", "torque")):
            values[name] = np.average(rows, axis=0, weights=lengths)
        else:
            values[name] = np.min(rows, axis=0) if name == "time_step" else rows[-1]
    return Record(**values)
