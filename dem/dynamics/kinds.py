"""Kinds of scenes: what a scene has is a constant of its kernels, and what it lacks is not compiled.

| flag | a scene has it where |
|:--|:--|
| FRICTION | a contact has a coefficient of friction above zero, or rolling resistance |
| DAMPING | a contact has a restitution below one, or rolling resistance |
| TURNS | a force turns a granule |
| ROTATES | granules look different when they turn |
| LEVERS | a normal force may pass beside a centre: granules or solids are not round |
| ORIENTED | outlines of granules have a direction |
| COMPOSED | granules have several constituents |
| GUESSES | contacts remember their normals, from which the search for the next begins |
| ROLLING | contacts have rolling resistance |
| LOCAL | R* is computed at each contact |
| LONG | the law has a second constant |
| PERIODIC | the scene repeats itself along a side |
| YIELDS | a normal force moves a boundary, so that contacts have another effective mass |
| LEDGER | energies are counted |
| WITH_OUTLINES, WITH_POLYGONS | solids have the outline of a granule, or of a polygon |
| FULL | velocities are at full steps: nothing turns, and contacts have dashpots |

Each flag doubles the kinds, and a kind takes several seconds to compile. What costs no time where it
is absent is data instead: walls, round solids, gravity, paths, held granules, patches and threads.
"""

from typing import NamedTuple

from dem.contacts.layout import SIZES_AT, Layout
from dem.dynamics import scan
from dem.jit.kernel import Kernel, kernel
from dem.shapes.protocol import ellipse_contact, find_contact, refine_normal


class Kernels(NamedTuple):
    """The kernels of a kind of scene.

    Attributes
    ----------
    flags : dict of str to bool
        What the scene has.
    layout : Layout
        Where columns of the list are.
    work : Kernel
        What moves the bed, such as dem.dynamics.step.advance.
    scan : Kernel
        dem.dynamics.scan.scan, for all kinds of scenes of a law.
    """

    flags: dict[str, bool]
    layout: Layout
    work: Kernel
    scan: Kernel


def types_of(*tuples) -> tuple[type, ...]:
    """Types of the values of shapes and laws: a user's may be an integer here and a float there."""
    return tuple(type(value) for values in tuples for value in values)


def bound(function, flags: dict[str, bool], layout: Layout, shape, outlines, law, **more) -> Kernel:
    """The kernel of a function for the contacts of a kind of scene; outlines: solids that have the
    outline of a granule, or the granules."""
    methods = [type(m) for s in (shape, outlines) for m in s if type(m) in ellipse_contact.answers]
    return kernel(
        function,
        (type(shape), type(outlines), type(law), *methods),
        **flags,
        **layout.constants,
        sizes_at=SIZES_AT[layout.size_count],
        outline_sizes_at=SIZES_AT[layout.outline_size_count],
        find_outline=find_contact.answers[type(outlines)],
        refine_outline=refine_normal.answers[type(outlines)],
        TYPES=types_of(shape, outlines, law),
        **more,
    )


def kernels(work, flags: dict[str, bool], layout: Layout, shape, outlines, law) -> Kernels:
    """The kernels of scenes with some flags, where `work` moves the bed."""
    scanning = kernel(scan.scan, (type(law),), TYPES=types_of(law))
    return Kernels(flags, layout, bound(work, flags, layout, shape, outlines, law), scanning)
