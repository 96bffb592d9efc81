"""Our discs as a run of LIGGGHTS (https://www.cfdem.com), by its program: for time, not for motion.

Its Hertz contact and its dashpot are ours; its tangential spring remembers a length.
Walls and the cylinder are of a material RIGID times stiffer than the granules, and the cylinder is a
disc HEAVY times denser with a prescribed velocity: LIGGGHTS has no moving cylinder.
"""

import re
import tempfile
from pathlib import Path

import numpy as np

from dem.base.errors import RunError
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from studies.common.peers.material import RIGID, restitution_if_pulling
from studies.common.peers.program import absent, last_lines, output

NAME, SHAPES = "LIGGGHTS", (Disc,)
PROGRAM = "liggghts"
COMMAND = PROGRAM, "-log", "none"
SKIN = 0.3  # of the mean radius
HEAVY = 1e9
INPUT = """\
units si
hard_particles yes
dimension 2
boundary f f p
newton off
atom_style granular
atom_modify map array
communicate single vel yes
read_data bed
group granules type 1
group cylinder type 3
fix modulus all property/global youngsModulus peratomtype {modulus!r} {rigid!r} {rigid!r}
fix poisson all property/global poissonsRatio peratomtype {poisson!r} {poisson!r} {poisson!r}
fix restitution all property/global coefficientRestitution peratomtypepair 3 {restitution}
fix friction all property/global coefficientFriction peratomtypepair 3 {friction}
neighbor {skin:.17g} bin
neigh_modify every 1 delay 0 check yes
neigh_modify exclude group cylinder cylinder
pair_style gran model hertz tangential history limitForce on
pair_coeff * *
timestep {time_step:.17g}
fix left granules wall/gran model hertz tangential history primitive type 2 xplane 0 limitForce on
fix right granules wall/gran model hertz tangential history primitive type 2 xplane {width:.17g} limitForce on
fix floor granules wall/gran model hertz tangential history primitive type 2 yplane 0 limitForce on
fix lid granules wall/gran model hertz tangential history primitive type 2 yplane {height:.17g} limitForce on
fix motion cylinder move linear {speed[0]:.17g} {speed[1]:.17g} 0 units box
fix steps granules nve/sphere
fix plane granules enforce2d
thermo 1000000
run {warm}
run {steps}
"""


def available() -> str | None:
    """None if LIGGGHTS can be used, else one sentence that says why not."""
    return absent(PROGRAM)


def version() -> str:
    """Release as the program itself names it."""
    with tempfile.TemporaryDirectory() as folder:
        match = re.search(r"LIGGGHTS-\S+ [\d.]+", output(*COMMAND, folder=folder, text="\n"))
    return match[0] if match else "unknown"


def seconds(scene: Scene, state: State, time_step: float, warm: int, steps: int) -> float:
    """Time (s) that a number of steps takes after `warm` others, without starting and ending."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "bed").write_text(_bed(scene, state.checked(scene.granules)))
        text = output(*COMMAND, folder=folder, text=_input(scene, time_step, warm, steps))
    times = re.findall(r"^Loop time of (\S+) ", text, re.M)
    if len(times) != 2:
        raise RunError(f"LIGGGHTS stopped: {last_lines(text)}")
    return float(times[1])


def _bed(scene, state):
    """Data file. In two dimensions the program takes pi r^2 times density for mass."""
    (cylinder,) = scene.solids
    density, radius = scene.material.density * scene.thickness, cylinder.radius
    position = np.vstack([state.position, cylinder.position])
    velocity = np.vstack([state.velocity, cylinder.velocity])
    size = 2.0 * np.append(scene.shape.radius, radius)
    kind = [1] * scene.granules + [3]
    weight = [density] * scene.granules + [HEAVY * density]
    spin = np.append(state.angular_velocity, 0.0)
    width, height = scene.planes[[1, 3], 2]
    lines = ["bed", "", f"{len(size)} atoms", "3 atom types", ""]
    lines += [f"0 {width:.17g} xlo xhi", f"0 {height:.17g} ylo yhi"]
    lines += [f"{-radius:.17g} {radius:.17g} zlo zhi", "", "Atoms", ""]
    atoms = zip(kind, size, weight, *position.T, strict=True)
    for k, (sort, *values) in enumerate(atoms, 1):
        lines.append(" ".join((f"{k} {sort}", *(f"{value:.17g}" for value in values), "0")))
    lines += ["", "Velocities", ""]
    for k, (u, v, turn) in enumerate(zip(*velocity.T, spin, strict=True), 1):
        lines.append(f"{k} {u:.17g} {v:.17g} 0 0 0 {turn:.17g}")
    return "\n".join(lines) + "\n"


def _input(scene, time_step, warm, steps):
    material, mu = scene.material, scene.friction
    kinds = mu.granule, mu.wall, mu.solid
    width, height = scene.planes[[1, 3], 2]
    return INPUT.format(
        modulus=material.young_modulus,
        rigid=RIGID * material.young_modulus,
        poisson=material.poisson_ratio,
        restitution=" ".join(9 * [repr(restitution_if_pulling(material.restitution))]),
        friction=" ".join(repr(kinds[max(i, j)]) for i in range(3) for j in range(3)),
        skin=SKIN * scene.shape.radius.mean(),
        time_step=time_step,
        width=width,
        height=height,
        speed=scene.solids[0].velocity,
        warm=warm,
        steps=steps,
    )
