"""Our discs as a run of LIGGGHTS (https://www.cfdem.com), by its program: for time, not for motion.

Its Hertz contact is ours up to the value of the dashpot; its tangential spring remembers a length.
Walls and cylinder are of a material RIGID times stiffer than the granules, and the cylinder is a
disc HEAVY times denser with a prescribed velocity: LIGGGHTS has no moving cylinder.
"""

import re
import tempfile
from pathlib import Path

import numpy as np

from dem.base.errors import RunError
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from studies.common.peers.material import RIGID
from studies.common.peers.program import absent, last_lines, output

NAME, SHAPES = "LIGGGHTS", (Disc,)
PROGRAM = "liggghts"
COMMAND = PROGRAM, "-log", "none"
SKIN = 0.3  # of the mean radius
HEAVY = 1e9
MODEL = "model hertz tangential history"


def available() -> str | None:
    """None if LIGGGHTS can be used, else one sentence that says why not."""
    return absent(PROGRAM)


def version() -> str:
    """Release as the program itself names it."""
    with tempfile.TemporaryDirectory() as folder:
        found = re.search(r"LIGGGHTS-\S+ [\d.]+", output(*COMMAND, folder=folder, text="\n"))
    return found[0] if found else "unknown"


def seconds(scene: Scene, state: State, time_step: float, warm: int, steps: int) -> float:
    """Time (s) that a number of steps takes after `warm` others, without starting and ending."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "bed").write_text(_bed(scene, state.checked(scene.granules)))
        said = output(
            *COMMAND, folder=folder, text="\n".join((*_input(scene, time_step, warm, steps), ""))
        )
    times = re.findall(r"^Loop time of (\S+) ", said, re.M)
    if len(times) != 2:
        raise RunError(f"LIGGGHTS stopped: {last_lines(said)}")
    return float(times[1])


def _bed(scene, state):
    """Data file. In two dimensions the program takes pi r^2 times density for mass."""
    density, radius = scene.material.density * scene.thickness, 0.5 * scene.cylinder.diameter
    position = np.vstack([state.position, scene.cylinder.position])
    velocity = np.vstack([state.velocity, scene.cylinder.velocity])
    size = 2.0 * np.append(scene.shape.radius, radius)
    kind = [1] * scene.granules + [3]
    weight = [density] * scene.granules + [HEAVY * density]
    spin = np.append(state.angular_velocity, 0.0)
    width, height = np.asarray(scene.walls)[[1, 3], 2]
    lines = ["bed", "", f"{len(size)} atoms", "3 atom types", ""]
    lines += [f"0 {width:.17g} xlo xhi", f"0 {height:.17g} ylo yhi"]
    lines += [f"{-radius:.17g} {radius:.17g} zlo zhi", "", "Atoms", ""]
    for k, (x, y) in enumerate(position):
        lines.append(f"{k + 1} {kind[k]} {size[k]:.17g} {weight[k]:.17g} {x:.17g} {y:.17g} 0")
    lines += ["", "Velocities", ""]
    for k, (u, v) in enumerate(velocity):
        lines.append(f"{k + 1} {u:.17g} {v:.17g} 0 0 0 {spin[k]:.17g}")
    return "\n".join(lines) + "\n"


def _input(scene, time_step, warm, steps):
    material, friction = scene.material, scene.friction
    (u, v), (width, height) = scene.cylinder.velocity, np.asarray(scene.walls)[[1, 3], 2]
    each = [friction.granule, friction.wall, friction.cylinder]
    table = [each[max(i, j)] for i in range(3) for j in range(3)]
    stiff = RIGID * material.young_modulus
    wanted = {
        "youngsModulus peratomtype": [material.young_modulus, stiff, stiff],
        "poissonsRatio peratomtype": [material.poisson_ratio] * 3,
        "coefficientRestitution peratomtypepair 3": [material.restitution] * 9,
        "coefficientFriction peratomtypepair 3": table,
    }
    yield from ("units si", "hard_particles yes", "dimension 2", "boundary f f p", "newton off")
    yield from ("atom_style granular", "atom_modify map array", "communicate single vel yes")
    yield from ("read_data bed", "group granules type 1", "group cylinder type 3")
    for number, (name, values) in enumerate(wanted.items()):
        yield f"fix material{number} all property/global {name} " + " ".join(map(repr, values))
    yield f"neighbor {SKIN * scene.shape.radius.mean():.17g} bin"
    yield from (
        "neigh_modify every 1 delay 0 check yes",
        "neigh_modify exclude group cylinder cylinder",
    )
    yield from (f"pair_style gran {MODEL} limitForce on", "pair_coeff * *")
    yield f"timestep {time_step:.17g}"
    walls = [("x", 0.0), ("x", width), ("y", 0.0), ("y", height)]
    for number, (axis, place) in enumerate(walls):
        plane = f"primitive type 2 {axis}plane {place:.17g} limitForce on"
        yield f"fix wall{number} granules wall/gran {MODEL} {plane}"
    yield f"fix motion cylinder move linear {u:.17g} {v:.17g} 0 units box"
    yield from ("fix steps granules nve/sphere", "fix plane granules enforce2d")
    yield from ("thermo 1000000", f"run {warm}", f"run {steps}")
