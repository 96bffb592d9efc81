"""Our discs as a run of YADE (https://yade-dem.org), by its program: for time, not for motion.

Its contact has Hertz's law, our E* and G*, and our dashpot; its spheres are kept in the
plane and get our masses. Walls and the cylinder are of a material RIGID times stiffer than the granules.
"""

import json
import math
import re
import tempfile
from pathlib import Path

import numpy as np

from dem.base.errors import RunError
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from studies.common.peers.material import RIGID, restitution_if_pulling
from studies.common.peers.program import absent, last_lines, output

NAME, SHAPES = "YADE", (Disc,)
PROGRAM = "yade"
SKIN = 0.3  # of the mean radius; timings are flat about it
SCRIPT = """\
import json, time
from yade import *

with open("scene") as file:
    d = json.load(file)

def material(stiffness):
    mine = dict(poisson=d["poisson_ratio"], frictionAngle=0.0, density=1.0)
    return O.materials.append(FrictMat(young=stiffness * d["young_modulus"], **mine))

granules, walls, cylinder = material(1.0), material(d["rigid"]), material(d["rigid"])
for (x, y), (u, v), spin, radius, mass, inertia in d["discs"]:
    disc = utils.sphere((x, y, 0.0), radius, material=granules)
    disc.state.mass, disc.state.inertia = mass, (inertia,) * 3
    disc.state.vel, disc.state.angVel, disc.state.blockedDOFs = (u, v, 0.0), (0.0, 0.0, spin), "zXY"
    O.bodies.append(disc)
(x, y), (u, v), radius = d["cylinder"]
moving = utils.sphere((x, y, 0.0), radius, material=cylinder, fixed=True)
moving.state.vel = u, v, 0.0
O.bodies.append(moving)
for axis, length in enumerate(d["box"]):
    for place, sense in ((0.0, 1), (length, -1)):
        O.bodies.append(utils.wall(place, axis, sense=sense, material=walls))

def matcher(*pairs):
    return MatchMaker(matches=[(granules, other, v) for other, v in zip((granules, walls, cylinder), pairs)])

bounce = dict(en=matcher(*[d["restitution"]] * 3), es=matcher(*[d["restitution"]] * 3))
O.dt = d["time_step"]
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=d["skin"]),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(frictAngle=matcher(*d["angles"]), **bounce)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    NewtonIntegrator(damping=0.0, exactAsphericalRot=False),
]
if d["warm"] > 0:  # zero would be without end
    O.run(d["warm"], True)
started = time.process_time()
O.run(d["steps"], True)
print("seconds", time.process_time() - started, flush=True)
"""


def available() -> str | None:
    """None if YADE can be used, else one sentence that says why not."""
    return absent(PROGRAM)


def version() -> str:
    """Release as the program itself names it."""
    match = re.search(r"version: (\S+)", output(PROGRAM, "--version"))
    return match[1] if match else "unknown"


def seconds(scene: Scene, state: State, time_step: float, warm: int, steps: int) -> float:
    """Processor time (s) that a number of steps takes after `warm` others, without starting and ending."""
    with tempfile.TemporaryDirectory() as folder:
        values = _values(scene, state.checked(scene.granules))
        values |= {"time_step": time_step, "warm": warm, "steps": steps}
        (Path(folder) / "scene").write_text(json.dumps(values))
        (Path(folder) / "run.py").write_text(SCRIPT)
        text = output(PROGRAM, "-n", "-x", "-j1", "run.py", folder=folder)
    match = re.search(r"^seconds (\S+)", text, re.M)
    if match is None:
        raise RunError(f"YADE stopped: {last_lines(text)}")
    return float(match[1])


def _values(scene, state):
    material, friction, (cylinder,) = scene.material, scene.friction, scene.solids
    columns = (
        state.position,
        state.velocity,
        state.angular_velocity,
        scene.shape.radius,
        scene.mass,
        scene.inertia,
    )
    return {
        "young_modulus": material.young_modulus,
        "poisson_ratio": material.poisson_ratio,
        "restitution": restitution_if_pulling(material.restitution),
        "rigid": RIGID,
        "angles": [math.atan(mu) for mu in (friction.granule, friction.wall, friction.solid)],
        "skin": SKIN * float(scene.shape.radius.mean()),
        "discs": list(zip(*(np.asarray(column).tolist() for column in columns), strict=True)),
        "cylinder": [list(cylinder.position), list(cylinder.velocity), cylinder.radius],
        "box": scene.planes[[1, 3], 2].tolist(),
    }
