"""What the kernels and Python ask of a shape, answered by the file of that shape.

A granule has one or more convex *constituents*, and contacts are between constituents. A shape is a
NamedTuple of arrays with one entry per granule, or per constituent. Its class selects, at compile
time, the answers to the questions of the kernels, and has MEMBERS and the members of `Shape` for
Python. `dem.check_shape` tests both. Conventions of a contact between constituents 1 and 2:

* d = x2 - x1 (m); n is the unit normal from 1 to 2 and t = (-ny, nx) the tangent;
* overlap (m) is positive where they touch;
* the contact point is midway between the two surfaces, on one line with both forces;
* levers (m) lead from the centres to it: n1 n + t1 t for 1 and -n2 n + t2 t for 2.

An outline is a tuple of numbers: of a disc its radius; of all others cosine and sine of the angle,
then a row of `outlines`.
"""

from functools import partial
from typing import NamedTuple, Self

import numpy as np

from dem.jit.questions import question, register

SEPARATED = -1.0  # overlap of constituents that do not touch


class ContactGeometry(NamedTuple):
    """One contact: overlap (m, negative for a gap), normal (nx, ny), levers n1, t1, n2, t2 (m).

    t1 and t2 are zero for discs. radius: the effective radius R* (m) at the contact, where
    Shape.local_radius.
    """

    overlap: float
    nx: float
    ny: float
    n1: float
    t1: float
    n2: float
    t2: float
    radius: float


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
    # Numbers (constituents, s) of each outline beside cosine and sine, at most six. Read by contacts.
    # Wrong: other granules touch than are drawn.
    "outlines",
    # Function of a number of points: outlines (n, rings, points, 2) in m about the centre at angle
    # zero, closed: the first point is the last. Read by figures, films, export, report. Wrong:
    # pictures only.
    "polygons",
)


class Shape:
    """What Python asks of a shape beside MEMBERS, with what most shapes have in common."""

    __slots__ = ()

    # Whether an outline has a direction, so that a normal force may pass beside its centre; not of
    # discs. Read by contacts. Wrong: granules keep the outlines that they start with.
    oriented = True

    # Whether R* is computed at each contact, from radii of curvature there. Read by contacts. Wrong:
    # contacts are too stiff or too soft.
    local_radius = False

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
    def places(self) -> np.ndarray | None:
        """Centres (constituents, 2) in m from the granule's centre at angle zero; None where each
        granule is its own only constituent.

        Read by the integrator. Wrong: constituents are elsewhere.
        """
        return None

    def circle_outline(self, radius: float) -> tuple[float, ...]:
        """Row of `outlines` of a circle of a radius (m), such as a round solid.

        Read by contacts with solids. Wrong: the cylinder is none.
        """
        return (radius,)

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
        """These granules, then the others, which differ only in their sizes. Read by mixtures."""
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


def outline(shape, constituent, orientation):
    """The outline of a constituent; orientation (n, 2): cosine and sine of the granules."""
    numbers = tuple(shape.outlines[constituent].tolist())
    return (
        (*orientation[shape.owner[constituent]].tolist(), *numbers) if shape.oriented else numbers
    )


def circle(shape, radius):
    """The outline, in this shape's terms, of a circle of a radius (m)."""
    numbers = shape.circle_outline(radius)
    return (1.0, 0.0, *numbers) if shape.oriented else numbers


# Answered by each shape, with plain functions


@question
def support(shape, outline_1, nx, ny):
    """Where a constituent touches a straight line with outward normal n: (h, q, rho).

    h (m) is the distance of that line from the centre; q = dh/d(angle) (m) the coordinate along t
    of the point that touches it; rho the radius of curvature (m) there, where Shape.local_radius.
    """
    raise NotImplementedError


@question
def find_contact(shape, dx, dy, outline_1, outline_2, guess):
    """Contact of two constituents, without a branch: (ContactGeometry, converged).

    The overlap is negative where they do not touch; `guess` a normal near the right one, what the
    contact remembers. `converged` is False where the guess was too far off.
    """
    raise NotImplementedError


@question
def refine_normal(shape, dx, dy, outline_1, outline_2, guess):
    """A guess near enough for find_contact, from any other."""
    return guess


@question
def ellipse_contact(method, dx, dy, outline_1, outline_2, guess):
    """Contact of two ellipses by a method: (overlap, nx, ny, n1, t1, n2, t2), (rho1, rho2),
    converged, with rho the radii of curvature (m) there."""
    raise NotImplementedError


def solve_contact(shape, dx, dy, outline_1, outline_2, guess):
    """Contact of two constituents: the ContactGeometry, from any guess."""
    geometry, converged = find_contact(shape, dx, dy, outline_1, outline_2, guess)
    if not converged:
        guess = refine_normal(shape, dx, dy, outline_1, outline_2, guess)
        geometry, _ = find_contact(shape, dx, dy, outline_1, outline_2, guess)
    return geometry


SHAPE_QUESTIONS = support, find_contact, refine_normal
# as dem.jit.questions.register
answer = partial(register, questions=SHAPE_QUESTIONS, members=MEMBERS, usual=Shape)
answer_method = partial(register, questions=(ellipse_contact,), members=(), usual=object)


def is_shape(cls: type) -> bool:
    """Whether the kernels know a class as a shape."""
    return cls in support.answers


def is_alone(shape) -> bool:
    """Whether each granule of a shape is its own only constituent."""
    return shape.places is None


def sizes_of(shape) -> dict[str, np.ndarray]:
    """The arrays that granules are made of, such as sizes (n,) in m, by name."""
    return {name: size for name, size in shape._asdict().items() if isinstance(size, np.ndarray)}


def resized(shape, change):
    """Granules with other arrays: what a function returns for each array."""
    return shape._replace(**{name: change(size) for name, size in sizes_of(shape).items()})
