"""Simple shear: the lid keeps its pressure, both stresses are the same at all heights, and what is recorded comes
after the bed has settled."""

from functools import cache

import numpy as np
import pytest
from sweeps import sheared_values

import dem
from dem.experiment.bed import make_bed
from dem.experiment.config import of_values
from dem.experiment.kinds import shear

pytestmark = pytest.mark.quick
PRESSURE, NOMINAL = 1e5, 713.65  # Pa; 1/s: 0.1 over sqrt(m / (P thickness)), 0.140 ms


def run_of(fraction=0.83, young_modulus=5e9, **cell):
    """A run of the small bed."""
    values = sheared_values()
    values["material"]["young_modulus"] = young_modulus
    values["packing"]["fraction"] = fraction
    values["shear"] |= cell
    return of_values(values)


@cache
def measured():
    return shear.run(run_of(young_modulus=5e8))


def test_momentum_that_goes_in_at_the_lid_goes_through_every_height():
    """The lid bears the pressure that is asked for: in steady flow it does not rise, so the forces on it
    balance, but for half a per cent by which runs scatter."""
    result = measured()
    assert np.mean(result["lid_normal_stress"]) == pytest.approx(PRESSURE, rel=0.02)
    for stress in ("shear_stress", "normal_stress"):
        assert result[stress].mean() == pytest.approx(result[f"lid_{stress}"].mean(), rel=0.1)


def test_rough_walls_drag_the_bed_with_them():
    """The rate of shear in the middle is that of the walls, but for what slips next to them."""
    assert 0.6 < measured()["shear_rate"].mean() / NOMINAL < 1.2
    assert 0.2 < measured()["lid_shear_stress"].mean() / PRESSURE < 0.6


def test_the_packing_fraction_is_that_between_the_walls():
    """Discs of the walls, whose mean heights bound the bed, are half in it. A disc that is partly in the middle
    counts with that part, so that the fraction hardly jumps."""
    result, run = measured(), run_of(young_modulus=5e8)
    scene, _ = shear.make_cell(run, make_bed(run.bed_description))
    area = (scene.shape.area * np.where(scene.is_held, 0.5, 1.0)).sum()
    between = area / (scene.periodic[0] * result["shear_height"])
    assert result["shear_fraction"].mean() == pytest.approx(between.mean(), rel=0.03)
    assert np.abs(np.diff(result["shear_fraction"])).max() < 0.02


@pytest.mark.parametrize(
    ("pressure", "number", "rate"), [(1e5, 0.1, NOMINAL), (16e5, 0.05, 2.0 * NOMINAL)]
)
def test_the_inertial_number_is_a_ratio_of_two_times(pressure, number, rate):
    """Sixteen times the pressure brings granules back four times as fast, at the same number. The lid moves at
    that rate times the height of the free bed, and is pressed down by the pressure."""
    run = run_of(pressure=pressure, inertial_number=number)
    assert shear.rate_of(run) == pytest.approx(rate, rel=1e-4)
    assert shear.duration(run) == pytest.approx(4.0 / rate, rel=1e-4)
    bed = make_bed(run.bed_description)
    scene, state = shear.make_cell(run, bed)
    floor, lid = (state.position[group.granules, 1] for group in scene.held)
    speed, force = (rate * (lid.min() - floor.max()), 0.0), -pressure * bed.width * scene.thickness
    assert scene.held[1].motion.velocity == pytest.approx(speed, rel=1e-4)
    assert scene.held[1].motion.force == (None, pytest.approx(force))


@cache
def time_of(number, settle):
    """Time (s) of a run of soft granules over a strain of 0.1, by its first step."""
    more = {"inertial_number": number, "settle": settle, "strain": 0.1, "samples": 2}
    run = run_of(young_modulus=5e7, **more)
    step = (
        dem.Simulation(*shear.make_cell(run, make_bed(run.bed_description)))
        .diagnose()
        .longest_time_step
    )
    return shear.run(run)["steps"] * step


def test_a_slow_flow_settles_over_the_strain_that_is_asked_for():
    assert time_of(0.01, 1.0) / time_of(0.01, 0.5) == pytest.approx(1.1 / 0.6, rel=0.05)
    assert time_of(0.01, 1.0) == pytest.approx(1.1 / 71.365, rel=0.3)


def test_a_fast_flow_settles_until_its_bed_has_fallen_three_times():
    """Which takes 1.64 ms through 7.8 mm, more than the strain that is asked for."""
    assert time_of(0.3, 1.0) == time_of(0.3, 2.0)
    assert time_of(0.3, 1.0) == pytest.approx(3 * 1.64e-3, rel=0.25)


def test_both_walls_go_all_the_way_along_the_bed():
    """No gap between held discs is wide enough for another disc."""
    run = run_of()
    scene, state = shear.make_cell(run, make_bed(run.bed_description))
    for group in scene.held:
        x = np.sort(state.position[group.granules, 0] % 9e-3)
        assert np.diff(x, append=x[0] + 9e-3).max() < 2.0e-3


def test_a_granule_that_gets_out_is_told():
    """In a loose bed there are gaps in the walls."""
    loose = run_of(0.6, 5e7, inertial_number=0.3, samples=20)
    with pytest.raises(dem.RunError, match=r"granule \d+ got out through a gap in the rough walls"):
        shear.run(loose)
