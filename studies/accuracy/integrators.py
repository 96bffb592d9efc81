"""Time integrators that people use, as sequences of the package's own kicks, drifts and forces.

A step is a table of stages. A stage kicks the velocities over a part of the step, then moves the
granules over a part of it, then may evaluate the forces there. All methods run through one compiled
function, so that they differ in nothing else.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.dynamics.assembly import assemble, granule_table
from dem.dynamics.boundaries import move_boundaries
from dem.dynamics.checkpoint import writable
from dem.dynamics.forces import forces, greater
from dem.dynamics.integration import boundaries_moved, drift
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.dynamics.skin import MARGIN, SKIN
from dem.dynamics.world import at_full_steps
from dem.jit.columns import DVX, DVY, DW, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import given, plus
from dem.scene import Scene, State

KICK, DRIFT, AHEAD, EVALUATE = range(4)  # columns of a table of stages
INSTANT = 1e-30  # s: nothing slips in it


class Integrator(NamedTuple):
    """name; forces: evaluations per step; stages (s, 4), one row each; expects: whether dashpots see the
    acceleration that the last two let expect, as in the package, or the last one.

    Columns: parts of the time step over which velocities are kicked and positions moved; by how
    much of the half drift the dashpot looks ahead of the velocity; whether (1) or not (0) the
    forces are evaluated then.
    """

    name: str
    stages: np.ndarray
    forces: int
    expects: bool = False


def integrator(name: str, *stages: tuple, looks_ahead: bool = True) -> Integrator:
    """From rows (kick, drift, evaluate forces).

    looks_ahead: a dashpot sees the velocity at the time of the positions, v + a (what the drifts
    are ahead of the kicks); else it sees v. drift leaves a dt / 2 in the columns of the
    change of velocity, so that AHEAD counts in halves of the drift.
    """
    kick, move, evaluate = np.array(stages, float).T
    ahead = 2.0 * (np.cumsum(move) - np.cumsum(kick)) / np.where(move == 0.0, np.inf, move)
    table = np.column_stack([kick, move, ahead if looks_ahead else 0.0 * ahead, evaluate])
    return Integrator(name, table, int(evaluate.sum()))


# Position-extended Forest-Ruth-like method: Omelyan, Mryglod and Folk (2002), Comput. Phys.
# Commun. 146, 188: fourth order with the least error, at four evaluations of the forces. No method
# of kicks and drifts above second order does without steps back in time.
XI, LAMBDA, CHI = 0.1786178958448091, -0.2123418310626054, -0.06626458266981849

LATE = integrator("Verlet, dashpot a step late", (0.5, 1, 1), (0.5, 0, 0))
VERLET = LATE._replace(name="Verlet", expects=True)
HALF_STEP = integrator("Verlet, half-step dashpot", (0.5, 1, 1), (0.5, 0, 0), looks_ahead=False)
SYMPLECTIC_EULER = integrator("symplectic Euler", (1, 1, 1))
EXPLICIT_EULER = integrator("explicit Euler", (0, 1, 0), (1, 0, 1))
PEFRL = integrator(
    "PEFRL (4th order)",
    (0.0, XI, 1), (0.5 - LAMBDA, CHI, 1), (LAMBDA, 1.0 - 2.0 * (CHI + XI), 1),
    (LAMBDA, CHI, 1), (0.5 - LAMBDA, XI, 0),
)  # fmt: skip
INTEGRATORS = (VERLET, LATE, HALF_STEP, SYMPLECTIC_EULER, EXPLICIT_EULER, PEFRL)


@inlined
def let_dashpots_see(bodies, full, ahead):
    """full: dem.dynamics.world.at_full_steps."""
    for i in range(bodies.shape[0]):
        bodies[i, VX] = plus(bodies[i, VX], given(full, (ahead - 1.0) * bodies[i, DVX]))
        bodies[i, VY] = plus(bodies[i, VY], given(full, (ahead - 1.0) * bodies[i, DVY]))
        bodies[i, DVX] *= ahead
        bodies[i, DVY] *= ahead
        bodies[i, DW] *= ahead


@compiled
def advance(world, stages, span, dt, steps, room):
    """Take up to `steps` steps of dt (s); stop when a part has moved farther than `room` (m).

    span (2,): time moved since the forces were evaluated (s), and kicks to come (s), both carried from
    call to call. Returns the number of steps done and the largest displacement (m); that of granules counts as 0 up to
    `room`.
    """
    granules = world.bodies.shape[0]
    kick, done, moved, limit = span[1], 0, 0.0, room * room
    while done < steps and moved <= limit:
        for s in range(stages.shape[0]):
            kick += dt * stages[s, KICK]
            move, evaluate = dt * stages[s, DRIFT], stages[s, EVALUATE] > 0.0
            if move == 0.0 and not evaluate:
                continue  # the next stage makes this kick with its own
            drift(world, kick, move, 0, granules)
            move_boundaries(world, kick, move)
            farther = boundaries_moved(world)
            span[0] += move
            kick = 0.0
            if evaluate:
                if stages[s, AHEAD] != 1.0:
                    let_dashpots_see(world.bodies, at_full_steps(world), stages[s, AHEAD])
                moved = greater(farther, forces(world, span[0], limit))
                span[0] = 0.0
        done += 1
    span[1] = kick
    return done, math.sqrt(moved)


class Motion:
    """A scene in motion by an integrator at a fixed time step (s).

    skin: of the neighbour lists, over the mean bounding radius.
    """

    def __init__(
        self, scene: Scene, state: State, method: Integrator, time_step: float, skin: float = SKIN
    ):
        self._table = granule_table(scene, skin)
        self._stages, self._step = method.stages, float(time_step)
        self.world = assemble(scene, state.checked(scene.granules), self._table)
        if not method.expects:
            self.world = self.world._replace(previous_acceleration=None)
        self.world = rebuild_neighbor_list(self.world, self._table)
        self._span = np.zeros(2)
        forces(self.world, INSTANT, math.inf)
        drift(self.world, 0.0, 0.0, 0, scene.granules)

    def advance(self, steps: int) -> bool:
        """Take a number of steps; False where the granules went too far to know their contacts."""
        reach = 0.5 * self._table.skin
        while steps > 0:
            done, moved = advance(
                self.world, self._stages, self._span, self._step, steps, MARGIN * reach
            )
            if not moved <= reach:
                return False
            if moved > MARGIN * reach:
                self.world = rebuild_neighbor_list(self.world, self._table)
            steps -= done
        return True

    @property
    def state(self) -> State:
        """Copies of position (m), velocity (m/s), angle (rad) and angular velocity (rad/s)."""
        world = writable(self.world)
        drift(world, self._span[1], 0.0, 0, len(world.bodies))
        bodies = world.bodies
        return State(bodies[:, [X, Y]], bodies[:, [VX, VY]], world.angle, bodies[:, W])
