"""Two-dimensional discrete element method for discs, dumbbells, ellipses and other smooth granules.

Conventions: SI units; x to the right, y upwards, angles anticlockwise; arrays have one row a
granule. Forces are in newtons as in the paper: Hertz's law for spheres, masses of granules of a
stated thickness out of the plane.

The public names are those of __init__.pyi; each loads when it is first used, so that a command
loads only what it needs.
"""

import lazy_loader

__version__ = "1.0.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
