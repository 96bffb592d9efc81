"""Do head-on elastic impacts follow Hertz: greatest overlap, greatest force, duration, speed
afterwards?

Overlap d = (15 m* v^2 / (16 E* sqrt(R*)))^(2/5), force 4/3 E* sqrt(R*) d^1.5, duration 2.9432 d /
v, for the materials and speeds of Chung and Ooi's tests 1 (two spheres) and 2 (a sphere and a rigid
plane), as other codes repeat them (Yade's examples). The spheres move in a plane, which changes
nothing head-on.

Tolerance: a frame lasts 1/500 of the impact and is a step: 0.16 (2.94 / 500)^2 by the scenes'
bound. The sampled peak misses at most 2.94^2 1.25 / 2 of 1/1000^2. Twice the sum; forces follow the
3/2 power of the overlap, and are means over a frame: twice that.
"""

import numpy as np

import dem
from studies.verification.row import Row
from studies.verification.scenes import FRAMES, SAMPLED, Sphere, impact, on_floor, scene_of

TITLE = "Hertz: overlap, force, duration"
SOURCE = "Hertz (1882); Chung and Ooi (2011), tests 1 and 2"
PAIRS = {"glass": (2800.0, 4.8e10, 0.20), "limestone": (2500.0, 2.0e10, 0.25)}
PLANES = {"aluminium alloy": (2699.0, 7.0e10, 0.30), "magnesium alloy": (1800.0, 4.0e10, 0.35)}


def measure() -> list[Row]:
    rows, radius, speed = [], 0.01, 10.0
    for name, material in PAIRS.items():
        material = dem.Material(*material, 1.0)
        scene = scene_of(Sphere([radius, radius]), material)
        scales = impact(material, 2, 0.5 * radius, 0.5 * scene.mass[0], 2.0 * speed)
        state = dem.State([[-radius, 1.0], [radius, 1.0]], [[speed, 0.0], [-speed, 0.0]])
        lasts = 1.2 * scales.duration
        run = dem.simulate(scene, state, lasts, lasts / FRAMES, FRAMES)
        overlap = 2.0 * radius - np.diff(run.position[:, :, 0], axis=1)[:, 0]
        force = -scene.mass[0] * np.diff(run.velocity[:, 0, 0]) / np.diff(run.time)
        returned = -run.velocity[-1, 0, 0] / speed
        rows += compared(f"{name} on {name}", scales, run.time, overlap, force, returned)
    for name, material in PLANES.items():
        material = dem.Material(*material, 1.0)
        scales, run = on_floor(Sphere([0.1]), material, (0.0, -0.2), fraction=None)
        overlap, returned = 0.1 - run.position[:, 0, 1], run.velocity[-1, 0, 1] / 0.2
        name, force = f"{name} on a plane", run.wall_force[1:, 0]
        rows += compared(name, scales, run.time, overlap, force, returned)
    return rows


def compared(name, scales, time, overlap, force, speed) -> list[Row]:
    """What came out beside Hertz's scales."""
    last = np.flatnonzero(overlap > 0.0)[-1]
    over = np.interp(0.0, -overlap[last : last + 2], time[last : last + 2])
    return [
        Row(
            f"{name}: greatest overlap",
            "m",
            overlap.max(),
            scales.overlap,
            SAMPLED * scales.overlap,
        ),
        Row(
            f"{name}: greatest force", "N", force.max(), scales.force, 2.0 * SAMPLED * scales.force
        ),
        Row(f"{name}: duration", "s", over, scales.duration, SAMPLED * scales.duration),
        Row(f"{name}: returned speed", "1", speed, 1.0, SAMPLED),
    ]
