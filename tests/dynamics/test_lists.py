"""Neighbour lists that suit how granules move."""

import numpy as np
import pytest
from project import quick

import dem
from dem.dynamics.system import System

R, SIDE = 1e-3, 12
SOFT = dem.Material(young_modulus=1e7, restitution=0.6)


def steps_a_list(run, duration):
    """How many steps a list lasts, over a time (s)."""
    count, steps, rebuild = [], run.steps, System.rebuild
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(System, "rebuild", lambda *args: (count.append(1), rebuild(*args)))
        run.advance(duration)
    return (run.steps - steps) / len(count)


@quick
def test_lists_of_granules_that_begin_to_fall_last_longer():
    """Than with the skin that they begin with, which a user may ask for. What the bed does is the same."""
    place = np.vstack([3.0 * R * np.mgrid[:SIDE, :SIDE].reshape(2, -1).T, [0.0, 1.0]])
    scene = dem.Scene(
        dem.Disc(np.full(len(place), R)),
        SOFT,
        dem.Friction(),
        gravity=(0.0, -9.81),
        thickness=R,
        held=[dem.Held([len(place) - 1])],
    )
    runs = [dem.Simulation(scene, dem.State(place), skin=skin) for skin in (None, 0.12)]
    for run in runs:
        run.advance(0.15)
    lasts = [steps_a_list(run, 5e-3) for run in runs]
    assert lasts[0] > 2.0 * lasts[1]
    places = [run.state.position for run in runs]
    assert np.allclose(*places, rtol=0.0, atol=1e-4 * R)
