"""What every shape keeps: its sizes fit its outline, and a class is no part of how granules move."""

import numpy as np
import pytest
from collisions import ELASTIC, LEAST, gains, volley
from egg import Egg
from forms import FORMS, RATIOS, TRIMER
from numpy.testing import assert_allclose
from refusals.granules import OFF, Lumps, one

import dem
from dem.shapes import KINDS

SIZES = 1e-3 * np.array([0.5, 1.0, 0.7, 1.3, 0.9, 1.1, 0.8])


# Sizes


@pytest.mark.quick
@pytest.mark.parametrize("form", FORMS)
def test_sizes_are_those_of_the_outline(form):
    """Area, inertia, bounding circle, levers and bends of each granule, by sums over the outline that is drawn."""
    shape = FORMS[form](SIZES)
    for g, rings in enumerate(shape.polygons(2049)):
        z = rings @ [1.0, 1.0j]
        a, b = z[:, :-1], z[:, 1:]
        triangle = 0.5 * (a.conj() * b).imag
        area = triangle.sum()
        moment = (triangle * (abs(a) ** 2 + (a.conj() * b).real + abs(b) ** 2)).sum() / 6.0
        centre, size = (triangle * (a + b)).sum() / 3.0 / area, shape.bounding_radius[g]
        assert_allclose(centre, 0.3 * SIZES[g] if "loaded" in form else 0.0, atol=1e-5 * size)
        assert_allclose(shape.area[g], area, rtol=1e-4)
        assert_allclose(shape.gyration_squared[g], moment / area, rtol=2e-4)
        assert_allclose(abs(z).max(), size, rtol=2e-4)
        edge = (b - a)[abs(b - a) > 1e-9 * size]
        lever = ((0.5 * (a + b))[abs(b - a) > 1e-9 * size].conj() * edge).real / abs(edge)
        assert_allclose(abs(lever).max(), shape.normal_lever[g], rtol=1e-2, atol=2e-3 * size)
        turn = np.angle(edge[1:] / edge[:-1])
        bend = (np.diff(lever) / turn)[(turn > 1e-5) & (turn < 0.1)].max()
        assert 0.8 * shape.normal_bend[g] - 1e-2 * size < bend < shape.normal_bend[g] + 1e-2 * size


@pytest.mark.quick
@pytest.mark.parametrize("ratio", RATIOS)
def test_granules_of_a_size_have_the_area_and_the_form_that_are_asked_for(ratio):
    """Each argument of of_size, beside others that are not its default."""
    ellipse = dem.Ellipse.of_size(SIZES, ratio)
    box = dem.Superellipse.of_size(SIZES, ratio, 3.0, 0.4)
    for shape in (ellipse, box, dem.Disc.of_size(SIZES), dem.Clump.of_size(SIZES, ratio * TRIMER)):
        assert_allclose(shape.area, 0.25 * np.pi * SIZES**2, rtol=1e-6)
    for shape in (ellipse, box):
        assert_allclose(shape.semi_major / shape.semi_minor, ratio)
    assert_allclose(box.rounding / box.semi_minor, 0.4)
    assert box.exponent == 3.0


@pytest.mark.quick
def test_outlines_of_superellipses_are_those_of_their_name():
    """|x/a|^n + |y/b|^n = 1 without rounding; with n = 2 an ellipse of semi-axes sqrt(a^2 + 2 c^2)."""
    a, b, c = 1e-3 * np.array([[1.0, 2.0, 3.0], [1.0, 0.5, 1.5], [0.2, 0.4, 0.3]])
    for n in (1.4, 2.0, 3.0, 8.0):
        x, y = np.moveaxis(dem.Superellipse(a, b, 1e-6 * b, n).polygons()[:, 0], -1, 0)
        assert_allclose((abs(x).T / a) ** n + (abs(y).T / b) ** n, 1.0, rtol=1e-3)
    x, y = np.moveaxis(dem.Superellipse(a, b, c, 2.0).polygons()[:, 0], -1, 0)
    assert_allclose(x.T**2 / (a**2 + 2.0 * c**2) + y.T**2 / (b**2 + 2.0 * c**2), 1.0, rtol=1e-9)


EXTREME = [
    dem.Superellipse.of_size(SIZES[:3], 3.0, 20.0, 0.01),
    dem.Superellipse.of_size(SIZES[:3], 1.0, 1.2, 0.1),
    dem.Ellipse.of_size(SIZES[:3], 10.0),
]


@pytest.mark.parametrize("shape", [*(form(SIZES[:3]) for form in FORMS.values()), *EXTREME])
def test_check_shape_accepts_what_keeps_the_laws(shape):
    """All shapes of the registry, long and nearly flat ones and one without symmetry."""
    dem.check_shape(shape)


def test_each_shape_of_the_package_is_asked_here():
    assert {kind.name for kind in KINDS.values()} <= {type(FORMS[f](SIZES)).__name__ for f in FORMS}


def test_the_remedy_for_a_granule_off_its_centre_helps():
    """The sentence says what to subtract from the support function; the shape is then accepted."""
    with pytest.raises(dem.InputError, match=r"subtract c_x nx") as error:
        dem.check_shape(OFF)
    x = float(str(error.value).partition("c = (")[2].partition(",")[0])
    dem.check_shape(Lumps(OFF.radius, OFF.lump, OFF.shift - one(1.0) / 1e-3 * x))


# Motion

ALIKE = {
    "disc": [
        dem.Disc,
        lambda r: dem.Clump([[(5.0, 1.0, s), (5.0, 1.0 - 0.5 * s, 0.5 * s)] for s in r]),
        lambda r: dem.Superellipse(0.6 * r, 0.6 * r, np.sqrt(0.32) * r, 2.0),
        lambda r: Egg(r, 0.0),
    ],
    "dumbbell": [
        lambda r: dem.Dumbbell(0.6 * r),
        lambda r: dem.Clump([[(2.0 * s, s, 0.6 * s), (0.8 * s, s, 0.6 * s)] for s in r]),
    ],
    "ellipse": [
        lambda r: dem.Ellipse(r, 0.7 * r),
        lambda r: dem.Superellipse(np.sqrt(0.68) * r, np.sqrt(0.17) * r, 0.4 * r, 2.0),
    ],
}


def bustle(form):
    """A result of granules that fly and spin in a box with a solid that turns."""
    rng, count = np.random.default_rng(1), 25
    grid = 2.2e-3 * (np.stack(np.meshgrid(*2 * [np.arange(5)]), -1).reshape(-1, 2) + 0.5)
    shape = form(1e-3 * rng.uniform(0.8, 1.0, count))
    cylinder = dem.Cylinder(2e-3, (5.5e-3, 12.5e-3), (0.5, -1.0), spin=300.0)
    scene = dem.Scene(
        shape, dem.Material(young_modulus=1e8, restitution=0.5), dem.Friction(0.5, 0.3, 0.4),
        dem.box(11e-3, 14e-3), cylinder, thickness=1e-3,
    )  # fmt: skip
    velocity, angle = rng.normal(size=(count, 2)), rng.uniform(0.0, 7.0, count)
    start = dem.State(grid, velocity, angle, rng.normal(scale=1e3, size=count))
    return start, dem.simulate(scene, start, 1e-3, time_step=5e-7)


@pytest.mark.quick
@pytest.mark.parametrize("outline", ALIKE)
def test_granules_of_one_outline_move_alike_whatever_their_class(outline):
    """Discs, dumbbells and ellipses that are given as other shapes, with friction, damping, spins, walls and a solid."""
    (start, first), *others = map(bustle, ALIKE[outline])
    assert np.ptp(first.state.angular_velocity - start.angular_velocity) > 100.0
    for _, other in others:
        assert_allclose(other.scene.mass, first.scene.mass, rtol=1e-9)
        assert_allclose(other.state.velocity, first.state.velocity, atol=1e-4)
        spins = other.state.angular_velocity, first.state.angular_velocity
        assert_allclose(*spins, atol=0.1)
        assert_allclose(other.solid_torque[1], first.solid_torque[1], rtol=1e-4)


@pytest.mark.quick
@pytest.mark.parametrize("form", [form for form in FORMS if form != "dumbbell"])
def test_an_elastic_impact_is_that_of_a_rigid_body(form):
    """A floor gives the impulse 2 v_n / (1/m + arm^2/I) at the lowest point of the outline, wherever the centre of
    mass is; granules that would meet it twice are left out."""
    shape, speed = FORMS[form](SIZES), 0.02
    outlines = shape.polygons(2049)[:, 0] @ [1.0, 1.0j]
    for angle in (0.4, 2.9):
        turned = outlines * np.exp(1j * angle)
        lowest = turned.imag.argmin(axis=1)
        point = turned[np.arange(len(SIZES)), lowest]
        place = np.column_stack([0.02 * np.arange(len(SIZES)), 1e-9 - point.imag])
        walls = {"walls": [[0.0, -1.0, 0.0]], "solids": dem.Cylinder(1e-3, (0.0, 1.0))}
        scene = dem.Scene(shape, ELASTIC, **LEAST | walls)
        velocity = np.tile([0.0, -speed], (len(SIZES), 1))
        run = dem.Simulation(
            scene, dem.State(place, velocity, angle + 0.0 * SIZES), step_fraction=0.02
        )
        run.advance(2e-7)
        while len(run.contacts().granule):
            run.advance(2e-6)
        impulse = 2.0 * speed / (1.0 / scene.mass + point.real**2 / scene.inertia)
        once = point.real**2 < scene.inertia / scene.mass
        assert once.sum() > 1
        spin, state = impulse * point.real / scene.inertia, run.state
        rise = impulse / scene.mass - speed
        assert_allclose(state.velocity[once, 1], rise[once], atol=5e-3 * speed)
        assert_allclose(state.angular_velocity[once], spin[once], rtol=2e-2, atol=0.3)


@pytest.mark.parametrize("form", ["ellipse", "superellipse of 12", "egg"])
def test_elastic_bounces_keep_energy_alike(form):
    """The error of energy falls with the step at one order, and is as small for all smooth shapes."""
    sizes = 1e-3 * np.random.default_rng(0).uniform(0.5, 1.0, 100)
    scene, state = volley(FORMS[form](sizes), 1, 500.0, material=ELASTIC, **LEAST)
    steps = np.array([0.04, 0.02, 0.01])
    error = [np.median(np.abs(gains(scene, state, step))) for step in steps]
    assert np.polyfit(np.log(steps), np.log(error), 1)[0] > 2.0
    assert error[-1] < 3e-8
