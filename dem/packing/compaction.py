"""Beds compacted in a box of fixed size: granules swell and come to rest after every step.

With friction the bed comes to rest by damped motion (dem.dynamics.simulation), without friction by
FIRE (dem.packing.minimise). The uses are beds packed with friction, and the packing fraction at
which a bed jams. Contacts lose their memory of friction between steps, and before a run.
"""

import math

import numpy as np

from dem.base.errors import PackingError
from dem.dynamics.contact_output import list_contacts
from dem.dynamics.simulation import Simulation
from dem.material import Friction
from dem.packing.job import Job
from dem.packing.minimise import minimise
from dem.packing.random import finished, pressure_of, relaxed
from dem.packing.swelling import COARSE_STEP, DAMPED, greatest_force
from dem.scene import State

START = 0.74  # packing fraction of the bed before it is pressed: no shape jams there
STEP = 0.005  # of the packing fraction, at most, between two rests
RESTING = 1e-5  # E* R^2: a bed is at rest when no granule feels a greater net force
MOVING = 2e-4  # E* R^2: beyond it a finished bed is refused
PATIENCE = 20_000  # iterations of FIRE
PIECE = 10.0  # sqrt(m / (E* R)): one piece of damped motion
PIECES = 80  # of damped motion, at most, after a step


class Press:
    """A bed in a room whose granules grow to the sizes of `shape`.

    full: packing fraction when they have grown; fraction: as they are; friction: Coulomb's
    coefficient of all contacts while they grow; prepare: makes the bed that is pressed, as
    `relaxed` does, and job is its. Raises PackingError as that does.
    """

    def __init__(self, shape, room, friction=0.0, prepare=relaxed, job=None):
        job = job or Job()
        self.threads = job.threads
        self.shape, self.room, self.friction = shape, room, friction
        self.full = float(shape.area.sum() / room.area)
        self.fraction = min(START, self.full)
        self.unit = room.unit(shape)  # N
        bed = prepare(self.granules(), room, job)
        self.state, self.pressure, self.net_force = bed.state, bed.pressure, bed.net_force

    def granules(self):
        """The granules as they are."""
        return self.shape.scaled(math.sqrt(self.fraction / self.full))

    def minimised(self, iterations, resting):
        """The bed as it is without friction, minimised to a net force of `resting` (E* R^2)."""
        scene, job = self.room.scene(self.granules()), Job(self.threads)
        return minimise(scene, self.state, iterations, resting * self.unit, job)

    def bed(self):
        """The Bed of full-sized granules packed with friction. Raises PackingError.

        The packing fraction at which it jams depends on how it is pressed.
        """
        self.press(self.full)
        if not self.net_force <= MOVING:
            raise PackingError(
                f"{self.room.name(self.granules())} is not at rest after it was pressed with "
                f"friction {self.friction:g}: net force {self.net_force:.2g} E* R^2."
            )
        return finished(self.granules(), self.room, self.minimised(0, RESTING), self.net_force)

    def press(self, fraction, resting=RESTING, patience=PATIENCE):
        """Grow the granules to a packing fraction; returns `pressure`, the mean normal stress on
        the walls, or of the contacts without walls, as Bed.pressure.

        resting: greatest net force (E* R^2) of a bed at rest; patience: iterations of FIRE, at
        most.
        """
        steps = max(1, math.ceil(abs(fraction - self.fraction) / STEP - 1e-9))
        for part in np.linspace(self.fraction, fraction, 1 + steps)[1:]:
            self.fraction = float(part)
            if self.friction:
                self._damp(resting)
            else:
                bed = self.minimised(patience, resting)
                self.state, self.net_force = bed.state, bed.net_force / self.unit
                self.pressure = pressure_of(bed.system, self.room)
        return self.pressure

    def contacts(self):
        """Contacts of the bed as it is, without friction."""
        bed = self.minimised(0, RESTING)
        return list_contacts(bed.system, bed.order)

    def _damp(self, resting):
        friction = Friction(self.friction, self.friction, self.friction)
        scene = self.room.scene(self.granules(), DAMPED, friction)
        run = Simulation(scene, self.state, step_fraction=COARSE_STEP, threads=self.threads)
        radius = self.shape.constituent_radius.mean()
        piece = PIECE * math.sqrt(scene.mass.mean() * radius / self.unit)
        for _ in range(PIECES):
            run.advance(piece)
            net_force = greatest_force(run.world)
            if net_force <= resting * self.unit:
                break
        self.net_force = net_force / self.unit
        self.state = State(run.state.position, angle=run.state.angle)
        self.pressure = pressure_of(run.engine.observe()[0], self.room)
