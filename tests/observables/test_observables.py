"""Each recorded number against what follows from the motion of the same run, at its own time."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from beds import PRESSURE
from numpy.testing import assert_allclose
from sweeps import smoke

from dem.experiment.bed import make_bed
from dem.experiment.kinds import drag
from dem.experiment.observables import OBSERVABLES
from dem.experiment.scene import start

pytestmark = pytest.mark.quick

WATCHED = sorted(
    {*OBSERVABLES} - {"ledger"}
)  # it is one number of a Simulation, and asks for kernels
BINS, SNAPSHOTS, EVERY = 40, 5, 10
STROKE, SPEED, BOX = 1.2e-3, 2.0, 8e-3  # m, m/s, m
TIME = STROKE / SPEED * np.linspace(0.0, 1.0, BINS + 1)[1:]  # s, end of each bin
ASKEW = 1.2  # rad, direction of the motion
SPINS = -300.0, 500.0  # rad/s
RUNS = {
    "ellipses": ("e3", {}),
    "discs": (
        "c1",
        {
            "packing.fraction": None,
            "packing.pressure": PRESSURE,
            "periodic": "x",
            "second": {"diameter": 1e-3, "gap": 3e-4, "bearing": 0.5, "spin": SPINS[1]},
            "cylinder.spin": SPINS[0],
            "cylinder.direction": ASKEW,
        },
    ),
}


def replicate(name):
    shape, changes = RUNS[name]
    record = {"bins": BINS, "window": [4e-4, 1e-3], "snapshots": SNAPSHOTS, "observables": WATCHED}
    return smoke(record=record).changed(changes, shape).replicate(shape, 3900.0, 1)


@cache
def recorded(name):
    return drag.run(replicate(name))


@cache
def moved(name):
    """The same run by a Simulation: forces of each bin, states and contacts at each snapshot."""
    run = replicate(name)
    bed = make_bed(run)
    simulation = start(run, bed)
    records, states, contacts = [], [simulation.state], [simulation.contacts()]
    for _ in range(SNAPSHOTS - 1):
        records.append(simulation.record(STROKE / SPEED / BINS, EVERY))
        states.append(simulation.state)
        contacts.append(simulation.contacts())

    def bins(field):
        return np.concatenate([getattr(record, field) for record in records])

    discs, scene = name == "discs", simulation.scene
    top = np.append(bed.height, bins("wall_offset")[:, -1])
    angle = ASKEW if discs else 0.5 * np.pi
    return SimpleNamespace(
        discs=discs,
        scene=scene,
        states=states,
        contacts=contacts,
        bins=bins,
        force=bins("normal_force") + bins("tangential_force"),
        top=top,
        area=BOX * top - 0.25 * np.pi * (1.5e-3**2 + discs * 1e-3**2),
        ahead=np.array([np.cos(angle), np.sin(angle)]),
        right=np.array([np.sin(angle), -np.cos(angle)]),
        diameter=run.shape.diameter,
        position=np.array([state.position for state in states]),
        angle=np.array([state.angle for state in states]),
        way=STROKE * np.linspace(0.0, 1.0, SNAPSHOTS),
    )


def apart(m, position):
    """Separations (n, n, 2) of all from all, of the nearest images."""
    away = position - position[:, None]
    away[..., 0] -= m.discs * BOX * np.rint(away[..., 0] / BOX)
    return away


def near(m, position, diameters):
    distance = np.hypot(*np.moveaxis(apart(m, position), -1, 0))
    return (distance < diameters * m.diameter) & ~np.eye(len(position), dtype=bool)


def pairs(contacts):
    real = contacts.partner >= 0
    ends = zip(contacts.granule[real], contacts.partner[real], strict=True)
    return {tuple(sorted(map(int, end))) for end in ends}


def at_snapshots(value):
    """An expectation by snapshot of a number that is recorded by bin: of the bins that end there."""

    def expected(m):
        every = np.full(BINS, np.nan)
        every[EVERY - 1 :: EVERY] = [value(m, k) for k in range(1, SNAPSHOTS)]
        return every

    return expected


def kinetic_energy(m, k):
    state, scene = m.states[k], m.scene
    linear = scene.mass * (state.velocity**2).sum(axis=1)
    return 0.5 * (linear + scene.inertia * state.angular_velocity**2).sum()


def max_overlap(m, k):
    contacts, shape = m.contacts[k], m.scene.shape
    radius = np.sqrt(shape.area / np.pi)
    solids = [solid.radius for solid in m.scene.solids]
    other = np.concatenate([radius, np.full(len(m.scene.walls), np.inf), solids[::-1]])
    return (contacts.overlap / np.minimum(radius[contacts.granule], other[contacts.partner])).max()


def stress(along, across):
    """Sum over contacts of the force along one axis times the branch along another, over the volume."""

    def expected(m):
        work = [c.total_force[:, along] @ c.branch[:, across] for c in m.contacts]
        return work / (m.area[::EVERY] * m.scene.thickness)

    return expected


def kinetic_pressure(m):
    """Energy of the motion about the mean, over the volume."""
    mass = m.scene.mass
    away = [state.velocity - mass @ state.velocity / mass.sum() for state in m.states]
    energy = 0.5 * (np.square(away).sum(axis=-1) @ mass)
    return energy / (m.area[::EVERY] * m.scene.thickness)


def fabric(m):
    """Mean of exp(2 i angle) of the normals between granules: its size and its axis."""
    means = []
    for contacts in m.contacts:
        normal = contacts.normal[contacts.partner >= 0]
        means.append(np.exp(2j * np.arctan2(normal[:, 1], normal[:, 0])).mean())
    return np.array(means)


def over_the_lag(measure):
    """A mean over the granules at each snapshot against the one two before: 0.6 mm, nearest to 0.5 mm."""

    def expected(m):
        return [np.nan] * 2 + [measure(m, k - 2, k) for k in range(2, SNAPSHOTS)]

    return expected


def non_affine(m, before, after):
    around, start = near(m, m.position[before], 2.5), apart(m, m.position[before])
    motion, missed = m.position[after] - m.position[before], []
    for i, others in enumerate(around):
        if others.sum() >= 3:
            old = start[i, others]
            new = old + motion[others] - motion[i]
            affine, *_ = np.linalg.lstsq(old, new, rcond=None)
            missed.append(((new - old @ affine) ** 2).sum(axis=1).mean())
    return np.mean(missed) / m.diameter**2


def fluctuation(m, before, after):
    around, motion = near(m, m.position[before], 2.5), m.position[after] - m.position[before]
    away = [motion[i] - motion[others].mean(axis=0) for i, others in enumerate(around)]
    return np.hypot(*np.transpose(away)).mean() / (m.way[after] - m.way[before])


def mixing(m):
    layer = np.floor(8.0 * m.position[0, :, 1] / m.top[0])
    apart = layer[:, None] != layer
    shares = [apart[near(m, position, 1.5)].mean() for position in m.position]
    return np.array(shares) - shares[0]


def contacts_lost(m, before, after):
    old, new = pairs(m.contacts[before]), pairs(m.contacts[after])
    return len(old - new) / len(old)


def alignment(past, start):
    """Mean of cos 2(angle - direction of motion) within two diameters of the cylinder where it is."""

    def expected(m):
        values = [np.nan] * SNAPSHOTS
        for k in range(1, SNAPSHOTS) if not m.discs else ():
            place = m.scene.solids[0].position + m.way[k] * m.ahead
            gap = np.hypot(*(m.position[k] - place).T) - 0.75e-3
            motion = m.position[k] - m.position[k - 1]
            x, y = (motion - past * (m.way[k] - m.way[k - 1]) * m.ahead).T
            chosen = (gap < 2.0 * m.diameter) & (np.hypot(x, y) > 0.01 * m.diameter)
            turn = m.angle[0 if start else k] - np.arctan2(y, x)
            values[k] = np.cos(2.0 * turn[chosen]).mean()
        return values

    return expected


def wall_force(m):
    forces = np.full((4, BINS), np.nan)
    forces[2 * m.discs :] = m.bins("wall_force").T
    return forces


EXPECTED = {
    "drag": lambda m: -m.force[:, 0] @ m.ahead,
    "drag_normal": lambda m: -m.bins("normal_force")[:, 0] @ m.ahead,
    "drag_tangential": lambda m: -m.bins("tangential_force")[:, 0] @ m.ahead,
    "transverse_force": lambda m: m.force[:, 0] @ m.right,
    "wall_force": wall_force,
    "kinetic_energy": at_snapshots(kinetic_energy),
    "coordination_number": at_snapshots(lambda m, k: len(pairs(m.contacts[k])) / 30.0),
    "max_overlap": at_snapshots(max_overlap),
    "time_step": lambda m: m.bins("time_step"),
    "solid_drag": lambda m: -(m.force @ m.ahead).T,
    "solid_side_force": lambda m: (m.force @ m.right).T,
    "solid_torque": lambda m: m.bins("torque").T,
    "solid_angle": lambda m: np.outer(SPINS if m.discs else [0.0], TIME),
    "top_height": lambda m: m.top[1:],
    "bed_fraction": lambda m: m.scene.shape.area.sum() / m.area[1:],
    "stress_xx": stress(0, 0),
    "stress_xy": stress(0, 1),
    "stress_yx": stress(1, 0),
    "stress_yy": stress(1, 1),
    "kinetic_pressure": kinetic_pressure,
    "fabric_anisotropy": lambda m: np.abs(fabric(m)),
    "fabric_angle": lambda m: 0.5 * np.angle(fabric(m)),
    "non_affine": over_the_lag(non_affine),
    "fluctuation": over_the_lag(fluctuation),
    "mixing": mixing,
    "contacts_lost": over_the_lag(contacts_lost),
    "alignment": alignment(0.0, False),
    "alignment_start": alignment(0.0, True),
    "streaming": alignment(1.0, False),
    "streaming_start": alignment(1.0, True),
    "cylinder_y": lambda m: m.scene.solids[0].position[1] + m.way * m.ahead[1],
    "cylinder_orientation": lambda m: SPINS[0] * m.way / SPEED,
    "second_orientation": lambda m: SPINS[1] * m.way / SPEED,
    "top_y": lambda m: m.top[::EVERY],
    "granule_x": lambda m: m.position[..., 0],
    "granule_y": lambda m: m.position[..., 1],
    "granule_angle": lambda m: m.angle,
    "granule_diameter": lambda m: np.sqrt(4.0 / np.pi * m.scene.shape.area),
}
NAMES = [name for kind in WATCHED for name in OBSERVABLES[kind]["VARIABLES"]]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("run", RUNS)
def test_a_recorded_number_is_that_of_the_motion(run, name):
    """Where it is recorded at the end of each bin, at the bins that end at a snapshot."""
    if name not in recorded(run):
        assert run == "ellipses" and name in ("top_y", "cylinder_orientation", "second_orientation")
        return
    value = np.array(recorded(run)[name])
    expected = np.broadcast_to(EXPECTED[name](moved(run)), value.shape)
    known = np.isfinite(expected)
    scale = np.abs(expected[known]).max(initial=0.0)
    assert_allclose(value[known], expected[known], rtol=1e-6, atol=1e-7 * scale)
    if name not in ("kinetic_energy", "coordination_number", "max_overlap"):
        assert np.isnan(value[~known]).all()


@pytest.mark.parametrize("run", RUNS)
def test_signs_and_sizes_are_those_of_a_cylinder_that_is_drawn_through_a_bed(run):
    """It is pushed back, walls outwards; friction is a part of the drag; steps fill their bins."""
    values, m = recorded(run), moved(run)
    assert values["drag"].mean() > 0.0 and np.nanmin(values["wall_force"]) >= 0.0
    assert 0.0 < values["drag_tangential"].mean() < values["drag_normal"].mean()
    steps = np.ceil(STROKE / SPEED / BINS / values["time_step"]).sum()
    assert 0.8 * steps < values["steps"] <= steps
    assert values["box_height"] == m.top[0]
