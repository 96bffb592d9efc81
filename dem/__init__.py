"""Two-dimensional discrete element method for discs, dumbbells and ellipses.

Conventions: SI units; x to the right, y upwards, angles anticlockwise; arrays have one row a
granule. Forces are in newtons as in the paper: Hertz's law for spheres, masses of granules of a
stated thickness out of the plane.
"""

from dem.errors import InputError, OverlapError, PackingError, RunError, StateError
from dem.scene import Cylinder, Friction, Material, Scene, State, box
from dem.shapes import CommonNormal, Disc, Dumbbell, Ellipse, GeometricPotential
from dem.simulate import Result, Simulation, simulate

__all__ = [
    "CommonNormal", "Cylinder", "Disc", "Dumbbell", "Ellipse", "Friction", "GeometricPotential",
    "InputError", "Material", "OverlapError", "PackingError", "Result", "RunError", "Scene",
    "Simulation", "State", "StateError", "box", "simulate",
]  # fmt: skip
