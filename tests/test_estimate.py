"""What a dry run says of time."""

from pathlib import Path

import pytest

from dem.sweep.campaign import Campaign
from dem.sweep.config import parse
from dem.sweep.estimate import cost, summary
from dem.sweep.store import Store

SWEEP = """
extends: config/smoke.yaml
results: results/told
record: {observables: [drag]}
cylinder: {stroke: %s}
numerics: {step_fraction: %s}
sweep:
  shape: [c1, d1]
  seed: {until: 5 %%}
"""


@pytest.fixture
def told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def of(stroke, fraction):
        Path("sweep.yaml").write_text(SWEEP % (stroke, fraction))
        return Campaign.of(Path("sweep.yaml"))

    return of


def test_a_dry_run_says_which_settings_give_the_same_mean_in_less_time(told):
    """A stroke that ends with the window, and the longest step that is stable; nothing where it is so already."""
    both, stroke, neither = (summary(told(*each), 1) for each in ((1.4e-3, 0.3), (1.4e-3, 0.95), (1.0e-3, 0.95)))
    assert "With numerics.step_fraction 0.95 and cylinder.stroke 0.001 it would take" in both
    assert "With cylinder.stroke 0.001 it would take" in stroke
    assert "it would take" not in neither


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
