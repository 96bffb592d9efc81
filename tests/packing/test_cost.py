"""What beds cost, as a dry run and a sentence say it before they are packed."""

import pytest
from project import quick
from sweeps import SMOKE

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


@quick
@pytest.mark.parametrize(
    ("count", "fraction", "slow"),
    [(100_000, 0.84, True), (100_000, 0.86, False), (400, 0.84, False)],
)
def test_a_sentence_comes_before_a_large_bed_near_random_close_packing(count, fraction, slow):
    """It says what to ask for instead; small beds, which walls make denser, and others need none."""
    said = sweep_of(count, packing={"fraction": fraction}).check()
    warnings = [words for words in said if "random close packing" in words]
    assert len(warnings) == slow
    if slow:
        assert "ask for 0.86, or for packing.pressure" in warnings[0]


@quick
def test_a_dry_run_counts_beds_and_no_more_processes_than_runs(folder):
    """A large bed takes its time, once for all runs that share it; a second process has no run."""

    def seconds(**changes):
        state = sweep_of(100_000, sweep={"shape": "c1"}, **changes)
        assert "with 1 process (" in summary(state, 8)
        return time_of(state.store, [*state.block("drag").unique()], 1)[0]

    assert seconds() > seconds(packing={"fraction": 0.80}) + 60.0
