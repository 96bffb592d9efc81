"""What a sweep file says of the cylinder: its outline, its angle, its motion, and a second one."""

import inspect
import math
import re
from pathlib import Path

import beds
import numpy as np
import pytest
from numpy.testing import assert_allclose
from project import CONFIG

import dem
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene, solids
from dem.sweep.config import load

pytestmark = pytest.mark.quick


def run(changes=None):
    """A run of the paper's discs with some values changed by path."""
    return load(CONFIG / "paper.yaml").changed(changes or {}, "c1").replicate("c1", 3900.0, 1)


def test_a_run_without_the_new_keys_is_known_by_what_it_was():
    """Finished runs and beds stay finished: what is not asked for, or is as it is without a word, is no part of
    what they are."""
    new = r"null|pressure|second|walls|law|cylinder\.(?!diameter|velocity|start|stroke)"
    usual = {"contact.law": "hertz", "cylinder.outline": "circle", "cylinder.angle": 0.0}
    one, same = run(), run(usual)
    assert not re.search(new, one.run_key())
    assert (one.id, one.bed_id) == (same.id, same.bed_id)


@pytest.mark.parametrize("outline", ["circle", "ellipse", "plate", "square", "wedge"])
def test_the_box_leaves_room_for_the_outline_that_is_drawn(outline):
    replicate = run({"cylinder.outline": outline})
    bed, (solid,) = replicate.bed_description, solids(replicate, 20e-3)
    x, y = solid.ring(4097).T
    area = 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    room = bed.width * bed.height(replicate.diameters) - area
    assert_allclose(0.25 * math.pi * np.sum(replicate.diameters**2) / room, 0.84, rtol=1e-6)
    assert_allclose(bed.solids[0].radius, np.hypot(x, y).max(), rtol=1e-5)
    assert_allclose(np.ptp(x), replicate.configuration.cylinder.diameter, rtol=1e-4)


@pytest.mark.parametrize(
    ("direction", "bearing", "towards"),
    [
        (None, 0.0, (1.0, 0.0)),  # to the right of a motion upwards
        (None, math.pi / 2, (0.0, 1.0)),
        (0.0, 0.0, (0.0, -1.0)),  # to the right of a motion to the right
        (0.0, math.pi / 2, (1.0, 0.0)),
    ],
)
def test_a_second_cylinder_is_at_its_gap_and_bearing(direction, bearing, towards):
    second = {"diameter": 2e-3, "gap": 1e-3, "bearing": bearing}
    first, other = solids(run({"cylinder.direction": direction, "second": second}), 20e-3)
    apart = np.subtract(other.position, first.position)
    assert_allclose(apart, (first.radius + other.radius + 1e-3) * np.array(towards), atol=1e-12)
    assert_allclose(np.add(first.position, other.position), [20e-3, 10e-3])
    assert first.velocity == other.velocity


def test_a_cylinder_that_turns_freely_has_the_inertia_of_its_density():
    (solid,) = solids(run({"cylinder.spin": "free", "material.thickness": 1e-3}), 20e-3)
    mass = 3900.0 * math.pi * solid.radius**2 * 1e-3
    assert_allclose(solid.spin.inertia, 0.5 * mass * solid.radius**2)


def test_a_mixture_is_pressed_as_hard_as_one_material():
    """The top wall bears the pressure that is asked for, although the granules differ in stiffness."""
    disc = {"kind": "disc", "diameter": 1092e-6}
    soft = disc | {"material": {"young_modulus": 14e9}}
    mixture = {"granules": 60, "mixture": {"hard": 0.5, "soft": 0.5}}
    pressed = beds.replicate(2e7, shapes={"c1": mixture, "hard": disc, "soft": soft})
    bed = make_bed(pressed.bed_description)
    force = dem.Simulation(make_scene(pressed, bed), bed.state).record(1e-10, 1).wall_force[0]
    assert_allclose(force[-1], 2e7 * beds.area_of(pressed), rtol=0.02)


@pytest.mark.parametrize(("path", "of"), [("shapes.c1.kind", dem.Disc), ("contact.law", dem.Hertz)])
def test_an_edit_of_a_file_of_a_user_s_own_makes_another_bed(tmp_path, path, of):
    """Of the shape of the granules, and of the law of their contacts."""
    own = tmp_path / f"mine_{of.__name__}.py"
    own.write_text(Path(inspect.getfile(of)).read_text())
    values = {"beside": str(tmp_path), path: f"{own.stem}.{of.__name__}"}
    if of is dem.Disc:
        values["shapes.c1.aspect_ratio"] = 1.0
    first = run(values).bed_id
    own.write_text(own.read_text() + "\nEDITED = True\n")
    assert run(values).bed_id != first
