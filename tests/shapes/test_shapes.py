"""What every shape keeps: its sizes fit its outline, and a class is no part of how granules move."""

from dataclasses import replace

import numpy as np
import pytest
from collisions import ELASTIC, LEAST
from egg import Egg
from forms import FORMS
from numpy.testing import assert_allclose, assert_array_equal
from project import quick
from scenes import TIME_STEP, granules, scene_of

import dem

SIZES = 1e-3 * np.array([0.5, 1.0, 0.7, 1.3, 0.9, 1.1, 0.8])


# Sizes


@quick
@pytest.mark.parametrize("form", FORMS)
def test_bounds_are_those_of_the_outline(form):
    """Bounding circle, and greatest lever and bend of each granule, by the edges of the outline that is drawn."""
    shape = FORMS[form](SIZES)
    for g, rings in enumerate(shape.polygons(2049)):
        z, size = rings @ [1.0, 1.0j], shape.bounding_radius[g]
        assert_allclose(abs(z).max(), size, rtol=2e-4)
        is_edge = abs(np.diff(z)) > 1e-9 * size
        edge, middle = np.diff(z)[is_edge], (z[:, :-1] + 0.5 * np.diff(z))[is_edge]
        lever = (middle.conj() * edge).real / abs(edge)
        assert_allclose(abs(lever).max(), shape.normal_lever[g], rtol=1e-2, atol=2e-3 * size)
        turn = np.angle(edge[1:] / edge[:-1])
        bend = (np.diff(lever) / turn)[(turn > 1e-5) & (turn < 0.1)].max()
        assert 0.8 * shape.normal_bend[g] - 1e-2 * size < bend < shape.normal_bend[g] + 1e-2 * size


@quick
def test_granules_of_a_size_have_the_form_that_is_asked_for():
    """Each argument of of_size, beside others that are not its default."""
    box = dem.Superellipse.of_size(SIZES, 2.0, 3.0, 0.4)
    for shape in (dem.Ellipse.of_size(SIZES, 2.0), box):
        assert_allclose(shape.semi_major / shape.semi_minor, 2.0)
    assert_allclose(box.rounding / box.semi_minor, 0.4)
    assert box.exponent == 3.0


@quick
def test_outlines_of_superellipses_are_those_of_their_name():
    """|x/a|^n + |y/b|^n = 1 without rounding."""
    for n in (1.4, 2.0, 3.0, 8.0):
        x, y = abs(dem.Superellipse([2.0], [1.0], [1e-6], n).polygons()[0, 0].T)
        assert_allclose((0.5 * x) ** n + y**n, 1.0, rtol=1e-3)


EXTREME = [
    dem.Superellipse.of_size(SIZES[:3], 3.0, 20.0, 0.01),
    dem.Superellipse.of_size(SIZES[:3], 1.0, 1.2, 0.1),
    dem.Ellipse.of_size(SIZES[:3], 10.0),
]


@pytest.mark.parametrize("shape", [*(form(SIZES[:3]) for form in FORMS.values()), *EXTREME])
def test_check_shape_accepts_what_keeps_the_laws(shape):
    """All shapes of the registry, long and nearly flat ones and one without symmetry."""
    dem.check_shape(shape)


# Motion

ALIKE = {
    "disc": [
        dem.Disc,
        lambda r: dem.Clump([[(5.0, 1.0, s), (5.0, 1.0 - 0.5 * s, 0.5 * s)] for s in r]),
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
    """A result of granules that collide in a box with a solid that turns."""
    shape, start = granules(form)
    scene = replace(scene_of("box of discs")[0], shape=shape)
    return start, dem.simulate(scene, start, 2e-4, TIME_STEP, allow_unstable=True)


@quick
@pytest.mark.parametrize("outline", ALIKE)
def test_granules_of_one_outline_move_alike_whatever_their_class(outline):
    """Discs, dumbbells and ellipses that are given as other shapes, with friction, damping, spins, walls and a solid."""
    (start, first), *others = map(bustle, ALIKE[outline])
    assert np.ptp(first.state.angular_velocity - start.angular_velocity) > 100.0
    for _, other in others:
        assert_allclose(other.scene.mass, first.scene.mass, rtol=1e-9)
        assert_allclose(other.state.velocity, first.state.velocity, atol=1e-4)
        spin = first.state.angular_velocity
        assert_allclose(other.state.angular_velocity, spin, atol=0.1)
        assert_allclose(other.solid_torque[1], first.solid_torque[1], rtol=1e-4)


@quick
@pytest.mark.parametrize("form", [form for form in FORMS if form != "dumbbell"])
def test_an_elastic_impact_is_that_of_a_rigid_body(form):
    """A floor gives the impulse 2 v_n / (1/m + arm^2/I) at the lowest point of the outline, wherever the centre of
    mass is; granules that would meet it twice are left out."""
    shape, angle, speed = FORMS[form](SIZES), np.linspace(0.4, 2.9, 7), 0.02
    outlines = shape.polygons(2049)[:, 0] @ [1.0, 1.0j] * np.exp(1j * angle)[:, None]
    lowest = outlines[np.arange(7), outlines.imag.argmin(axis=1)]
    place = np.column_stack([0.02 * np.arange(7), 1e-9 - lowest.imag])
    walls = {"walls": [[0.0, -1.0, 0.0]], "solids": dem.Cylinder(1e-3, (0.0, 1.0))}
    scene = dem.Scene(shape, ELASTIC, **LEAST | walls)
    state = dem.State(place, np.full((7, 2), [0.0, -speed]), angle)
    run, arm = dem.Simulation(scene, state, step_fraction=0.02), lowest.real
    run.advance(2e-7)
    while len(run.contacts().granule):
        run.advance(2e-6)
    impulse = 2.0 * speed / (1.0 / scene.mass + arm**2 / scene.inertia)
    once = arm**2 < scene.inertia / scene.mass
    assert once.sum() > 1
    rise, spin = impulse / scene.mass - speed, impulse * arm / scene.inertia
    assert_allclose(run.state.velocity[once, 1], rise[once], atol=5e-3 * speed)
    assert_allclose(run.state.angular_velocity[once], spin[once], rtol=2e-2, atol=0.3)


@quick
def test_the_numbers_of_a_shape_may_be_views_of_others(monkeypatch):
    """Compiled code reads arrays as they were the first time."""

    def velocities():
        disc, material = dem.Disc([1e-3, 2e-3]), dem.Material(restitution=0.5)
        state = dem.State([[0.0, 0.0], [2.9e-3, 0.0]])
        run = dem.Simulation(dem.Scene(disc, material, dem.Friction()), state)
        run.advance(1e-6)
        return run.state.velocity

    expected = velocities()
    view = property(lambda disc: np.column_stack([disc.radius, 9.0 * disc.radius])[:, 0])
    monkeypatch.setattr(dem.Disc, "constituent_radius", view)
    monkeypatch.setattr(dem.Disc, "constituent_bounding_radius", view)
    assert_array_equal(velocities(), expected)
