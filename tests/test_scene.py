"""What a scene is made of: masses, thickness, and materials and coefficients of each kind of contact."""

import math
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import dem
from dem.periodic import nearest_image, periods_of, walled, wrapped
from dem.solids import walls_of

pytestmark = pytest.mark.quick

R = 1e-3
GLASS = dem.Material(2500.0, 7e10, 0.22, 0.9)
STEEL = dem.Material(7800.0, 2.1e11, 0.3, 0.4)
RUBBER = dem.Material(1100.0, 1e9, 0.45, 0.2)
GRANULES = {"material": [GLASS, STEEL], "species": [0, 1], "thickness": R}
AWAY = dem.Cylinder(R, (0.1, 0.1))


def star(*materials):
    """E* (Pa): 1/E* is the sum of (1 - nu^2)/E of both (Johnson 1985, equation 4.24)."""
    return 1.0 / sum((1.0 - m.poisson_ratio**2) / m.young_modulus for m in materials)


def near(partner, gap, velocity, body=None, **more):
    """A disc of steel, and a gap (m) above it one of glass of a velocity: in the place of the lower one
    may be a wall or a cylinder, each with what is in `body`."""
    places = [[0.0, 2 * R + gap], [0.0, 0.0] if partner == "granule" else [0.05, 0.05]]
    body = body or {}
    changes = {
        "granule": {"solids": AWAY, "walls": [[0.0, -1.0, 1.0]]},
        "wall": {"solids": AWAY, "walls": [dem.Wall([0.0, -1.0, -R], **body)]},
        "solid": {"solids": dem.Cylinder(2 * R, (0.0, 0.0), **body), "walls": [[0.0, -1.0, 1.0]]},
    }[partner]
    scene = dem.Scene(dem.Disc([R, R]), **{"friction": dem.Friction()} | GRANULES | changes | more)
    return scene, dem.State(places, [velocity, [0.0, 0.0]])


def test_the_thickness_is_the_mean_diameter_of_discs_of_the_same_areas():
    """Of granules of several sizes, the mean of diameters and not that of areas."""
    assert dem.Scene(dem.Disc([0.5e-3, 1.5e-3])).thickness == pytest.approx(2e-3)
    ellipses = dem.Ellipse([2e-3, 4.5e-3], [0.5e-3, 2e-3])  # of areas pi mm2 and 9 pi mm2
    assert dem.Scene(ellipses).thickness == pytest.approx(4e-3)
    assert dem.Scene(ellipses, thickness=1e-3).thickness == 1e-3


def test_mass_and_inertia_are_those_of_each_size_and_material():
    """Of ellipses of half-axes a and b: pi a b and (a^2 + b^2) / 4."""
    shape = dem.Ellipse([2e-3, 4e-3, 2e-3], [1e-3, 2e-3, 1e-3])
    scene = dem.Scene(shape, [GLASS, STEEL], species=[0, 0, 1], thickness=3e-3)
    mass = math.pi * 3e-3 * np.array([2500.0 * 2e-6, 2500.0 * 8e-6, 7800.0 * 2e-6])
    assert_allclose(scene.mass, mass)
    assert_allclose(scene.inertia, mass * np.array([5e-6, 20e-6, 5e-6]) / 4.0, rtol=1e-6)


@pytest.mark.parametrize("given", ["own", "boundary", "both", "neither"])
@pytest.mark.parametrize("partner", ["wall", "solid"])
def test_a_wall_or_solid_has_its_own_material_or_that_of_all_or_is_rigid(partner, given):
    """Of the force of Hertz, and of the rebound: its restitution is the geometric mean of both."""
    own = {"material": RUBBER} if given in ("own", "both") else {}
    all_of_them = {"boundary": STEEL} if given in ("boundary", "both") else {}
    second = RUBBER if own else STEEL if all_of_them else None
    overlap = 1e-8
    scene, state = near(partner, -overlap, [0.0, -1.0], body=own, **all_of_them)
    run = dem.Simulation(scene, state, step_fraction=0.05)
    (force,) = run.contacts().force
    radius = R if partner == "wall" else 0.5 * R
    materials = [GLASS, second] if second else [GLASS]
    assert force == pytest.approx(4 / 3 * star(*materials) * math.sqrt(radius) * overlap**1.5)
    while run.contacts().granule.size:
        run.advance(1e-5)
    mean = math.sqrt(0.9 * second.restitution) if second else 0.9
    assert run.state.velocity[0, 1] == pytest.approx(mean, rel=5e-3)


def test_granules_of_two_materials_have_the_modulus_and_restitution_of_both():
    """In their centre of mass, where glass is faster."""
    overlap = 1e-8
    scene, state = near("granule", -overlap, [0.0, -1.0])
    run = dem.Simulation(scene, state, step_fraction=0.05)
    (force,) = run.contacts().force
    assert force == pytest.approx(4 / 3 * star(GLASS, STEEL) * math.sqrt(0.5 * R) * overlap**1.5)
    run.advance(1e-4)
    velocity = run.state.velocity[:, 1]
    assert velocity[0] - velocity[1] == pytest.approx(0.6, rel=5e-3)  # sqrt(0.9 * 0.4)
    assert 2500.0 * velocity[0] + 7800.0 * velocity[1] == pytest.approx(-2500.0)


@pytest.mark.parametrize(
    ("partner", "species", "own", "mu"),
    [("granule", pair, None, mu) for pair, mu in (((0, 0), 0.1), ((0, 1), 0.3), ((1, 1), 0.5))]
    + [(partner, (0, 1), own, own or mu) for (partner, mu), own in product((("wall", 0.2), ("solid", 0.4)), (None, 0.15, 0.6))],
)  # fmt: skip
def test_what_slides_is_caught_by_the_coefficient_of_its_contact(partner, species, own, mu):
    """The change of its tangential velocity is mu times that of its normal velocity, while it slides."""
    table = dem.Friction([[0.1, 0.3], [0.3, 0.5]], wall=0.2, solid=0.4)
    body = {} if own is None else {"friction": own}
    scene, state = near(
        partner, 1e-7, [2.0, -0.2], body=body, species=species, friction=table,
        material=[dem.Material(restitution=0.99)] * 2,
    )  # fmt: skip
    velocity = dem.simulate(scene, state, 6e-5, step_fraction=0.05).velocity
    change = velocity[-1, 0] - velocity[0, 0]
    assert change[1] > 0.1
    # the normal of round bodies turns while they touch
    assert -change[0] / change[1] == pytest.approx(mu, rel=0.1 if partner != "wall" else 1e-6)


@pytest.mark.parametrize(
    ("sides", "periods", "walls"),
    [("none", None, [0, 1, 2, 3]), ("x", (3.0, None), [2, 3]),
     ("y", (None, 5.0), [0, 1]), ("xy", (3.0, 5.0), [])],
)  # fmt: skip
def test_a_box_has_walls_where_it_does_not_repeat_itself(sides, periods, walls):
    """And places in it, and ways to images, are less whole periods there."""
    assert periods_of(3.0, 5.0, sides) == periods
    assert np.flatnonzero(walled(periods)).tolist() == walls
    rows = np.array([[-1, 0, 0], [1, 0, 3.0], [0, -1, 0], [0, 1, 5.0]])[walls]
    standing = walls_of(3.0, 5.0, periods)
    assert_array_equal(np.zeros((0, 3)) if standing is None else standing, rows)
    far, repeats = np.array([[7.0, -1.0], [-1e-30, 12.4]]), np.array([c in sides for c in "xy"])
    assert_allclose(wrapped(far, periods), np.where(repeats, [[1.0, 4.0], [0.0, 2.4]], far))
    assert_allclose(
        nearest_image(far, periods), np.where(repeats, [[1, -1], [0, 2.4]], far), atol=1e-20
    )
    period = np.where(repeats, [3.0, 5.0], np.inf)
    assert (wrapped(far, periods) < period).all()
