"""A bed that is pressed: granules grow in a box of fixed size and come to rest after every step.

With friction the bed comes to rest by damped motion (dem.dynamics.simulation), without friction by
FIRE (dem.packing.minimise). The uses are beds packed with friction, and the packing fraction at
which a bed jams. Contacts lose their memory of friction between steps, and before a run.
"""

import math
from collections.abc import Callable

import numpy as np

from dem.base.errors import PackingError
from dem.contacts.force_law import effective_modulus
from dem.dynamics.assembly import assemble, granule_table
from dem.dynamics.contact_list import ContactList, list_contacts
from dem.dynamics.simulation import Simulation
from dem.dynamics.skin import SKIN_OF_PACKING
from dem.packing.grown import DAMPED, FRACTION
from dem.packing.minimise import minimise
from dem.packing.random import (
    SOFT,
    Bed,
    finished,
    name_of,
    pack,
    pressure_of,
    soft_scene,
)
from dem.periodic import periods_of
from dem.scene import Cylinder, Friction, Scene, State, walls_of

Preparation = Callable[..., Bed]  # called as dem.pack is
START = 0.74  # packing fraction of the bed before it is pressed: no shape jams there
STEP = 0.005  # of the packing fraction, at most, between two rests
RESTING = 1e-5  # E* R^2: a bed is at rest when no granule feels a greater net force
MOVING = 2e-4  # E* R^2: beyond it a finished bed is refused
PATIENCE = 20_000  # iterations of FIRE
PIECE = 10.0  # sqrt(m / (E* R)): one piece of damped motion
PIECES = 80  # of damped motion, at most, after a step


def compact(
    shape, width, height, cylinder: Cylinder | None, seed: int, friction: float,
    periodic: str = "none", prepare: Preparation = pack,
) -> Bed:  # fmt: skip
    """A bed packed with friction, otherwise as dem.pack makes it. Raises PackingError.

    The packing fraction at which it jams depends on how it is pressed.
    """
    press = Press(shape, width, height, cylinder, seed, friction, periodic, prepare)
    press.press(press.full)
    scene = press.scene()
    if not press.net_force <= MOVING:
        raise PackingError(
            f"{name_of(scene, width, height, seed)} is not at rest after it was pressed with "
            f"friction {friction:g}: net force {press.net_force:.2g} E* R^2."
        )
    table = granule_table(scene, SKIN_OF_PACKING)
    world = assemble(scene, press.state.checked(scene.granules), table)
    world, rest = minimise(scene, table, world, 0, RESTING * press.unit)
    return finished(scene, table, world, rest, width, height, press.net_force, seed)


class Press:
    """A bed in a box of width and height (m) whose granules grow up to those of `shape`.

    full: packing fraction when they have grown; fraction: as they are; friction: Coulomb's
    coefficient of all contacts while they grow; periodic: as of dem.pack; prepare: dem.pack or
    dem.grow, which makes the bed that is pressed. Raises PackingError as these do.
    """

    def __init__(
        self, shape, width, height, cylinder: Cylinder | None, seed: int, friction: float = 0.0,
        periodic: str = "none", prepare: Preparation = pack,
    ):  # fmt: skip
        self.shape, self.friction = shape, friction
        self.cylinder = cylinder and Cylinder(cylinder.diameter, cylinder.position)
        self.size, self.periodic = (width, height), periods_of(width, height, periodic)
        self.walls = walls_of(width, height, self.periodic)
        around = 0.0 if cylinder is None else math.pi * (0.5 * cylinder.diameter) ** 2
        room = width * height - around
        self.full = float(shape.area.sum() / room)
        self.fraction = min(START, self.full)
        self.unit = effective_modulus(SOFT, SOFT) * shape.constituent_radius.mean() ** 2  # N
        bed = prepare(self.grown(), width, height, self.cylinder, seed, periodic)
        self.state = bed.state
        self.pressure, self.net_force = bed.pressure, bed.net_force

    def scene(self) -> Scene:
        """The box, without friction, with the granules as they are."""
        return soft_scene(self.grown(), self.walls, self.cylinder, self.periodic)

    def grown(self):
        """The granules as they are."""
        return self.shape.scaled(math.sqrt(self.fraction / self.full))

    def press(self, fraction: float, resting: float = RESTING, patience: int = PATIENCE) -> float:
        """Grow the granules to a packing fraction; returns `pressure`, the mean normal stress on
        the walls, or of the contacts without walls, over E* (unit thickness, m).

        resting: greatest net force (E* R^2) of a bed at rest; patience: iterations of FIRE, at most.
        """
        for part in np.linspace(self.fraction, fraction, 1 + self._steps(fraction))[1:]:
            self.fraction = float(part)
            self._rest(resting * self.unit, patience)
        return self.pressure

    def _steps(self, fraction):
        return max(1, math.ceil(abs(fraction - self.fraction) / STEP - 1e-9))

    def contacts(self) -> ContactList:
        """Contacts of the bed as it is, without friction."""
        scene = self.scene()
        table = granule_table(scene, SKIN_OF_PACKING)
        world = assemble(scene, self.state.checked(scene.granules), table)
        world, _ = minimise(scene, table, world, 0, RESTING * self.unit)
        return list_contacts(world, np.arange(scene.granules))

    def _rest(self, enough, patience):
        if self.friction:
            self._damp(enough)
        else:
            self._minimise(enough, patience)

    def _minimise(self, enough, patience):
        scene = self.scene()
        table = granule_table(scene, SKIN_OF_PACKING)
        world = assemble(scene, self.state.checked(scene.granules), table)
        world, rest = minimise(scene, table, world, patience, enough)
        self.state = State(world.bodies[:, :2].copy(), angle=world.angle.copy())
        self.net_force = rest.net_force / self.unit
        self.pressure = pressure_of(world, scene, *self.size)

    def _damp(self, enough):
        friction = Friction(self.friction, self.friction, self.friction)
        scene = Scene(
            self.grown(), DAMPED, friction, self.walls, self.cylinder, thickness=1.0,
            periodic=self.periodic,
        )  # fmt: skip
        run = Simulation(scene, self.state, step_fraction=FRACTION)
        radius = self.shape.constituent_radius.mean()
        piece = PIECE * math.sqrt(scene.mass.mean() * radius / self.unit)
        for _ in range(PIECES):
            run.collect_impulses()
            run.advance(piece)
            net = np.linalg.norm(run.world.force[:, :2], axis=1).max()
            if net <= enough:
                break
        end = run.state
        self.state = State(end.position, angle=end.angle)
        self.net_force = float(net) / self.unit
        self.pressure = pressure_of(run.world, scene, *self.size, piece)
