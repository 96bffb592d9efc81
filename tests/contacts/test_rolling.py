"""Rolling resistance: what holds a disc, what stops it, what it takes of momentum and energy.

A run of many discs with it is that of the model in plain numpy: test_twin.py.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from project import CONFIG

import dem
from dem.contacts.rolling import rolling_moment
from dem.laws.protocol import force, measure
from dem.sweep.config import load

R, G = 5e-3, 9.81  # m, m/s2
SAND = dem.Material(density=2500.0, young_modulus=1e8, restitution=0.1)
BOX, ROLLING, LINE = dem.box(2.0, 1.0), dem.Rolling(0.3, 0.2, 0.1), dem.Line()


def laid(mu_r, slope=0.0):
    """A disc on the floor of a box that is tilted (rad), at rest under gravity."""
    rolling, friction = dem.Rolling(1.0, mu_r, 1.0), dem.Friction(0.8, 0.8, 0.8)
    pull = G * np.sin(slope), -G * np.cos(slope)
    scene = dem.Scene(dem.Disc([R]), SAND, friction, BOX, gravity=pull, rolling=rolling)
    weight = scene.mass[0] * G * np.cos(slope)
    modulus = SAND.young_modulus / (1.0 - SAND.poisson_ratio**2)
    depth = (0.75 * weight / modulus / np.sqrt(R)) ** (2.0 / 3.0)
    return scene, dem.State([[1.0, R - depth]])


def test_a_rolling_disc_stops_where_its_energy_is_spent():
    """After 3 v^2 / (4 mu_r g), of a moment mu_r R N that brakes a mass of 3/2 m."""
    mu_r, speed = 0.05, 0.2
    scene, state = laid(mu_r)
    state.velocity[0, 0], state.angular_velocity[0] = speed, -speed / R
    expected = 0.75 * speed**2 / (mu_r * G)
    run = dem.simulate(scene, state, 3.0 * expected / speed)
    assert run.position[-1, 0, 0] - 1.0 == pytest.approx(expected, rel=1e-3)
    assert np.abs(run.velocity[-1]).max() < 1e-6 * speed


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_disc_stays_on_a_slope_up_to_the_coefficient(share):
    """Once it has settled; beyond, it rolls with the rest of the pull, at the lever of the contact."""
    mu_r, time = 0.2, 0.2  # s
    slope = np.arctan(share * mu_r)
    scene, state = laid(mu_r, slope)
    run = dem.simulate(scene, state, 2.0 * time, frames=2)
    lever = 0.5 * (R + state.position[0, 1])
    pull = G * (np.sin(slope) - mu_r * R / lever * np.cos(slope)) / (1.0 + 0.5 * (R / lever) ** 2)
    first, last = run.velocity[1:, 0, 0]
    assert last - first == pytest.approx(max(pull, 0.0) * time, rel=1e-3, abs=1e-9)
    assert (last < 1e-9) == (share < 1.0)


@pytest.mark.parametrize("law", [dem.Hertz(), dem.Linear(), dem.Line()])
def test_a_contact_resists_rolling_as_its_normal_spring_and_its_force_do_under_any_law(law):
    """By 3 (mu_r R)^2 dN/d(delta) a rad, and by mu_r R N at most."""
    constant, overlap, arm = 1e6, 3e-5, 2e-4  # in N and m, arm is mu_r R
    measured, second = (measure(law, d, 4.0 * R) for d in (overlap, (1.0 + 1e-6) * overlap))
    normal = force(law, constant, overlap, measured)
    stiffness = (force(law, constant, (1.0 + 1e-6) * overlap, second) - normal) / (1e-6 * overlap)
    springs = constant, measured, measured, None, 0.0
    moments = []
    for angle in (1e-6, -1.0):
        contacts = SimpleNamespace(
            law=law, rolling=np.array([[arm], [0.0]]), rolling_moment=np.zeros(1)
        )
        turned = contacts.rolling, contacts, 0, normal, springs, (angle, 0.0), None
        moments.append(rolling_moment(*turned)[0])
    assert moments[0] == pytest.approx(-3e-6 * arm**2 * stiffness, rel=1e-5)
    assert moments[1] == arm * normal


def test_rolling_resistance_keeps_angular_momentum():
    """Both bodies feel opposite moments: two discs of unequal size that meet spinning."""
    radius = np.array([R, 0.4 * R])
    scene = dem.Scene(dem.Disc(radius), SAND, dem.Friction(), BOX, rolling=dem.Rolling(granule=0.5))
    position = [[1.0, 0.5], [1.0 + 1.42 * R, 0.5 + 0.1 * R]]
    state = dem.State(position, [[0.1, 0.0], [-0.3, 0.2]], angular_velocity=[200.0, 50.0])
    result = dem.simulate(scene, state, 5e-3).state

    def angular(state):
        (x, y), (vx, vy) = (state.position - position[0]).T, state.velocity.T
        return scene.mass * (x * vy - y * vx), scene.inertia * state.angular_velocity

    scale, spun = np.abs(angular(state)).sum(), np.subtract(angular(result), angular(state))[1]
    assert np.abs(spun).max() > 0.01 * scale
    assert np.sum(angular(result)) == pytest.approx(np.sum(angular(state)), abs=1e-10 * scale)


def test_the_critical_step_counts_rolling_springs():
    """A disc that rocks on a stiff rolling spring comes to rest just below it."""
    scene, state = laid(1.0, slope=0.5)
    critical = dem.Simulation(scene, state).diagnose().critical_time_step
    run = dem.simulate(scene, state, 5e3 * critical, 0.99 * critical)
    assert np.abs(run.velocity[-1]).max() < 1e-9 and abs(run.angular_velocity[-1, 0]) < 1e-6


def swarm(rolling=ROLLING, law=LINE, ledger=True):
    """Twenty discs that fly together within a box."""
    rng = np.random.default_rng(5)
    radius = R * rng.uniform(0.8, 1.2, 20)
    position = (
        2.5 * R * (np.stack(np.meshgrid(np.arange(5.0), np.arange(4.0)), -1).reshape(-1, 2) + 0.6)
    )
    state = dem.State(
        position, rng.normal(size=(20, 2)), angular_velocity=rng.normal(scale=300.0, size=20)
    )
    scene = dem.Scene(
        dem.Disc(radius), SAND, dem.Friction(), dem.box(15 * R, 12 * R), gravity=(0.0, -G),
        rolling=rolling, law=law,
    )  # fmt: skip
    return dem.Simulation(scene, state, step_fraction=0.1, ledger=ledger)


def test_the_energy_of_a_bed_that_resists_rolling_adds_up():
    """While it falls together and comes to rest, with what the rolling springs hold and lose."""
    run = swarm()
    for _ in range(10):
        run.advance(5e-3)
        ledger = run.ledger()
        assert ledger.residual < 1e-3
        assert ledger.elastic_rolling >= 0.0
    assert ledger.rolled > 0.01 * ledger.before
    assert run.contacts().rolling_moment.any()


def test_coefficients_of_zero_leave_the_motion_as_it_is():
    """So that a sweep may begin with zero."""
    one, other = (swarm(rolling, dem.Hertz(), False) for rolling in (dem.Rolling(0, 0, 0), None))
    for run in (one, other):
        run.advance(0.02)
    assert np.array_equal(one.state.position, other.state.position)


def test_a_simulation_goes_on_with_its_rolling_springs():
    """From a checkpoint with the same bits; a result does not know them."""
    run = swarm()
    run.advance(0.03)
    saved = run.checkpoint()
    run.advance(0.01)
    other = swarm()
    other.restore(saved)
    other.advance(0.01)
    assert np.array_equal(run.contacts().rolling_moment, other.contacts().rolling_moment)
    assert run.contacts().rolling_moment.any()


def test_rolling_resistance_varies_as_others_do_and_leaves_the_bed(tmp_path):
    """A dimension of a sweep from zero on, whose runs share their beds, and all roll."""
    file = tmp_path / "roll.yaml"
    file.write_text(
        f"extends: {CONFIG / 'smoke.yaml'}\nresults: results/roll\n"
        "rolling: {granule: 0.1, wall: 0.1, cylinder: 0.1}\n"
        "sweep: {shape: c1, density: 3900.0, seed: [1], rolling.granule: [0.0, 0.3]}"
    )
    block = load(file).block("drag")
    runs, plain = list(block.runs.values()), load(CONFIG / "smoke.yaml").block("drag").first
    assert "rolling_granule" in block.dims and runs[0].id != runs[1].id
    assert runs[0].bed_id == runs[1].bed_id == plain.bed_id
    assert all(run.rolling for run in runs) and not plain.rolling
    assert "rolling" not in plain.run_key()


def test_other_shapes_are_beside_discs_where_their_coefficients_are_zero(tmp_path):
    file = tmp_path / "roll.yaml"
    file.write_text(
        f"extends: {CONFIG / 'smoke.yaml'}\nresults: results/roll\n"
        "rolling: {granule: 0.0, wall: 0.0, cylinder: 0.0}\n"
        "sweep:\n"
        "  density: 3900.0\n"
        "  seed: [1]\n"
        "  granules: {rough: {shape: c1, rolling.granule: 0.2}, d1: {shape: d1}}\n"
    )
    discs, dumbbells = load(file).block("drag").runs.values()
    assert discs.rolling.granule == 0.2 and dumbbells.rolling is None


REFUSED = {
    "Rolling.granule is -0.1; it must be at least 0.": lambda: dem.Rolling(-0.1),
    "rolling is for discs, and shape is Ellipse; rolling must be None, because granules that are "
    "not round resist rolling by their shape.": lambda: dem.Scene(
        dem.Ellipse([R], [0.5 * R]), rolling=dem.Rolling()
    ),
}


@pytest.mark.parametrize("words", REFUSED)
def test_rolling_that_cannot_be_is_refused(words):
    with pytest.raises(dem.InputError) as error:
        REFUSED[words]()
    assert str(error.value) == words
