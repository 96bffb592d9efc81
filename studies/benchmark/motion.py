"""Do two codes move the same granules alike? Ours and LAMMPS from the same start."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from dem.dynamics.simulation import Simulation
from studies.benchmark.scenes import Case
from studies.common.peers import lammps

KINDS = ("disc", "dumbbell")  # of granules that LAMMPS has too


class Check(NamedTuple):
    """A case that both codes move; same: whether LAMMPS has our dashpot and tangential spring."""

    case: Case
    same: bool


def checks(cases: dict[str, Case]) -> dict[str, Check]:
    """Beds at rest that a moving cylinder stirs, by what they have."""
    variants = {}
    for kind in (kind for kind in KINDS if kind in cases):
        case = cases[kind]
        elastic = replace(case.scene.material, restitution=1.0)
        bare = case._replace(scene=replace(case.scene, material=elastic, friction=None))
        variants[f"{kind}s, no friction, no damping"] = Check(bare, False)
        variants[f"{kind}s, our law"] = Check(case, True)
        variants[f"{kind}s, fastest style"] = Check(case, False)
    return variants


def differences(check: Check, steps: tuple[int, ...]) -> np.ndarray:
    """After `steps` each (2, steps): greatest distance of a granule between the codes over the mean
    radius, and difference of the impulses that the cylinder received over that in ours."""
    (scene, state, time_step), legs = check.case, np.diff(steps, prepend=0)
    ours, impulse, rows = Simulation(scene, state, time_step), np.zeros(2), []
    theirs = lammps.run(scene, state, time_step, legs, check.same, 1)
    for leg, count, other in zip(legs, steps, theirs, strict=True):
        record = ours.record(leg * time_step, 1)
        impulse += leg * (record.normal_force + record.tangential_force)[0, 0]
        apart = np.linalg.norm(ours.state.position - other.position, axis=1).max()
        missed = np.linalg.norm(impulse - count * other.force) / np.linalg.norm(impulse)
        rows.append((apart / scene.shape.bounding_radius.mean(), missed))
    return np.array(rows).T
