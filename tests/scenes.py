"""Scenes that together have all that a scene can have."""

from dataclasses import replace

import numpy as np
from forms import clumps

import dem

STEPS, FRAMES, TIME_STEP = 80, 4, 1e-6  # s; a collision takes some 50 steps


SOFT = {"density": 2.5e3, "young_modulus": 1e8, "poisson_ratio": 0.3}


WIDTH, HEIGHT = 6e-3, 5e-3  # m


def path(*velocities, spin=None):
    """A path that turns at four times of the run."""
    time = TIME_STEP * np.array([20.0, 40.0, 41.0, 60.0])
    return dem.PrescribedMotion(time, np.array(velocities), spin)


TO_AND_FRO = ((0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (0.0, -1.0))  # m/s


LID = dem.Drive(force=(None, -0.2), mass=5e-6, velocity=(0.3, 0.0))


RISING = TIME_STEP * np.array([10.0, 50.0])


DAMPED = dem.Drive(force=(0.1, -0.3), mass=2e-5, damping=0.05, velocity=(1.0, 2.0))


PULLED = dem.Drive(
    force=(dem.PrescribedLoad(RISING, [-0.1, 0.3]), -0.3), mass=2e-5, damping=0.05, velocity=(1.0, 2.0),
    spring=(2e3, 1e3), anchor=path(*TO_AND_FRO),
)  # fmt: skip


GUIDED = dem.Drive(force=(None, -0.3), mass=2e-5, damping=0.05, velocity=(1.0, 2.0))


FREE = dem.Drive(force=(0.1, -0.3), mass=2e-5, velocity=(1.0, 2.0))


TURN = dem.Turn(
    inertia=1e-10, torque=dem.PrescribedLoad(RISING, [3e-5, 1e-5]), damping=1e-6, spin=500.0,
    spring=1e-3, anchor=300.0, weight=(0.05, -0.1), centre=(1e-4, 2e-4),
)  # fmt: skip


WALLS = dem.box(WIDTH, HEIGHT)


WEDGE = dem.Polygon([[-2.5e-4, -2e-4], [3e-4, -1.5e-4], [0.0, 2.5e-4]], radius=1.6e-4)


PLATE = dem.plate(length=9e-4, thickness=3.2e-4)


OVAL = dem.Ellipse([4.5e-4], [2.5e-4])


def moving(*motions, **last):
    """Walls of the box that move so; the last one is also of these values."""
    *walls, top = map(dem.Wall, WALLS, motions)
    return [*walls, replace(top, **last)]


def granules(make, columns=5, rows=4):
    """Granules on a grid from which they are displaced: most touch, few deeply."""
    rng, n = np.random.default_rng(7), columns * rows
    sizes = rng.uniform(0.45e-3, 0.65e-3, n)
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(n, 2)
    position = (grid + 0.5 + rng.uniform(-0.06, 0.06, (n, 2))) * [WIDTH / 5, HEIGHT / 4]
    state = dem.State(
        position, rng.normal(size=(n, 2)), rng.uniform(0.0, 7.0, n), rng.normal(scale=1e3, size=n)
    )
    return make(sizes), state


# with the kernels that test_laws.py and test_motion.py share; without rolling, and without a ledger: at night
LEDGERS = "discs in plane strain", "discs"


def ellipses(**options):
    return lambda r: dem.Ellipse(1.1 * r, r / 1.2, **options)


MADE = {
    "dumbbells": lambda r: dem.Dumbbell(0.55 * r),
    "clumps": lambda r: clumps(0.8 * r),
    "ellipses": ellipses(),
    "ellipses by the chord": ellipses(contact="geometric_potential"),
    "ellipses of local radius around solids": ellipses(
        contact=dem.CommonNormal(1e-6), hertz_radius="local"
    ),
    "superellipses": lambda r: dem.Superellipse(0.9 * r, 0.8 * r, 0.3 * r, 3.0),
}


def scene_of(name):
    """Scenes that together have everything, in as few kernels as can be."""
    table = dem.Friction([[0.3, 0.1], [0.1, 0.6]], 0.5, 0.2, stiffness=0.7)
    damped, elastic = dem.Material(restitution=0.6, **SOFT), dem.Material(restitution=1.0, **SOFT)
    steel = dem.Material(2e3, 2e8, 0.2, 0.9)
    axis = 2.4e-3, 2.5e-3  # m
    cylinder = dem.Cylinder(1e-3, axis, (1.0, 2.0), spin=500.0)
    mixture = {"friction": table, "species": np.arange(20) % 2}
    hard = {"friction": 0.9, "material": steel}
    group = [9, 13, 14]
    changes = {
        "discs": mixture | {
            "material": [damped, elastic],
            "walls": moving((0.0, 0.0), (-1.0, 2.0), path(*TO_AND_FRO), LID, friction=0.1, material=elastic),
            "solids": [
                dem.Cylinder(1e-3, axis, PULLED, TURN),
                dem.Cylinder(6e-4, (4.8e-3, 3.75e-3), (0.5, 0.0), -900.0, friction=0.9, material=elastic),
            ],
            "gravity": (3e3, -1e4),
            "thickness": 1e-3,
            "boundary": steel,
            "held": [dem.Held([0, 1], (0.5, 1.0)), dem.Held(group, GUIDED)],
        },
        "smooth discs": {
            "friction": None,
            "walls": moving((0.0, 0.0), (0.0, 0.0), path(*TO_AND_FRO), (0.0, -1.0)),
            "solids": dem.Cylinder(1e-3, axis, path(*TO_AND_FRO)),
            "gravity": (3e3, -1e4),
        },
        "discs around solids": {
            "friction": None,
            "solids": [
                dem.Solid(WEDGE, axis, 0.4, DAMPED, TURN, **hard),
                dem.Solid(PLATE, (3.6e-3, 1.25e-3), 0.9, path(*TO_AND_FRO, spin=[0.0, 4e3, 9e3, -5e3])),
                dem.Solid(OVAL, (1.2e-3, 3.75e-3), 0.3, (0.5, -1.0), 4e3, **hard),
                dem.Cylinder(5e-4, (4.8e-3, 2.5e-3), GUIDED, -900.0),
            ],
        },
        "smooth discs around solids": {
            "friction": None,
            "solids": [
                dem.Solid(WEDGE, axis, 0.4, FREE, TURN),
                dem.Solid(PLATE, (3.6e-3, 1.25e-3), 0.9, (0.0, 1.0), 4e3),
            ],
        },
        "ellipses of local radius around solids": mixture | {
            "material": [damped, steel],
            "solids": [
                dem.Solid(WEDGE, axis, 0.4, (1.0, 2.0), 4e3),
                dem.Solid(OVAL, (1.2e-3, 3.75e-3), 0.3, (0.5, -1.0), TURN),
            ],
            "held": [dem.Held([9, 13], (0.5, 1.0))],
        },
        "dumbbells": {
            "solids": dem.Cylinder(1e-3, axis, path(*TO_AND_FRO, spin=[0.0, 900.0, -500.0, 0.0])),
            "held": [dem.Held(group, GUIDED)],
        },
        "ellipses by the chord": {"friction": None},
        "discs in plane strain": mixture | {
            "law": dem.Line(),
            "rolling": dem.Rolling(0.2, 0.3, 0.1, damping=0.2),
            "material": [damped, steel],
            "boundary": elastic,
        },
    }  # fmt: skip
    shape, state = granules(MADE.get(name, dem.Disc))
    if name == "smooth discs":
        state.angular_velocity[:] = 0.0
    rough = {"friction": dem.Friction(0.3, 0.5, 0.2, stiffness=0.7), "material": damped}
    values = rough | {"walls": WALLS, "solids": cylinder} | changes.get(name, {})
    return dem.Scene(shape, **values), state


SHAPES = "box of discs", "dumbbells", "clumps", "ellipses", "superellipses"


SCENES = (
    "box of discs",
    "discs",
    "smooth discs",
    "discs around solids",
    "dumbbells",
    "clumps",
    "ellipses",
    "ellipses by the chord",
    "ellipses of local radius around solids",
    "superellipses",
    "discs in plane strain",
)  # fmt: skip; smooth discs around solids at night


ANCHOR = dem.Drive((0.0, 0.0), mass=1e6)


def lids(rows):
    """Walls that are heavy, and that nothing pushes: their scenes are of the kind that has a lid."""
    return [dem.Wall(row, dem.Drive((None, 0.0), 1.0)) for row in rows] or None


def mapped(scene, state, matrix):
    """Scene and state seen through an orthogonal matrix."""
    matrix = np.array(matrix)
    hand = np.linalg.det(matrix)
    walls = np.column_stack([scene.planes[:, :2] @ matrix.T, scene.planes[:, 2]])
    solids = [
        replace(
            solid,
            position=matrix @ solid.position,
            velocity=matrix @ solid.velocity,
            spin=hand * solid.spin,
        )
        for solid in scene.solids
    ]
    shape = scene.shape
    if isinstance(shape, dem.Clump):  # which a mirror changes
        shape = shape._replace(discs=shape.discs * [1.0, hand, 1.0])
    turn = np.arctan2(matrix[1, 0], matrix[0, 0])
    seen = dem.State(
        state.position @ matrix.T,
        state.velocity @ matrix.T,
        turn + hand * state.angle,
        hand * state.angular_velocity,
    )
    return replace(scene, shape=shape, walls=walls, solids=solids), seen
