"""What a dry run says of time."""

import re
from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
from pictures import text_of
from sweeps import SMOKE

from dem.cli import show
from dem.io.dataset import read
from dem.report.status import status
from dem.sweep.combine import combine_block
from dem.sweep.config import parse
from dem.sweep.estimate import effort
from dem.sweep.state import SweepState


def test_the_estimated_time_of_a_run_is_in_proportion_to_its_steps():
    """At any step fraction: stiffness bounds short steps, damping long ones."""
    ratios = []
    for fraction in (0.05, 0.3, 0.95):
        values = {
            "results": "results/told",
            "sweep": {"shape": "c1", "numerics.step_fraction": [fraction]},
        }
        sweep = parse({"extends": "config/smoke.yaml"} | values, "a sweep")
        run = sweep.block("drag").first
        result = run.configuration.module.run(run)
        ratios.append(effort(run) / int(result["steps"]))
    assert max(ratios) < 1.25 * min(ratios)


SPENT = 100.0  # s a run


VALUES = {
    "extends": str(SMOKE),
    "results": "results",
    "batch": 8,
    "record": {"observables": ["drag"]},
    "sweep": {"shape": "c1", "seed": "1 to 12"},
}


def finish(state, count):
    """Keep what so many runs of a first batch would have given: the drag is 100 N and their seed."""
    state.begin("drag")
    for replicate in list(state.block("drag").unique())[:count]:
        experiment = replicate.configuration.module
        sizes = experiment.sizes(replicate)
        row = {
            name: np.full([sizes[dimension] for dimension in dimensions], 100.0 + replicate.seed)
            for name, (dimensions, *_) in experiment.layout.items()
        }
        row |= {"failure": 0, "failure_reason": "", "spent": SPENT}
        state.store.keep(replicate.id, row)


@pytest.fixture
def stopped(tmp_path):
    """A sweep of twelve runs in batches of eight and four that stopped when three runs were finished."""
    with chdir(tmp_path):
        state = SweepState(parse(VALUES))
        finish(state, 3)
        yield state


def test_status_knows_the_mean_of_finished_runs_before_their_batch_ends(stopped):
    assert re.search(r"c1 +12 +3 +9 +102 ", text_of(status(stopped)))


def test_a_partial_file_holds_finished_runs_before_their_batch_ends(stopped):
    combine_block(stopped, "drag", "drag", Path("part.nc"), partial=True)
    values, attrs = read(Path("part.nc"), ("drag",))
    drag = values["drag"].mean(axis=-1).ravel()
    assert attrs["partial"] == "3 of 12 runs"
    assert drag[:3].tolist() == [101.0, 102.0, 103.0] and np.isnan(drag[3:]).all()


def test_watching_ends_when_nothing_is_left(monkeypatch):
    monkeypatch.setattr(show.time, "sleep", lambda seconds: pytest.fail("it goes on"))
    show.watched(lambda: ("a table", False))
