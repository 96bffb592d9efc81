"""What beds cost, as a dry run and a sentence say it before they are packed."""

import numpy as np
import pytest
from sweeps import SMOKE

import dem
from dem.packing.cost import LARGE, expected_iterations, near_jamming
from dem.packing.job import Job
from dem.packing.random import Room, relaxed
from dem.sweep.config import parse
from dem.sweep.estimate import summary, time_of
from dem.sweep.state import SweepState


def sweep_of(granules, **changes):
    """A sweep of two beds of discs in a box in which there is room for them."""
    values = {
        "extends": str(SMOKE),
        "results": "results/large",
        "box_width": 0.3 if granules > 400 else 0.03,
        "shapes": {"c1": {"granules": granules}},
        "sweep": {"shape": "c1", "seed": "1 to 2"},
    }
    return SweepState(parse(values | changes))


@pytest.mark.quick
@pytest.mark.parametrize(
    ("count", "fraction", "slow"),
    [(100_000, 0.84, True), (100_000, 0.86, False), (100_000, 0.82, False), (400, 0.84, False)],
)
def test_a_sentence_comes_before_a_large_bed_near_random_close_packing(count, fraction, slow):
    """It says what to ask for instead; small beds, which walls make denser, and others need none."""
    said = sweep_of(count, packing={"fraction": fraction}).check()
    warnings = [words for words in said if "random close packing" in words]
    assert len(warnings) == slow
    if slow:
        assert f"{count:,} discs at a packing fraction of {fraction}" in warnings[0]
        assert "0.842" in warnings[0] and "ask for 0.86, or for packing.pressure" in warnings[0]
    assert (near_jamming(LARGE - 1, 0.84), near_jamming(LARGE, 0.84) is None) == (None, False)


def test_beds_take_as_many_iterations_as_is_expected():
    """Within a factor of three; ten times as many near random close packing."""
    assert expected_iterations(100_000, 0.84) > 10 * expected_iterations(100_000, 0.82)
    shape, reports = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 1100)), []
    side = float(np.sqrt(shape.area.sum() / 0.86))
    job = Job(report=lambda iterations, net_force: reports.append(iterations))
    relaxed(shape, Room(side, side, (), 1), job)
    assert 1 / 3 < reports[-1] / expected_iterations(1100, 0.86) < 3


@pytest.mark.quick
def test_a_dry_run_counts_beds_and_no_more_processes_than_runs(tmp_path, monkeypatch):
    """A large bed takes its time, once for all runs that share it; a second process has no run."""
    monkeypatch.chdir(tmp_path)

    def seconds(**changes):
        state = sweep_of(100_000, sweep={"shape": "c1"}, **changes)
        assert "with 1 process (" in summary(state, 8)
        return time_of(state.store, [*state.block("drag").unique()], 1)[0]

    assert seconds() > seconds(packing={"fraction": 0.80}) + 60.0
