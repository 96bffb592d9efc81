"""Collisions of pairs, and with walls and solids, against closed forms and conservation laws."""

import numpy as np
import pytest
from collisions import (
    APART,
    ELASTIC,
    HEAVY,
    LEAST,
    ROUGH,
    SLIPPERY,
    energy,
    followed,
    gains,
    head_on,
    leaving,
    stated_force,
    volley,
)
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from twin import Law, damping_ratio

import dem

SHAPES = {
    "disc": dem.Disc,
    "dumbbell": dem.Dumbbell,
    "ellipse": lambda r: dem.Ellipse(1.5 * r, r),
    "superellipse": lambda r: dem.Superellipse(1.5 * r, r, 0.3 * r, 3.0),
}
# That of lines with what the energy of a bed that resists rolling needs too, so that one kernel serves.
LAWS = {
    "hertz": {"law": dem.Hertz()},
    "linear": {"law": dem.Linear()},
    "stiff": {"law": dem.Linear(stiffness=1e7)},
    "line": {"law": dem.Line(), "rolling": dem.Rolling()},
}


def sizes(n, seed=0):
    return 1e-3 * np.random.default_rng(seed).uniform(0.5, 1.0, n)


# Along the line of centres


def meetings(form, law, restitution, count=24):
    """Granules of many sizes that meet, head-on and at many speeds, one of their own material, one of another, a
    wall and a solid that are rigid, and a wall and a solid of the other material.

    Returns scene, state, unit vectors (6, count, 2) of approach, and the coefficients of restitution (6, 1) that are
    asked for.
    """
    rng, soft = np.random.default_rng(0), dem.Material(restitution=restitution)
    hard = dem.Material(3e3, 2e11, 0.25, 0.8)
    shape = form(1e-3 * rng.uniform(0.5, 1.0, 8 * count))
    reach = np.ptp(shape.polygons(65)[..., 0], axis=(1, 2)).reshape(8, count) / 2.0
    speed = 10.0 ** rng.uniform(-1.0, 0.5, (6, count))
    gap, row = speed * rng.uniform(0.0, 2e-6, (6, count)), 8e-3 * np.arange(count)
    turn = 2.0 * np.pi * np.arange(count) / count
    out, rim = np.stack([np.cos(turn), np.sin(turn)], axis=-1), 0.1  # m
    place = np.zeros((8, count, 2))
    place[..., 1], right = row, np.array([[1.0], [-1.0]])
    place[1::6, :, 1] += 4e-3  # those of another material, beside the others
    place[:2, :, 0], place[6:, :, 0] = -gap[:2] - reach[:2], reach[6:]
    place[2:4, :, 0] = right * (0.5 - gap[2:4] - reach[2:4])
    solids = [
        dem.Cylinder(2.0 * rim, (0.0, -0.2)),
        dem.Cylinder(2.0 * rim, (0.0, 0.6), material=hard),
    ]
    for k, solid in zip((4, 5), solids, strict=True):
        place[k] = solid.position + (rim + gap[k] + reach[k])[:, None] * out
    along = np.zeros((6, count, 2))
    along[:4, :, 0], along[4:] = np.array([1.0, 1.0, 1.0, -1.0])[:, None], -out
    velocity, angle, kind = np.zeros((8, count, 2)), np.zeros((8, count)), np.zeros((8, count), int)
    velocity[:6], angle[4:6], kind[7] = speed[..., None] * along, turn, 1
    walls = [dem.Wall([1.0, 0.0, 0.5]), dem.Wall([-1.0, 0.0, 0.5], material=hard)]
    scene = dem.Scene(
        shape, [soft, hard], SLIPPERY, walls, solids, thickness=1e-3, species=kind.ravel(), **law
    )
    state = dem.State(place.reshape(-1, 2), velocity.reshape(-1, 2), angle.ravel())
    both = np.sqrt(restitution * hard.restitution)
    asked = np.array([restitution, both, restitution, both, restitution, both])[:, None]
    return scene, state, along, asked


def restitutions(form, law, restitution, step_fraction=None):
    """Speed of separation over that of approach (6, count) in the collisions of `meetings`, over what is asked for."""
    scene, state, along, asked = meetings(form, law, restitution)
    options = {"step_fraction": step_fraction} if step_fraction else {}
    run = dem.Simulation(scene, state, ledger="rolling" in law, **options)
    while run.time < 6e-5 or len(run.contacts().granule):
        run.advance(6e-5)
    before, after = (s.velocity.reshape(8, -1, 2) for s in (state, run.state))
    after[:2] -= after[6:]
    return -(after[:6] * along).sum(axis=-1) / (before[:6] * along).sum(axis=-1) / asked


@pytest.mark.quick
@pytest.mark.parametrize(
    ("kind", "law", "restitution", "step_fraction", "most"),
    [("disc", law, e, None, 1e-2) for law in ("hertz", "line") for e in (0.9, 0.5, 0.1)]
    + [("disc", law, e, None, 2e-2) for law in ("linear", "stiff") for e in (0.9, 0.5, 0.1)]
    + [("disc", law, 0.5, 0.02, 3e-3) for law in ("hertz", "linear", "line")]
    + [("disc", "hertz", e, None, 4e-2) for e in (0.02, 0.01, 0.001)]
    + [(kind, "hertz", 0.3, None, 1e-2) for kind in SHAPES],
)
def test_restitution_is_as_asked(kind, law, restitution, step_fraction, most):
    """At any speed, size and phase of a step, and in the mean over these nearer. Between two materials it is the
    geometric mean of both; a body without a material has no say."""
    error = restitutions(SHAPES[kind], LAWS[law], restitution, step_fraction) - 1.0
    assert np.abs(error).max() < most
    assert np.abs(error.mean(axis=1)).max() < 0.3 * most


@pytest.mark.quick
def test_elastic_collisions_at_the_default_step_err_by_a_tenth_of_a_per_cent():
    """The energy, in the root mean square over many collisions, and in the worst of them, as docs/scope.md says."""
    gain = restitutions(dem.Disc, LAWS["hertz"], ELASTIC.restitution)[::2] ** 2 - 1.0
    assert np.sqrt((gain**2).mean()) < 0.002
    assert np.abs(gain).max() < 0.005


def test_published_benchmark_of_two_spheres():
    """Two spheres of 10 mm at +-10 m/s reach the published overlap, force and contact time."""
    radius = 10e-3
    material = dem.Material(2800.0, 48e9, 0.2, ELASTIC.restitution)
    sphere = LEAST | {"material": material, "thickness": 4.0 * radius / 3.0}
    scene, state = head_on([[radius, radius]], [20.0], **sphere)
    time, overlap, speed = followed(scene, state, 5e-5, 2000)
    assert_allclose(scene.mass[0], 2800.0 * 4.0 / 3.0 * np.pi * radius**3)
    force = -0.5 * scene.mass[0] * np.gradient(speed[:, 0], time)
    assert_allclose(overlap.max(), 2.7411e-4, rtol=1e-4)
    assert_allclose(force.max(), 10696.9, rtol=1e-4)
    assert_allclose(leaving(time, overlap[:, 0]), 4.0339e-5, rtol=1e-4)


@pytest.mark.parametrize("law", LAWS)
def test_elastic_collisions_follow_the_force_of_the_books(law):
    """Contact time and greatest overlap of unequal discs, by the equation of motion of one body."""
    radii, speeds = 1e-3 * np.array([[1.0, 1.0], [1.0, 3.0], [2.0, 0.3]]), np.array([1.0, 0.3, 3.0])
    options = LAWS[law] | LEAST | {"material": ELASTIC, "thickness": 1e-3}
    scene, state = head_on(radii, speeds, **options)
    expected = []
    for radius, mass, speed in zip(radii, scene.mass.reshape(-1, 2), speeds, strict=True):
        inertia = 1.0 / np.sum(1.0 / mass)

        def motion(t, y, radius=radius, inertia=inertia):
            push = stated_force(scene.law, y[0], radius, 2 * [ELASTIC], 1e-3) if y[0] > 0.0 else 0.0
            return y[1], -push / inertia

        turn, leave = (lambda t, y: y[1]), (lambda t, y: y[0] - 1e-13)
        turn.direction = leave.direction = -1.0
        path = solve_ivp(motion, (0.0, 1e-4), (0.0, speed), events=[turn, leave], rtol=1e-8, atol=1e-13,
                         max_step=1e-6)  # fmt: skip
        expected.append([path.t_events[1][0], path.y_events[0][0][0]])
    time, overlap, _ = followed(
        scene, state, 1.1 * np.max(expected, axis=0)[0], 2000, law == "line"
    )
    found = [[leaving(time, o), o.max()] for o in overlap.T]
    assert_allclose(found, expected, rtol=1e-3)


@pytest.mark.parametrize(
    ("restitution", "depth", "order"),
    [(ELASTIC.restitution, 0.0, 2.0), (0.5, 3e-6, 2.0), (0.5, 0.0, 1.25)],
)
def test_order_of_convergence(restitution, depth, order):
    """Second order in the time step, elastic and damped; an impact with a dashpot is of order 5/4, because its force
    begins like the fourth root of time."""
    material = dem.Material(restitution=restitution)
    scene, state = head_on([[1e-3, 1e-3]], [1.0], -depth, material=material, **ROUGH)
    law, mass = Law(scene, material, material, 0.0), 0.5 * scene.mass[0]

    def motion(t, y):
        new, rate = (0.0, 0.0, 0.0), (-y[1], 0.0, 0.0)
        return y[1], -law.push(new, y[0], (1e-3, 1e-3), mass, 1.0, rate, rate, 0.0)[0] / mass

    duration, steps = 6e-5, 2 ** np.arange(6, 11)
    exact = solve_ivp(motion, (0.0, duration), (depth, 1.0), "DOP853", rtol=1e-12, atol=1e-16).y
    final = [followed(scene, state, duration, n) for n in steps]
    for k in (1, 2):
        error = np.abs([f[k][-1, 0] / exact[k - 1, -1] - 1.0 for f in final])
        assert_allclose(-np.polyfit(np.log(steps), np.log(error), 1)[0], order, atol=0.12)


@pytest.mark.quick
@pytest.mark.parametrize("restitution", [0.9, 0.5, 0.1])
def test_a_collision_off_the_centre_returns_less_than_restitution(restitution):
    """Its damping ratio is sqrt(m*/m_c) times that of a central one; m_c is the mass at the contact.

    Two dumbbells side by side, the upper disc of one against the lower disc of the other: m*/m_c = 5/3.
    """
    a = 0.5e-3
    state = dem.State(
        [[0.0, 0.0], [2.0 * a, 2.0 * a]], [[0.5, 0.0], [-0.5, 0.0]], [0.5 * np.pi] * 2
    )
    scene = dem.Scene(dem.Dumbbell([a, a]), dem.Material(restitution=restitution), **HEAVY, **LEAST)
    result = dem.simulate(scene, state, 1e-4, step_fraction=0.01).state
    speed = result.velocity[:, 0] - a * result.angular_velocity * [1.0, -1.0]
    ratio = damping_ratio(speed[1] - speed[0]) / damping_ratio(restitution)
    assert_allclose(ratio, np.sqrt(5.0 / 3.0), rtol=1e-2)


# Along the tangent


@pytest.mark.quick
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("partner", ["granule", "wall", "solid"])
def test_oblique_impact_in_gross_sliding(partner, sign):
    """The impulse (1 + e) m* v_n along the normal, and mu times that against the slip, from every side: velocities and
    spins of discs of unequal size that both spin, and what walls and solids feel."""
    e, speed, time, radius, other = 0.5, 0.1, 4e-5, 1e-3, 2.5e-3
    mu = {"granule": 0.1, "wall": 0.2, "solid": 0.3}[partner]
    slip, spin, spin_2 = 0.3 * sign, 100.0 * sign, 0.0 if partner == "wall" else 40.0 * sign
    for angle in (0.3, 2.0, 4.4):
        n = np.array([np.cos(angle), np.sin(angle)])
        t = np.array([-n[1], n[0]])
        place, velocity, both = [-(radius + 1e-7) * n], [speed * n + slip * t], [radius]
        around = dict(APART)
        if partner == "granule":
            place, velocity, both = [*place, other * n], [*velocity, [0.0, 0.0]], [radius, other]
        elif partner == "wall":
            around = {"walls": [[*n, 0.0]], "solids": dem.Cylinder(radius, -n)}
        else:
            around["solids"] = dem.Cylinder(2.0 * other, other * n, spin=spin_2)
        scene = dem.Scene(
            dem.Disc(both), dem.Material(restitution=e), dem.Friction(0.1, 0.2, 0.3),
            thickness=1e-3, **around,
        )  # fmt: skip
        start = dem.State(place, velocity, None, [spin, spin_2][: len(both)])
        run = dem.simulate(scene, start, time, step_fraction=0.02)
        pull = (1.0 + e) * speed / np.sum(1.0 / scene.mass)  # N s
        push = pull * (n + sign * mu * t)  # on the partner
        after, spins = velocity[0] - push / scene.mass[0], np.array([spin, spin_2])
        assert_allclose(run.state.velocity[0], after, atol=4e-3 * speed)
        lost = sign * mu * pull * np.array(both) / scene.inertia
        assert_allclose(
            run.state.angular_velocity, spins[: len(both)] - lost, atol=5e-3 * abs(lost[0])
        )
        if partner == "granule":
            assert_allclose(run.state.velocity[1], push / scene.mass[1], atol=4e-3 * speed)
        elif partner == "wall":
            felt = run.wall_force[-1, 0], run.wall_tangential_force[-1, 0]
            assert_allclose(time * np.array(felt), [pull, sign * mu * pull], rtol=5e-3)
        else:
            assert_allclose(time * run.solid_force[-1, 0], push, atol=5e-3 * pull)
            torque = -sign * mu * pull * other
            assert_allclose(time * run.solid_torque[-1, 0], torque, rtol=5e-3)


def floor(**properties):
    """Scene of one disc of 5 mm above a floor, with gravity."""
    material = dem.Material(density=2500.0, young_modulus=1e8, restitution=0.1)
    return dem.Scene(
        dem.Disc(np.array([5e-3])), material, walls=dem.box(10.0, 1.0), gravity=(0.0, -9.81),
        thickness=1e-2, **properties,
    )  # fmt: skip


@pytest.mark.quick
def test_sliding_disc_ends_rolling():
    """A disc that slides on a floor slows down by mu g and rolls on at 2/3 of its speed."""
    mu, speed, gravity = 0.3, 0.1, 9.81
    scene = floor(friction=dem.Friction(mu, mu, mu))
    state = dem.simulate(scene, dem.State([[1.0, 5e-3]]), 0.02, time_step=1e-5).state
    rolling = speed / (3.0 * mu * gravity)
    state.velocity[0, 0] = speed
    run = dem.simulate(scene, state, 2.0 * rolling, time_step=1e-5, frames=40)
    expected = np.maximum(speed - mu * gravity * run.time, 2.0 / 3.0 * speed)
    assert_allclose(run.velocity[:, 0, 0], expected, atol=2e-3 * speed)
    assert_allclose(run.angular_velocity[-1] * 5e-3, -run.velocity[-1, 0, 0], rtol=2e-3)


def test_disc_at_rest_on_a_floor_stays_there():
    """A disc laid on a floor under gravity does not jump, at the step that the library chooses."""
    run = dem.simulate(floor(friction=SLIPPERY), dem.State([[1.0, 5e-3]]), 0.1, frames=9)
    assert np.abs(run.position - run.position[0]).max() < 1e-5


# Momentum and energy


@pytest.mark.quick
@pytest.mark.parametrize("kind", [*SHAPES, "disc that resists rolling"])
def test_momentum_and_angular_momentum_are_conserved(kind):
    """A swarm that collides with friction and damping keeps both momenta to rounding, after whole steps."""
    rng = np.random.default_rng(3)
    n, pitch = 36, 3.1e-3
    grid = pitch * np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0)), -1).reshape(-1, 2)
    velocity = rng.normal(size=(n, 2)) - 200.0 * (grid - grid.mean(axis=0))
    state = dem.State(grid, velocity, rng.uniform(0.0, 7.0, n), rng.normal(scale=500.0, size=n))
    rolling = dem.Rolling(granule=0.5) if "rolling" in kind else None
    scene = dem.Scene(SHAPES[kind.split()[0]](sizes(n)), rolling=rolling, **HEAVY, **ROUGH)
    result = dem.simulate(scene, state, 8e-3, time_step=8e-3 / 2**14).state
    m = scene.mass[:, None]

    def angular(s):
        (x, y), (vx, vy) = s.position.T, s.velocity.T
        return scene.mass * (x * vy - y * vx) + scene.inertia * s.angular_velocity

    assert energy(scene, result).sum() < 0.6 * energy(scene, state).sum()
    total = np.abs(m * velocity).sum()
    assert_allclose((m * (result.velocity - velocity)).sum(axis=0), 0.0, atol=3e-12 * total)
    total = np.abs(angular(state)).sum()
    assert abs((angular(result) - angular(state)).sum()) < 3e-12 * total


@pytest.mark.quick
@pytest.mark.parametrize(
    ("kind", "restitution"), [("disc", ELASTIC.restitution), *((k, 0.9) for k in SHAPES)]
)
def test_oblique_impact_makes_no_energy(kind, restitution):
    """Random frictional impacts, most of them grazing, never gain kinetic energy."""
    material = dem.Material(restitution=restitution)
    gain = gains(*volley(SHAPES[kind](sizes(400)), 1, 1000.0, material=material, **ROUGH), 0.05)
    assert gain.max() < 1e-5
    assert gain.min() < -0.3  # some do lose much


def test_the_contact_normal_of_the_paper_does_not_conserve_energy():
    """The paper's contact normal, the chord of the two deepest points, does not conserve energy."""
    r = sizes(400)
    root = np.sqrt(np.resize([1.125, 1.25, 1.375, 2.0], r.size))
    shape = dem.Ellipse(r * root, r / root, dem.GeometricPotential())
    gain = gains(*volley(shape, 2, 300.0, material=ELASTIC, **APART), 0.0125)
    assert gain.max() > 0.1 and np.sqrt(np.mean(gain**2)) > 0.01
