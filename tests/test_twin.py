"""Whole runs of every kind of scene, against the model in plain numpy (twin.py)."""

from dataclasses import replace

import numpy as np
import pytest
import twin

import dem
from conftest import CONFIG

STEPS, FRAMES, TIME_STEP = 200, 4, 1e-6  # s; a collision takes some 50 steps
SOFT = {"density": 2.5e3, "young_modulus": 1e8, "poisson_ratio": 0.3}
WIDTH, HEIGHT = 6e-3, 5e-3  # m


def path(*velocities, spin=None):
    """A path that turns at four times of the run."""
    time = TIME_STEP * np.array([30.0, 80.0, 81.0, 150.0])
    return dem.PrescribedMotion(time, np.array(velocities), spin)


TO_AND_FRO = ((0.0, 1.0), (1.0, -1.0), (2.0, 1.0), (0.0, -1.0))  # m/s
LID = dem.Drive(force=(None, -0.2), mass=5e-6, velocity=(0.3, 0.0))
DAMPED = dem.Drive(force=(0.1, -0.3), mass=2e-5, damping=0.05, velocity=(1.0, 2.0))
GUIDED = dem.Drive(force=(None, -0.3), mass=2e-5, damping=0.05, velocity=(1.0, 2.0))
FREE = dem.Drive(force=(0.1, -0.3), mass=2e-5, velocity=(1.0, 2.0))
TURN = dem.Turn(inertia=1e-10, torque=1e-5, damping=1e-6, spin=500.0)
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


LAWS = {
    "linear discs": {"law": dem.Linear()},
    "discs in plane strain": {
        "law": dem.Line(),
        "rolling": dem.Rolling(0.2, 0.3, 0.1, damping=0.2),
    },
}
# with the kernels that test_laws.py and test_motion.py share; without rolling, and without a ledger: at night
LEDGERS = "discs in plane strain", "discs"


def scene_of(name):
    """Scenes that together have everything, in as few kernels as can be."""
    rough = dem.Friction(0.3, 0.5, 0.2, stiffness=0.7)
    table = dem.Friction([[0.3, 0.1], [0.1, 0.6]], 0.5, 0.2, stiffness=0.7)
    damped, elastic = dem.Material(restitution=0.6, **SOFT), dem.Material(restitution=1.0, **SOFT)
    steel = dem.Material(2e3, 2e8, 0.2, 0.9)
    cylinder = dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), (1.0, 2.0), spin=500.0)

    def ellipses(**options):
        return lambda r: dem.Ellipse(1.1 * r, r / 1.2, **options)

    if name == "box of discs":
        shape, state = granules(dem.Disc)
        return dem.Scene(shape, damped, rough, WALLS, cylinder), state
    if name == "discs that resist rolling":
        shape, state = granules(dem.Disc)
        cylinder = dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), (1.0, 2.0), spin=TURN)
        return dem.Scene(
            shape, damped, rough, WALLS, cylinder, rolling=dem.Rolling(0.2, 0.3, 0.1, damping=0.2)
        ), state  # fmt: skip
    if name == "discs":
        shape, state = granules(dem.Disc)
        return dem.Scene(
            shape, [damped, elastic], table,
            moving((0.0, 0.0), (-1.0, 2.0), path(*TO_AND_FRO), LID, friction=0.1, material=elastic),
            [dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), DAMPED, TURN),
             dem.Cylinder(6e-4, (4.8e-3, 3.75e-3), (0.5, 0.0), -900.0, friction=0.9, material=elastic)],
            gravity=(3e3, -1e4), thickness=1e-3, boundary=steel, species=np.arange(20) % 2,
            held=[dem.Held([0, 1], (0.5, 1.0)), dem.Held([9, 13, 14], GUIDED)],
        ), state  # fmt: skip
    if name in LAWS:
        shape, state = granules(dem.Disc)
        return dem.Scene(
            shape, [damped, steel], table, WALLS, cylinder, boundary=elastic,
            species=np.arange(20) % 2, **LAWS[name],
        ), state  # fmt: skip
    if name == "smooth discs":
        shape, state = granules(dem.Disc)
        state.angular_velocity[:] = 0.0
        return dem.Scene(
            shape, damped, None, moving((0.0, 0.0), (0.0, 0.0), path(*TO_AND_FRO), LID),
            dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), FREE), gravity=(3e3, -1e4),
            held=[dem.Held([3, 4], path(*TO_AND_FRO)), dem.Held([9, 13, 14], GUIDED)],
        ), state  # fmt: skip
    if name == "discs around solids":
        shape, state = granules(dem.Disc)
        hard = {"friction": 0.9, "material": steel}
        solids = [
            dem.Solid(WEDGE, (2.4e-3, 2.5e-3), 0.4, DAMPED, TURN, **hard),
            dem.Solid(PLATE, (3.6e-3, 1.25e-3), 0.9, path(*TO_AND_FRO, spin=[0.0, 4e3, 9e3, -5e3])),
            dem.Solid(OVAL, (1.2e-3, 3.75e-3), 0.3, (0.5, -1.0), 4e3, **hard),
            dem.Cylinder(5e-4, (4.8e-3, 2.5e-3), GUIDED, -900.0),
        ]
        return dem.Scene(shape, damped, None, WALLS, solids), state
    if name == "smooth discs around solids":
        shape, state = granules(dem.Disc)
        solids = [
            dem.Solid(WEDGE, (2.4e-3, 2.5e-3), 0.4, FREE, TURN),
            dem.Solid(PLATE, (3.6e-3, 1.25e-3), 0.9, (0.0, 1.0), 4e3),
        ]
        return dem.Scene(shape, damped, None, WALLS, solids), state
    if name == "ellipses of local radius around solids":
        precise = dem.CommonNormal(1e-6)
        shape, state = granules(ellipses(contact=precise, hertz_radius="local"))
        solids = [
            dem.Solid(WEDGE, (2.4e-3, 2.5e-3), 0.4, (1.0, 2.0), 4e3),
            dem.Solid(OVAL, (1.2e-3, 3.75e-3), 0.3, (0.5, -1.0), TURN),
        ]
        materials = {"material": [damped, steel], "species": np.arange(20) % 2}
        held = [dem.Held([9, 13], (0.5, 1.0))]
        return dem.Scene(
            shape, friction=table, walls=WALLS, solids=solids, held=held, **materials
        ), state
    if name == "dumbbells":
        shape, state = granules(lambda r: dem.Dumbbell(0.55 * r))
        turning = path(*TO_AND_FRO, spin=[0.0, 900.0, -500.0, 0.0])
        cylinder = dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), turning)
        return dem.Scene(shape, damped, rough, WALLS, cylinder), state
    if name == "clumps":
        forms = [
            [(0, 0, 1)],
            [(0, 0, 0.7), (0.9, 0.3, 0.4)],
            [(-0.7, 0, 0.6), (0.5, 0, 0.5), (0, 0.6, 0.4)],
        ]
        shape, state = granules(
            lambda r: dem.Clump([size * np.array(forms[k % 3]) for k, size in enumerate(r)])
        )
        return dem.Scene(shape, damped, rough, WALLS, cylinder), state
    if name == "ellipses":
        shape, state = granules(ellipses())
        return dem.Scene(shape, damped, rough, WALLS, cylinder), state
    if name == "ellipses by the chord":
        shape, state = granules(ellipses(contact="geometric_potential"))
        return dem.Scene(shape, damped, None, WALLS, cylinder), state
    shape, state = granules(lambda r: dem.Superellipse(0.9 * r, 0.8 * r, 0.3 * r, 3.0))
    return dem.Scene(shape, damped, rough, WALLS, cylinder), state


SCENES = (
    "box of discs",
    "discs that resist rolling",
    "discs",
    "smooth discs",
    "discs around solids",
    "dumbbells",
    "clumps",
    "ellipses",
    "ellipses by the chord",
    "ellipses of local radius around solids",
    "superellipses",
    *LAWS,
)  # fmt: skip; smooth discs around solids at night


def assert_same(result, expected, close=1e-9):
    """All arrays of a run are those of the twin, to `close` of what they change by."""
    length = 1e-3  # m, of the lever of a torque
    force = max(
        np.nanmax(np.abs(load), initial=0.0) for name, load in expected.items() if "force" in name
    )
    for name, values in expected.items():
        array = getattr(result, name)
        if array is None:
            assert not values.size or not np.nan_to_num(values).any(), name
            continue
        assert array.shape == values.shape, name
        scale = np.nanmax(np.abs(values - values[0]), initial=0.0)
        scale = expected["velocity"].max() / length if name == "angular_velocity" else scale
        scale = force if "force" in name else force * length if "torque" in name else scale
        np.testing.assert_allclose(array, values, rtol=0.0, atol=close * scale, err_msg=name)


def assert_run_is_that_of_the_model(scene, state, close=1e-9, ledger=False):
    """After 200 steps."""
    expected = twin.simulate(scene, state, TIME_STEP, STEPS, FRAMES)
    result = dem.simulate(
        scene, state, STEPS * TIME_STEP, TIME_STEP, FRAMES, skin=0.3, allow_unstable=True,
        ledger=ledger,
    )  # fmt: skip
    assert_same(result, expected, close)


@pytest.mark.parametrize("name", SCENES)
def test_a_run_is_that_of_the_model(name):
    """Positions, angles, velocities, spins and the forces on all boundaries, after 200 steps."""
    # normals of ellipses that are apart are exact from the third step on
    later = "ellipses", "ellipses of local radius around solids"
    close = 1e-6 if name in later else 1e-9
    assert_run_is_that_of_the_model(*scene_of(name), close, ledger=name in LEDGERS)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_large_bed_is_that_of_the_model(threads):
    """Beds of more than 1,024 granules are shared out to threads, and reordered."""
    shape, state = granules(dem.Disc, 40, 28)
    steps, width, height = 20, 8 * WIDTH, 7 * HEIGHT
    scene = dem.Scene(
        shape, dem.Material(restitution=0.6, **SOFT), dem.Friction(0.3, 0.5, 0.2),
        dem.box(width, height)[2:], dem.Cylinder(1e-3, (24e-3, 17.5e-3), FREE, spin=500.0),
        gravity=(0.0, -1e4), periodic=(width, None),
        held=[dem.Held([700, 701, 740], path(*TO_AND_FRO)), dem.Held([5, 6], FREE)],
    )  # fmt: skip
    expected = twin.simulate(scene, state, TIME_STEP, steps)
    result = dem.simulate(
        scene, state, steps * TIME_STEP, TIME_STEP, skin=0.3, threads=threads, allow_unstable=True
    )
    assert_same(result, expected)


def test_a_run_of_a_configuration_is_that_of_the_model():
    """The values of a file become the scene that they say, and its forces the columns of drag.nc."""
    material = {"young_modulus": 5e9, "poisson_ratio": 0.3, "restitution": 0.6, "thickness": 1.3e-3}
    friction = {"granule": 0.3, "wall": 0.5, "cylinder": 0.2}
    dt, bins, every, steps = 5e-8, 40, 10, 5  # s; steps a bin
    values = {
        "extends": str(CONFIG / "smoke.yaml"), "shape": "c1", "density": 2e3, "seed": 4,
        "material": material, "friction": friction, "numerics": {"time_step": dt},
        "cylinder": {"stroke": 2.0 * bins * steps * dt},
        "record": {"bins": bins, "snapshots": 5, "window": [0.0, 1e-5]},
    }  # fmt: skip
    run = dem.run_experiment(values)

    radius, height = 0.5 * run.granule_diameter.values, float(run.box_height)
    cylinder = dem.Cylinder(1.5e-3, (4e-3, 0.25 * height), (0.0, 2.0))
    thickness = material.pop("thickness")
    scene = dem.Scene(
        dem.Disc(radius), dem.Material(2e3, **material), dem.Friction(*friction.values()),
        dem.box(8e-3, height), cylinder, thickness=thickness,
    )  # fmt: skip
    first = run.isel(snapshot=0)
    position = np.column_stack([first.granule_x, first.granule_y])
    expected = twin.simulate(
        scene, dem.State(position, angle=first.granule_angle), dt, bins * steps, bins
    )
    assert 0.25 * np.pi * ((2 * radius) ** 2).sum() / (8e-3 * height - np.pi * 0.75e-3**2) == (
        pytest.approx(0.84, rel=1e-9)
    )
    speed, spin = expected["velocity"][1:], expected["angular_velocity"][1:]
    energy = 0.5 * (scene.mass * (speed**2).sum(axis=-1) + scene.inertia * spin**2).sum(axis=-1)
    np.testing.assert_allclose(run.kinetic_energy, energy, rtol=1e-9)
    force = np.nanmax(np.abs(expected["wall_force"]))
    for name, values in {
        "drag": -expected["solid_force"][1:, 0, 1],
        "transverse_force": expected["solid_force"][1:, 0, 0],
        "wall_force": expected["wall_force"][1:].T,
    }.items():
        np.testing.assert_allclose(run[name], values, rtol=0.0, atol=1e-9 * force, err_msg=name)
    assert np.abs(expected["solid_force"][1:, 0, 1]).max() > 1e-3 * force
    for axis, name in enumerate(("granule_x", "granule_y")):
        track = expected["position"][::every, :, axis]
        np.testing.assert_allclose(run[name] - track[0], track - track[0], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(run.cylinder_y, expected["solid_position"][::every, 0, 1])
