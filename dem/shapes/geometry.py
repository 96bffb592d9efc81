"""What the kernels ask of a shape, answered by the file of that shape.

A granule is made of one or more convex *parts*; contacts are between parts. A shape is a
NamedTuple of arrays with one entry a granule; its class selects, while compiling, the answers to
the questions below. Conventions of a contact between parts 1 and 2:

* d = x2 - x1 (m); n is the unit normal from 1 to 2 and t = (-ny, nx) the tangent;
* overlap (m) is positive where the parts touch;
* the contact point lies midway between the two surfaces, on one line with both forces;
* levers (m) lead from the centres to it: n1 n + t1 t for part 1 and -n2 n + t2 t for part 2.
  A lever that a shape does not have is None, and so is all arithmetic with it.
"""

from numba.extending import overload

from dem.jit.compilation import INLINED, inlined
from dem.jit.optional import either, optional

SEPARATED = -1.0  # overlap of parts that do not touch


def _question(stub):
    """Turn a stub into a function whose compiled body is chosen by the class of its first argument."""
    answers = {}

    def choose(first, *rest):
        return answers.get(getattr(first, "instance_class", None))

    overload(stub, strict=False, jit_options=INLINED)(choose)
    stub.answers = answers
    return stub


@_question
def outline(shape, part, frame):
    """Numbers that describe one part in the present orientation, as its shape likes them."""


@_question
def support(shape, own, nx, ny):
    """Where a part touches a straight line with outward normal n: (h, q, radius).

    h (m) is the distance of that line from the centre; q = dh/d(angle) (m) the coordinate along t
    of the point that touches it, None for a disc; radius as in probe.
    """


@_question
def probe(shape, dx, dy, own, other, guess):
    """Contact of two parts, without a branch: (hit, sure).

    hit is (overlap, nx, ny, n1, t1, n2, t2, radius), the overlap negative where the parts do not
    touch; `guess` a normal near the right one, what the contact remembers (None for discs);
    `radius` the effective radius R* (m) at the contact, or None for the pair's constant. `sure`
    is False where the guess was too far off, None where that can not be.
    """


@_question
def seek(shape, dx, dy, own, other, guess):
    """A guess near enough for probe, from any other."""


@_question
def save(shape, own, values, at):
    """Write an outline to values[at], values[at + ROW] ... (dem.jit.lanes)."""


@_question
def load(shape, values, at):
    """The outline that save has written."""


@_question
def recall(shape, values, k):
    """The hit of lane k (dem.jit.lanes), as probe has found it."""


@_question
def round_outline(shape, radius):
    """Outline, in this shape's terms, of a circle (the cylinder)."""


@_question
def place(shape, bodies, frame, parts, low, high):
    """Motion of the parts of granules low to high from that of the granules."""


@_question
def collect(shape, part_force, frame, force, low, high):
    """Forces (N) and torques (N m) on granules low to high from those on their parts."""


@_question
def meet(method, dx, dy, own, other, guess):
    """Contact of two ellipses by one of the methods: as probe, with both radii of curvature last."""


@_question
def find_normal(method, dx, dy, own, other, guess):
    """A guess near enough for meet, from any other."""


@inlined
def touch(shape, dx, dy, own, other, guess):
    """Contact of two parts: the hit of probe, from any guess."""
    hit, sure = probe(shape, dx, dy, own, other, guess)
    return either(_again(sure, hit, shape, dx, dy, own, other, guess), hit)


@optional
def _again(sure, hit, shape, dx, dy, own, other, guess):
    if sure:
        return hit
    return probe(shape, dx, dy, own, other, seek(shape, dx, dy, own, other, guess))[0]


def register(shape_class, **answers):
    """Make a shape known to the kernels: one function a question, by name."""
    questions = globals()
    for name, answer in answers.items():
        questions[name].answers[shape_class] = answer
