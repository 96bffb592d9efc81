"""A bed as arrays, with its kernels: what it can be asked for. `Simulation` and packing drive it."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from dem.contacts.layout import BLOCK, aligned, layout_of
from dem.dynamics.checkpoint import copied
from dem.dynamics.critical_step import BOUNDS
from dem.dynamics.forces import FORCES, RESPOND, SHOW
from dem.dynamics.kinds import kernels
from dem.dynamics.neighbours import Lists
from dem.dynamics.scan import (
    CONSTANTS,
    ENERGIES,
    LEAST_OVERLAP,
    RESULT,
    ROWS,
    SCAN,
    Moment,
)
from dem.dynamics.step import DRIFT, STEPS, Threads, advance, places
from dem.dynamics.world import INVERSE_MASS, Boundaries, World

CHUNK = 1024  # blocks whose geometry is kept at a time
NONE = np.zeros((0, ROWS, BLOCK))
SHARED = "shape", "outlines", "contacts", "faces", "held", "patches"  # which no drift changes
NOW = Moment()
NO_BOUNDS = np.zeros((0, BOUNDS))


class System:
    """A bed as arrays, with its kernels.

    Attributes
    ----------
    world : World
        The arrays.
    table : GranuleTable
        Constants of the granules.
    kernels : Kernels
        Of its kind.
    lists : Lists
        Makes the lists of contacts.
    work : function
        What moves it: dem.dynamics.step.advance, or dem.packing.minimise.fire.
    """

    def __init__(
        self, world: World, table: Any, flags: dict[str, bool], lists: Lists, work=advance
    ):
        self.world, self.table, self.lists, self.work = world, table, lists, work
        given = world.shape, world.outlines, world.law
        self.kernels = kernels(work, flags, lists.bodies.layout, *given)
        self.place = places(1)[0]

    def __reduce__(self):
        return System, (self.world, self.table, self.kernels.flags, self.lists, self.work)

    def with_world(self, world: World) -> "System":
        """The same for other arrays."""
        return System(world, self.table, self.kernels.flags, self.lists, self.work)

    def suited(self, world: World) -> "System":
        """The same for arrays whose boundaries may yield where they did not, or not where they did."""
        flags, bodies = self.kernels.flags, self.lists.bodies
        flags = flags | {"YIELDS": flags["DAMPING"] and yields(world.boundaries)}
        if flags == self.kernels.flags:
            return self.with_world(world)
        layout = layout_of(flags, bodies.outlines.shape[1], bodies.others.shape[1])
        return System(world, self.table, flags, Lists(bodies._replace(layout=layout)), self.work)

    def changed(self, boundaries: Boundaries) -> "System":
        """The same for boundaries that move or meet granules otherwise; what contacts remember stays."""
        world, before = self.world, self.kernels.layout
        system = self.suited(world._replace(boundaries=boundaries))
        after = system.kernels.layout
        if after != before:
            old = world.contacts.table.reshape(-1, before.stride)
            table = aligned(len(old), after.stride)
            table[:, after.history :] = old[:, before.history :]
            contacts = world.contacts._replace(table=table.reshape(-1))
            system.world = system.world._replace(contacts=contacts)
        return system

    @property
    def alone(self) -> bool:
        """Whether each granule is its own only constituent."""
        return not self.kernels.flags["COMPOSED"]

    def rebuild(self, skin: float) -> None:
        """Make the list for the present positions, with constants and what contacts remember."""
        world = self.world
        bare = without_shape(world)._replace(law=None)
        contacts, patches, shared = self.lists.renewed(bare, skin + world.law.range)
        constituents, rows = world.constituents, len(world.constituents.motion)
        force = constituents.force
        if len(force) < rows + shared:
            force = aligned(rows + shared + shared // 8, 4)
            force[:rows] = constituents.force[:rows]
        granules = world.granules._replace(force=force) if self.alone else world.granules
        constituents = constituents._replace(force=force)
        self.world = world._replace(
            granules=granules, constituents=constituents, contacts=contacts, patches=patches
        )
        self._scan(self.world, CONSTANTS)

    def _scan(self, world, task, begin=0, rows=NONE, result=None, moment=NOW, bounds=NO_BOUNDS):
        """See dem.dynamics.scan.scan."""
        given = without_shape(world), self.table, self.kernels.layout, task, moment, begin, rows
        self.kernels.scan(*given, bounds, np.zeros(RESULT) if result is None else result)

    def advance(self, kick, dt, steps, limit, threads: Threads | None = None):
        """See dem.dynamics.step.advance."""
        given = self.world, STEPS, kick, dt, steps, limit, NONE
        if threads is None:
            return self.kernels.work(*given, self.place)
        return threads.together(self.kernels.work, *given)

    def drift(self, kick: float, dt: float) -> None:
        """Kick (s) and move (dt, s) all bodies, without forces."""
        self.kernels.work(self.world, DRIFT, kick, dt, 0, 0.0, NONE, self.place)

    def forces(self, dt: float) -> None:
        """Forces of the present positions, over a step dt (s)."""
        self.kernels.work(self.world, FORCES, 0.0, dt, 0, 0.0, NONE, self.place)

    def geometries(self, task: int = SHOW) -> Iterator[tuple[int, int, np.ndarray]]:
        """First and last (excluded) of some blocks, and the geometry of their contacts (blocks, ROWS,
        BLOCK), until the whole list is done. What contacts remember stays."""
        world = self.world
        if task == RESPOND or self.kernels.flags["GUESSES"]:
            contacts = world.contacts._replace(table=world.contacts.table.copy())
            world = world._replace(contacts=contacts)
        blocks = int(world.contacts.first[-1])
        for begin in range(0, max(blocks, 1), CHUNK):
            end = min(begin + CHUNK, blocks)
            rows = np.empty((end - begin, ROWS, BLOCK))
            given = 0.0, 0.0, begin, 0.0, rows, self.place
            self.kernels.work(world, task, *given)
            if task == RESPOND:  # springs as they are, at the present overlaps
                self._put_springs_back(world, begin, end)
                self.kernels.work(world, task, *given)
                self._scan(world, ENERGIES, begin, rows)
            yield begin, end, rows

    def _put_springs_back(self, world, begin, end):
        """What contacts of some blocks remember but for the measure of the law."""
        layout = self.kernels.layout
        blocks, saved = (
            contacts.table.reshape(-1, layout.stride)[begin:end]
            for contacts in (world.contacts, self.world.contacts)
        )
        for column in (layout.tangential_force, layout.rolling_moment):
            if column >= 0:
                blocks[:, column : column + BLOCK] = saved[:, column : column + BLOCK]

    def scan(self, moment: Moment = NOW, steps: bool = True, least: float = 0.0) -> np.ndarray:
        """The result of a scan (dem.dynamics.scan).

        steps: whether time steps are asked for; least (m): smallest overlap of a contact in these,
        zero for the overlap of a collision at the greatest expected speed.
        """
        bodies = len(self.world.granules.angle) + len(self.world.boundaries.angle)
        bounds, result = np.zeros((bodies, BOUNDS)) if steps else NO_BOUNDS, np.zeros(RESULT)
        result[LEAST_OVERLAP] = least
        for begin, _, rows in self.geometries():
            self._scan(self.world, SCAN, begin, rows, result, moment, bounds)
        return result

    def elastic(self) -> np.ndarray:
        """Elastic energies (J) of normal, tangential and rolling springs."""
        energies = np.zeros(RESULT)
        for begin, _, rows in self.geometries():
            self._scan(self.world, ENERGIES, begin, rows, energies)
        return energies[:3]

    def later(self, pending_kick: float, ahead: float) -> "System":
        """A copy, from velocities of half a step to the state at a time `ahead` (s) after its
        positions.

        pending_kick (s): kicks to come up to the time of its positions. Within a step forces count
        as they are: an error of second order, as in a step.
        """
        world = self.world
        kept = {name: getattr(world, name) for name in SHARED}
        moved = copied(world._replace(**dict.fromkeys(SHARED)))
        copy = self.with_world(moved._replace(**kept))
        half = 0.5 * ahead
        copy.drift(pending_kick + half, ahead)
        copy.drift(half, 0.0)
        return copy

    def impulses(self, kick: float) -> np.ndarray:
        """Boundaries.impulses after a further kick (s)."""
        return self.world.boundaries.impulses + kick * self.world.boundaries.contact_forces


def yields(boundaries: Boundaries) -> bool:
    """Whether normal forces move any boundary, or turn it."""
    inverse = boundaries.drive[:, INVERSE_MASS : INVERSE_MASS + 3]
    turned = inverse[: len(boundaries.reach), 2] * boundaries.reach
    return bool(inverse[:, :2].any() or turned.any())


def without_shape(world: World) -> World:
    """The arrays for kernels that no shape changes."""
    return world._replace(shape=None, outlines=None)


def is_finite(values) -> bool:
    return bool(np.isfinite(values).all())


def longest_move(world: World) -> float:
    """Most by which two bodies can have come nearer since the lists were made (m)."""
    constituents, boundaries = world.constituents, world.boundaries
    moved = constituents.motion[: len(constituents.owner), :2] - constituents.reference
    moved = np.hypot(moved[:, 0], moved[:, 1])
    count, planes = len(boundaries.reference), boundaries.planes
    apart = boundaries.motion[:count, :2] - boundaries.reference[:, :2]
    turned = abs(boundaries.angle[:count] - boundaries.reference[:, 2]) * boundaries.reach
    solids = np.hypot(apart[:, 0], apart[:, 1]) + turned
    walls = abs((apart[: len(planes)] * planes[:, :2]).sum(axis=1))
    greatest = [walls.max(initial=0.0), solids[len(planes) :].max(initial=0.0)]
    if not is_finite(moved):
        return math.inf
    return float(np.sort(np.concatenate([greatest, moved]))[-2:].sum())
