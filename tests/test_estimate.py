"""What a dry run says of time."""

from dem.sweep.config import parse
from dem.sweep.estimate import cost
from dem.sweep.store import Store


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
