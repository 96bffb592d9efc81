"""The sweep over velocities."""

from pathlib import Path

from dem.analysis.velocity import LEAST
from dem.sweep.config import load

STUDY = Path(__file__).parent.parent


def test_every_bed_is_drawn_in_all_ways():
    """So that beds are their own control; without friction no contact has any."""
    block = load(STUDY / "sweep.yaml").block("drag")
    beds = {}
    for run in block.runs.values():
        configuration = run.configuration
        ways = beds.setdefault(run.bed_key(), set())
        ways.add(
            (
                configuration.cylinder.velocity,
                configuration.friction.granule,
                configuration.friction.wall,
                configuration.friction.cylinder,
            )
        )
    velocities = {velocity for velocity, *_ in ways}
    assert len(beds) == block.shape[-1] >= LEAST["seed"] and 2.0 in velocities
    for ways in beds.values():
        assert ways == {(v, mu, mu, mu) for v in velocities for mu in (0.0, 0.3)}
