"""Beds under a pressure: what is asked is borne, and held."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from beds import HIGH, PRESSURE, area_of, replicate
from matplotlib.figure import Figure
from project import quick

import dem
from dem.experiment import phases
from dem.experiment.bed import make_bed
from dem.experiment.box import check_stroke
from dem.experiment.kinds import drag
from dem.experiment.phases import RunData
from dem.experiment.scene import make_scene
from dem.experiment.snapshots import snapshots_of
from dem.figures.bed import draw, view_of
from dem.figures.frames import of_motion


@cache
def bed_under(pressure=PRESSURE):
    return make_bed(replicate(pressure).bed_description)


@cache
def drawn():
    """What the run records."""
    return phases.run(replicate(), bed_under())


@quick
def test_the_top_wall_falls_through_nothing_at_the_speed_of_its_damping():
    """Where damping bears the pressure P alone: at sqrt(P / density), 124.03 m/s at 60 MPa and 3900 kg/m3. It has
    the mass of a row of granules, 8 mm long and 1.092 mm high and thick."""
    run = replicate()
    top = make_scene(run, bed_under()).walls[-1].motion
    assert top.force == (None, pytest.approx(-60e6 * 8e-3 * 1.092e-3))
    assert -top.force[1] / top.damping == pytest.approx(124.03, rel=1e-4)
    assert top.mass == pytest.approx(3900.0 * 8e-3 * 1.092e-3**2)


@quick
def test_the_top_wall_holds_the_pressure_while_the_cylinder_moves():
    """Its mean force is the pressure to within 3 %, though the cylinder pushes the bed against it; a
    wall that does not yield bears much more."""
    mean = drawn()["wall_force"][3].mean()
    assert mean == pytest.approx(PRESSURE * area_of(replicate()), rel=0.03)


def test_a_snapshot_shows_the_top_wall_where_it_is():
    """What touches it there pushes it with the pressure; it is drawn there, and not where it began."""
    run = replicate()
    motion = snapshots_of(run, drawn() | drag.axes(run.configuration))
    contacts = motion.contacts(-1)
    force = contacts.force[contacts.partner == -3].sum()  # after the cylinder and the bottom
    assert force / area_of(run) == pytest.approx(PRESSURE, rel=0.1)
    frames, axes = of_motion(motion), Figure().subplots()
    draw(axes, frames, -1, view_of(frames))
    top = axes.patches[0].get_xy()[:, 1].max()
    assert top == pytest.approx(1e3 * motion.height[-1], rel=1e-6)
    assert abs(motion.height[-1] / motion.height[0] - 1.0) > 1e-3


def test_a_bed_at_rest_pushes_the_solid_of_a_picture_as_that_of_its_run():
    """The solid is where the run has it: forces of the contacts that the picture shows add up to what
    the run records, though the bed under the pressure is not as high as the box that it was packed in."""
    run, bed = replicate(HIGH), bed_under(HIGH)
    scene = make_scene(run, bed)
    at_rest = replace(scene, solids=replace(scene.solids[0], velocity=(0.0, 0.0)))
    simulation = dem.Simulation(at_rest, bed.state)
    data = RunData(
        run, bed, simulation.record(1e-10, 20), [simulation.state] * 3, np.zeros((0, 2, 20))
    )
    contacts = data.snapshots.contacts(0)
    mine = contacts.partner == -1
    force = contacts.force[mine]
    total, recorded = force @ contacts.normal[mine], data.record.normal_force[0, 0]
    np.testing.assert_allclose(total, recorded, rtol=0.0, atol=0.02 * force.sum())


@quick
def test_more_pressure_makes_a_lower_box_around_the_same_cylinder():
    """The cylinder is where it is before the height is known."""
    low, high = (bed_under(pressure) for pressure in (PRESSURE, 5e6))
    assert low.height < high.height
    (solid,), (other,) = (make_scene(replicate(), bed).solids for bed in (low, high))
    assert solid.position == other.position


def test_a_box_too_low_for_the_stroke_is_refused():
    """Of the box at a packing fraction of 0.84 the stroke leaves a micrometre; the bed is lower."""
    run, bed = replicate(HIGH), bed_under(HIGH)
    nominal = run.bed_description.height(run.diameters)
    (at,) = make_scene(run, bed).solids
    stroke = nominal - at.position[1] - at.radius - 1e-6
    assert bed.height < nominal
    with pytest.raises(dem.PackingError, match="would leave it during its stroke; at most"):
        check_stroke(replicate(HIGH, **{"cylinder.stroke": stroke}), bed)
