"""Scenes, materials, motions and periods that cannot be."""

from functools import partial

import numpy as np

import dem

R = 1e-3
ROUND = dem.Disc([2e-3])
DISC, DISCS = dem.Disc([R]), dem.Disc([0.5e-3, 0.4e-3])
PIECES = dem.Superellipse([R], [R], [0.2 * R], 3.0)
PAIR = np.eye(2)
REST, TURNING = (dem.PrescribedMotion([0.0], [[0.0, 0.0]], *spin) for spin in ([], [[1.0]]))


def beside(*places, outline=ROUND, angle=0.0, **more):
    """A scene of two solids, 4 mm wide if they are round."""
    solids = [dem.Solid(outline, place, k * angle) for k, place in enumerate(places)]
    return partial(dem.Scene, DISC, solids=solids, **more)


def held(count, *groups):
    return lambda: dem.Scene(dem.Disc(np.full(count, R)), held=list(map(dem.Held, groups)))


CALLS = {
    "gravity is (0.0, -9.81), in the plane of the bed, and base_plate is given": lambda: dem.Scene(
        DISC, gravity=(0.0, -9.81), base_plate=dem.BasePlate(0.3)
    ),
    "BasePlate.slope is 2; it must be below 1.5": lambda: dem.BasePlate(0.3, slope=2),
    # motion
    "PrescribedMotion.time has 2 rows; it must rise": lambda: dem.PrescribedMotion([1, 0], PAIR),
    "PrescribedMotion.time has 3 rows": lambda: dem.PrescribedMotion([0, 1, 2], PAIR),
    "and, if it has any, a spin": lambda: dem.PrescribedMotion([0, 1], PAIR, [1]),
    "it must be two forces (x, y), None for an axis whose": lambda: dem.Drive(3.0, 1.0),
    "Drive.mass is 0.0; it must be positive": lambda: dem.Drive((1.0, 1.0), 0.0),
    "Drive.damping is -1.0; it must be at least 0": lambda: dem.Drive((1.0, 1.0), 1.0, -1.0),
    "Drive.spring is -1.0; it must be a stiffness, or two (x, y)": lambda: dem.Drive(
        (1.0, 1.0), 1.0, spring=-1.0
    ),
    "it must be a velocity (x, y) or a dem.PrescribedMotion without spin": lambda: dem.Drive(
        (1.0, 1.0), 1.0, spring=1.0, anchor=2.0
    ),
    "Turn.torque is 'all'; it must be a torque or a dem.PrescribedLoad": lambda: dem.Turn(
        1.0, "all"
    ),
    "PrescribedLoad.time has 2 rows; it must rise, with a value for each row": lambda: (
        dem.PrescribedLoad([0.0, 1.0], [1.0])
    ),
    "numbers of granules, or one truth value per granule": lambda: dem.Held([-1]),
    "Held.motion is 'up'; it must be a velocity (x, y), a": lambda: dem.Held([0], "up"),
    "Held.motion is PrescribedMotion(time=": lambda: dem.Held([0], TURNING),
    "Wall.motion is PrescribedMotion(time=": lambda: dem.Wall([1.0, 0.0, 0.0], TURNING),
    "velocity is 1.0; it must be a velocity": lambda: dem.Cylinder(1.0, (0, 0), 1.0),
    "Scene.held is [1]; it must be a list of dem.Held": lambda: dem.Scene(DISCS, held=[1]),
    "some of the 2 granules, each in one group, and leave at least one free": held(2, [2]),
    "some of the 3 granules": held(3, [0], [0]),
    "some of the 4 granules": held(4, [0, 1, 2, 3]),
    # solids
    "solids[1] is 0.001 m inside solids[0]": beside((0, 0), (3e-3, 0)),
    "solids[1] is 0.002 m inside solids[0]": beside((R, 0), (19e-3, 0), periodic=(20e-3, None)),
    "solids[1] is 0.0043 m inside solids[0]": beside(  # a cross, of which no corner is inside
        (0, 0), (0, 0), outline=dem.plate(8e-3, 0.6e-3), angle=0.5 * np.pi
    ),
    "solids[0] is 0.0005 m inside wall 0": beside((0, 1.5e-3), walls=[[0, -1, 0]]),
    "two or more corners of a convex polygon, anticlockwise": lambda: dem.Polygon(
        [[0, 0], [2e-3, 0], [1e-3, 0.2e-3], [1e-3, 2e-3]], 1e-4
    ),
    "has a radius of 0.0001 m; it must be more than 0.0002 m": beside(
        (0, 0), outline=[dem.plate(4e-3, 0.2e-3), dem.circle(4e-3)]
    ),
    "sides is 2; it must be at least 3": lambda: dem.ring(10e-3, 1e-3, 2),
    "has the outline Ellipse; among granules of Superellipse it must be round": lambda: dem.Scene(
        PIECES, solids=dem.Solid(dem.Ellipse([2e-3], [1e-3]), (0, 0))
    ),
    "solids[0].outline.exponent is 4.0; it must be that of the granules, 3.": lambda: dem.Scene(
        PIECES, solids=dem.Solid(PIECES._replace(exponent=4.0), (0, 0))
    ),
    # materials
    "species must be the number of the material of each of the 1 granules, below 2": lambda: (
        dem.Scene(DISC, [dem.Material()] * 2)
    ),
    "Friction.granule has 2 rows; it must have one for each of the 1 materials": lambda: dem.Scene(
        DISC, friction=dem.Friction(PAIR)
    ),
    "it must be symmetric": lambda: dem.Friction([[0.1, 0.2], [0.3, 0.3]]),
    # periods
    "periodic is (0.01, -1.0); it must be": lambda: dem.Scene(DISCS, periodic=(0.01, -1.0)),
    "x is 0.002 m; it must be at least 0.0025 m": lambda: dem.Scene(DISCS, periodic=(2e-3, None)),
    "walls must have nx = 0, because the scene repeats itself along x": lambda: dem.Scene(
        DISCS, walls=dem.box(1e-2, 1e-2), periodic=(0.01, None)
    ),
}
HAMMER = {"kind": "clump", "discs": [[0, 0, 1], [3, 0, 0.3]], "diameter": 1.1e-3, "granules": 200}
FILES = {
    "periodic is true; it must be 'none', 'x', 'y' or 'xy'": {"periodic": True},
    "along x it must be at least": {"periodic": "x", "box_width": 3e-3},
    # five times the radius of the circle about the centre of mass that holds the clump
    "along x it must be at least 0.00804 m": {
        "periodic": "x", "box_width": 8e-3, "packing.size_spread": 0, "shapes.c1": HAMMER,
    },
}  # fmt: skip
