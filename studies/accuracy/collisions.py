"""The scenes of the study of time steps: single collisions, and the bed that the cylinder enters.

A Collision and a Bed answer the same questions: how to start, what to read, what is right.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dem.base.errors import InputError
from dem.contacts.force_law import effective_modulus
from dem.dynamics.simulation import Simulation
from dem.dynamics.skin import SKIN
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene
from dem.scene import Friction, Material, Scene, State
from dem.shapes.disc import Disc
from dem.shapes.ellipse import Ellipse
from dem.sweep.config import Sweep

OVERLAP = 0.05  # of the radius, in an elastic head-on collision: between light touch and the bed
SLANT = 0.25  # tangential over normal speed: for mu = 0.3 contacts stick at first and slide at last
TILT = 0.6, -0.9  # rad, of the two ellipses to the contact normal
ASPECT_RATIO = 1.375
SPACING = 8.0  # bounding radii between pairs
LASTS = 2  # times the duration of an elastic head-on collision: all pairs have met and parted
SEED = 1  # of the beds
STROKE = 5e-5  # m, of the cylinder: before chaos
HEAD_ON, DAMPED, OBLIQUE, ELLIPSES = (
    "head-on, elastic", "head-on, damped", "oblique, friction", "ellipses, elastic",
)  # fmt: skip
DISCS, DUMBBELLS, BARE = "bed of discs", "bed of dumbbells", "bed, no friction, no damping"


def error(found: np.ndarray, right: np.ndarray) -> float:
    """Root of the mean squared distance between rows of what `read` returned and the right ones."""
    return float(np.sqrt(np.mean(np.sum((found - right) ** 2, axis=-1))))


@dataclass(frozen=True)
class Collision:
    """Two granules of one kind, at the moment when they touch.

    properties: of the Scene. position, velocity (2, 2), m and m/s; angle (2,), rad; they do not
    spin before. exact (2, 3): what to read afterwards, or None if no closed form is known.
    skin: of the neighbour lists, which hold throughout.
    """

    name: str
    shape: Disc | Ellipse
    properties: dict
    position: np.ndarray
    velocity: np.ndarray
    angle: np.ndarray
    exact: np.ndarray | None = None
    skin: float = 1.0

    @property
    def speed(self) -> float:
        """Speed (m/s) at which they meet."""
        return float(np.linalg.norm(self.velocity[1] - self.velocity[0]))

    @property
    def contact_time(self) -> float:
        """Duration (s) of an elastic head-on collision of discs like these (Hertz).

        2.868 (m*^2 / (R* E*^2 v))^(1/5): Johnson (1985), Contact Mechanics, section 11.4.
        """
        mass, radius, modulus = _effective(self.shape, self.properties)
        return 2.868266 * (mass**2 / (radius * modulus**2 * self.speed)) ** 0.2

    @property
    def duration(self) -> float:
        """Time (s) after which they have parted."""
        return LASTS * self.contact_time

    @cached_property
    def critical_step(self) -> float:
        """Bound on the critical time step (s) of dem.dynamics.diagnostics."""
        return Simulation(*self.start(0.0, 1)).diagnose().critical_time_step

    def steps(self, time_step: float, share: float = 0.0) -> tuple[int, float]:
        """Number and length (s) of steps near a wanted one.

        The error of a contact depends as much on where in a step it begins and ends.
        `start` spreads the beginnings; a share from 0 to 1 of one more step a contact, the ends.
        """
        count = self.duration / time_step + LASTS * share
        return int(np.ceil(count)), self.duration / count

    def start(self, time_step: float, pairs: int) -> tuple[Scene, State]:
        """Pairs far from each other, from half to all but half a step (s) before their touch."""
        before = (np.arange(pairs) + 0.5) / pairs * time_step
        pitch, row = SPACING * self.shape.bounding_radius.max(), int(np.ceil(np.sqrt(pairs)))
        place = pitch * np.column_stack(np.divmod(np.arange(pairs), row))
        position = place[:, None] + self.position - before[:, None, None] * self.velocity
        sizes = {k: v for k, v in self.shape._asdict().items() if isinstance(v, np.ndarray)}
        shape = self.shape._replace(**{k: np.tile(v, pairs) for k, v in sizes.items()})
        velocity, angle = np.tile(self.velocity, (pairs, 1)), np.tile(self.angle, pairs)
        return Scene(shape, **self.properties), State(position.reshape(-1, 2), velocity, angle)

    def read(self, scene: Scene, start: State, end: State) -> np.ndarray:
        """Velocity and spin of each granule over the speed of impact, (pairs, 2, 3).

        A spin counts with the radius of gyration: its square is then one of energy.
        """
        spin = np.sqrt(scene.shape.gyration_squared) * end.angular_velocity
        return np.column_stack([end.velocity, spin]).reshape(-1, 2, 3) / self.speed


class Bed:
    """The start of the cylinder's stroke through the first bed of a kind of granule in the sweep.

    bare: without friction and damping.
    """

    exact, skin, contact_time = None, SKIN, np.nan

    def __init__(self, name: str, sweep: Sweep, kind: str, bare: bool = False):
        cases = [c for c in sweep.cases.values() if sweep.shapes[c.shape].kind == kind]
        if not cases:
            raise InputError(f"the configuration has no case of a {kind}; the study needs one.")
        replicate = sweep.replicate(cases[0].shape, cases[0].density, SEED)
        packed = make_bed(replicate)
        scene = make_scene(replicate, packed)
        elastic = replace(scene.material, restitution=1.0)
        self.name = name
        self.scene = replace(scene, material=elastic, friction=None) if bare else scene
        self._state = packed.state
        self.duration = STROKE / sweep.cylinder.velocity
        self.critical_step = Simulation(self.scene, self._state).diagnose().critical_time_step

    def steps(self, time_step: float, share: float = 0.0) -> tuple[int, float]:
        """Number and length (s) of steps near a wanted one that end with the stroke."""
        count = max(1, round(self.duration / time_step))
        return count, self.duration / count

    def start(self, time_step: float, pairs: int) -> tuple[Scene, State]:
        """The bed at rest, for any step."""
        return self.scene, self._state

    def read(self, scene: Scene, start: State, end: State) -> np.ndarray:
        """Displacement of each granule over the cylinder's, (n, 2)."""
        return (end.position - start.position) / STROKE


def collisions(sweep: Sweep) -> list[Collision]:
    """Of granules of the size and the material of the sweep's first case."""
    case = next(iter(sweep.cases.values()))
    size = np.full(2, sweep.shapes[case.shape].diameter)
    material = Material(case.density, **sweep.material.model_dump(exclude={"thickness"}))
    damped = {
        "material": material, "friction": Friction(**sweep.friction.model_dump()),
        "thickness": float(sweep.material.thickness or size[0]),
    }  # fmt: skip
    elastic = damped | {"material": replace(material, restitution=1.0)}
    bare = elastic | {"friction": None}
    disc, ellipse = Disc.of_size(size), Ellipse.of_size(size, ASPECT_RATIO)
    speed = impact_speed(disc, bare, OVERLAP)
    return [
        discs(HEAD_ON, disc, bare, speed, 0.0, 1.0),
        discs(DAMPED, disc, damped, speed, 0.0, material.restitution),
        discs(OBLIQUE, disc, elastic, speed, SLANT, None),
        ellipses(ELLIPSES, ellipse, bare, speed),
    ]


def scenes(sweep: Sweep) -> list[Collision | Bed]:
    """All of the study."""
    beds = (
        Bed(DISCS, sweep, "disc"),
        Bed(DUMBBELLS, sweep, "dumbbell"),
        Bed(BARE, sweep, "disc", True),
    )
    return [*collisions(sweep), *beds]


def discs(name, shape, properties, speed, slant, restitution) -> Collision:
    """Two discs that meet along x at a speed (m/s) and slide at slant times it.

    With a coefficient of restitution the velocities afterwards are known: so much of the speed.
    """
    half = np.array([[-0.5, 0.0], [0.5, 0.0]])
    velocity = 0.5 * speed * np.array([[1.0, slant], [-1.0, -slant]])
    exact = None if restitution is None else np.pad(restitution * half, ((0, 0), (0, 1)))
    diameter = 2.0 * shape.radius[0]
    return Collision(name, shape, properties, diameter * half, velocity, np.zeros(2), exact)


def ellipses(name, shape, properties, speed) -> Collision:
    """Two tilted ellipses that meet along their common normal, x, off their centres."""
    axes = np.array([shape.semi_major[0], shape.semi_minor[0]])
    touch = []
    for tilt, normal in zip(TILT, (1.0, -1.0), strict=True):
        turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
        own = normal * turn[0]  # the normal in the frame of the ellipse
        touch.append(turn @ (axes**2 * own / np.linalg.norm(axes * own)))
    half = 0.5 * (touch[0] - touch[1])
    velocity = 0.5 * speed * np.array([[1.0, 0.0], [-1.0, 0.0]])
    return Collision(name, shape, properties, np.array([-half, half]), velocity, np.array(TILT))


def impact_speed(shape, properties, overlap: float) -> float:
    """Speed (m/s) of the elastic head-on collision with this greatest overlap over the radius.

    The inverse of dem.contacts.force_law.impact_overlap.
    """
    mass, radius, modulus = _effective(shape, properties)
    depth = overlap * shape.constituent_radius[0]
    return float(np.sqrt(16.0 * modulus * np.sqrt(radius) * depth**2.5 / (15.0 * mass)))


def _effective(shape, properties):
    """m* (kg), R* (m) and E* (Pa) of two equal granules."""
    mass, material = Scene(shape, **properties).mass[0], properties["material"]
    return 0.5 * mass, 0.5 * shape.constituent_radius[0], effective_modulus(material, material)
