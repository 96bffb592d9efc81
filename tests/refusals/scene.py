"""Scenes, materials, motions and periods that cannot be."""

import math
from functools import partial

import numpy as np

import dem

R = 1e-3
DISC, DISCS = dem.Disc([R]), dem.Disc([0.5e-3, 0.4e-3])
BLADE = dem.plate(8e-3, 0.6e-3)
PIECES = dem.Superellipse([R], [R], [0.2 * R], 3.0)
REST = dem.PrescribedMotion([0.0], [[0.0, 0.0]])
TURNING = dem.PrescribedMotion([0.0], [[0.0, 0.0]], [1.0])


def beside(*positions, periodic=None, outline=None, angles=(0.0, 0.0)):
    """A scene of two solids, 4 mm wide if they are round."""
    solids = [
        dem.Solid(outline or dem.Disc([2e-3]), place, angle)
        for place, angle in zip(positions, angles, strict=False)
    ]
    return partial(dem.Scene, DISC, solids=solids, periodic=periodic)


def pushed(**motion):
    """A push of a cylinder on its way."""
    cylinder = dem.Cylinder(R, (0.1, 0.1), **motion)
    scene = dem.Scene(DISC, friction=dem.Friction(), walls=dem.box(0.2, 0.2), solids=cylinder)
    dem.Simulation(scene, dem.State([[0.05, 0.05]])).set_velocity((1.0, 0.0))


CALLS = {
    # motion
    "times that fall": (lambda: dem.PrescribedMotion([1.0, 0.0], np.zeros((2, 2))), "PrescribedMotion.time has 2 rows; it must rise, with a velocity and"),
    "too few velocities": (lambda: dem.PrescribedMotion([0.0, 1.0, 2.0], np.zeros((2, 2))), "PrescribedMotion.time has 3 rows; it must rise, with a velocity and"),
    "too few spins": (lambda: dem.PrescribedMotion([0.0, 1.0], np.zeros((2, 2)), [1.0]), "PrescribedMotion.time has 2 rows; it must rise, with a velocity and, if it has any, a spin"),
    "no number in a path": (lambda: dem.PrescribedMotion([0.0], [[np.nan, 0.0]]), "PrescribedMotion.velocity is [[nan, 0.0]]; all must be from -1e+20 to 1e+20, and nan is at [0, 0]"),
    "one force": (lambda: dem.Drive(3.0, 1.0), "Drive.force is 3.0; it must be two forces (x, y), None for an axis whose velocity is kept, in N"),
    "a drive without mass": (lambda: dem.Drive((1.0, 1.0), 0.0), "Drive.mass is 0.0; it must be positive, at least 1e-20, in kg"),
    "negative damping": (lambda: dem.Drive((1.0, 1.0), 1.0, -1.0), "Drive.damping is -1.0; it must be at least 0, in N s m-1"),
    "a turn without inertia": (lambda: dem.Turn(0.0), "Turn.inertia is 0.0; it must be positive"),
    "a negative granule": (lambda: dem.Held([-1]), "Held.granules is [-1]; it must be numbers of granules, or one truth value per granule"),
    "a motion in words": (lambda: dem.Held([0], "up"), "Held.motion is 'up'; it must be a velocity (x, y), a dem.PrescribedMotion without spin"),
    "held granules that turn": (lambda: dem.Held([0], TURNING), "Held.motion is PrescribedMotion(time=array([0.]), velocity=array([[0., 0...; it must be a"),
    "a wall that turns": (lambda: dem.Wall([1.0, 0.0, 0.0], TURNING), "Wall.motion is PrescribedMotion(time=array([0.]), velocity=array([[0., 0...; it must be a"),
    "a cylinder of one velocity": (lambda: dem.Cylinder(1.0, (0, 0), 1.0), "velocity is 1.0; it must be a velocity"),
    "held is a number": (lambda: dem.Scene(DISCS, held=[1]), "Scene.held is [1]; it must be a list of dem.Held"),
    "a push on a path": (lambda: pushed(velocity=REST), "solids[0] follow a PrescribedMotion, a Drive or a Turn"),
    # solids
    "round solids that overlap": (beside((0, 0), (3e-3, 0)), "solids[1] is 0.001 m inside solids[0]"),
    "a cross, of which no corner is inside": (beside((0, 0), (0, 0), outline=BLADE, angles=(0.0, 0.5 * math.pi)), "solids[1] is 0.0043 m inside solids[0]"),
    "round solids that overlap across a side": (beside((1e-3, 0), (18e-3, 0), periodic=(20e-3, None)), "solids[1] is 0.001 m inside solids[0]"),
    "a solid in a wall": (lambda: dem.Scene(DISC, walls=[[0, -1, 0]], solids=dem.Cylinder(2e-3, (0, 0.5e-3))), "solids[0] is 0.0005 m inside wall 0"),
    "a polygon that is not convex": (lambda: dem.Polygon([[0, 0], [2e-3, 0], [1e-3, 0.2e-3], [1e-3, 2e-3]], 1e-4), "it must be two or more corners of a convex polygon, anticlockwise"),
    "a plate that granules pass": (lambda: dem.Scene(DISC, solids=dem.Solid(dem.plate(4e-3, 0.2e-3), (0, 0))), "solids[0] has a radius of 0.0001 m; it must be more than 0.0002 m"),
    "an outline of another shape": (lambda: dem.Scene(PIECES, solids=dem.Solid(dem.Ellipse([2e-3], [1e-3]), (0, 0))), "solids[0] has the outline Ellipse; among granules of Superellipse it must be round"),
    "an outline of another exponent": (lambda: dem.Scene(PIECES, solids=dem.Solid(dem.Superellipse([2e-3], [1e-3], [2e-4], 4.0), (0, 0))), "solids[0].outline.exponent is 4.0; it must be that of the granules, 3."),
    # materials
    "no species": (lambda: dem.Scene(DISC, [dem.Material()] * 2), "species must be the number of the material of each of the 1 granules, below 2"),
    "friction of too many materials": (lambda: dem.Scene(DISC, friction=dem.Friction([[0.1, 0.2], [0.2, 0.3]])), "Friction.granule has 2 rows; it must have one for each of the 1 materials"),
    "friction that is not mutual": (lambda: dem.Friction([[0.1, 0.2], [0.3, 0.3]]), "it must be symmetric"),
    # periods
    "a period in words": (lambda: dem.Scene(DISCS, periodic="x"), "Scene.periodic is 'x'; it must be two periods"),
    "a negative period": (lambda: dem.Scene(DISCS, periodic=(0.01, -1.0)), "Scene.periodic is (0.01, -1.0); it must be two periods (x, y), None for a side"),
    "a short period": (lambda: dem.Scene(DISCS, periodic=(2e-3, None)), "periodic along x is 0.002 m; it must be at least 0.0025 m"),
    "a wall across a side": (lambda: dem.Scene(DISCS, walls=dem.box(1e-2, 1e-2), periodic=(0.01, None)), "walls must have nx = 0, because the scene repeats itself along x"),
} | {
    f"held {groups} of {n}": (
        partial(dem.Scene, dem.Disc(np.full(n, R)), held=[dem.Held(group) for group in groups]),
        f"held must be of some of the {n} granules, each in one group, and leave at least one free",
    )
    for n, groups in ((2, [[2]]), (3, [[0], [0]]), (4, [[0, 1, 2, 3]]))
}  # fmt: skip

FILES = {
    "periodic along z": ({"periodic": "z"}, "periodic is 'z'"),
    "periodic is yes": ({"periodic": True}, "periodic is true"),
    "a box narrower than its cylinder": ({"periodic": "x", "box_width": 3e-3}, "along x it must be at least"),
}  # fmt: skip
