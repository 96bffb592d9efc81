"""Sinks and sources of a scene: granules and their mass are counted, and all come as they were asked to."""

import numpy as np
import pytest
from project import CONFIG

from dem.analysis.one_run import read_snapshots
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene
from dem.figures.frames import of_motion
from dem.sweep.batch_job import write_one
from dem.sweep.config import load

pytestmark = pytest.mark.quick
PEG = {"outline": "circle", "diameter": 1e-3, "x": 4e-3, "y": 2e-3}
BOX = {"shapes.disc.granules": 12, "box_width": 8e-3, "packing.height": 12e-3, "packing.region": [0, 4e-3, 8e-3, 8e-3],
       "record.bins": 12, "record.snapshots": 7, "record.region": [0, 0, 8e-3, 12e-3], "solids": {"peg": PEG}}  # fmt: skip
BELOW, ABOVE = [None, None, None, 2e-3], [1e-3, 9e-3, 7e-3, 11.5e-3]


def run_of(source, sink=None, **changes):
    """The run of a dozen discs that fall, and what it records."""
    given = {"sources": {"above": {"region": ABOVE} | source}, "phases": {"on": {"time": 6e-2}}}
    if sink is not None:
        given["sinks"] = {"below": {"region": BELOW} | sink}
    c = load(CONFIG / "scenes/column.yaml").changed(BOX | given | changes, "disc")
    run = c.replicate("disc", 2500.0, 1)
    return run, c.module.run(run)


def test_granules_and_mass_are_those_of_the_start_and_what_came_less_what_went():
    """To the last granule and its mass; new ones have sizes of the same distribution, and none comes into another."""
    run, values = run_of({"count": 9}, {})
    mass = make_scene(run, make_bed(run.bed_description)).mass
    present = np.isfinite(values["granule_x"])
    assert (
        present.shape == (7, 21)
        and 0.8e-3 <= run.diameters[12:].min() < run.diameters[12:].max() <= 1.2e-3
    )
    for name, counted in (("granules", present.sum(axis=1)), ("mass", present @ mass)):
        (come,), (gone,) = values[f"source_{name}"], values[f"sink_{name}"]
        change = np.cumsum((come - gone).reshape(6, 2).sum(axis=1))
        np.testing.assert_allclose(np.diff(counted).cumsum(), change, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(values[f"region_{name}"], counted, rtol=1e-12)
    assert come.sum() == pytest.approx(mass[12:].sum()) and values["sink_granules"].sum() > 9
    assert values["max_overlap"].max() < 0.05


@pytest.mark.parametrize("periodic", ["none", "x"])
def test_a_hopper_that_is_fed_again_keeps_its_granules(periodic):
    """Those that are not there wait."""
    _, values = run_of({"velocity_y": -0.5}, {"to": "above"}, periodic=periodic)
    present = np.isfinite(values["granule_x"]).sum(axis=1)
    (come,), (gone,) = values["source_granules"], values["sink_granules"]
    assert values["granule_x"].shape == (7, 12) and gone.sum() > 12
    waiting = np.cumsum((gone - come).reshape(6, 2).sum(axis=1))
    np.testing.assert_array_equal(present[1:] + waiting, 12)
    assert (waiting < 4).all()  # there is room above


def test_a_picture_shows_no_granule_fast_that_came_again(tmp_path):
    """From the floor to the top at once: all that move fall, by no more than gravity gives them."""
    run, values = run_of({}, {"to": "above"}, **{"record.snapshots": 13})
    write_one(tmp_path / "run.nc", run, values)
    motion = read_snapshots(tmp_path / "run.nc")
    again = np.diff(motion.position[..., 1], axis=0) > 5e-3
    frames = of_motion(motion)
    assert again.any() and (motion.age[1:][again] <= 5e-3).all()
    assert frames.fastest < 9.81 * 6e-2 and not (frames.velocity[..., 1] > 0.2).any()


def test_granules_come_at_the_rate_and_with_the_velocity_that_are_asked_for():
    """Whole, within the region; without gravity they fly straight."""
    velocity, left, right = [0.02, -0.02], 0.5e-3, 6.5e-3
    source = dict(zip(("velocity_x", "velocity_y"), velocity, strict=True)) | {
        "count": 9,
        "rate": 100.0,
    }
    source["region"] = [left, 9e-3, right, 11.5e-3]
    run, values = run_of(source, gravity=0.0, exchange_interval=1e-3)
    came = np.cumsum(values["source_granules"])
    np.testing.assert_allclose(came, np.floor(100.0 * 5e-3 * np.arange(1, 13) + 1e-6))
    place = np.stack([values["granule_x"], values["granule_y"]], axis=-1)[:, 12:18]
    moved = np.diff(place, axis=0)
    np.testing.assert_allclose(
        moved[np.isfinite(moved)].reshape(-1, 2), np.tile(velocity, (15, 1)) * 1e-2, rtol=1e-6
    )
    first, radius = np.nanmin(place[..., 0], axis=0), 0.5 * run.diameters[12:18]
    assert (first >= left + radius).all() and (first <= right - radius + 0.02 * 1e-2).all()


def test_a_source_that_was_blocked_makes_up_for_it():
    """Granules of the bed fall out of its region first."""
    source = {"region": [1e-3, 4e-3, 7e-3, 6.4e-3], "count": 15, "rate": 200.0}
    _, values = run_of(source, exchange_interval=1e-3)
    owed = np.arange(1, 13) - np.cumsum(values["source_granules"])
    assert owed.min() == 0.0 and owed.max() > 1.0 and owed[-1] == 0.0


def test_the_last_granule_of_a_bed_stays():
    _, values = run_of({"count": 1, "rate": 1e-3}, {"region": [None] * 4})
    assert np.isfinite(values["granule_x"][1:]).sum() == 6


def test_a_phase_until_rest_waits_for_granules_that_still_come():
    """The bed is at rest between two of them."""
    phases = {"fill": {"until": "rest"}, "on": {"time": 6e-3}}
    _, values = run_of({"count": 3, "rate": 4.0}, phases=phases)
    assert (np.isfinite(values["granule_x"]).sum(axis=1) == 15).all()
