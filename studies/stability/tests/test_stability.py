"""The study of stability: what it measures is there, and its verdicts can go either way."""

from pathlib import Path

import numpy as np
import pytest
from beds import small_bed

import dem
from dem.dynamics.checkpoint import copied
from dem.sweep.config import load
from studies.stability import catalogue, linear, results
from studies.stability.scenes import start
from studies.stability.watching import friction_excess, momenta, unlisted

STUDY = Path(__file__).parent.parent
SHORT = {"experiment": "draw", "shapes": ["c1"], "change": {"displacement": 5e-5}}


@pytest.fixture(scope="module")
def sweep():
    return load(STUDY / "smoke.yaml")


def test_friction_beyond_the_cap_is_seen():
    """Friction stays within mu N; against half of mu, it exceeds."""
    small = small_bed("disc")
    run = dem.Simulation(small.scene(), small.state)
    run.advance(5e-5)
    assert abs(friction_excess(run)) < 1e-14
    assert friction_excess(run, 0.5) > 0.01


def test_pairs_that_are_not_listed_are_counted():
    """A bed's list is complete; a granule put onto another without a new list is missed."""
    small = small_bed("disc")
    world = copied(dem.Simulation(small.scene(), small.state).world)
    assert unlisted(world) == 0
    far = np.linalg.norm(world.bodies[:, :2] - world.bodies[0, :2], axis=1).argmax()
    world.bodies[0, :2] = world.bodies[far, :2]
    assert unlisted(world) > 0


def test_momenta_of_a_known_motion():
    """Two discs that circle each other: no momentum, and 2 m r v of angular momentum plus spin."""
    velocity, shape = [[0.0, 3.0], [0.0, -3.0]], dem.Disc(np.full(2, 1e-3))
    state = dem.State([[1e-2, 0.0], [-1e-2, 0.0]], velocity, angular_velocity=[5.0, 5.0])
    run = dem.Simulation(dem.Scene(shape, friction=dem.Friction()), state)
    mass = run.scene.mass[0]
    momentum, turning, sizes = momenta(run)
    assert np.abs(momentum).max() < 1e-15 * sizes[0]
    expected = 2.0 * mass * (1e-2 * 3.0 + 0.5 * 1e-6 * 5.0)
    assert (turning, *sizes) == pytest.approx((expected, 6.0 * mass, expected), rel=1e-12)


@pytest.mark.parametrize(
    ("case", "passed"),
    [
        ({"limits": {"residual": 1e-2, "excess": 1e-14}}, [1, 1]),
        ({"limits": {"residual": 0}}, [0]),
        ({"change": {"fraction": 1.6}, "expect": "InputError"}, [1]),
        ({"expect": "OverlapError"}, [0]),
        ({"experiment": "restart", "limits": {"difference": 0}}, [1]),
    ],
)
def test_verdicts_follow_limits(sweep, case, passed):
    """By the values that come out; a refusal passes where it is expected, and only there."""
    case = catalogue.Case(**SHORT | case)
    rows = results.verdicts(sweep, "c1", "case", case)
    assert [row["passed"] for row in rows] == passed


def test_a_bed_grows_beyond_its_limit_only(sweep):
    """The bound lies below the true limit of the linearised bed."""
    small = start(linear.small(sweep, "c1", 40, catalogue.Changes()), still=True)
    matrices, bound = linear.matrices(small), small.diagnose().critical_time_step
    limit = linear.limit(*matrices, bound, results.GROWTH)
    grown = [linear.growth(*matrices, step) for step in (bound, 1.05 * limit)]
    assert bound < limit and grown[0] < results.GROWTH < grown[1]
