"""Do two codes move the same granules alike? Ours and LAMMPS from the same start."""

from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import Simulation
from dem.scene import State
from studies.benchmark.scenes import Case
from studies.common.peers import lammps

SPEED = 1.0  # m/s, standard deviation of each component at the start
SEED = 1
KINDS = ("disc", "dumbbell")  # of granules that LAMMPS has too


def checks(cases: dict[str, Case]) -> dict[str, Case]:
    """Undamped beds with random velocities around a cylinder at rest, by what they have.

    Undamped, so that energy stays; with friction, LAMMPS takes the radius as the arm of the
    tangential force, where ours takes radius - overlap / 2, and unloads its spring differently.
    """
    variants = {}
    for kind in (kind for kind in KINDS if kind in cases):
        scene, start, time_step = cases[kind]
        still = replace(scene.solids[0], velocity=(0.0, 0.0))
        elastic = replace(scene.material, restitution=1.0)
        rng = np.random.default_rng(SEED)
        velocity = SPEED * rng.normal(size=start.position.shape)
        state = State(start.position, velocity, start.angle)
        for friction, words in ((None, "no friction"), (scene.friction, "friction")):
            changed = replace(scene, solids=still, material=elastic, friction=friction)
            variants[f"{kind}s, {words}"] = Case(changed, state, time_step)
    return variants


def differences(case: Case, steps: tuple[int, ...]) -> np.ndarray:
    """Greatest distance of a granule between the codes, over the mean radius, after `steps`
    each."""
    scene, state, time_step = case
    ours = Simulation(scene, state, time_step)
    distances, done = [], 0
    with lammps.Run(scene, state, time_step) as theirs:
        for count in steps:
            ours.advance((count - done) * time_step)
            theirs.advance(count - done)
            done = count
            apart = np.linalg.norm(ours.state.position - theirs.position, axis=1)
            distances.append(apart.max() / scene.shape.bounding_radius.mean())
    return np.array(distances)
