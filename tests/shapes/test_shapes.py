"""What a shape must answer: every shape of the registry does, and wrong ones are told what is wrong."""

import itertools
import re
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from beds import section_of
from collisions import APART, ELASTIC, LEAST, gains, volley
from egg import Egg, support

import dem
from dem.jit.compilation import inlined
from dem.shapes import KINDS, protocol, smooth, superellipse

SIZES = 1e-3 * np.array([0.5, 0.7, 1.0])


def granules(kind, diameters=SIZES):
    return KINDS[kind].shape.of_size(diameters, section_of(kind).form)


RIGHT = {kind: lambda kind=kind: granules(kind) for kind in KINDS} | {
    "egg": lambda: Egg(SIZES),
    "loaded egg": lambda: Egg(SIZES, 0.05, 0.3),
    "one granule": lambda: dem.Superellipse.of_size(SIZES[:1], 1.5),
    "box": lambda: dem.Superellipse.of_size(SIZES, 3.0, 20.0, 0.01),
    "star": lambda: dem.Superellipse.of_size(SIZES, 1.0, 1.2, 0.1),
    "needle": lambda: dem.Ellipse.of_size(SIZES, 10.0),
}


@pytest.mark.parametrize("name", RIGHT)
def test_shapes_keep_the_laws(name):
    """All shapes of the registry, long and nearly flat ones and one without symmetry are accepted."""
    dem.check_shape(RIGHT[name]())


class Stranger(NamedTuple):
    """A class that no kernel knows."""

    radius: np.ndarray


NUMBERS = itertools.count()


def new(function):
    """A class of smooth shapes with a support function (r, ), which kernels are compiled for."""
    kind = NamedTuple(f"Wrong{next(NUMBERS)}", [("radius", np.ndarray)])  # noqa: UP014
    return smooth.smooth(function)(kind)


@cache
def round_shapes():
    return new(round_support)


def like_round(patch, **members):
    """The round shape with some members of its own: of one class, which compiles once."""
    for name, member in members.items():
        patch.setattr(round_shapes(), name, member)
    return round_shapes()(SIZES)


def oval(slope=1.0, curvature=1.0, shift=0.0):
    """Support function of an ellipse of 3:2, a = r, with faults: factors, and a centre off by shift."""

    def support(nx, ny, sizes):
        (r,) = sizes
        h = r * np.sqrt(nx * nx + 4.0 / 9.0 * ny * ny)
        q, rho = -5.0 / 9.0 * r * r * nx * ny / h, 4.0 / 9.0 * r**4 / h**3
        return h + shift * r * nx, slope * q - shift * r * ny, curvature * rho

    return support


round_support = oval()


def dented(nx, ny, sizes):
    (r,) = sizes
    cosine, sine = nx * (4.0 * nx * nx - 3.0), ny * (3.0 - 4.0 * ny * ny)
    return r * (1.0 + 0.2 * cosine), -0.6 * r * sine, r * (1.0 - 1.6 * cosine)


def stadium(nx, ny, sizes):
    (r,) = sizes
    return r * (1.0 + np.abs(nx)), -r * np.sign(nx) * ny, r + 0.0 * nx


find_contact = inlined(smooth.find_contact)


def no_second_lever(shape, dx, dy, one, other, guess):
    c, converged = find_contact(shape, dx, dy, one, other, guess)
    return c._replace(t2=0.0), converged


def no_lever(shape, dx, dy, one, other, guess):
    c, converged = find_contact(shape, dx, dy, one, other, guess)
    return c._replace(t1=0.0, t2=0.0), converged


def no_overlap(shape, dx, dy, one, other, guess):
    c, converged = find_contact(shape, dx, dy, one, other, guess)
    return c._replace(overlap=-1.0), converged


def biased_normal(shape, dx, dy, one, other, guess):
    c, converged = find_contact(shape, dx, dy, one, other, guess)
    return c._replace(nx=c.nx - 0.05 * c.ny, ny=c.ny + 0.05 * c.nx), converged


USUAL = {
    function.__name__: function
    for function in (
        smooth.outline,
        smooth.circle,
        smooth.support,
        smooth.refine_normal,
        smooth.find_contact,
    )
}


@cache
def with_answer(**answer):
    """The round shape with another answer to one question of the kernels."""
    shape = new(round_support)(SIZES)
    protocol.answer(type(shape), **USUAL | answer)
    return shape


def larger_circle(shape, radius):
    return (1.0, 0.0, 0.0, 1.1 * radius) + (1.0,)


def half(patch, name):
    """The round shape with half of one of its properties."""
    whole = getattr(smooth.Smooth, name).fget
    return like_round(patch, **{name: property(lambda shape: 0.5 * whole(shape))})


def narrow(patch):
    """The round shape whose of_size takes no account of its aspect ratio."""
    shape = round_shapes()
    patch.setattr(shape, "of_size", lambda size, ratio: shape(0.5 * size), raising=False)
    return round_shapes()(SIZES)


WRONG = {
    "area is": lambda patch: half(patch, "area"),
    "of_size gives a granule of 3.490659e-07 m2": narrow,
    "gyration_squared is": lambda patch: half(patch, "gyration_squared"),
    "bounding_radius is": lambda patch: half(patch, "bounding_radius"),
    "normal_lever is": lambda patch: half(patch, "normal_lever"),
    "normal_bend is 0": lambda patch: half(patch, "normal_bend"),
    "area is [nan nan nan]; it must be 3 finite": lambda patch: like_round(
        patch, area=property(lambda shape: np.nan * shape.radius)
    ),
    "area is 1.0; it must be 3 finite": lambda patch: like_round(
        patch, area=property(lambda shape: 1.0)
    ),
    "grow by the power 2": lambda patch: like_round(patch, scaled=lambda shape, factor: shape),
    "not convex": lambda patch: new(dented)(SIZES),
    "centre of mass": lambda patch: new(oval(shift=0.1))(SIZES),
    "its outline has": lambda patch: new(oval(curvature=0.9))(SIZES),
    "differ": lambda patch: like_round(
        patch, polygons=lambda s, points=64: smooth.Smooth.polygons(s, points)[..., ::-1] * [1, -1]
    ),
    "q of support": lambda patch: new(oval(slope=1.05))(SIZES),
    "area is 1.2854e-06 m2": lambda patch: new(stadium)(SIZES),
    "area is 0.00153479 m2": lambda patch: dem.Superellipse(SIZES, SIZES, 1e-9 * SIZES),
    "levers of a contact": lambda patch: with_answer(find_contact=no_lever),
    "swapping them changes it": lambda patch: with_answer(find_contact=no_second_lever),
    "nearly coincide must touch": lambda patch: with_answer(find_contact=no_overlap),
    "normal of a contact": lambda patch: with_answer(find_contact=biased_normal),
    "circle": lambda patch: with_answer(circle=larger_circle),
    "bounces would make or lose energy": lambda patch: dem.Ellipse.of_size(
        SIZES, 1.5, "geometric_potential"
    ),
    "semi_minor must not exceed": lambda patch: dem.Ellipse(SIZES, 2.0 * SIZES),
}


@pytest.mark.parametrize("sentence", WRONG)
def test_what_breaks_a_law_is_told(monkeypatch, sentence):
    """A wrong answer is named in a sentence that begins with the shape."""
    shape = WRONG[sentence](monkeypatch)
    with pytest.raises(dem.InputError) as error:
        dem.check_shape(shape)
    assert sentence in str(error.value) and str(error.value).endswith(".")
    assert str(error.value).startswith(type(shape).__name__)


def lumps():
    """A class of shapes with sizes (radius, lump, shift) in m; each granule has its own."""

    def support(nx, ny, sizes):
        r, e, c = sizes
        cosine, sine = nx * (4.0 * nx * nx - 3.0), ny * (3.0 - 4.0 * ny * ny)
        return r + e * cosine + c * nx, -3.0 * e * sine - c * ny, r - 8.0 * e * cosine

    fields = [(name, np.ndarray) for name in ("radius", "lump", "shift")]
    return smooth.smooth(support)(NamedTuple("Lumps", fields))


LUMPS = cache(lumps)
MANY = np.full(9, 1e-3)


def one(value, of=MANY):
    """Sizes (m) of which only the sixth is not zero."""
    return np.where(np.arange(len(of)) == 5, value * of, 0.0)


def test_a_granule_that_is_not_convex_is_found_among_many():
    """check_shape and Scene name it, whichever it is."""
    shape = LUMPS()(MANY, one(0.2), 0.0 * MANY)
    for check in (dem.check_shape, dem.Scene):
        with pytest.raises(
            dem.InputError, match="granule 5 is not convex: its radius of curvature"
        ):
            check(shape)


def test_a_granule_off_its_centre_is_found_among_many_and_the_remedy_helps():
    """The sentence says what to subtract from the support function; the shape is then accepted."""
    shape = LUMPS()(MANY, 0.05 * MANY, one(0.1))
    with pytest.raises(dem.InputError, match=r"the centre of mass is .* subtract c_x nx") as error:
        dem.check_shape(shape)
    x, y = map(float, re.search(r"c = \((\S+), (\S+)\) m", str(error.value)).groups())
    assert abs(y) < 1e-9
    dem.check_shape(shape._replace(shift=shape.shift - one(1.0) / 1e-3 * x))


@pytest.mark.parametrize("value", [3, None, dem.Disc, Stranger(SIZES)])
def test_only_granules_are_checked(value):
    """What is no granules at all, a class too, is refused as by Scene."""
    with pytest.raises(dem.InputError, match=r"^shape is .*; it must be granules of a shape, such"):
        dem.check_shape(value)


@pytest.mark.parametrize("missing", ["find_contact", "support", "circle"])
def test_an_open_question_is_refused_when_the_shape_is_made_known(missing):
    """A class that leaves a question of the kernels open is refused, with both names."""
    answers = [
        getattr(smooth, name)
        for name in ("outline", "circle", "support", "find_contact")
        if name != missing
    ]
    with pytest.raises(dem.InputError, match=f"it must answer the questions .*{missing}.* of the"):
        protocol.answer(Stranger, *answers)
    assert not protocol.is_shape(Stranger)


def test_a_missing_member_is_refused_when_the_shape_is_made_known():
    """A class that lacks what Python asks is refused, with both names."""
    answers = smooth.outline, smooth.circle, smooth.support, smooth.find_contact
    with pytest.raises(dem.InputError, match="Stranger has no area"):
        protocol.answer(Stranger, *answers)
    assert not protocol.is_shape(Stranger)


def test_a_name_is_given_once():
    """Two classes of one name would run each other's machine code: the second one is refused."""
    twin = NamedTuple("Egg", [("radius", np.ndarray)])  # noqa: UP014
    with pytest.raises(dem.InputError, match="Egg is the name of a class"):
        smooth.smooth(support)(twin)


def test_an_unknown_question_is_refused():
    """An answer to what no kernel asks is refused, with both names."""
    with pytest.raises(dem.InputError, match="Egg answers colour; it must answer"):
        protocol.answer(Egg, colour=support)


def test_a_superellipse_of_exponent_two_without_rounding_is_an_ellipse():
    """Support, slope and curvature of the limit are those of the ellipse."""
    angle = np.linspace(0.1, 6.0, 50)
    nx, ny = np.cos(angle), np.sin(angle)
    h = np.sqrt(4.0 * nx**2 + ny**2)
    values = superellipse.support(nx, ny, (2.0, 1.0, 0.0, 2.0))
    np.testing.assert_allclose(values, [h, -3.0 * nx * ny / h, 4.0 / h**3], rtol=1e-12, atol=1e-14)


BOUNCING = {
    "ellipse": lambda d: dem.Ellipse.of_size(d, 1.5),
    "superellipse": lambda d: dem.Superellipse.of_size(d, 1.5),
    "box": lambda d: dem.Superellipse.of_size(d, 1.5, 10.0, 0.05),
    "egg": lambda d: Egg(0.5 * d),
}


@pytest.mark.parametrize("name", BOUNCING)
def test_elastic_bounces_keep_energy_alike(name):
    """The error of energy falls with the step at one order, and is as small for all smooth shapes."""
    sizes = 1e-3 * np.random.default_rng(0).uniform(1.0, 2.0, 200)
    scene, state = volley(BOUNCING[name](sizes), 1, 500.0, material=ELASTIC, **LEAST)
    steps = np.array([0.04, 0.02, 0.01])
    error = [np.median(np.abs(gains(scene, state, step))) for step in steps]
    assert np.polyfit(np.log(steps), np.log(error), 1)[0] > 2.0
    assert error[-1] < 3e-8


def test_a_granule_turns_about_its_centre_of_mass_wherever_its_outline_is():
    """An elastic hit on a floor gives a loaded disc the momentum and the spin of a rigid body whose lever is the
    distance of its centre of mass from the line of the force."""
    disc, speed, lever = Egg(np.array([1e-3]), 0.0, 0.3), 1.0, 0.3e-3
    scene = dem.Scene(disc, ELASTIC, **LEAST | {"walls": [[0.0, -1.0, 0.0], *APART["walls"][:3]]})
    start = dem.State([[0.0, 1.01e-3]], velocity=[[0.0, -speed]])
    result = dem.simulate(scene, start, 5e-5).state
    inertia = disc.gyration_squared[0] / lever**2  # over mass and lever squared
    spin = 2.0 * speed / lever / (1.0 + inertia)
    assert result.velocity[0, 1] == pytest.approx(
        speed * (inertia - 1.0) / (inertia + 1.0), rel=1e-3
    )
    assert result.angular_velocity[0] == pytest.approx(spin, rel=1e-3)
    assert abs(result.velocity[0, 0]) < 1e-9 * speed


def test_granules_without_symmetry_hand_their_momentum_to_walls_and_solids():
    """Of eggs that fly about in a box: what they lose, walls and a cylinder get (Newton's third law)."""
    rng, time = np.random.default_rng(1), 1e-3
    position = 1e-3 * (np.stack(np.meshgrid(*2 * [np.arange(8)]), -1).reshape(-1, 2) + 0.5)
    cylinder = dem.Cylinder(1.5e-3, (4e-3, 2e-3), (0.0, 4.0))
    position = position[np.hypot(*(position - cylinder.position).T) > 2.0 * cylinder.radius]
    n = len(position)
    friction = dem.Friction(wall=0.0)  # because a Result has only the normal forces of walls
    scene = dem.Scene(
        Egg(1e-3 * rng.uniform(0.4, 0.46, n)),
        friction=friction,
        walls=dem.box(8e-3, 8e-3),
        solids=cylinder,
        thickness=1e-3,
    )
    start = dem.State(position, rng.normal(size=(n, 2)), rng.uniform(0.0, 2.0 * np.pi, n))
    run = dem.simulate(scene, start, time)
    assert run.solid_force[1, 0, 1] < 0.0 and (run.wall_force[1] > 0.0).all()
    assert np.abs(run.angular_velocity[1]).max() > 0.0
    impulse = time * (run.solid_force[1, 0] + run.wall_force[1] @ scene.planes[:, :2])
    gain = scene.mass @ (run.state.velocity - start.velocity)
    np.testing.assert_allclose(-impulse, gain, atol=1e-3 * time * run.wall_force[1].sum())
