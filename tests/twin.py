"""The model in plain numpy: what `dem.simulate` computes with a fixed time step, without its kernels.

Written from docs/explanation and from the docstrings of `dem.Scene`, `dem.Solid`, `dem.Wall`,
`dem.PrescribedMotion`, `dem.Drive`, `dem.Turn` and `dem.Held`; it knows no neighbour list, no blocks and no
threads. Of `dem` it uses public names, to read a scene. SI units, angles anticlockwise; n leads from body 1
to body 2 and t = (-ny, nx).

Every contact is one of two *constituents*, convex outlines about a centre: the discs of a dumbbell or a
clump, or the granule itself. All outlines are given by their support function.
"""

from copy import copy, deepcopy
from typing import NamedTuple

import numpy as np
from scipy.special import lambertw

import dem

DIRECTIONS = 2.0 * np.pi * np.arange(64) / 64  # rad, at which a search begins
NEWTON = 12  # steps, from there to rounding
EARLY = 1e-4  # m: a dashpot also sees who touches within half a step


def unit(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def dot(a, b):
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def turned(vector):
    """Vectors after a turn by a right angle: of n, this is t; times a spin, the velocity at an arm."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


# Outlines


class Outline(NamedTuple):
    """Convex outlines at an angle (rad): ellipses a, b (m), or rounded superellipses where c is a length (m)."""

    angle: np.ndarray
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray | None = None
    exponent: float = 2.0

    def of(self, index):
        """Those with these numbers."""
        c = None if self.c is None else self.c[index]
        return Outline(self.angle[index], self.a[index], self.b[index], c, self.exponent)


def support(outline, normal):
    """h (m): how far the tangent line with this outward normal is from the centre; h' = dh/d(angle) (m),
    which is the place of the point that touches it, along t; radius of curvature h + h'' (m)."""
    axis = unit(outline.angle)
    x, y = dot(axis, normal), cross(axis, normal)
    if outline.c is None:
        h = np.sqrt((outline.a * x) ** 2 + (outline.b * y) ** 2)
        return h, (outline.b**2 - outline.a**2) * x * y / h, (outline.a * outline.b) ** 2 / h**3
    q = outline.exponent / (outline.exponent - 1.0)  # h = S^(1/q), S = u^(q/2) + v^(q/2)
    s = ds = dds = 0.0
    for size, turn, sign in ((outline.a, x, -1.0), (outline.b, y, 1.0)):
        u = (size * turn) ** 2 + outline.c**2
        du, ddu = sign * 2.0 * size**2 * x * y, sign * 2.0 * size**2 * (x**2 - y**2)
        s += u ** (0.5 * q)
        ds += 0.5 * q * u ** (0.5 * q - 1.0) * du
        dds += 0.5 * q * u ** (0.5 * q - 1.0) * (ddu + (0.5 * q - 1.0) * du**2 / u)
    h = s ** (1.0 / q)
    rate = ds / (q * s)  # h'/h
    return h, h * rate, h + h * (rate**2 + (dds * s - ds**2) / (q * s**2))


class Touch(NamedTuple):
    """Contacts: overlap (m), negative or -inf for a gap; n; contact point (m) from the centre of 1;
    radii of curvature (m) there."""

    overlap: np.ndarray
    normal: np.ndarray
    point: np.ndarray
    curvature: tuple


def common_normal(d, one, two):
    """Contacts along the direction of the largest gap s(n) = n.d - h1(n) - h2(-n); d (m) leads from 1 to 2."""

    def gap(angle, d, one, two):
        n = unit(angle)
        (h1, q1, rho1), (h2, q2, rho2) = support(one, n), support(two, -n)
        s = dot(n, d) - h1 - h2
        return s, dot(turned(n), d) - q1 - q2, -s - rho1 - rho2, (h1, q1, rho1, rho2)

    index = np.arange(len(d))[:, None]
    angle = DIRECTIONS[gap(DIRECTIONS, d[:, None], one.of(index), two.of(index))[0].argmax(axis=1)]
    for _ in range(NEWTON):
        _, slope, bend, _ = gap(angle, d, one, two)
        angle = angle + np.clip(-slope / np.minimum(bend, -1e-300), -0.1, 0.1)
    s, _, _, (h1, q1, rho1, rho2) = gap(angle, d, one, two)
    n = unit(angle)
    return Touch(-s, n, (h1 + 0.5 * s)[:, None] * n + q1[:, None] * turned(n), (rho1, rho2))


def chord(d, one, two):
    """Contacts of ellipses as in the paper: the chord between those points of each that are deepest in the
    other; d (m) leads from 1 to 2."""

    def deepest(d, one, other):
        """Least G = (x/a)^2 + (y/b)^2 - 1 of the other on my outline; the point from my centre; rho there."""

        def point(u, d, one, other):
            axis, frame = unit(one.angle), unit(other.angle)
            along, up = one.a * np.cos(u), one.b * np.sin(u)
            x = along[..., None] * axis + up[..., None] * turned(axis)
            dx = -(one.a * np.sin(u))[..., None] * axis
            dx = dx + (one.b * np.cos(u))[..., None] * turned(axis)

            def scaled(w):  # in coordinates in which the other is a unit circle
                return np.stack([dot(frame, w) / other.a, cross(frame, w) / other.b], axis=-1)

            return x, scaled(x - d), scaled(dx), scaled(x)

        index = np.arange(len(d))[:, None]
        _, r, _, _ = point(DIRECTIONS, d[:, None], one.of(index), other.of(index))
        u = DIRECTIONS[dot(r, r).argmin(axis=1)]
        for _ in range(NEWTON):
            _, r, t, p = point(u, d, one, other)
            bend = np.maximum(dot(t, t) - dot(r, p), 0.1 * dot(t, t))
            u = u - np.clip(dot(r, t) / bend, -0.1, 0.1)
        x, r, _, _ = point(u, d, one, other)
        speed = (one.a * np.sin(u)) ** 2 + (one.b * np.cos(u)) ** 2
        return dot(r, r) - 1.0, x, speed**1.5 / (one.a * one.b)

    inside, x1, rho1 = deepest(d, one, two)
    _, x2, rho2 = deepest(-d, two, one)
    e = x1 - d - x2  # from the point of 2 inside 1 to that of 1 inside 2
    length = np.maximum(np.hypot(e[:, 0], e[:, 1]), 1e-300)
    overlap = np.where(inside < 0.0, length, -np.inf)
    return Touch(overlap, e / length[:, None], x1 - 0.5 * e, (rho1, rho2))


def polygon_touch(d, one, corners, radius):
    """Contacts with a convex polygon of these corners (k, 2) and a rounding (m), about a place that d (m)
    leads to: common normals of convex outlines, of which one has faces and corners.

    The gap s(n) is greatest at the normal of a face, or where that to one corner is greatest.
    """
    circle = Outline(*np.zeros((1, len(d))), *np.full((2, len(d)), radius))
    edges = np.roll(corners, -1, axis=0) - corners
    into = turned(edges) / np.hypot(*edges.T)[:, None]
    normals = [np.broadcast_to(n, d.shape) for n in into]
    normals += [common_normal(d + corner, one, circle).normal for corner in corners]

    def gap(n):
        return dot(n, d) - support(one, n)[0] - radius + (n @ corners.T).min(axis=-1)

    n = np.stack(normals)[np.argmax([gap(n) for n in normals], axis=0), np.arange(len(d))]
    (h, q, rho), s = support(one, n), gap(n)
    point = (h + 0.5 * s)[:, None] * n + q[:, None] * turned(n)
    return Touch(-s, n, point, (rho, np.full_like(rho, np.inf)))


def search_of(shape):
    """How granules of a shape find a contact."""
    by_chord = isinstance(getattr(shape, "contact", None), dem.GeometricPotential)
    return chord if by_chord else common_normal


class Granules:
    """What the granules of a scene are: constituents (p,) with their owner, offset from its centre (m, at
    angle zero) and radius R (m) in Hertz's law; mass (kg), inertia (kg m2) and reach (m) of each granule."""

    def __init__(self, scene):
        shape, self.local = scene.shape, False
        self.search = search_of(shape)
        self.owner, self.exponent = np.arange(scene.granules), 2.0
        self.offset, self.c = np.zeros((scene.granules, 2)), None
        if isinstance(shape, dem.Disc):
            self.a = self.b = self.radius = shape.radius
            area, gyration_squared, self.reach = np.pi * self.a**2, 0.5 * self.a**2, self.a
        elif isinstance(shape, dem.Dumbbell):
            self.owner = np.repeat(self.owner, 2)
            self.a = self.b = self.radius = shape.radius[self.owner]
            self.offset = self.a[:, None] * np.tile([[1.0, 0.0], [-1.0, 0.0]], (scene.granules, 1))
            area, gyration_squared = 2.0 * np.pi * shape.radius**2, 1.5 * shape.radius**2
            self.reach = self.a
        elif isinstance(shape, dem.Clump):
            self.owner, self.offset = shape.owner, shape.discs[:, :2]
            self.a = self.b = self.radius = self.reach = shape.discs[:, 2]
            area, gyration_squared = shape.area, shape.gyration_squared
        elif isinstance(shape, dem.Ellipse):
            self.a, self.b = shape.semi_major, shape.semi_minor
            self.radius, self.local = np.sqrt(self.a * self.b), shape.hertz_radius
            area, gyration_squared = np.pi * self.a * self.b, (self.a**2 + self.b**2) / 4.0
            self.reach = self.a
        else:
            self.a, self.b, self.c, self.exponent = shape
            angle = np.linspace(0.0, 2.0 * np.pi, 2048, endpoint=False)
            sizes = self.a[:, None], self.b[:, None], self.c[:, None]
            h, q, rho = support(Outline(np.zeros((1, 1)), *sizes, self.exponent), unit(angle))
            area = np.pi * (h * rho).mean(axis=1)
            gyration_squared = 0.5 * np.pi * ((h**2 + q**2) * h * rho).mean(axis=1) / area
            self.radius, self.reach = np.sqrt(area / np.pi), 1.01 * np.hypot(h, q).max(axis=1)
        density = np.array([material.density for material in scene.materials])
        self.mass = density[scene.species] * area * scene.thickness
        self.inertia = self.mass * gyration_squared

    def offsets(self, angle):
        """Of all constituents from the centres (m), for the angles of the granules."""
        axis = unit(angle)[self.owner]
        return self.offset[:, :1] * axis + self.offset[:, 1:] * turned(axis)

    def outline(self, angle):
        """Outlines of all constituents, for the angles of the granules."""
        return Outline(angle[self.owner], self.a, self.b, self.c, self.exponent)


# Forces


def damping_ratio(restitution):
    """zeta: bisection of e(zeta) of a contact that ends where its force is zero, under any law."""

    def bounce(zeta):
        if zeta < 1.0:
            psi = np.arcsin(zeta)
            return np.exp(-(np.pi - 2.0 * psi) * np.tan(psi))
        u = np.arccosh(zeta)
        return np.exp(-2.0 * u / np.tanh(u)) if u > 0.0 else np.exp(-2.0)

    low, high = 0.0, 1e4
    for _ in range(200 if restitution < 1.0 else 0):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if bounce(middle) > restitution else (low, middle)
    return low


def mean_root(overlap, change):
    """delta^(1/4) (m^0.25), of which a dashpot near touch sees the mean over the step; change (m): what the
    overlap changes in half of it. For delta beyond that the mean is a series.
    """
    one = 1.0 + np.clip(overlap / np.where(change > 0.0, change, 1.0), -1.0, None)
    ratio = np.where(overlap > change, change / np.where(overlap > 0.0, overlap, 1.0), 0.0)
    early = 0.4 * 0.4**3 * change * one**5  # ((2/5) (d + h)^(5/4) / h)^4
    late = overlap * (1.0 - ratio**2 * (0.125 + 0.0558 * ratio**2))
    near = np.where(overlap < change, early, late)
    far = ~((-change < overlap) & (overlap < 8.0 * change))
    return np.where(far, np.maximum(overlap, 0.0), near) ** 0.25


def spring_of(law, overlap, a):
    """What a law says of an overlap (m), over its constant K: force f = du/d(delta), the measure that
    tangential and rolling stiffness go with, y = sqrt(2 u) and dy/d(delta). a: the length of the law of lines (m)."""
    touch = overlap > 0.0
    d = np.where(touch, overlap, 1e-9)
    if isinstance(law, dem.Linear):
        values = d, 1.0, d, 1.0
    elif isinstance(law, dem.Line):  # d = p (ln(a/p) - 1), u = p^2/2 (ln(a/p) - 3/2)
        w = -lambertw(-np.e * d / a, -1).real  # ln(a/p) - 1
        p = d / w
        y = p * np.sqrt(w - 0.5)
        values = p, 1.0 / (w - 1.0), y, p / y
    else:
        values = d**1.5, d**0.5, np.sqrt(0.8) * d**1.25, np.sqrt(5.0) / 2.0 * d**0.25
    return [np.where(touch, value, 0.0) for value in values]


CONSTANTS = "young", "shear", "zeta", "friction", "share", "rolling", "rolling_damping"


class Law:
    """The force law of one kind of contact: E* and G* (Pa), damping ratio, coefficient of friction, share of
    the granule in 1/E*, coefficient of rolling resistance and its damping ratio.

    other: material of the partner, None if it is rigid; stiffness: of the tangential springs over Mindlin's;
    turns: whether contacts turn anything in the scene.
    """

    def __init__(
        self, scene, material, other, friction, stiffness=1.0, turns=True, rolling=(0.0, 0.0)
    ):
        self.elastic, self.thickness = scene.law, scene.thickness
        pair = [material] if other is None else [material, other]
        self.young = 1.0 / sum((1.0 - m.poisson_ratio**2) / m.young_modulus for m in pair)
        self.shear = stiffness / sum(
            2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.young_modulus for m in pair
        )
        restitution = np.prod([m.restitution for m in pair]) ** (1.0 / len(pair))
        self.zeta, self.friction, self.turns = damping_ratio(restitution), friction, turns
        self.share = self.young * (1.0 - material.poisson_ratio**2) / material.young_modulus
        self.rolling, self.rolling_damping = rolling

    def of(self, index):
        """Those of contacts with these numbers."""
        law = copy(self)
        for name in CONSTANTS:
            setattr(law, name, getattr(self, name)[index])
        return law

    def constants(self, radii):
        """K, what k_t is over G*/E* K and the measure, and the length a (m) of the law of lines."""
        one, two = radii[0], np.where(np.isfinite(radii[1]), radii[1], radii[0])
        radius = 1.0 / (1.0 / radii[0] + 1.0 / radii[1])
        a = 4.0 * one ** (2.0 * self.share) * two ** (2.0 - 2.0 * self.share) / radius
        if isinstance(self.elastic, dem.Linear):
            return self.elastic.stiffness or np.pi / 4.0 * self.young * self.thickness, 4.0, a
        if isinstance(self.elastic, dem.Line):
            return np.pi * self.young * self.thickness, 4.0, a
        return 4.0 / 3.0 * self.young * np.sqrt(radius), 6.0, a

    def push(self, memory, overlap, radii, mass, inertia, middle, rate, dt):
        """N and T (N) and M (N m) on body 2, and the memory afterwards: the spring (N), the overlap (m) and the
        moment (N m) of the rolling spring.

        radii, mass, inertia: of both bodies (m), m* (kg) and I* (kg m2); middle, rate: v_n and v_t (m/s) and the
        spin of 2 relative to 1 (rad/s) in the middle of the step of dt (s), and at its end. Contacts that do not
        touch remember nothing.
        """
        (spring, last, moment), (k, ratio, a) = memory, self.constants(radii)
        change = 0.5 * dt * np.abs(middle[0] if self.turns else rate[0])
        force, measure, _, root = spring_of(self.elastic, overlap, a)
        if isinstance(self.elastic, dem.Hertz):
            root = np.sqrt(5.0) / 2.0 * mean_root(overlap, change)
        else:
            near = (-change < overlap) & (overlap < 8.0 * change)
            late, early = (
                spring_of(self.elastic, end, a)[2] for end in (overlap + change, overlap - change)
            )
            root = np.where(near, (late - early) / np.where(near, 2.0 * change, 1.0), root)
        c = 2.0 * self.zeta * np.sqrt(mass * k)
        normal = np.maximum(k * force - c * root * rate[0], 0.0)
        old = spring_of(self.elastic, last, a)[1]
        scale = np.minimum(measure / np.where(old > 0.0, old, np.inf), 1.0)
        scale = np.where(old > 0.0, scale, 1.0)
        limit, stiffness = self.friction * normal, 0.5 * ratio * self.shear / self.young * k
        slid = stiffness * (scale * old + measure) * middle[1] * dt
        spring = np.clip(scale * spring - slid, -limit, limit)
        overlap = np.maximum(overlap, 0.0)
        dashpot = 2.0 * c * np.sqrt(self.shear / self.young) * root * rate[1]
        tangential = np.clip(spring - dashpot, -limit, limit)
        hertz = isinstance(
            self.elastic, dem.Hertz
        )  # k_n is 3/2 K sqrt(delta), else K times the measure
        arm = self.rolling / (1.0 / radii[0] + 1.0 / radii[1])
        limit, stiffness = arm * normal, 3.0 * arm**2 * k * (1.5 if hertz else 1.0)
        moment = scale * moment - 0.5 * stiffness * (scale * old + measure) * middle[2] * dt
        moment = np.clip(moment, -limit, limit)
        root = root * 2.0 / np.sqrt(5.0) if hertz else root
        dashpot = 2.0 * self.rolling_damping * np.sqrt(stiffness * inertia) * root * rate[2]
        total = np.clip(moment - dashpot, -limit, limit)
        return normal, tangential, total, (spring, overlap, moment)


# Motion


class Bodies:
    """Bodies that move: velocity (m/s) and spin (rad/s) are those of half steps, and their changes lead to
    the end of the step."""

    def __init__(self, position, velocity, angle, spin):
        self.position, self.velocity = np.array(position, float), np.array(velocity, float)
        self.angle, self.spin = np.array(angle, float), np.array(spin, float)
        self.change, self.spin_change = np.zeros_like(self.velocity), np.zeros_like(self.spin)

    def drift(self, dt):
        self.position += dt * self.velocity
        self.angle += dt * self.spin

    def velocity_at(self, index, arm):
        """Velocities (m/s) at arms (m) from the centres: in the middle of the step, and at its end."""
        across = turned(arm)
        middle = self.velocity[index] + self.spin[index][:, None] * across
        return middle, middle + self.change[index] + self.spin_change[index][:, None] * across


class Boundaries(Bodies):
    """Walls, solids or held groups: bodies with a motion and a spin each, and the force (N) and torque (N m) of
    contacts on them."""

    def __init__(self, motions, spins=None, position=None, angle=None):
        self.motions, count = motions, len(motions)
        self.spins = count * [0.0] if spins is None else spins
        position = np.zeros((count, 2)) if position is None else position
        angle = np.zeros(count) if angle is None else angle
        super().__init__(position, np.zeros((count, 2)), angle, np.zeros(count))
        self.force, self.torque = np.zeros((count, 2)), np.zeros(count)
        self.last, self.begin = np.zeros((count, 3)), np.column_stack([position, angle])
        for b, (motion, spin) in enumerate(zip(motions, self.spins, strict=True)):
            self.spin[b] = spin.spin if isinstance(spin, dem.Turn) else spin
            if not isinstance(motion, dem.PrescribedMotion):
                self.velocity[b] = motion.velocity if isinstance(motion, dem.Drive) else motion
        self.follow(0.0, 0.0)

    def follow(self, time, dt):
        """Those on a path: velocity of the middle of a step of dt (s), and the change to its end."""
        for b, path in enumerate(self.motions):
            if isinstance(path, dem.PrescribedMotion):
                rows = [path.velocity[:, 0], path.velocity[:, 1]]
                rows += [] if path.spin is None else [path.spin]
                middle, end = (np.array([np.interp(t, path.time, row) for row in rows])
                            for t in (time + 0.5 * dt, time + dt))  # fmt: skip
                self.velocity[b], self.change[b] = middle[:2], (end - middle)[:2]
                if path.spin is not None:
                    self.spin[b], self.spin_change[b] = middle[2], end[2] - middle[2]

    def kick(self, time, kick, dt):
        """Velocities for the next step of dt (s), after forces have acted for `kick` (s)."""
        self.follow(time, dt)
        middle = time + 0.5 * (dt - kick)
        gone = np.column_stack([self.position, self.angle]) - self.begin
        for b, (drive, turn) in enumerate(zip(self.motions, self.spins, strict=True)):
            for axis, push in enumerate(drive.force if isinstance(drive, dem.Drive) else ()):
                if push is not None:
                    ahead = way(drive.anchor, axis, time) - gone[b, axis]
                    pushed = load(push, middle) + drive.spring[axis] * ahead + self.force[b, axis]
                    self.velocity[b, axis], self.change[b, axis] = self.yielded(
                        b, axis, self.velocity[b, axis], pushed, drive.damping, drive.mass, kick, dt
                    )
            if isinstance(turn, dem.Turn):
                arm = turn.centre @ np.array([unit(self.angle[b]), turned(unit(self.angle[b]))])
                pushed = (
                    load(turn.torque, middle) + cross(arm, np.array(turn.weight)) + self.torque[b]
                )
                pushed += turn.spring * (turn.anchor * time - gone[b, 2])
                self.spin[b], self.spin_change[b] = self.yielded(
                    b, 2, self.spin[b], pushed, turn.damping, turn.inertia, kick, dt
                )

    def yielded(self, b, axis, velocity, pushed, damping, mass, kick, dt):
        """Velocity after a kick, and its change to the end of the step; of translation or rotation."""
        drag = 0.5 * kick * damping  # at the mean velocity of the kick
        new_velocity = (velocity * (mass - drag) + kick * pushed) / (mass + drag)
        acceleration = (pushed - damping * 0.5 * (velocity + new_velocity)) / mass
        change = 0.5 * dt * (2.0 * acceleration - self.last[b, axis])
        self.last[b, axis] = acceleration
        return new_velocity, change


def load(push, time):
    """A force (N) or a torque (N m) at a time (s)."""
    return np.interp(time, push.time, push.value) if isinstance(push, dem.PrescribedLoad) else push


def way(anchor, axis, time):
    """How far an anchor has gone along an axis (m) at a time (s)."""
    if not isinstance(anchor, dem.PrescribedMotion):
        return anchor[axis] * time
    moments = np.unique(np.clip([0.0, time, *anchor.time], 0.0, time))
    velocity = np.interp(moments, anchor.time, anchor.velocity[:, axis])
    return (0.5 * (velocity[1:] + velocity[:-1]) * np.diff(moments)).sum()


def lightness_of(motions):
    """Inverse masses (1/kg) of boundaries along x and y: zero along an axis whose velocity is given."""
    driven = [
        drive if isinstance(drive, dem.Drive) else dem.Drive((None, None), 1.0) for drive in motions
    ]
    return np.array(
        [[0.0 if push is None else 1.0 / drive.mass for push in drive.force] for drive in driven]
    ).reshape(-1, 2)


class Contacts:
    """All contacts that there could be of constituents `one` with `two`: constituents or boundaries.

    laws: of which `which` (k,) tells that of each; lightness (k, 2): the sum of inverse masses (1/kg) of both along
    x and y; where nothing yields, that of the granule; inertia (k,): I* (kg m2) about the contact; swing: 1/I
    (1/(kg m2)) of a boundary that turns, unless it is round.
    """

    def __init__(self, laws, kind, one, two, lightness, mass, inertia, swing=0.0):
        self.one, self.two, self.law = one, two, copy(laws[0])
        for name in CONSTANTS:
            setattr(self.law, name, np.array([getattr(law, name) for law in laws])[kind])
        self.lightness = np.where(lightness + swing > 0.0, lightness, 1.0 / mass[:, None])
        self.mass, self.swing = mass, swing
        self.inertia, self.memory = inertia, np.zeros((3, len(one)))


class Twin:
    """A scene in motion."""

    def __init__(self, scene, state):
        self.scene, self.granules = scene, Granules(scene)
        n, owner, mass = scene.granules, self.granules.owner, self.granules.mass
        self.bodies = Bodies(
            state.position, state.velocity, state.angle, state.angular_velocity
        )  # fmt: skip
        self.time, self.force, self.torque = 0.0, np.zeros((n, 2)), np.zeros(n)
        self.group = np.full(n, -1)
        for b, group in enumerate(scene.held):
            self.group[group.granules] = b
        self.held = Boundaries([h.motion for h in scene.held])
        self.start = self.bodies.position.copy()
        self.carry()
        self.planes, solids = scene.planes.copy(), scene.solids
        self.walls = Boundaries([wall.motion for wall in scene.walls])
        self.solids = Boundaries(
            [solid.velocity for solid in solids], [solid.spin for solid in solids],
            np.array([solid.position for solid in solids]).reshape(-1, 2),
            [solid.angle for solid in solids],
        )  # fmt: skip

        materials, species = scene.materials, scene.species[owner]
        rough = scene.friction or dem.Friction(0.0, 0.0, 0.0)
        table = np.broadcast_to(rough.granule, 2 * (len(materials),))
        friction = [
            [rough.wall if wall.friction is None else wall.friction for wall in scene.walls],
            [rough.solid if solid.friction is None else solid.friction for solid in solids],
        ]
        turns = max([table.max(), *friction[0], *friction[1]]) > 0.0
        turns |= not isinstance(scene.shape, dem.Disc) or not all(s.is_round for s in solids)

        rolling = scene.rolling or dem.Rolling(0.0, 0.0, 0.0)
        turns |= scene.rolling is not None

        def law(one, other, mu, mu_r):
            coefficients = mu_r, rolling.damping
            return Law(scene, one, other, mu, rough.stiffness, turns, coefficients)

        free = self.group < 0
        one, two = np.triu_indices(len(owner), 1)
        real = (owner[one] != owner[two]) & (free[owner[one]] | free[owner[two]])
        one, two = one[real], two[real]
        lightness = np.repeat(
            1.0 / mass[:, None], 2, axis=1
        )  # of held granules, that of their group
        lightness[~free] = lightness_of(self.held.motions)[self.group[~free]]
        lightness, mass = lightness[owner], mass[owner]
        inertia = self.granules.inertia[owner] + mass * self.granules.radius**2  # about the rim
        swing = np.where(free[owner], 1.0 / inertia, 0.0)
        laws = [
            law(first, second, table[a, b], rolling.granule)
            for a, first in enumerate(materials)
            for b, second in enumerate(materials)
        ]
        kind = len(materials) * species[one] + species[two]
        both = lightness[one] + lightness[two]
        self.pairs = Contacts(
            laws, kind, one, two, both, mass[one], 1.0 / (swing[one] + swing[two])
        )

        def around(bodies, moving, coefficients, mu_r):
            yields, every = lightness_of(moving.motions), np.arange(len(owner))
            for k, (body, mu) in enumerate(zip(bodies, coefficients, strict=True)):
                partner = body.material or scene.boundary
                laws = [law(material, partner, mu, mu_r) for material in materials]
                two, turn = np.full(len(owner), k), getattr(body, "spin", None)
                swing = isinstance(turn, dem.Turn) and not body.is_round and 1.0 / turn.inertia
                yield Contacts(
                    laws, species, every, two, lightness + yields[k], mass, inertia, float(swing)
                )

        self.at_walls = list(around(scene.walls, self.walls, friction[0], rolling.wall))
        self.at_solids = list(around(solids, self.solids, friction[1], rolling.solid))
        self.sums, self.kicked = self.no_sums(), 0.0
        self.find_forces(0.0)
        self.last = self.accelerations()
        for boundaries in (self.walls, self.solids, self.held):
            boundaries.kick(0.0, 0.0, 0.0)

    def no_sums(self):
        """Forces (N) and torques (N m) on boundaries, summed over time: nothing yet."""
        walls, solids = np.zeros(len(self.planes)), np.zeros((len(self.scene.solids), 2))
        return {"solid_force": solids, "solid_torque": solids[:, 0], "wall_force": walls,
                "wall_tangential_force": walls, "held_force": np.zeros((len(self.scene.held), 2))}  # fmt: skip

    def nearest(self, d):
        """Vectors d (m) to the nearest image beside periodic sides."""
        period = [np.inf if side is None else side for side in self.scene.periodic or (None, None)]
        return d - np.where(np.isfinite(period), period, 0.0) * np.rint(d / period)

    def carry(self):
        """Held granules keep their places in their groups."""
        for i in np.flatnonzero(self.group >= 0):
            b = self.group[i]
            self.bodies.position[i] = self.start[i] + self.held.position[b]
            self.bodies.velocity[i] = self.held.velocity[b]
            self.bodies.change[i] = self.held.change[b]

    def find_forces(self, dt):
        """Forces and torques on all granules at the end of a step of dt (s)."""
        self.force[:], self.torque[:] = 0.0, 0.0
        granules, owner = self.granules, self.granules.owner
        offset = granules.offsets(self.bodies.angle)
        centre, outline = self.bodies.position[owner] + offset, granules.outline(self.bodies.angle)

        def pair(one, two):
            d = self.nearest(centre[two] - centre[one])
            touch = granules.search(d, outline.of(one), outline.of(two))
            separation = d + offset[one] - offset[two]  # of the centre of granule 2 from that of 1
            return touch, separation, (granules.radius[one], granules.radius[two])

        def near_pairs(one, two):
            d = self.nearest(centre[two] - centre[one])
            return dot(d, d) < (granules.reach[one] + granules.reach[two] + EARLY) ** 2

        self.act(self.pairs, self.bodies, near_pairs, pair, dt)

        def wall(one, two):
            n = self.planes[two, :2]
            h, q, rho = support(outline.of(one), n)
            overlap = h + dot(n, centre[one]) - self.planes[two, 2]
            point = (h - 0.5 * overlap)[:, None] * n + q[:, None] * turned(n)
            touch = Touch(overlap, n, point, (rho, np.full_like(rho, np.inf)))
            return touch, 0.0 * n, (granules.radius[one], np.full_like(rho, np.inf))

        def near_walls(one, two):
            normal, offset = self.planes[two, :2], self.planes[two, 2]
            return dot(normal, centre[one]) + granules.reach[one] + EARLY > offset

        self.walls.force[:] = 0.0
        for contacts in self.at_walls:
            wall_of, force, _ = self.act(contacts, self.walls, near_walls, wall, dt)
            np.add.at(self.walls.force, wall_of, force)
        n = self.planes[:, :2]
        self.loads = {
            "wall_force": dot(n, self.walls.force),
            "wall_tangential_force": dot(turned(n), self.walls.force),
        }

        def near_solids(one, two):
            d = self.nearest(self.solids.position[two] - centre[one])
            reach = np.array([solid.radius for solid in self.scene.solids])[two]
            return dot(d, d) < (granules.reach[one] + reach + EARLY) ** 2

        def solid(one, two):
            d = self.nearest(self.solids.position[two] - centre[one])
            k = two[:1]
            body, angle = self.scene.solids[k[0]], self.solids.angle[k]
            touch, radius = self.touch_solid(d, outline.of(one), body.outline, angle)
            return touch, d + offset[one], (granules.radius[one], np.full(len(one), radius))

        self.solids.force[:], self.solids.torque[:] = 0.0, 0.0
        for contacts in self.at_solids:
            solid_of, force, torque = self.act(contacts, self.solids, near_solids, solid, dt)
            np.add.at(self.solids.force, solid_of, force)
            np.add.at(self.solids.torque, solid_of, torque)
        self.loads["solid_force"] = self.solids.force.copy()
        self.loads["solid_torque"] = self.solids.torque.copy()

        self.held.force[:] = 0.0
        member = self.group >= 0
        np.add.at(self.held.force, self.group[member], self.force[member])
        self.loads["held_force"] = self.held.force.copy()

    def touch_solid(self, d, one, outline, angle):
        """Contacts with a solid of an outline at an angle (1,) in rad, and its radius (m) in Hertz's law."""
        if isinstance(outline, dem.Polygon):
            axis = unit(angle)
            corners = outline.corners[:, :1] * axis + outline.corners[:, 1:] * turned(axis)
            return polygon_touch(d, one, corners, outline.radius), np.inf
        round_ = isinstance(outline, dem.Disc)
        a, b = 2 * [outline.radius] if round_ else (outline.semi_major, outline.semi_minor)
        two = Outline(*(np.repeat(value, len(d)) for value in (angle, a, b)))
        search = self.granules.search if round_ else search_of(outline)
        return search(d, one, two), np.sqrt(a * b)

    def act(self, contacts, partners, near, geometry, dt):
        """Forces of all contacts of a kind on the granules; returns for those that may touch the partner, the
        force (N) and the torque (N m) on it."""
        owner = self.granules.owner
        index = np.flatnonzero(near(contacts.one, contacts.two))
        one, two = contacts.one[index], contacts.two[index]
        if not len(index):
            contacts.memory = np.zeros((3, len(contacts.one)))
            return two, np.zeros((0, 2)), np.zeros(0)
        touch, away, radii = geometry(one, two)
        n, t = touch.normal, turned(touch.normal)
        radii = touch.curvature if self.granules.local else radii
        g = owner[one]
        h = owner[two] if partners is self.bodies else two
        offset = self.granules.offsets(self.bodies.angle)[one]
        arm = offset + touch.point  # from the centre of granule 1
        other = arm - away  # from that of body 2
        first, second = self.bodies.velocity_at(g, arm), partners.velocity_at(h, other)
        middle, end = second[0] - first[0], second[1] - first[1]
        spin = partners.spin[h] - self.bodies.spin[g]
        spins = spin, spin + partners.spin_change[h] - self.bodies.spin_change[g]
        memory = [values[index] for values in contacts.memory]
        # 1/m*, along the normal
        yields = (contacts.lightness[index] * n**2).sum(axis=1)
        yields += contacts.swing * cross(other, n) ** 2
        mass = np.divide(1.0, yields, where=yields > 0.0, out=contacts.mass[index])
        normal, tangential, moment, memory = contacts.law.of(index).push(
            memory, touch.overlap, radii, mass, contacts.inertia[index],
            (dot(middle, n), dot(middle, t), spins[0]), (dot(end, n), dot(end, t), spins[1]), dt,
        )  # fmt: skip
        contacts.memory = np.zeros((3, len(contacts.one)))
        contacts.memory[:, index] = memory
        force = normal[:, None] * n + tangential[:, None] * t
        np.add.at(self.force, g, -force)
        np.add.at(self.torque, g, -cross(arm, force) - moment)
        torque = cross(other, force) + moment
        if partners is self.bodies:
            np.add.at(self.force, h, force)
            np.add.at(self.torque, h, torque)
        return two, force, torque

    def accelerations(self):
        """Of all granules (m/s2), and of their spins (rad/s2)."""
        free, fall = self.group < 0, self.scene.gravity or (0.0, 0.0)
        acceleration = (self.force / self.granules.mass[:, None] + fall) * free[:, None]
        return acceleration, self.torque / self.granules.inertia * free

    def kick_and_drift(self, kick, dt):
        """Let the forces act for `kick` (s), then move for dt (s); velocities are then those of half a step.

        Dashpots see what they become at the full step, if accelerations go on as from the last to these.
        """
        bodies, accelerations, last = self.bodies, self.accelerations(), self.last
        bodies.velocity += kick * accelerations[0]
        bodies.spin += kick * accelerations[1]
        bodies.change, bodies.spin_change = (
            0.5 * dt * (2.0 * new - old) for new, old in zip(accelerations, last, strict=True)
        )
        self.last = accelerations
        bodies.drift(dt)
        for name, load in self.loads.items():
            self.sums[name] = self.sums[name] + kick * load
        for boundaries in (self.walls, self.held, self.solids):
            boundaries.kick(self.time, kick, dt)
            boundaries.drift(dt)
        self.planes[:, 2] += dt * dot(self.planes[:, :2], self.walls.velocity)
        self.carry()
        self.time += dt

    def advance(self, steps, dt):
        """Velocity Verlet: the first kick of all is a half one, and velocities stay those of half steps."""
        for _ in range(steps):
            self.kick_and_drift(self.kicked + 0.5 * dt, dt)
            self.find_forces(dt)
            self.kicked = 0.5 * dt

    def look(self):
        """A copy with the velocities of now; impulses begin again at zero."""
        twin = deepcopy(self)
        twin.kick_and_drift(self.kicked, 0.0)
        self.sums = {name: total - twin.sums[name] for name, total in self.sums.items()}
        return twin


def simulate(scene, state, dt, steps, frames=1):
    """The arrays of a `dem.Result` by name: after `steps` steps of dt (s), in equal intervals."""
    twin, rows = Twin(scene, state), []

    def keep(twin, forces):
        bodies = twin.bodies
        arrays = {"time": twin.time, "position": bodies.position, "velocity": bodies.velocity,
               "angle": bodies.angle, "angular_velocity": bodies.spin, "wall_offset": twin.planes[:, 2],
               "solid_position": twin.solids.position, "solid_angle": twin.solids.angle}  # fmt: skip
        rows.append({name: np.array(array) for name, array in (arrays | forces).items()})

    keep(twin, {name: np.nan * total for name, total in twin.no_sums().items()})
    for _ in range(frames):
        twin.advance(steps // frames, dt)
        view = twin.look()
        keep(view, {name: total / (steps // frames * dt) for name, total in view.sums.items()})
    return {name: np.array([frame[name] for frame in rows]) for name in rows[0]}
