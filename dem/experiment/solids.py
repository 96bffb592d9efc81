"""What is drawn through the bed of a run: the cylinder, and a second one beside it."""

from dem.experiment.box import ahead_of, circles_of, polygon_of, width_of
from dem.experiment.run import Replicate
from dem.motion import Turn
from dem.shapes.disc import Disc
from dem.shapes.ellipse import Ellipse
from dem.solids import Polygon, Solid


def outline_of(section):
    """Outline of a cylinder, with its length along x, and a tip upwards."""
    half = 0.5 * section.diameter
    if polygon := polygon_of(section):
        return Polygon(*polygon)
    if section.outline == "ellipse":
        return Ellipse([half], [0.5 * width_of(section)])
    return Disc([half])


def solids_of(replicate: Replicate, height: float, thickness: float) -> tuple[Solid, ...]:
    """The solids of a run at their start in a box of a height (m); none without a cylinder.

    thickness (m): of granules and solids; it tells the inertia of those that turn freely.
    """
    own = replicate.configuration
    if own.cylinder is None:
        return ()
    one, second = own.cylinder, own.second
    velocity = tuple(one.velocity * component for component in ahead_of(one))
    solids = [Solid(outline_of(one), angle=one.angle or 0.0, position=(0.0, 0.0))]
    if second is not None:
        solids.append(Solid(Disc([0.5 * second.diameter]), position=(0.0, 0.0)))
    sections = (one, second)
    drawn = []
    for solid, section, (x, y, _) in zip(solids, sections, circles_of(own, height), strict=False):
        spin = section.spin or 0.0
        if spin == "free":
            mass = replicate.density * solid.area * thickness
            spin = Turn(inertia=mass * solid.gyration_squared)
        drawn.append(
            Solid(
                solid.outline,
                (x, y),
                solid.angle,
                velocity,
                spin,
                getattr(section, "friction", None),
                one.material and replicate.material_of(one.material),
            )
        )
    return tuple(drawn)
