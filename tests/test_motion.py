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

R = 1e-3  # m
# As good as elastic, with the kernels of all others; what is softer does not bounce back.
ELASTIC = dem.Material(young_modulus=1e8, restitution=1.0 - 1e-9)
SOFT = dem.Material(young_modulus=1e8, restitution=0.6)
REST = {"wall": (1.0, 0.0), "solid": (R, 1.0), "held": (R, 2.0)}  # m: of bodies that nothing meets
BODIES = list(REST)


def squeezed(body, motion, gap, **options):
    """A disc at a wall, and beyond a gap (m) to its right a wall, a solid or a held disc that moves so."""
    places = REST | {body: (gap + (2.0 if body == "wall" else 3.0) * R, 0.0)}
    moves = dict.fromkeys(BODIES, (0.0, 0.0)) | {body: motion}
    scene = dem.Scene(
        dem.Disc([R, R, R]), ELASTIC, dem.Friction(),
        [dem.Wall([-1, 0, 0]), dem.Wall([1, 0, places["wall"][0]], moves["wall"])],
        dem.Cylinder(2.0 * R, places["solid"], moves["solid"]),
        gravity=(0.0, 0.0), thickness=R, boundary=SOFT,
        held=[dem.Held([1], moves["held"]), dem.Held([2], ANCHOR)],
    )  # fmt: skip
    state = dem.State([[R, 0.0], places["held"], [R, 3.0]])
    return dem.Simulation(scene, state, ledger=True, **options)


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
    push, interval, gap = 0.5, 2e-7, 5e-6
    mass = ratio * ELASTIC.density * np.pi * R**3
    run = squeezed(body, dem.Drive((-push, None), mass), gap, step_fraction=0.03)
    origin = place(body, run, 1e-12)
    run.advance(2e-4)
    before, now = place(body, run, interval), place(body, run, interval)
    ledger, after = run.ledger(), place(body, run, interval)
    kinetic = 0.5 * mass * ((after - before) / (2.0 * interval)) ** 2
    assert ledger.work > 0.0 and ledger.residual < 1e-3
    assert push * (origin - now) == pytest.approx(kinetic + ledger.work, rel=2e-3)


@pytest.mark.parametrize("body", BODIES)
def test_light_driven_boundaries_are_stable_at_the_step_that_is_chosen(body):
    """A body of a thousandth of the mass of the disc that it presses on does not gain energy."""
    run = squeezed(body, dem.Drive((-1e-2, 0.0), 1e-8), 0.0)
    record = run.record(2e-4, 50)
    assert run.steps > 1000
    load = 1e-2 * 20e-6  # J: of the force over a way that it never goes
    assert record.kinetic_energy.max() < load and record.max_overlap.max() < 0.01


@pytest.mark.parametrize("body", BODIES)
def test_nothing_passes_a_moving_boundary_unseen(body):
    """A fast body hits the disc when it is there, however thin the skin is."""
    runs = [squeezed(body, (-30.0, 0.0), 5e-3, skin=skin, time_step=1e-8) for skin in (0.003, 0.3)]
    for run in runs:
        run.advance(5.3e-3 / 30.0)
    thin, thick = (run.state.velocity[0, 0] for run in runs)
    assert thin == pytest.approx(thick, rel=1e-6) and thick < -1.0


def test_frames_show_walls_where_they_were():
    """The contacts of a frame are those with the wall at that time, and it is drawn there."""
    walls = [dem.Wall(dem.box(1.0, 1.0)[0], (1.0, 0.0)), *dem.box(1.0, 1.0)[1:]]
    scene = dem.Scene(dem.Disc([R]), SOFT, dem.Friction(), walls, dem.Cylinder(R, (0.5, 0.5)))
    result = dem.simulate(scene, dem.State([[2.0 * R, 5e-3]]), 1.1e-3, frames=11)
    assert [-2 in result.contacts(frame).partner for frame in (5, 11)] == [False, True]
    assert_allclose(result.walls[:, 0, 2], -result.time, rtol=1e-9)
    (space,) = dem.plot.bed(result, color="speed").axes[0].patches
    assert space.get_xy()[:, 0].min() == pytest.approx(1e3 * result.time[-1])
