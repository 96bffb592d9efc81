"""Two-dimensional discrete element method for discs, dumbbells and ellipses.

Conventions: SI units; x to the right, y upwards, angles anticlockwise; arrays have one row a
granule. Forces are in newtons as in the paper: Hertz's law for spheres, masses of granules of a
stated thickness out of the plane.

The names below load when they are first used, so that a command loads only what it needs.
"""

from importlib import import_module

_HOME = {
    "errors": ("InputError", "OverlapError", "PackingError", "RunError", "StateError"),
    "scene": ("Cylinder", "Friction", "Material", "Scene", "State", "box"),
    "shapes": ("CommonNormal", "Disc", "Dumbbell", "Ellipse", "GeometricPotential"),
    "packing": ("Bed", "pack"),
    "simulation": ("Result", "Simulation", "simulate"),
}
_MODULE = {name: module for module, names in _HOME.items() for name in names}

__all__ = sorted(_MODULE)  # noqa: PLE0605


def __getattr__(name):
    if name not in _MODULE:
        raise AttributeError(f"module 'dem' has no attribute {name!r}")
    value = getattr(import_module(f"dem.{_MODULE[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return __all__
