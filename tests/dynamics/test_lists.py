"""Neighbour lists that suit how granules move."""

import numpy as np
import pytest
from project import quick

import dem
from dem.dynamics.skin import SKIN
from dem.dynamics.system import System

R = 1e-3
PLACE = 3.0 * R * (1.0 + np.mgrid[:6, :6].reshape(2, -1).T)


def lists_of(run, duration):
    """Skins (m) of the lists that are made in a time (s)."""
    skins, rebuild = [], System.rebuild
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(System, "rebuild", lambda *args: (skins.append(args[1]), rebuild(*args)))
        run.advance(duration)
    return np.array(skins)


@quick
def test_lists_of_granules_that_fall_last_longer_and_are_narrow_again_when_they_lie():
    """Than with the skin that they begin with, which a user may ask for. What they do is the same."""
    scene = dem.Scene(
        dem.Disc(np.full(len(PLACE), R)),
        dem.Material(young_modulus=1e7, restitution=0.3),
        dem.Friction(),
        gravity=(0.0, -9.81),
        thickness=R,
        walls=[dem.Wall((0.0, -1.0, 0.1))],
    )
    fallen, fixed = (dem.Simulation(scene, dem.State(PLACE), skin=skin) for skin in (None, SKIN))
    lists = [lists_of(run, 0.13) for run in (fallen, fixed)]
    assert lists[0].max() > 2.0 * lists[0][0] and len(set(lists[1])) == 1
    assert 1.5 * len(lists[0]) < len(lists[1])
    places = [run.state.position for run in (fallen, fixed)]
    assert np.allclose(*places, rtol=0.0, atol=1e-4 * R)
    assert lists_of(fallen, 1.0)[-1] == pytest.approx(SKIN * R)
