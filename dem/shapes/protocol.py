"""What the kernels and Python ask of a shape, answered by the file of that shape.

A granule has one or more convex *constituents*, and contacts are between constituents. A shape is a
NamedTuple of arrays with one entry per granule, or per constituent. Its class selects, at compile
time, the answers to the questions of the kernels, and has MEMBERS and those of `Shape` for Python.
`dem.check_shape` tests both. Conventions of a contact between constituents 1 and 2:

* d = x2 - x1 (m); n is the unit normal from 1 to 2 and t = (-ny, nx) the tangent;
* overlap (m) is positive where they touch;
* the contact point is midway between the two surfaces, on one line with both forces;
* levers (m) lead from the centres to it: n1 n + t1 t for 1 and -n2 n + t2 t for 2.
  A lever that a shape does not have is None, and so is all arithmetic with it.
"""

from functools import partial
from typing import NamedTuple, Self

import numpy as np
from numba.extending import overload

from dem.jit.compilation import INLINED, inlined
from dem.jit.questions import question, register

SEPARATED = -1.0  # overlap of constituents that do not touch


class ContactGeometry(NamedTuple):
    """One contact: overlap (m, negative for a gap), normal (nx, ny), levers n1, t1, n2, t2 (m).

    t1 and t2 are None for discs, n2 and t2 for walls. radius: the effective radius R* (m) at the
    contact, or None where the pair's constant counts.
    """

    overlap: float
    nx: float
    ny: float
    n1: float
    t1: float | None
    n2: float | None
    t2: float | None
    radius: float | None


# What Python asks of n granules, who reads it, and what a wrong answer breaks; lengths in m. The
# rest is in Shape. of_size(diameter, aspect_ratio) is asked only of the shapes that configurations
# name: granules with the area of discs of these diameters (n,).
MEMBERS = (
    # Area (n,) in m2. Read by mass, packing and configuration. Wrong: the packing fraction, every
    # mass and so every velocity after an impact.
    "area",
    # Moment of inertia over mass (n,) in m2. Read by inertia. Wrong: spins and the time step;
    # energy is still conserved, so nothing else reveals it.
    "gyration_squared",
    # Radius (n,) in m of the circle about the centre of mass that holds the granule. Read by
    # packing, ordering and the bound of how far a surface moves. Too small: contacts are noticed
    # late; too large: packing begins looser and takes longer.
    "bounding_radius",
    # Radius (constituents,) in m that enters Hertz's law. Read by stiffness and by the guard of
    # overlaps. Wrong: contacts too stiff or too soft.
    "constituent_radius",
    # Greatest distance (n,) in m of a line of normal force from the granule's centre. Read by the
    # minimiser of packings, and to tell whether granules turn without friction. Too small: the
    # minimiser's steps are too long; zero: granules do not turn.
    "normal_lever",
    # Greatest second derivative (n,) in m of the support distance with the granule's angle. Read by
    # the bound of the time step. Too small: a turning granule gains energy; unbounded, as at a flat
    # side: the step is none.
    "normal_bend",
    # Function of a number of points: outlines (n, rings, points, 2) in m about the centre at angle
    # zero, closed: the first point is the last. Read by figures, films, export, report. Wrong:
    # pictures only.
    "polygons",
)


class Shape:
    """What Python asks of a shape beside MEMBERS, with what most shapes have in common."""

    __slots__ = ()

    # Whether an outline is cosine and sine of the angle, and then sizes that never change. The list
    # of pairs then has the sizes of both constituents. Read by the neighbour lists. Wrong: contacts
    # have the sizes of the time when the list was made.
    lists_sizes = False

    # Whether the granule looks different when it turns. Read by the integrator. Wrong: granules
    # keep the orientation that they start with.
    needs_angle = True

    # Whether a contact remembers its normal. Read by the neighbour lists. Wrong: the search for a
    # normal begins at every step from the line of centres, or contacts keep unused memory.
    guesses = False

    # Why these granules cannot be used, as a sentence, or None. Read by Scene.
    fault: str | None = None

    @property
    def owner(self) -> np.ndarray:
        """Granule (constituents,) that each constituent belongs to, without unit, in ascending
        order.

        Read by all that goes from contacts to granules. Wrong: forces act on other granules.
        """
        return np.arange(max(map(len, sizes_of(self).values())))

    @property
    def constituent_bounding_radius(self) -> np.ndarray:
        """Radius (constituents,) in m of the circle about its centre that holds the constituent.

        Read by the neighbour list. Too small: contacts are missed; too large: the list is long.
        """
        return self.bounding_radius

    def take(self, numbers: np.ndarray) -> Self:
        """The granules of these numbers, in this order. Read by ordering and mixtures."""
        return resized(self, lambda size: size[numbers])

    def appended(self, *others: Self) -> Self:
        """These granules, then those of others, alike in all but their sizes. Read by mixtures."""
        every = self, *others
        return self._replace(
            **{name: np.concatenate([getattr(s, name) for s in every]) for name in sizes_of(self)}
        )

    def scaled(self, factor: float) -> Self:
        """Granules of the same shape, all lengths multiplied by a factor. Read by packing.

        Parameters
        ----------
        factor : float
            Ratio of new to old lengths, without unit; for granules of one outline also one of
            each, an ndarray of shape (n,).

        Returns
        -------
        Self
            The scaled granules.
        """
        # lengths, not numbers of constituents
        return resized(self, lambda size: size * factor if size.dtype == float else size)


def unit_circle(points):
    """Closed polygon (points, 2) of a circle of radius one."""
    turn = np.linspace(0.0, 2.0 * np.pi, points)
    return np.stack([np.cos(turn), np.sin(turn)], axis=-1)


@question
def outline(shape, constituent, orientation):
    """Numbers (a tuple, at most 8) that describe a constituent in its present orientation."""
    raise NotImplementedError


@question
def circle(shape, radius):
    """The outline, in this shape's terms, of a circle, such as a round solid."""
    raise NotImplementedError


@question
def support(shape, outline_1, nx, ny):
    """Where a constituent touches a straight line with outward normal n: (h, q, radius).

    h (m) is the distance of that line from the centre; q = dh/d(angle) (m) the coordinate along t
    of the point that touches it, None for a disc; radius as in ContactGeometry.
    """
    raise NotImplementedError


@question
def find_contact(shape, dx, dy, outline_1, outline_2, guess):
    """Contact of two constituents, without a branch: (ContactGeometry, converged).

    The overlap is negative where they do not touch; `guess` a normal near the right one, what the
    contact remembers (None for discs). `converged` is False where the guess was too far off, None
    where that cannot be.
    """
    raise NotImplementedError


@question
def refine_normal(shape, dx, dy, outline_1, outline_2, guess):
    """A guess near enough for find_contact, from any other."""
    return guess


@question
def tangential_lever(shape):
    """True if normal forces can exert a torque about a centre; None for discs."""
    return True


@question
def local_radius(shape):
    """Not None if R* is computed at each contact; None: one R* per pair."""
    return


@question
def owner_of(shape, constituent):
    """Granule that a constituent belongs to; the default is for granules with one constituent."""
    return constituent


@question
def first_of(shape, granule):
    """First constituent of a granule; the number of granules has that of constituents."""
    return granule


@question
def place(shape, bodies, orientation, constituents, low, high):
    """Motion of the constituents of granules low to high from the motion of the granules.

    The default is for granules with one constituent: both are one array.
    """
    return


@question
def collect(shape, constituent_force, orientation, force, low, high):
    """Forces (N) and torques (N m) on granules low to high from those on their constituents."""
    return


@question
def ellipse_contact(method, dx, dy, outline_1, outline_2, guess):
    """Contact of two ellipses by a method: (overlap, nx, ny, n1, t1, n2, t2), (rho1, rho2),
    converged, with rho the radii of curvature (m) there."""
    raise NotImplementedError


@inlined
def solve_contact(shape, dx, dy, outline_1, outline_2, guess):
    """Contact of two constituents: the ContactGeometry, from any guess."""
    geometry, converged = find_contact(shape, dx, dy, outline_1, outline_2, guess)
    return _refined(converged, geometry, shape, dx, dy, outline_1, outline_2, guess)


@inlined
def _refined(converged, geometry, shape, dx, dy, outline_1, outline_2, guess):
    if converged is None or converged:
        return geometry
    guess = refine_normal(shape, dx, dy, outline_1, outline_2, guess)
    return find_contact(shape, dx, dy, outline_1, outline_2, guess)[0]


def outline_among(outlines, shape, constituent, orientation):
    """The outline of a constituent in the terms of other granules: of its own shape, or of any if
    it is a disc."""


@overload(outline_among, strict=False, jit_options=INLINED)
def _outline_among(outlines, shape, constituent, orientation):
    if outlines.instance_class is shape.instance_class:
        return lambda outlines, shape, constituent, orientation: outline(
            shape, constituent, orientation
        )
    return lambda outlines, shape, constituent, orientation: circle(
        outlines, outline(shape, constituent, orientation)[0]
    )


SHAPE_QUESTIONS = (
    outline,
    circle,
    support,
    find_contact,
    refine_normal,
    tangential_lever,
    local_radius,
    owner_of,
    first_of,
    place,
    collect,
)
# as dem.jit.questions.register
answer = partial(register, questions=SHAPE_QUESTIONS, members=MEMBERS, usual=Shape)
answer_method = partial(register, questions=(ellipse_contact,), members=(), usual=object)


def is_shape(cls: type) -> bool:
    """Whether the kernels know a class as a shape."""
    return cls in outline.answers


def is_of_discs(shape) -> bool:
    """Whether all constituents of a shape are discs."""
    return tangential_lever(shape) is None


def is_alone(shape) -> bool:
    """Whether each granule of a shape is its own only constituent."""
    return type(shape) not in place.answers


def sizes_of(shape) -> dict[str, np.ndarray]:
    """The arrays that granules are made of, such as sizes (n,) in m, by name."""
    return {name: size for name, size in shape._asdict().items() if isinstance(size, np.ndarray)}


def resized(shape, change):
    """Granules with other arrays: what a function returns for those of each name."""
    return shape._replace(**{name: change(size) for name, size in sizes_of(shape).items()})
