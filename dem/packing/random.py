"""A random bed at rest, at a prescribed packing fraction, around the cylinder.

Granules are dropped at random places and angles, small enough that no two bounding circles
overlap, and then grown in small steps; after each the elastic energy is minimised without
friction (dem.packing.minimise). Growing from apart keeps dumbbells from interlocking. The bed depends on
the geometry and the seed alone: moduli and masses cancel.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from dem.base.errors import InputError, PackingError
from dem.base.validate import checked, one_of, or_none, positive, whole
from dem.contacts.force_law import effective_modulus
from dem.dynamics.assembly import GranuleTable, assemble, granule_table
from dem.dynamics.diagnostics import survey
from dem.dynamics.forces import forces
from dem.dynamics.world import World
from dem.packing.minimise import minimise
from dem.scene import Cylinder, Material, Scene, State, box, granules

REST = 1e-9  # E* R^2: a bed is at rest when no granule feels a greater net force
LOOSE = 0.3  # area fraction of the bounding circles at the start
GROWTH = 1.02  # of all lengths, in one step
SETTLED = 1e-5  # E* R^2: enough between two steps of growth
PATIENCE = 400  # iterations between two steps of growth
LONGEST = 100_000  # iterations of the last relaxation
DEEPEST = 0.2  # greatest overlap over the smaller radius in a finished bed
SKIN = 0.3  # of the mean bounding radius
SOFT = Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=1.0)


class Bed(NamedTuple):
    """A finished bed: `state` and `walls` are what a Scene and a Simulation of it take.

    position (n, 2) in m and angle (n,) in rad; width and height (m) of the box. What remains in
    it: net_force, the largest on a granule over E* R^2; pressure, the mean normal stress on the
    walls over E* (unit thickness, m); coordination_number; max_overlap over the smaller radius.
    """

    position: np.ndarray
    angle: np.ndarray
    width: float
    height: float
    net_force: float
    pressure: float
    coordination_number: float
    max_overlap: float

    @property
    def state(self) -> State:
        """The granules at rest where they are."""
        return State(self.position, angle=self.angle)

    @property
    def walls(self) -> np.ndarray:
        """The box around them, as dem.box gives it."""
        return box(self.width, self.height)


def scatter(
    shape: Any, width: float, height: float, cylinder: Cylinder | None, rng: np.random.Generator
) -> np.ndarray:
    """Random sequential addition of the bounding circles: positions (n, 2) in m.

    A grid of squares, none smaller than the largest circle is wide, tells who is near: the work
    is proportional to the number of granules.
    """
    radius = shape.bounding_radius
    size = max(2.0 * radius.max(), math.sqrt(width * height / len(radius)))
    grid: dict[tuple[int, int], list[int]] = {}
    position = np.empty((len(radius), 2))
    for i, r in enumerate(radius):
        for _ in range(1000):
            trial = r + (np.array([width, height]) - 2.0 * r) * rng.random(2)
            column, row = int(trial[0] // size), int(trial[1] // size)
            if _blocked(trial, r, cylinder):
                continue
            near = [
                j for c in range(column - 1, column + 2) for k in range(row - 1, row + 2)
                for j in grid.get((c, k), ())
            ]  # fmt: skip
            gap = position[near] - trial
            if (np.einsum("ij,ij->i", gap, gap) >= (r + radius[near]) ** 2).all():
                position[i] = trial
                grid.setdefault((column, row), []).append(i)
                break
        else:
            raise PackingError(
                f"granule {i} of {len(radius)} found no free place in 1000 trials: the box of "
                f"{width:.3g} m by {height:.3g} m is too small for granules of {r:.3g} m."
            )
    return position


def _blocked(place: np.ndarray, radius: float, cylinder: Cylinder | None) -> bool:
    if cylinder is None:
        return False
    return math.dist(place, cylinder.position) < radius + 0.5 * cylinder.diameter


@checked(
    shape=granules,
    width=positive("m"),
    height=positive("m"),
    cylinder=or_none(one_of(Cylinder)),
    seed=whole(0, 2**63 - 1),
)
def pack(shape: Any, width: float, height: float, cylinder: Cylinder | None, seed: int) -> Bed:
    """Random bed at rest of all granules of `shape` in a box of width and height (m).

    cylinder: room is left for it; None for a bed without. The packing fraction follows from the
    height: see dem.experiment.fit.height_of_box. Raises PackingError when no bed at rest is found and
    InputError for values that cannot be used, such as a cylinder that does not fit.
    """
    still, half = None, 0.0
    if cylinder is not None:
        (x, y), half = cylinder.position, 0.5 * cylinder.diameter
        if not (half < x < width - half and half < y < height - half):
            raise InputError(f"the cylinder at {cylinder.position} m does not fit into the box.")
        still = Cylinder(cylinder.diameter, cylinder.position)
    rng = np.random.default_rng([seed, 1])
    room = width * height - math.pi * half**2
    factor = min(1.0, math.sqrt(LOOSE * room / (np.pi * (shape.bounding_radius**2).sum())))
    position = scatter(shape.scaled(factor), width, height, cylinder, rng)
    state = State(position, angle=rng.uniform(0.0, 2.0 * np.pi, len(position)))
    while True:
        last = factor == 1.0
        scene = soft_scene(shape.scaled(factor), box(width, height), still)
        table = granule_table(scene, SKIN)
        world = assemble(scene, state.checked(len(position)), table)
        unit = effective_modulus(SOFT, SOFT) * table.radius.mean() ** 2  # N
        iterations, enough = (LONGEST, REST) if last else (PATIENCE, SETTLED)
        world, net_force = minimise(scene, table, world, iterations, enough * unit)
        if last:
            net_force /= unit
            if not net_force <= REST:
                raise PackingError(
                    f"{name_of(scene, width, height, seed)} is not at rest after {LONGEST} "
                    f"iterations: net force {net_force:.2g} E* R^2, asked for {REST:g}."
                )
            return finished(scene, table, world, width, height, net_force, seed)
        state = State(world.bodies[:, :2].copy(), angle=world.angle)
        factor = min(factor * GROWTH, 1.0)


def soft_scene(shape: Any, walls: np.ndarray, cylinder: Cylinder | None) -> Scene:
    """Granules of unit modulus and density, one metre thick, without friction."""
    return Scene(shape, SOFT, walls=walls, cylinder=cylinder, thickness=1.0)


def name_of(scene: Scene, width: float, height: float, seed: int) -> str:
    """What a sentence calls a bed."""
    radius = 0.0 if scene.cylinder is None else 0.5 * scene.cylinder.diameter
    fraction = scene.shape.area.sum() / (width * height - math.pi * radius**2)
    return f"the bed at packing fraction {fraction:.4g} (seed {seed})"


def finished(
    scene: Scene,
    table: GranuleTable,
    world: World,
    width: float,
    height: float,
    net_force: float,
    seed: int,
) -> Bed:
    """The Bed in the arrays of the kernels, with net_force over E* R^2; raises PackingError where
    granules lie outside or too deep in each other."""
    cylinder, name = scene.cylinder, name_of(scene, width, height, seed)
    touching, overlap, part, _ = survey(world, table, 0.0)
    position = world.bodies[:, :2].copy()
    lost = ((position < 0.0) | (position > [width, height])).any(axis=1)
    if cylinder is not None:
        lost |= np.hypot(*(position - cylinder.position).T) < 0.5 * cylinder.diameter
    if lost.any():
        raise PackingError(
            f"{name} cannot be made: the centre of granule {lost.argmax()} was pushed into the "
            "cylinder or out of the box: ask for a lower packing fraction."
        )
    if not overlap <= DEEPEST:
        raise PackingError(
            f"{name} cannot be made: granule {part // table.per} overlaps by {overlap:.2g} of the "
            f"smaller radius, at most {DEEPEST:g} is allowed: ask for a lower packing fraction."
        )
    forces(world, 1.0)  # nothing has been summed before: the impulse over one second
    assert world.walls is not None
    stress = world.walls.impulse.sum() / (2.0 * (width + height))
    return Bed(
        position=position,
        angle=np.mod(world.angle, 2.0 * np.pi),
        width=width,
        height=height,
        net_force=net_force,
        pressure=stress / effective_modulus(scene.material, scene.material),
        coordination_number=2.0 * touching / scene.granules,
        max_overlap=overlap,
    )
