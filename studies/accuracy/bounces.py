"""Total energy over thousands of frictionless elastic bounces, by method of contact.

A few granules fly about in a box without friction or damping. Energy is conserved, except for the
error of the integrator and for forces that are not the gradient of a potential. It is read when
nothing touches, because then all of it is kinetic.
"""

from typing import NamedTuple

import numpy as np

from dem.base.errors import RunError
from dem.contacts.force_law import effective_modulus, impact_overlap
from dem.dynamics.simulation import Simulation
from dem.scene import Material, Scene, State, box
from dem.shapes.disc import Disc
from dem.shapes.ellipse import Ellipse
from studies.common.timing import one_core

SEED = 2
MATERIAL = Material(restitution=1.0)
DIAMETER = 1e-3  # m, mean volume diameter; nothing depends on it
SPREAD = 0.2  # volume diameters are within this share of their mean
SIDE = 3.6  # of the box, in mean diameters: room for four granules of aspect ratio 2
OVERLAP = 0.05  # of a head-on collision at the first rms speed, over the radius: as in the beds
DURATION = 2.943  # of a Hertz contact, times greatest overlap over speed of impact
LOOKS = 4  # at the granules during such a contact
AT_ONCE = 200  # looks: some ten bounces
BURST = 100.0  # times the first energy: far enough
DISC = "disc"
ELLIPSES = {  # method: what Ellipse takes, beside the sizes
    "common normal": ("common_normal", "volume"),
    "common normal, local curvature": ("common_normal", "local"),
    "geometric potential": ("geometric_potential", "volume"),
    "geometric potential, local curvature": ("geometric_potential", "local"),
}


class Plan(NamedTuple):
    """bounces between granules (not with walls), read at `points` numbers; runs of each kind from
    different starts; aspect ratios; time steps in a contact at the first rms speed."""

    bounces: int = 10_000
    points: int = 21
    runs: int = 2
    ratios: tuple[float, ...] = (1.0, 1.125, 1.375, 2.0)
    steps: int = 200
    methods: tuple[str, ...] = (DISC, *ELLIPSES)

    @property
    def numbers(self):
        """Numbers of bounces at which the energy is read, evenly spaced in the logarithm."""
        return np.unique(np.geomspace(1.0, self.bounces, self.points).round().astype(int))


USUAL = Plan()
SMOKE = Plan(bounces=30, points=5, runs=1, ratios=(1.0, 1.375), methods=("common normal",))


def first_speed() -> tuple[float, float]:
    """Speed (m/s) of the head-on collision of two like discs that overlaps by OVERLAP, and how
    long it lasts (s)."""
    radius = 0.5 * DIAMETER
    mass = MATERIAL.density * np.pi * radius**2 * DIAMETER
    modulus = effective_modulus(MATERIAL, MATERIAL)
    at_one = impact_overlap(0.5 * mass, 0.5 * radius, modulus, 1.0)
    speed = (OVERLAP * radius / at_one) ** 1.25  # the overlap grows with speed^(4/5)
    return speed, DURATION * OVERLAP * radius / speed


def make_scene(method: str, ratio: float, seed: int) -> tuple[Scene, State]:
    """Four granules in a box, at the corners of a square, with random sizes, angles, velocities."""
    rng = np.random.default_rng((SEED, seed))
    sizes = DIAMETER * (1.0 + SPREAD * rng.uniform(-1.0, 1.0, 4))
    shape = (
        Disc(0.5 * sizes) if method == DISC else Ellipse.of_size(sizes, ratio, *ELLIPSES[method])
    )
    side = SIDE * DIAMETER
    scene = Scene(shape, MATERIAL, walls=box(side, side), thickness=DIAMETER)
    corners = 0.25 * side * np.array([[1.0, 1.0], [3.0, 1.0], [1.0, 3.0], [3.0, 3.0]])
    velocity = first_speed()[0] / np.sqrt(2.0) * rng.normal(size=(4, 2))
    return scene, State(corners, velocity, rng.uniform(0.0, 2.0 * np.pi, 4))


def follow(scene: Scene, state: State, steps: int, numbers):
    """Energy over the first, after each of the `numbers` of bounces, and the bounces until it burst.

    steps: time steps in a contact at the first speed. A bounce is counted when two granules that
    were apart touch at the next look. NaN: energies after it has burst; the latter if it has not.
    """
    duration = first_speed()[1]
    run = Simulation(scene, state, time_step=duration / steps, allow_unstable=True)
    energy = np.full(len(numbers), np.nan)
    first, touching, done, filled = run.diagnose().kinetic_energy, 0, 0, 0
    while filled < len(numbers):
        try:
            record = run.record(duration / LOOKS, AT_ONCE)
        except RunError:  # the granules have become too fast for the time step
            return energy, done
        pairs = np.rint(0.5 * scene.granules * record.coordination_number).astype(int)
        count = done + np.cumsum(np.maximum(np.diff(pairs, prepend=touching), 0))
        touching, done = pairs[-1], count[-1]
        free = record.max_overlap == 0.0  # walls included
        share, count = record.kinetic_energy[free] / first, count[free]
        burst = np.flatnonzero(share > BURST)
        last = burst[0] if burst.size else len(share)
        for at in np.searchsorted(count[:last], numbers[filled:]):
            if at < last:
                energy[filled], filled = share[at], filled + 1
        if burst.size:
            return energy, count[last]
    return energy, np.nan


def measure(plan: Plan = USUAL, progress=lambda done: None) -> dict:
    """Variables of studies.accuracy.layout; progress gets the share done.

    Discs have aspect ratio 1, ellipses all others; NaN for the rest. The first time, kernels of all
    methods are compiled.
    """
    numbers = plan.numbers
    energy = np.full((len(plan.methods), len(plan.ratios), plan.runs, len(numbers)), np.nan)
    burst = np.full(energy.shape[:3], np.nan)
    with one_core():
        for m, r, k in np.ndindex(burst.shape):
            if (plan.methods[m] == DISC) == (plan.ratios[r] == 1.0):
                scene, state = make_scene(plan.methods[m], plan.ratios[r], k)
                energy[m, r, k], burst[m, r, k] = follow(scene, state, plan.steps, numbers)
            done = np.ravel_multi_index((m, r, k), burst.shape) + 1
            progress(done / burst.size)
    return {
        "bounce_method": np.array(plan.methods),
        "bounce_aspect_ratio": np.array(plan.ratios),
        "bounce_number": numbers,
        "bounce_energy": energy,
        "bounce_burst": burst,
        "bounce_steps": plan.steps,
    }
