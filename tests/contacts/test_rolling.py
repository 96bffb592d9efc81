"""Rolling resistance: what holds a disc, what stops it, and which granules have it.

Its springs and limits are in tests/laws, its momenta in test_collision.py; a run of many discs with it is that of
the model in plain numpy: test_twin.py.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from project import CONFIG, quick
from scenes import scene_of

import dem
from dem.sweep.config import load

R, G = 5e-3, 9.81  # m, m/s2
SAND = dem.Material(density=2500.0, young_modulus=1e8, restitution=0.1)


def laid(mu_r, slope=0.0):
    """A disc on the floor of a box that is tilted (rad), at rest under gravity."""
    rolling, friction = dem.Rolling(1.0, mu_r, 1.0), dem.Friction(0.8, 0.8, 0.8)
    pull = G * np.sin(slope), -G * np.cos(slope)
    walls = dem.box(2.0, 1.0)
    scene = dem.Scene(dem.Disc([R]), SAND, friction, walls, gravity=pull, rolling=rolling)
    weight = scene.mass[0] * G * np.cos(slope)
    modulus = SAND.young_modulus / (1.0 - SAND.poisson_ratio**2)
    depth = (0.75 * weight / modulus / np.sqrt(R)) ** (2.0 / 3.0)
    return scene, dem.State([[1.0, R - depth]])


@quick
@pytest.mark.parametrize("mu_r", [0.0, 0.05])
def test_a_sliding_disc_ends_rolling_and_stops_where_its_energy_is_spent(mu_r):
    """It slows down by mu g and spins up by the moment (mu - mu_r) m g R, until it rolls; then by 2/3 of mu_r g."""
    mu, speed = 0.8, 0.2
    scene, state = laid(mu_r)
    state.velocity[0, 0] = speed
    rolls = speed / (G * (3.0 * mu - 2.0 * mu_r))  # s
    left = speed - mu * G * rolls
    stops = rolls + 1.5 * left / (mu_r * G) if mu_r else 0.1
    run = dem.simulate(scene, state, stops, frames=40)
    slowed = np.maximum(speed - mu * G * run.time, left - 2.0 / 3.0 * mu_r * G * (run.time - rolls))
    assert_allclose(run.velocity[:, 0, 0], slowed, atol=2e-3 * speed)
    rolling = run.time > rolls + 1e-3
    spin = run.angular_velocity[rolling, 0]
    assert_allclose(spin * R, -run.velocity[rolling, 0, 0], atol=2e-3 * speed)


@quick
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


def test_the_critical_step_counts_rolling_springs():
    """A disc that rocks on a stiff rolling spring comes to rest just below it."""
    scene, state = laid(1.0, slope=0.5)
    critical = dem.Simulation(scene, state).diagnose().critical_time_step
    run = dem.simulate(scene, state, 5e3 * critical, 0.99 * critical)
    assert np.abs(run.velocity[-1]).max() < 1e-9 and abs(run.angular_velocity[-1, 0]) < 1e-6


@quick
def test_coefficients_of_zero_leave_the_motion_as_it_is():
    """So that a sweep may begin with zero."""
    scene, state = scene_of("box of discs")
    one, other = (
        dem.simulate(replace(scene, solids=None, rolling=rolling), state, 1e-4).position
        for rolling in (dem.Rolling(0, 0, 0), None)
    )
    assert np.array_equal(one, other)


@quick
def test_rolling_resistance_varies_as_others_do_and_leaves_the_bed(tmp_path):
    """From zero on; runs share their beds, and all of discs roll. Other shapes are beside them where their
    coefficients are zero."""
    file = tmp_path / "roll.yaml"
    file.write_text(
        f"extends: {CONFIG / 'smoke.yaml'}\nresults: results/roll\n"
        "rolling: {granule: 0.0, wall: 0.0, cylinder: 0.0}\n"
        "sweep: {density: 3900.0, seed: [1], granules: {smooth: {shape: c1}, "
        "rough: {shape: c1, rolling.granule: 0.2}, d1: {shape: d1}}}"
    )
    smooth, rough, dumbbells = load(file).block("drag").runs.values()
    assert (smooth.rolling.granule, rough.rolling.granule, dumbbells.rolling) == (0.0, 0.2, None)
    plain = load(CONFIG / "smoke.yaml").block("drag").first
    assert smooth.bed_id == rough.bed_id == plain.bed_id and not plain.rolling
