"""What a dry run says of time."""

import re
from pathlib import Path

import pytest
from made import run_all

from dem.sweep.campaign import Campaign
from dem.sweep.config import parse
from dem.sweep.estimate import cost, summary
from dem.sweep.store import Store

SWEEP = """
extends: config/smoke.yaml
results: results/told
cylinder: {stroke: %s}
sweep:
  shape: c1
  seed: {until: 30 %%, of: %s, least: 3}
"""


@pytest.fixture
def told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def of(stroke, of="drag"):
        Path("sweep.yaml").write_text(SWEEP % (stroke, of))
        return Campaign.of(Path("sweep.yaml"))

    return of


def test_a_dry_run_says_what_a_stroke_that_ends_with_the_window_saves(told):
    """The share of the time that is spent beyond the window, whose end is 1 mm."""
    said = summary(told(4.0e-3), 1)
    most = re.search(r"3 runs at least and 100 at most, .* to (\S+ \S+); the first", said)[1]
    less = re.search(r"With cylinder.stroke 0.001, where the window ends, it would take (.*)\.", said)[1]
    assert seconds(less) == pytest.approx(seconds(most) / 4.0, abs=0.7)  # told in whole seconds


def seconds(words):
    number, unit = words.split()
    return float(number) * {"s": 1.0, "min": 60.0}[unit]


@pytest.mark.parametrize("case", [(1.0e-3, "drag"), (4.0e-3, "max_overlap")])
def test_it_says_nothing_where_nothing_is_saved_or_the_mean_is_another(told, case):
    assert "it would take" not in summary(told(*case), 1)


def test_it_says_nothing_where_the_runs_are_there(told):
    """Runs of another stroke are other runs."""
    work = told(1.1e-3)
    assert "it would take" in summary(work, 1)
    run_all(work)
    assert "it would take" not in summary(work, 1)


def test_the_time_of_a_run_is_told_in_proportion_to_its_steps(tmp_path):
    """At any step fraction: stiffness bounds short steps, damping long ones."""
    ratios = []
    for fraction in (0.05, 0.3, 0.95):
        values = {"results": "results/told", "sweep": {"shape": "c1", "numerics.step_fraction": [fraction]}}
        sweep = parse({"extends": "config/smoke.yaml"} | values, "a sweep")
        run = sweep.block("drag").runs[0].replicate
        made = run.configuration.module.run(run)
        ratios.append(cost(Store(tmp_path), [run])[0] / int(made["steps"]))
    assert max(ratios) < 1.25 * min(ratios)
