"""The benchmark without other codes, and on other processors."""

import numpy as np
import pytest
from beds import small_bed

import dem
from studies.benchmark.results import SMOKE, compare_codes
from studies.benchmark.scenes import make_case
from studies.benchmark.sizes import tiled
from studies.common.peers import lammps


@pytest.mark.parametrize("installed", [True, False])
def test_the_benchmark_times_the_codes_that_are_there(monkeypatch, installed):
    """What is missing is named."""
    wheel = lammps.BUILDS[-1]
    if installed and wheel.available():
        pytest.skip(wheel.available())
    if not installed:
        monkeypatch.setattr(lammps.Build, "available", lambda build: "LAMMPS is not installed.")
    small = small_bed("disc")
    values = compare_codes({"disc": make_case(small.scene(), small.state)}, SMOKE)
    rates = dict(zip(values["code"], values["granule_steps_per_second"][0], strict=True))
    assert (rates["dem"] > 0.0).all() and (rates[wheel.NAME] > 0.0).all() == installed
    assert ("not run: LAMMPS is not installed." in values["code_status"]) != installed


@pytest.mark.parametrize("side", [2, 3])
def test_tiles_of_a_bed_at_rest_are_at_rest(side):
    """Where mirror images meet, a granule feels what it felt from the wall."""
    sizes = np.random.default_rng(5).uniform(0.8e-3, 1.2e-3, 40)
    height = dem.Disc.of_size(sizes).area.sum() / 0.86 / 6e-3
    bed = dem.pack(dem.Disc.of_size(sizes), 6e-3, height, None, 1)
    shape, walls = dem.Disc.of_size(np.tile(sizes, side**2)), dem.box(side * 6e-3, side * height)
    run = dem.Simulation(dem.Scene(shape, friction=dem.Friction(), walls=walls), tiled(bed, side))
    world, contacts = run.world, run.contacts()
    stiffness = (contacts.force / contacts.overlap**1.5).mean()
    typical = stiffness * (bed.max_overlap * 5e-4) ** 1.5
    assert bed.coordination_number > 3.0
    assert np.abs(world.force[:, :2]).max() < 1e-5 * typical
