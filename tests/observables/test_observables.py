"""Each recorded number against what follows from the motion of the same run, at its own time."""

from functools import cache

import meshio
import numpy as np
import pytest
from beds import PRESSURE
from numpy.testing import assert_allclose
from sweeps import smoke

from dem.experiment import phases
from dem.experiment.bed import make_bed
from dem.experiment.kinds import drag
from dem.experiment.observables import OBSERVABLES
from dem.experiment.scene import start
from dem.experiment.snapshots import snapshots_of
from dem.figures.export import export
from dem.figures.frames import of_motion

pytestmark = pytest.mark.quick

# the ledger is one number of a Simulation, and asks for kernels
WATCHED = sorted({*OBSERVABLES} - {"ledger", "scene"})
BINS, SNAPSHOTS, EVERY = 40, 5, 10
STROKE, SPEED, BOX = 1.2e-3, 2.0, 8e-3  # m, m/s, m
DIAMETER, WAY = 1.092e-3, np.linspace(0.0, STROKE, SNAPSHOTS)  # m
TIME = np.linspace(0.0, STROKE / SPEED, BINS + 1)[1:]  # s, end of each bin
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
    return phases.run(replicate(name))


def pairs(contacts):
    ends = np.stack([contacts.granule, contacts.partner], axis=1)
    return {*map(frozenset, ends[contacts.partner >= 0].tolist())}


@cache
def expected(name):
    """What follows from the motion of the same run, by a Simulation; of a number that is recorded by bin and known at
    snapshots alone, at the bins that end there."""
    run, discs = replicate(name), name == "discs"
    bed = make_bed(run.bed_description)
    simulation = start(run, bed)
    scene, mass = simulation.scene, simulation.scene.mass
    records, states, contacts = [], [simulation.state], [simulation.contacts()]
    for _ in range(SNAPSHOTS - 1):
        records.append(simulation.record(STROKE / SPEED / BINS, EVERY))
        states.append(simulation.state)
        contacts.append(simulation.contacts())

    def bins(field):
        return np.concatenate([getattr(record, field) for record in records])

    def at_snapshots(values):
        every = np.full(BINS, np.nan)
        every[EVERY - 1 :: EVERY] = values[1:]
        return every

    force = bins("normal_force") + bins("tangential_force")
    top = np.append(bed.height, bins("wall_offset")[:, -1])
    area = BOX * top - sum(solid.area for solid in scene.solids)
    course = ASKEW if discs else 0.5 * np.pi
    ahead = np.array([np.cos(course), np.sin(course)])
    right = np.array([np.sin(course), -np.cos(course)])
    position = np.array([state.position for state in states])
    angle = np.array([state.angle for state in states])
    touching, radius = list(map(pairs, contacts)), np.sqrt(scene.shape.area / np.pi)
    place = scene.solids[0].position + np.outer(WAY, ahead)

    def apart(position):
        """Separations (n, n, 2) of all from all, of the nearest images."""
        away = position - position[:, None]
        away[..., 0] -= discs * BOX * np.rint(away[..., 0] / BOX)
        return away

    def near(position, diameters):
        distance = np.hypot(*np.moveaxis(apart(position), -1, 0))
        return (distance < diameters * DIAMETER) & ~np.eye(len(position), dtype=bool)

    overlaps, stress, motion, fabric = [], [], [], []
    for state, c in zip(states, contacts, strict=True):
        # of Love and Weber: sum of force and branch; of the motion, its energy about the mean
        stress.append(c.total_force.T @ c.branch)
        away = state.velocity - mass @ state.velocity / mass.sum()
        motion.append(0.5 * mass @ np.square(away).sum(axis=1))
        # mean of exp(2 i angle) of the normals between granules: its size and its axis
        normal = c.normal[c.partner >= 0]
        fabric.append(np.exp(2j * np.arctan2(normal[:, 1], normal[:, 0])).mean())
        smaller = np.minimum(radius[c.granule], np.where(c.partner < 0, np.inf, radius[c.partner]))
        overlaps.append((c.overlap / smaller).max())
    volume = area[::EVERY] * scene.thickness
    stress = np.array(stress) / volume[:, None, None]

    layer = np.floor(8.0 * position[0, :, 1] / top[0])
    differ = layer[:, None] != layer
    mixed = np.array([differ[near(each, 1.5)].mean() for each in position])

    # over the lag, from the snapshot two before: 0.6 mm, nearest to 0.5 mm
    non_affine, fluctuation, lost = np.full((3, SNAPSHOTS), np.nan)
    for k in range(2, SNAPSHOTS):
        around, old = near(position[k - 2], 2.5), apart(position[k - 2])
        moved, missed, away = position[k] - position[k - 2], [], []
        for i, others in enumerate(around):
            away.append(moved[i] - moved[others].mean(axis=0))
            if others.sum() >= 3:
                new = old[i, others] + moved[others] - moved[i]
                _, squares, *_ = np.linalg.lstsq(old[i, others], new, rcond=None)
                missed.append(squares.sum() / len(new))
        non_affine[k] = np.mean(missed) / DIAMETER**2
        fluctuation[k] = np.hypot(*np.transpose(away)).mean() / (WAY[k] - WAY[k - 2])
        lost[k] = len(touching[k - 2] - touching[k]) / len(touching[k - 2])

    def alignment(past, start):
        """Mean of cos 2(angle - direction of motion) within two diameters of the cylinder where it is."""
        values = np.full(SNAPSHOTS, np.nan)
        for k in range(1, SNAPSHOTS) if not discs else ():
            gap = np.hypot(*(position[k] - place[k]).T) - 0.75e-3
            x, y = (position[k] - position[k - 1] - past * (place[k] - place[k - 1])).T
            chosen = (gap < 2.0 * DIAMETER) & (np.hypot(x, y) > 0.01 * DIAMETER)
            turn = angle[0 if start else k] - np.arctan2(y, x)
            values[k] = np.cos(2.0 * turn[chosen]).mean()
        return values

    moving = {
        "cylinder_orientation": SPINS[0] * WAY / SPEED,
        "second_orientation": SPINS[1] * WAY / SPEED,
        "top_y": top[::EVERY],
    }
    return {
        "drag": -force[:, 0] @ ahead,
        "drag_normal": -bins("normal_force")[:, 0] @ ahead,
        "drag_tangential": -bins("tangential_force")[:, 0] @ ahead,
        "transverse_force": force[:, 0] @ right,
        "wall_force": [*np.full((2 * discs, BINS), np.nan), *bins("wall_force").T],
        "kinetic_energy": bins("kinetic_energy"),
        "coordination_number": at_snapshots([len(each) / 30.0 for each in touching]),
        "max_overlap": at_snapshots(overlaps),
        "time_step": bins("time_step"),
        "solid_drag": -(force @ ahead).T,
        "solid_side_force": (force @ right).T,
        "solid_torque": bins("torque").T,
        "solid_angle": np.outer(SPINS if discs else [0.0], TIME),
        "top_height": top[1:],
        "bed_fraction": scene.shape.area.sum() / area[1:],
        "stress_xx": stress[:, 0, 0],
        "stress_xy": stress[:, 0, 1],
        "stress_yx": stress[:, 1, 0],
        "stress_yy": stress[:, 1, 1],
        "kinetic_pressure": motion / volume,
        "fabric_anisotropy": np.abs(fabric),
        "fabric_angle": 0.5 * np.angle(fabric),
        "non_affine": non_affine,
        "fluctuation": fluctuation,
        "mixing": mixed - mixed[0],
        "contacts_lost": lost,
        "alignment": alignment(0.0, False),
        "alignment_start": alignment(0.0, True),
        "streaming": alignment(1.0, False),
        "streaming_start": alignment(1.0, True),
        "cylinder_y": place[:, 1],
        "granule_x": position[..., 0],
        "granule_y": position[..., 1],
        "granule_angle": angle,
        "granule_diameter": 2.0 * radius,
        "steps": simulation.steps,
        "box_height": bed.height,
    } | (moving if discs else {})


NAMES = [name for kind in WATCHED for name in OBSERVABLES[kind]["VARIABLES"]]
NAMES += ["steps", "box_height"]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("run", RUNS)
def test_a_recorded_number_is_that_of_the_motion(run, name):
    assert (name in recorded(run)) == (name in expected(run))
    value = np.array(recorded(run).get(name, np.nan))
    truth = np.broadcast_to(expected(run).get(name, np.nan), value.shape)
    known = np.isfinite(truth)
    scale = np.abs(truth[known]).max(initial=0.0)
    assert_allclose(value[known], truth[known], rtol=1e-6, atol=1e-7 * scale)
    if name not in ("coordination_number", "max_overlap"):
        assert np.isnan(value[~known]).all()


def test_a_film_and_a_mesh_show_both_cylinders_as_they_turn(tmp_path):
    run = replicate("discs")
    motion = snapshots_of(run, recorded("discs") | drag.axes(run.configuration))
    turn = np.outer(WAY, SPINS) / SPEED
    assert_allclose(of_motion(motion).turn, turn, atol=1e-9)
    export(motion, tmp_path / "bed.pvd")
    mesh = meshio.read(tmp_path / "bed0004.vtu")
    _, rings, _ = (mesh.points[cells.data] for cells in mesh.cells)
    x, y, _ = (rings[:, 0] - rings.mean(axis=1)).T
    assert_allclose([mesh.cell_data["angle"][1], np.arctan2(y, x)], [turn[-1]] * 2, atol=1e-6)
