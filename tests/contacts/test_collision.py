"""Collisions of pairs, and with walls and solids, against closed forms and conservation laws."""

import numpy as np
import pytest
from collisions import APART, ELASTIC, HEAVY, LEAST, ROUGH, energy, gains, volley
from forms import FORMS
from numpy.testing import assert_allclose
from project import quick
from twin import damping_ratio

import dem

KINDS = "disc", "dumbbell", "clump", "ellipse", "superellipse of 4", "egg"


def sizes(n, seed=0):
    return 1e-3 * np.random.default_rng(seed).uniform(0.5, 1.0, n)


# Along the line of centres


def head_on(radius, speed, depth, duration, steps, **properties):
    """Scene of two equal discs that meet; time (s), overlap (m) and speed of approach (m/s) at every step."""
    scene = dem.Scene(dem.Disc([radius, radius]), **HEAVY | properties)
    x = np.array([0.5 * depth - radius, radius - 0.5 * depth])
    state = dem.State(np.column_stack([x, 0.0 * x]), [[0.5 * speed, 0.0], [-0.5 * speed, 0.0]])
    run = dem.simulate(scene, state, duration, time_step=duration / steps, frames=steps)
    overlap = 2.0 * radius - np.diff(run.position[..., 0])[:, 0]
    return scene, run.time, overlap, -np.diff(run.velocity[..., 0])[:, 0]


def test_published_benchmark_of_two_spheres():
    """Two spheres of 10 mm at +-10 m/s reach the published overlap, force and contact time."""
    radius = 10e-3
    material = dem.Material(2800.0, 48e9, 0.2, ELASTIC.restitution)
    sphere = LEAST | {"material": material, "thickness": 4.0 * radius / 3.0}
    scene, time, overlap, speed = head_on(radius, 20.0, 0.0, 5e-5, 2000, **sphere)
    assert_allclose(scene.mass[0], 2800.0 * 4.0 / 3.0 * np.pi * radius**3)
    force = -0.5 * scene.mass[0] * np.gradient(speed, time)
    assert_allclose(overlap.max(), 2.7411e-4, rtol=1e-4)
    assert_allclose(force.max(), 10696.9, rtol=1e-4)
    last = np.flatnonzero(overlap > 0.0)[-1] + np.array([1, 0])
    assert_allclose(np.interp(0.0, overlap[last], time[last]), 4.0339e-5, rtol=1e-4)


@pytest.mark.parametrize(
    ("restitution", "depth", "order"),
    [(ELASTIC.restitution, 0.0, 2.0), (0.5, 3e-6, 2.0), (0.5, 0.0, 1.25)],
)
def test_order_of_convergence(restitution, depth, order):
    """Second order in the time step, elastic and damped; an impact with a dashpot is of order 5/4, because its force
    begins like the fourth root of time. The limit is that of the model: tests/dynamics."""
    material = dem.Material(restitution=restitution)
    steps = 2 ** np.arange(6, 12)
    runs = [head_on(1e-3, 1.0, depth, 6e-5, n, material=material, **ROUGH) for n in steps]
    for k in (2, 3):
        error = np.abs(np.diff([run[k][-1] for run in runs]))
        assert_allclose(-np.polyfit(np.log(steps[1:]), np.log(error), 1)[0], order, atol=0.12)


@quick
@pytest.mark.parametrize("restitution", [0.9, 0.5, 0.1])
def test_a_collision_off_the_centre_returns_less_than_restitution(restitution):
    """Its damping ratio is sqrt(m*/m_c) times that of a central one; m_c is the mass at the contact.

    Two dumbbells side by side, the upper disc of one against the lower disc of the other: m*/m_c = 5/3.
    """
    a = 0.5e-3
    state = dem.State(
        [[0.0, 0.0], [2.0 * a, 2.0 * a]], [[0.5, 0.0], [-0.5, 0.0]], [0.5 * np.pi] * 2
    )
    scene = dem.Scene(dem.Dumbbell([a, a]), dem.Material(restitution=restitution), **HEAVY, **LEAST)
    result = dem.simulate(scene, state, 1e-4, step_fraction=0.01).state
    speed = result.velocity[:, 0] - a * result.angular_velocity * [1.0, -1.0]
    ratio = damping_ratio(speed[1] - speed[0]) / damping_ratio(restitution)
    assert_allclose(ratio, np.sqrt(5.0 / 3.0), rtol=1e-2)


# Along the tangent


@quick
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.3, 2.0, 4.4])
def test_oblique_impact_in_gross_sliding(angle, sign):
    """The impulse (1 + e) m* v_n along the normal, and mu times that against the slip, from every side: velocities and
    spins of discs of unequal size that both spin. What slides loses mu times the impulse times the mean slip."""
    restitution, mu, speed = 0.5, 0.1, 0.1
    radius, spin = np.array([1e-3, 2.5e-3]), sign * np.array([100.0, 40.0])
    material, friction = dem.Material(restitution=restitution), dem.Friction(mu)
    n = np.array([np.cos(angle), np.sin(angle)])
    t = np.array([-n[1], n[0]])
    velocity = np.array([speed * n + 0.3 * sign * t, [0.0, 0.0]])
    kind = {"law": dem.Line(), "rolling": dem.Rolling(0.0, 0.0, 0.0)}  # that has a ledger elsewhere
    scene = dem.Scene(dem.Disc(radius), material, friction, **APART, **kind)
    start = dem.State([-(radius[0] + 1e-7) * n, radius[1] * n], velocity, None, spin)
    run = dem.Simulation(scene, start, step_fraction=0.02, ledger=True)
    run.advance(4e-5)
    state = run.state
    pull = (1.0 + restitution) * speed / np.sum(1.0 / scene.mass)  # N s
    push = np.outer([-1.0, 1.0] / scene.mass, pull * (n + sign * mu * t))
    assert_allclose(state.velocity, velocity + push, atol=4e-3 * speed)
    lost = sign * mu * pull * radius / scene.inertia
    assert_allclose(state.angular_velocity, spin - lost, atol=5e-3 * abs(lost[0]))
    moves = (velocity, spin), (state.velocity, state.angular_velocity)
    slip = [abs((v[0] - v[1]) @ t + radius @ spins) for v, spins in moves]
    assert run.ledger().slid == pytest.approx(mu * pull * np.mean(slip), rel=0.02)


# Angular momentum and energy


@quick
@pytest.mark.parametrize("kind", [*KINDS, "disc that resists rolling"])
def test_angular_momentum_is_conserved(kind):
    """A swarm that collides with friction and damping keeps it to rounding, after whole steps. That boundaries take
    what a bed loses in momentum is asked in tests/dynamics."""
    rng, n = np.random.default_rng(3), 36
    grid = 3.1e-3 * np.stack(np.divmod(np.arange(n), 6), 1)
    velocity = rng.normal(size=(n, 2)) - 200.0 * (grid - grid.mean())
    state = dem.State(grid, velocity, rng.uniform(0.0, 7.0, n), rng.normal(scale=500.0, size=n))
    rolling = dem.Rolling(granule=0.5) if "rolling" in kind else None
    shape = FORMS[kind.partition(" that")[0]](sizes(n))
    shape = shape.scaled(1.5e-3 / shape.bounding_radius.max())
    scene = dem.Scene(shape, rolling=rolling, **HEAVY, **ROUGH)
    result = dem.simulate(scene, state, 8e-3, time_step=8e-3 / 2**14).state
    assert energy(scene, result).sum() < 0.6 * energy(scene, state).sum()
    before, after = (
        scene.mass * np.linalg.det(np.stack([s.position, s.velocity], 1))
        + scene.inertia * s.angular_velocity
        for s in (state, result)
    )
    assert abs((after - before).sum()) < 3e-11 * np.abs(before).sum()


@quick
@pytest.mark.parametrize(
    ("kind", "restitution"), [("disc", ELASTIC.restitution), *((k, 0.9) for k in KINDS)]
)
def test_oblique_impact_makes_no_energy(kind, restitution):
    """Random frictional impacts, most of them grazing, never gain kinetic energy."""
    material = dem.Material(restitution=restitution)
    gain = gains(*volley(FORMS[kind](sizes(120)), 1, 1000.0, material=material, **ROUGH), 0.05)
    assert gain.max() < 1e-5
    assert gain.min() < -0.3  # some do lose much


def test_the_contact_normal_of_the_paper_does_not_conserve_energy():
    """The paper's contact normal, the chord of the two deepest points, does not conserve energy."""
    shape = FORMS["ellipse"](sizes(400))._replace(contact=dem.GeometricPotential())
    gain = gains(*volley(shape, 2, 300.0, material=ELASTIC, **APART), 0.0125)
    assert gain.max() > 0.1 and np.sqrt(np.mean(gain**2)) > 0.01


@pytest.mark.parametrize("ratio", [1.0, 3.0, 50.0])
def test_a_disc_that_rolls_off_a_held_one_leaves_where_its_energy_says(ratio):
    """From rest at an angle a beside the top, without slip, it leaves at 4/7 cos a (energy, m v^2 / (R + r) = m g cos).
    Springs whose slip is that of another direction than their force would hold a small disc fast on a large one (Vyas
    and others 2025, Comput. Phys. Commun. 310, 109524)."""
    small, begin = 1e-3, 0.2
    reach = (1.0 + ratio) * small
    scene = dem.Scene(
        dem.Disc([ratio * small, small]),
        dem.Material(young_modulus=1e8, restitution=0.5),
        dem.Friction(20.0),
        gravity=(0.0, -9.81),
        held=[dem.Held([0])],
    )
    place = (1.0 - 1e-5) * reach * np.array([np.sin(begin), np.cos(begin)])
    run, piece = dem.Simulation(scene, dem.State([[0.0, 0.0], place])), 0.01 * np.sqrt(reach / 9.81)
    while len(run.contacts().granule) and run.time < 1e3 * piece:
        run.advance(piece)
        x, y = run.state.position[1]
    assert run.contacts().granule.size == 0
    assert_allclose(y / np.hypot(x, y), 4.0 / 7.0 * np.cos(begin), atol=0.02)
