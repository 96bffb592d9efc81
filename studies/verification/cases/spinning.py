"""What do impacts of spinning spheres return?

Chung and Ooi's tests 6 (a plane), 7 (two alike, which spin in the same sense) and 8 (a sphere five
times as large and all but rigid: here the cylinder), all with v_n = 0.2 m/s, r = 0.1 m, mu 0.4, e
0.5 and spins of 0.175 to 22 rad/s, as other codes repeat them (PySPH). Above 3.5 mu (1 + e) v_n / r
= 4.2 rad/s the spheres slide all the time and get 0.12 m/s along the plane, at the cost of 3 rad/s;
below, the differential equation of the documented law says it.

The greatest overlap with the cylinder is that of R* = 5 r / 6, damped as in `restitution`.

Tolerance: as in `oblique` and `restitution`; the lever of a contact is shorter than the radius by
half of the overlap.
"""

import dem
from studies.verification.contact_law import Contact, damping_ratio, depth
from studies.verification.row import Row
from studies.verification.scenes import FINE, FRAMES, Sphere, impact, mindlin, scene_of, within

TITLE = "Spinning spheres"
SOURCE = "Chung and Ooi (2011), tests 6, 7 and 8; own ODE"
RADIUS, SPEED, FRICTION, RESTITUTION = 0.1, 0.2, 0.4, 0.5
ALLOY, NYLON, COPPER = (2700.0, 7e10, 0.33), (1000.0, 2.5e9, 0.4), (8900.0, 1.2e11, 0.35)
SPINS = (0.175, 0.5, 1.3, 2.0, 3.0, 4.0, 5.0, 9.0, 22.0)
HIGH = 10.0  # m, where the floor is far
LARGE = dem.Cylinder(10.0 * RADIUS, (0.0, HIGH))
TESTS = {
    "test 6, aluminium": (ALLOY, "plane"),
    "test 6, nylon": (NYLON, "plane"),
    "test 7, aluminium": (ALLOY, "pair"),
    "test 7, copper": (COPPER, "pair"),
    "test 8, aluminium": (ALLOY, "cylinder"),
}


def measure() -> list[Row]:
    rows = [row for name, test in TESTS.items() for spin in SPINS for row in hit(name, *test, spin)]
    return [*rows, pressed()]


def pressed() -> Row:
    """Greatest overlap with the cylinder, which depends on its radius too; the spins do not."""
    material = dem.Material(*ALLOY, RESTITUTION)
    scene = scene_of(Sphere([RADIUS]), material, FRICTION, solids=LARGE)
    scales = impact(material, 1, RADIUS * 5.0 / 6.0, scene.mass[0], SPEED)
    state = dem.State([[0.0, HIGH + 6.0 * RADIUS]], [[0.0, -SPEED]])
    run = dem.simulate(scene, state, 1.2 * scales.duration, frames=FRAMES)
    value = HIGH + 6.0 * RADIUS - run.position[:, 0, 1].min()
    right = scales.overlap * depth(damping_ratio(RESTITUTION))
    near = within(RESTITUTION, SPEED, scales, run.time_step) / RESTITUTION
    return Row("test 8, aluminium: greatest overlap", "m", value, right, near * right)


def hit(name, material, partner, spin):
    """Velocity along the plane and spin of a sphere afterwards."""
    material, count, more = dem.Material(*material, RESTITUTION), 1, {}
    place, curvature = [[0.0, RADIUS]], RADIUS
    if partner == "pair":
        count, curvature = 2, 0.5 * RADIUS
        place = [[0.0, HIGH + RADIUS], [0.0, HIGH - RADIUS]]
    if partner == "cylinder":
        curvature = RADIUS * 5.0 / 6.0
        more["solids"] = LARGE
        place = [[0.0, HIGH + 6.0 * RADIUS]]
    scene = scene_of(Sphere(count * [RADIUS]), material, FRICTION, **more)
    mass = scene.mass[0]
    scales = impact(material, count, curvature, mass / count, count * SPEED)
    state = dem.State(place, [[0.0, -SPEED], [0.0, SPEED]][:count], angular_velocity=count * [spin])
    run = dem.simulate(scene, state, 3.0 * scales.duration, step_fraction=FINE)
    slides = FRICTION * (1.0 + RESTITUTION) * SPEED
    near = within(RESTITUTION, count * SPEED, scales, run.time_step)
    tolerance = near + 0.5 * scales.overlap / RADIUS
    along, turning = -slides, spin - 2.5 * slides / RADIUS
    if spin * RADIUS < 3.5 * slides:
        law = Contact(
            mass,
            0.4 * mass * RADIUS**2,
            RADIUS,
            scales.stiffness,
            mindlin(material, count, curvature),
            damping_ratio(RESTITUTION),
            FRICTION,
            count,
        )
        along, _, turning = law.collide((0.0, -SPEED), spin)
        tolerance = near + 1e-3 * max(1.0, spin * RADIUS / slides)
    tolerance *= slides
    yield Row(f"{name}: velocity", "m/s", run.velocity[-1, 0, 0], along, tolerance, spin)
    value = run.angular_velocity[-1, 0]
    yield Row(f"{name}: spin", "rad/s", value, turning, 2.5 * tolerance / RADIUS, spin)
