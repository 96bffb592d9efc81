"""What no simulation takes."""

import numpy as np
from scenes import scene_of

import dem

SCENE, STATE = scene_of("box of discs")
TINY = dem.Scene(dem.Disc([1e-20, 1e-20])), dem.State([[0.0, 0.0], [1e-3, 0.0]])


def simulated(time=1e-6, **options):
    return lambda: dem.simulate(SCENE, STATE, time, **options)


def state(**values):
    return lambda: dem.State([[0, 1], [2, 3]], **values)


CALLS = {
    "endless": (lambda: dem.simulate(*TINY, 1.0), "duration is 1 s, more than 1e+11 time steps"),
    "no time": (simulated(0.0), "duration is 0.0"),
    "no granules": (lambda: dem.Scene(dem.Disc(np.zeros(0))), "must have shape (n,), not (0,)"),
    "normal of a wall": (
        lambda: dem.Scene(dem.Disc([1e-3]), walls=[[1.0015, 0.0, 1.0]]),
        "must have length 1, not 1.0015",
    ),
    "a cylinder through a side": (
        lambda: dem.pack(dem.Disc([1e-3]), 1e-2, 1e-2, dem.Cylinder(1e-3, (0.0, 5e-3)), 1),
        "does not fit",
    ),
    "step_fraction": (simulated(step_fraction=-1.0), "step_fraction is -1.0"),
    "step_fraction beyond the critical step": (
        simulated(step_fraction=1.5),
        "step_fraction is 1.5; it must be at most 1",
    ),
    "ledger of threads": (simulated(threads=2, ledger=True), "threads is 2"),
    "no ledger": (lambda: dem.Simulation(SCENE, STATE).ledger(), "ledger is False"),
    "no such solid": (
        lambda: dem.Simulation(SCENE, STATE).set_velocity((0.0, 0.0), solid=1),
        "solid is 1; the scene has 1, numbered from 0",
    ),
    "velocity of a state": (state(velocity=[[0.0, 0.0]]), "velocity"),
    "angle of a state": (state(angle=[1.0]), "angle"),
    "spin of a state": (state(angular_velocity="12"), "angular_velocity"),
    "checkpoint that lacks an array": (
        lambda: dem.Simulation(SCENE, STATE).restore(
            {"scene": dem.Simulation(SCENE, STATE).checkpoint()["scene"]}
        ),
        "saved is no whole checkpoint; it lacks",
    ),
    "no checkpoint": (lambda: dem.Simulation(SCENE, STATE).restore({}), "of another scene"),
}
