"""What no simulation takes."""

import numpy as np
from scenes import scene_of

import dem

SCENE, STATE = scene_of("box of discs")
TINY = dem.Scene(dem.Disc([1e-20, 1e-20])), dem.State([[0.0, 0.0], [1e-3, 0.0]])


def run():
    return dem.Simulation(SCENE, STATE)


def removed_twice():
    changed = run()
    for _ in range(2):
        changed.remove(0)


def simulated(**options):
    return lambda: dem.simulate(SCENE, STATE, 1e-6, **options)


def inserted(*granules, at=((0.0, 0.0),)):
    """Granules of a bed from which the first is gone."""

    def call():
        changed = run()
        changed.remove_granules([0])
        changed.insert_granules([*granules], at)

    return call


def removed_granule():
    changed = run()
    for _ in range(2):
        changed.remove_granules([0])


EDGES = "it must hold two or more edges of bins that rise, in m"
CALLS = {
    "duration is 1 s, more than 1e+11 time steps": lambda: dem.simulate(*TINY, 1.0),
    "must have shape (n,), not (0,)": lambda: dem.Disc([]),
    "step_fraction is 1.5; it must be at most 1": simulated(step_fraction=1.5),
    "threads is 2": simulated(threads=2, ledger=True),
    "ledger is False": lambda: run().ledger(),
    "solid is 1; the scene has 1, numbered from 0": lambda: run().set_motion(1),
    "solid is -1; the scene has 1": lambda: run().remove(-1),
    "solid is 0, which was removed; it must be one of the others": removed_twice,
    "velocity is 1.0; it must be a velocity (x, y), a dem.PrescribedMotion or a": lambda: (
        run().set_motion(0, 1.0)
    ),
    "spin is 'on'; it must be an angular velocity or a dem.Turn": lambda: run().set_motion(
        0, spin="on"
    ),
    "granules has 20; the scene has 20, numbered from 0": lambda: run().remove_granules([3, 20]),
    "granules must leave at least one granule there": lambda: run().remove_granules([*range(20)]),
    "granules is [0.5]; it must be numbers of granules": lambda: run().remove_granules([0.5]),
    "granules has 0, which is not there; leave it out": removed_granule,
    "granules has 3, which is there already; leave it out": inserted(3),
    "granules has a number twice": inserted(0, 0, at=[[0.0, 0.0]] * 2),
    "position has 1 rows; it must have 2, as granules": inserted(0, 1),
    "position is [[nan, 0.0]]; all must be": inserted(0, at=[[np.nan, 0.0]]),
    "m inside wall ": inserted(0, at=[[0.0, 0.0]]),
    "m inside solid 0; insert granules where there is room": inserted(
        0, at=[SCENE.solids[0].position]
    ),
    "saved is no whole checkpoint; it lacks": lambda: run().restore(
        {"scene": run().checkpoint()["scene"]}
    ),
    "of another scene": lambda: run().restore({}),
    "x and y are both given; give edges along one of": lambda: run().stress(x=[0, 1], y=[0, 1]),
    f"y is [0.0]; {EDGES}": lambda: run().stress(y=[0.0]),
    f"y is [0.0, 0.002, 0.001]; {EDGES}": lambda: run().stress(y=[0.0, 2e-3, 1e-3]),
    f"x is 10; {EDGES}": lambda: run().stress(x=10),
}
