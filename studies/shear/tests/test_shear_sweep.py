"""The sweep over inertial numbers."""

from pathlib import Path

from dem.sweep.config import load

STUDY = Path(__file__).parent.parent


def test_every_bed_is_sheared_in_all_ways():
    """With friction in all contacts and with none, at the same inertial numbers."""
    beds = {}
    for run in load(STUDY / "sweep.yaml").block("drag").runs.values():
        configuration = run.configuration
        ways = beds.setdefault(run.bed_key(), set())
        ways.add(
            (configuration.shear.inertial_number, *configuration.friction.model_dump().values())
        )
    numbers = {number for number, *_ in next(iter(beds.values()))}
    assert {1e-3, 0.3} <= numbers
    for ways in beds.values():
        assert ways == {(number, mu, mu, mu, 1.0) for number in numbers for mu in (0.0, 0.4)}
