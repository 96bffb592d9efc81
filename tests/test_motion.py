"""Walls, solids and held granules that move: on paths, or as the forces on them say.

That their runs are those of the model, keep a ledger and go on from a checkpoint is asked of the scenes
of scenes.py.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import ANCHOR

import dem

pytestmark = pytest.mark.quick

R, FAR = 1e-3, 1.0  # m: boundaries that nothing meets, so that one compilation serves all
SOFT = dem.Material(young_modulus=1e8, restitution=0.6)
# As good as elastic and at rest, with the kernels of all others.
ELASTIC = dem.Material(young_modulus=1e8, restitution=1.0 - 1e-9)
AWAY = dem.Cylinder(1e-3, (0.5 * FAR, 0.5 * FAR))


def simulation(places, motions=(), held=(), walls=None, material=SOFT, solids=AWAY, **options):
    """Discs at these places (m), of which the last one is held, between walls of which the first ones move."""
    planes = dem.box(FAR, FAR) if walls is None else walls
    places = np.concatenate([places, [[0.5 * FAR if walls is None else R, 0.4 * FAR]]])
    motions = [*motions, *np.zeros((len(planes) - len(motions), 2))]
    scene = dem.Scene(
        dem.Disc(np.full(len(places), R)),
        material,
        dem.Friction(),
        list(map(dem.Wall, planes, motions)),
        solids,
        gravity=(0.0, 0.0),
        thickness=1e-3,
        boundary=SOFT,
        held=[*held, dem.Held([len(places) - 1], ANCHOR)],
    )
    return dem.Simulation(scene, dem.State(places), ledger=True, **options)


BODIES = "wall", "solid", "held"


def squeezed(body, motion, gap, step_fraction):
    """A disc at a wall, and beyond a gap (m) to its right a wall, a solid or a held disc that moves so."""
    face, places = 2 * R + gap, [[R, 0.0]]
    changes = {
        "wall": {"solids": None, "motions": [(0.0, 0.0), motion]},
        "solid": {"solids": dem.Cylinder(2 * R, (face + R, 0.0), motion)},
        "held": {"held": [dem.Held([1], motion)]},
    }[body]
    if body == "held":
        places.append([face + R, 0.0])
    walls = [[-1, 0, 0], [1, 0, face if body == "wall" else FAR]]
    return simulation(places, walls=walls, material=ELASTIC, step_fraction=step_fraction, **changes)


def place(body, run, interval):
    """Where such a body is along x (m), after an interval more."""
    record = run.record(interval, 1)
    if body == "held":
        return run.state.position[1, 0]
    return record.wall_offset[0, 1] if body == "wall" else record.solid_position[0, 0, 0]


@pytest.mark.parametrize("ratio", [0.1, 10.0])
@pytest.mark.parametrize("body", BODIES)
def test_the_work_of_a_drive_is_what_it_and_the_bed_gain(body, ratio):
    """A force presses a boundary of some masses of a disc on it, from rest: what it gives on its way is
    the kinetic energy of the boundary and its work, which the ledger adds up to a thousandth."""
    push, interval = 0.5, 2e-7
    mass = ratio * SOFT.density * np.pi * R**2 * 1e-3
    run = squeezed(body, dem.Drive((-push, None), mass), 5e-6, 0.03)
    origin = {"wall": 2 * R + 5e-6}.get(body, 3 * R + 5e-6)
    run.advance(2e-4)
    before, now, ledger, after = (
        place(body, run, interval),
        place(body, run, interval),
        run.ledger(),
        place(body, run, interval),
    )
    kinetic = 0.5 * mass * ((after - before) / (2.0 * interval)) ** 2
    assert ledger.work > 0.0 and ledger.residual < 1e-3
    assert push * (origin - now) == pytest.approx(kinetic + ledger.work, rel=2e-3)


@pytest.mark.parametrize("body", BODIES)
def test_light_driven_boundaries_are_stable_at_the_step_that_is_chosen(body):
    """A body of a thousandth of the mass of the disc that it presses on does not gain energy."""
    run = squeezed(body, dem.Drive((-1e-2, 0.0), 1e-8), 0.0, 1.0)
    record = run.record(2e-4, 50)
    assert run.steps > 1000
    load = 1e-2 * 20e-6  # J: of the force over a way that it never goes
    assert record.kinetic_energy.max() < load and record.max_overlap.max() < 0.01


@pytest.mark.parametrize("skin", [0.003, 0.3])
@pytest.mark.parametrize("body", ["wall", "held"])
def test_nothing_passes_a_moving_boundary_unseen(body, skin):
    """A fast wall or a fast held granule sweeps up all discs of a row, however thin the skin is."""
    row, fast = np.column_stack([6e-3 * np.arange(1, 9), np.full(8, 5e-3)]), (30.0, 0.0)
    hard = {"skin": skin, "material": dem.Material(young_modulus=1e10, restitution=0.6)}
    if body == "wall":
        run = simulation(row, [fast], **hard)
    else:
        run = simulation(row - [5.8e-3, 0.0], held=[dem.Held([0], fast)], **hard)
    face = -run.record(2e-3, 1).wall_offset[0, 0]
    x = run.state.position[:8, 0]
    assert (np.diff(x) > 1.8 * R).all() and x[0] - face > R
    assert max(face, x[0]) > 0.06 and x[-1] > 0.06


def test_frames_show_walls_where_they_were():
    """The contacts of a frame are those with the wall at that time, and it is drawn there."""
    walls = list(map(dem.Wall, dem.box(FAR, FAR), [(1.0, 0.0), *np.zeros((3, 2))]))
    scene = dem.Scene(dem.Disc([R]), SOFT, dem.Friction(), walls, AWAY)
    result = dem.simulate(scene, dem.State([[2.0 * R, 5e-3]]), 1.1e-3, frames=11)
    touch = [(-2 in result.contacts(frame).partner) for frame in (5, 11)]
    assert not touch[0] and (touch[1] or result.position[-1, 0, 0] > 2 * R)
    assert_allclose(result.walls[:, 0, 2], -result.time, rtol=1e-9)
    (space,) = dem.plot.bed(result, color="speed").axes[0].patches
    assert space.get_xy()[:, 0].min() == pytest.approx(1e3 * result.time[-1])
