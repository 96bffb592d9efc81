"""The shapes, one file each; a new shape is a new file and one line here."""

from dem.shapes import disc, dumbbell, ellipse
from dem.shapes.common_normal import CommonNormal
from dem.shapes.disc import Disc
from dem.shapes.dumbbell import Dumbbell
from dem.shapes.ellipse import Ellipse
from dem.shapes.geometric_potential import GeometricPotential

# name in configuration files and data: (class, whether the kernels know its angle)
SHAPES = {
    "disc": (Disc, disc.TURNS),
    "dumbbell": (Dumbbell, dumbbell.TURNS),
    "ellipse": (Ellipse, ellipse.TURNS),
}

__all__ = ["SHAPES", "CommonNormal", "Disc", "Dumbbell", "Ellipse", "GeometricPotential"]
