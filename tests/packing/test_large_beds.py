"""Beds of more than a patch: at rest, of any number of threads, kept while they are packed."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_array_equal
from sweeps import SMOKE
from twin import Twin

import dem
from dem.dynamics.contact_output import list_contacts
from dem.dynamics.world import PATCH
from dem.experiment.bed import make_bed
from dem.packing.constant_pressure import pack_under
from dem.packing.cost import LARGE, expected_iterations, near_jamming
from dem.packing.job import Job
from dem.packing.minimise import minimise
from dem.packing.random import Room, relaxed
from dem.sweep.config import load, parse
from dem.sweep.estimate import summary, time_of
from dem.sweep.state import SweepState

GRANULES = 1100
assert GRANULES > PATCH


@cache
def granules():
    """Discs of a large bed."""
    return dem.Disc.of_size(1e-3 * np.random.default_rng(1).uniform(0.8, 1.2, GRANULES))


def room(fraction, **more):
    """What `dem.pack` takes beside them."""
    side = float(np.sqrt(granules().area.sum() / fraction))
    return {"width": side, "height": side, "solids": (), "seed": 1} | more


@cache
def bed():
    return dem.pack(granules(), **room(0.86))


def test_a_large_bed_at_rest_bears_a_two_hundredth_of_its_contact_forces():
    """By the forces of the model in plain numpy: the greatest net force is below 0.5 % of the mean
    contact force, and below 1e-6 E* R^2."""
    shape, packing = granules(), bed()
    scene = replace(Room(**room(0.86)).scene(shape), friction=dem.Friction(0.0, 0.0, 0.0))
    net_force = np.hypot(*Twin(scene, packing.state).force.T).max()
    same = minimise(Room(**room(0.86)).scene(shape), packing.state, 0)
    unit = Room(**room(0.86)).unit(shape)
    contact_force = list_contacts(same.world, same.order).force.mean()
    assert net_force < min(5.5e-3 * contact_force, 1.1e-6 * unit)
    assert net_force == pytest.approx(packing.net_force * unit, rel=1e-6)


def test_a_large_bed_is_the_same_of_any_number_of_threads():
    """Pressed by granules that grow: forces, kicks that are taken back, and sums over all patches."""
    scene, start = Room(**room(0.86)).scene(granules().scaled(1.01)), bed().state
    one, two = (minimise(scene, start, 60, 0.0, Job(threads)) for threads in (1, 2))
    assert one.net_force == two.net_force > 0.0
    assert np.abs(one.state.position - start.position).max() > 1e-6
    for name in ("bodies", "angle", "force"):
        assert_array_equal(getattr(one.world, name), getattr(two.world, name))


class Stopped(KeyboardInterrupt):
    """Ctrl-C after some pieces."""


def stop_after(pieces):
    """A report that stops a bed."""
    left = iter(range(pieces))

    def report(iterations, net_force):
        if next(left, None) is None:
            raise Stopped

    return report


def under_pressure(job):
    """A bed whose top wall comes down, of fewer granules."""
    shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 60))
    return pack_under(shape, Room(8e-3, 9e-3, (), 1), 1e-6, job)


def at_a_fraction(job):
    """A large bed."""
    return relaxed(granules(), Room(**room(0.86)), job)


WAYS = {"fraction": at_a_fraction, "pressure": under_pressure}


@pytest.mark.parametrize("pieces", [3, 14])
@pytest.mark.parametrize("way", WAYS)
def test_a_bed_that_is_stopped_goes_on_to_the_same_bits(tmp_path, way, pieces):
    """While granules grow, while the top wall comes down, and at full size."""
    whole, path, stops = WAYS[way](Job()), tmp_path / "bed.npz", 0
    while True:
        job = Job(1, path, stop_after(pieces))
        job.begin("bed")
        try:
            resumed = WAYS[way](job)
            break
        except Stopped:
            stops += 1
            assert path.is_file()
    assert stops > 0
    for first, second in zip(whole[:-1], resumed[:-1], strict=True):
        assert_array_equal(first, second)
    other = Job(1, path)
    with pytest.raises(dem.InputError, match=r"bed\.npz: it is damaged or of another bed"):
        other.begin("another bed")


def test_what_was_reached_is_kept_of_a_bed_that_does_not_come_to_rest(tmp_path, monkeypatch):
    """The same call goes on from there, with as many iterations again."""
    monkeypatch.setattr("dem.packing.random.most_iterations", lambda *bed: 2000)
    for _ in range(3):
        with pytest.raises(dem.PackingError, match="not at rest after 2000 iterations: net force"):
            dem.pack(granules(), **room(0.86), checkpoint=tmp_path / "bed.npz")
    assert dem.pack(granules(), **room(0.86), checkpoint=tmp_path / "bed.npz").net_force < 1e-6


@pytest.mark.parametrize(
    ("count", "fraction", "slow"),
    [(100_000, 0.84, True), (100_000, 0.86, False), (100_000, 0.82, False), (400, 0.84, False)],
)
def test_a_sentence_comes_before_a_large_bed_near_random_close_packing(count, fraction, slow):
    """It says what to ask for instead; small beds, which walls make denser, and others need none."""
    changes = {"packing": {"fraction": fraction}, "shapes": {"c1": {"granules": count}}}
    values = {
        "extends": str(SMOKE),
        "results": "results/large",
        "box_width": 0.3 if count > 400 else 0.03,
    }
    values |= changes | {"sweep": {"shape": "c1", "seed": "1 to 2"}}
    warnings = [w for w in SweepState(parse(values)).check() if "random close packing" in w]
    assert len(warnings) == slow
    if slow:
        assert "0.842" in warnings[0] and "ask for 0.86, or for packing.pressure" in warnings[0]
    assert (near_jamming(count, fraction) is not None) == slow
    assert near_jamming(LARGE, 0.84)


def test_beds_are_as_slow_as_they_are_near_random_close_packing():
    """The expected iterations are those of beds that were measured, within a factor of three."""
    assert expected_iterations(100_000, 0.84) > 10 * expected_iterations(100_000, 0.82)
    job = Job()
    at_a_fraction(job)
    assert 1 / 3 < job.stage["iterations"] / expected_iterations(GRANULES, 0.86) < 3


def test_a_dry_run_counts_beds_and_no_more_processes_than_runs(tmp_path, monkeypatch):
    """A large bed takes its time, once for all runs that share it; a second process has no run."""
    monkeypatch.chdir(tmp_path)

    def seconds(jobs, **changes):
        values = {"extends": str(SMOKE), "results": "results/large", "sweep": {"shape": "c1"}}
        state = SweepState(parse(values | changes))
        runs = list(state.block("drag").unique())
        assert re.search(r"About .* with 1 process \(", summary(state, jobs))
        return time_of(state.store, runs, min(jobs, len(runs)))[0]

    large = {"shapes": {"c1": {"granules": 100_000}}, "box_width": 0.3}
    one = seconds(1, **large)
    assert seconds(8, **large) == one
    assert one > seconds(1, **large, packing={"fraction": 0.80}) + 60.0


def test_threads_are_no_part_of_a_run():
    sweep = load(SMOKE)
    one, two = (
        sweep.changed({"threads": threads}, "c1").replicate("c1", 3900.0, 1) for threads in (1, 2)
    )
    assert one.id == two.id and one.bed_id == two.bed_id and two.configuration.threads == 2
    assert make_bed(two).net_force <= 1e-9


def test_a_file_that_is_read_in_pieces_may_hold_texts(tmp_path, monkeypatch):
    """The one run of a large bed is such a file; its identity is a text."""
    monkeypatch.setattr("dem.io.lazily.SMALL", 0)
    path = tmp_path / "run.nc"
    xr.Dataset(
        {
            "run_id": ("run", np.array(["a8424e68"], object)),
            "granule_x": ("granule", np.arange(9.0)),
        }
    ).to_netcdf(path, format="NETCDF4_CLASSIC")
    with dem.open_results(path) as dataset:
        assert dataset["granule_x"].chunks and dataset["granule_x"].values.tolist() == [*range(9)]
        assert dataset["run_id"].values.tolist() == ["a8424e68"]
