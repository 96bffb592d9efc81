"""Slow and obvious counterparts of the kernels: loops over everything, vectors, plain numpy."""

import numpy as np
from scipy.optimize import minimize_scalar

from dem import Disc
from dem.contacts.force_law import damping_from_restitution


def effective(scene, boundary):
    """Effective Young's and shear moduli (Pa) of two granules, or of one and a rigid body."""
    m = scene.material
    shear = 0.5 * m.young_modulus / (1.0 + m.poisson_ratio)
    bodies = 1.0 if boundary else 2.0
    return (
        m.young_modulus / (1.0 - m.poisson_ratio**2) / bodies,
        shear / (2.0 - m.poisson_ratio) / bodies,
    )


def contact_force(scene, boundary, friction, radius, mass, overlap, n, velocity, dt):
    """Force (N) on the second of two bodies that have just met, moving at `velocity` (m/s)
    relative to the first; n leads from the first to the second."""
    young, shear = effective(scene, boundary)
    contact_radius = np.sqrt(radius * overlap)
    normal_stiffness = 2.0 * young * contact_radius
    tangential_stiffness = 8.0 * shear * contact_radius
    alpha = damping_from_restitution(scene.material.restitution)
    approach = -velocity @ n
    slip = velocity + approach * n
    elastic = 2.0 / 3.0 * normal_stiffness * overlap
    normal = elastic + alpha * np.sqrt(mass * normal_stiffness / 1.5) * approach
    normal = max(normal, 0.0)
    spring = cut(-tangential_stiffness * dt * slip, friction * normal)
    dashpot = -alpha * np.sqrt(mass * tangential_stiffness / 1.5) * slip
    return normal * n + cut(spring + dashpot, friction * normal)


def cut(vector, length):
    """The vector, shortened to the given length if it is longer."""
    size = np.hypot(*vector)
    return vector if size <= length else vector * (length / size)


def cross(a, b):
    """Component out of the plane of a vector product."""
    return a[0] * b[1] - a[1] * b[0]


def across(spin, arm):
    """Velocity of a point at `arm` from the centre of a body that spins."""
    return spin * np.array([-arm[1], arm[0]])


def discs_of(scene, state):
    """Owner, radius and centre of every disc of a bed of discs or dumbbells."""
    for g, r in enumerate(scene.shape.radius):
        if isinstance(scene.shape, Disc):
            yield g, r, state.position[g]
        else:
            axis = r * np.array([np.cos(state.angle[g]), np.sin(state.angle[g])])
            yield g, r, state.position[g] + axis
            yield g, r, state.position[g] - axis


def bed_forces(scene, state, dt):
    """Forces (n, 2) and torques (n,) of discs or dumbbells that have slipped for dt (s)."""
    discs = list(discs_of(scene, state))
    force, torque = np.zeros_like(state.position), np.zeros(len(state.position))
    mu = scene.friction

    def velocity_at(g, point):
        return state.velocity[g] + across(state.angular_velocity[g], point - state.position[g])

    def act(g, point, f):
        force[g] += f
        torque[g] += cross(point - state.position[g], f)

    for one, (g, r, x) in enumerate(discs):
        for h, s, y in discs[one + 1 :]:
            n, distance = (y - x) / np.hypot(*(y - x)), np.hypot(*(y - x))
            if g == h or distance >= r + s:
                continue
            overlap = r + s - distance
            point = x + (r - 0.5 * overlap) * n
            radius = 1.0 / (1.0 / r + 1.0 / s)
            mass = 1.0 / (1.0 / scene.mass[g] + 1.0 / scene.mass[h])
            relative = velocity_at(h, point) - velocity_at(g, point)
            f = contact_force(scene, False, mu.granule, radius, mass, overlap, n, relative, dt)
            act(h, point, f)
            act(g, point, -f)
        for nx, ny, offset in [] if scene.walls is None else scene.walls:
            n = np.array([nx, ny])
            overlap = r - (offset - n @ x)
            if overlap > 0.0:
                point = x + (r - 0.5 * overlap) * n
                relative = -velocity_at(g, point)
                act(g, point, -contact_force(
                    scene, True, mu.wall, r, scene.mass[g], overlap, n, relative, dt
                ))  # fmt: skip
        if scene.cylinder is not None:
            s, y = 0.5 * scene.cylinder.diameter, np.array(scene.cylinder.position)
            distance = np.hypot(*(y - x))
            if distance < r + s:
                n, overlap = (y - x) / distance, r + s - distance
                point = x + (r - 0.5 * overlap) * n
                relative = np.array(scene.cylinder.velocity) - velocity_at(g, point)
                radius = 1.0 / (1.0 / r + 1.0 / s)
                act(g, point, -contact_force(
                    scene, True, mu.cylinder, radius, scene.mass[g], overlap, n, relative, dt
                ))  # fmt: skip
    return force, torque


def outline(ellipse, points):
    """Points (points, 2) of the outline of (cos, sin, a, b) about its centre."""
    c, s, a, b = ellipse
    t = 2.0 * np.pi * np.arange(points) / points
    return np.column_stack([a * np.cos(t), b * np.sin(t)]) @ np.array([[c, s], [-s, c]])


def potential(ellipse, points):
    """(x/a)^2 + (y/b)^2 - 1 in the ellipse's own axes: negative inside."""
    c, s, a, b = ellipse
    x, y = points[..., 0], points[..., 1]
    return ((c * x + s * y) / a) ** 2 + ((c * y - s * x) / b) ** 2 - 1.0


def parting(d, first, second, points=2000):
    """Least translation that parts the sampled outlines of two ellipses, the second at d.

    Returns its length (m) and the angle of its direction (rad).
    """

    def depth(angle, mine, theirs):
        n = np.array([np.cos(angle), np.sin(angle)])
        return (mine @ n).max(axis=0) - ((theirs + d) @ n).min(axis=0)

    coarse, fine = ((outline(first, k), outline(second, k)) for k in (points, 10 * points))
    angles = np.linspace(0.0, 2.0 * np.pi, 361)
    best = angles[np.argmin(depth(angles, *coarse))]
    bounds = best - 2.0 * angles[1], best + 2.0 * angles[1]
    found = minimize_scalar(depth, bounds=bounds, args=fine, method="bounded",
                            options={"xatol": 1e-9})  # fmt: skip
    return found.fun, found.x
