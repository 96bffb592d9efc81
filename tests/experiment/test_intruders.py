"""What a sweep file says of the cylinder: its outline, its angle, its motion, and a second one."""

import json
import math
from dataclasses import replace

import meshio
import numpy as np
import pytest
from numpy.testing import assert_allclose
from project import CONFIG

import dem
from dem.experiment.bed import make_bed
from dem.experiment.box import height_of_box
from dem.experiment.intruders import area_of_solids, circles_of, solids
from dem.experiment.kinds import drag
from dem.experiment.scene import make_scene
from dem.experiment.snapshots import snapshots_of
from dem.figures.export import export
from dem.figures.frames import of_motion
from dem.sweep.config import load

SECOND = {"diameter": 2e-3, "gap": 1e-3}


def run(changes=(), **sections):
    """A run of the paper's discs with some values changed by path."""
    values = load(CONFIG / "paper.yaml").changed(dict(changes), "c1").values() | sections
    return dem.experiment.config.parse(values).replicate("c1", 3900.0, 1)


def drawn(replicate, height=20e-3):
    return solids(replicate, height)


def test_a_run_without_the_new_keys_is_known_by_what_it_was():
    """Finished runs stay finished: what is not asked for is no part of what a run is."""
    keys = json.loads(run().run_key().rsplit(" ", 2)[0])
    assert {path for path in keys if path.startswith("cylinder")} == {
        f"cylinder.{name}" for name in ("diameter", "velocity", "start", "stroke")
    }
    assert not {path for path in keys if path.startswith(("second", "walls"))}


@pytest.mark.parametrize(
    "changes",
    [
        {"cylinder.outline": "plate"},
        {"cylinder.outline": "wedge", "cylinder.angle": 0.3},
        {"cylinder.direction": 0.0},
        {"cylinder.outline": "ellipse", "cylinder.aspect_ratio": 3.0},
    ],
)
def test_what_shapes_or_moves_a_solid_is_part_of_its_bed(changes):
    assert run(changes).bed_key() != run().bed_key()


@pytest.mark.parametrize("outline", ["circle", "ellipse", "plate", "square", "wedge"])
def test_the_box_leaves_room_for_the_outline_that_is_drawn(outline):
    """Equation (18): the packing fraction is that of what the solid leaves."""
    replicate = run({"cylinder.outline": outline})
    (solid,) = drawn(replicate)
    configuration = replicate.configuration
    assert_allclose(area_of_solids(configuration), solid.area, rtol=1e-12)
    assert_allclose(circles_of(configuration, 20e-3)[0][2], solid.radius, rtol=1e-12)
    across = np.ptp(solid.ring(257)[:, 0])
    assert_allclose(across, configuration.cylinder.diameter, rtol=1e-4)


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
    replicate = run({"cylinder.direction": direction}, second=SECOND | {"bearing": bearing})
    first, second = drawn(replicate)
    apart = np.subtract(second.position, first.position)
    gap = np.hypot(*apart) - first.radius - second.radius
    assert_allclose(gap, 1e-3)
    assert_allclose(apart / np.hypot(*apart), towards, atol=1e-12)
    middle = 0.5 * np.add(first.position, second.position)
    assert_allclose(middle, [10e-3, 5e-3])
    assert_allclose(first.velocity, second.velocity)


def test_a_cylinder_that_turns_freely_has_the_inertia_of_its_density():
    free = {"cylinder.spin": "free", "material.thickness": 1e-3}
    (solid,) = drawn(run(free))
    mass = 3900.0 * math.pi * solid.radius**2 * 1e-3
    assert_allclose(solid.spin.inertia, 0.5 * mass * solid.radius**2)
    (plate,) = drawn(run(free | {"cylinder.outline": "plate"}))
    thin = plate.area * 3900.0 * 1e-3 * (2.0 * plate.radius) ** 2 / 12.0
    assert_allclose(plate.spin.inertia, thin, rtol=0.1)


@pytest.fixture(scope="module")
def pair():
    """Two cylinders that are drawn to the right, of which the second turns; values of the run."""
    changes = {
        "cylinder.direction": 0.0,
        "cylinder.start": 0.5,
        "cylinder.diameter": 2e-3,
        "cylinder.stroke": 1e-3,
        "box_width": 14e-3,
        "record.bins": 20,
        "record.window": [0.5e-3, 1e-3],
        "record.snapshots": 3,
        "record.observables": ["drag", "solids", "snapshots"],
        "shapes.c1.granules": 150,
    }
    replicate = run(changes, second={"diameter": 2e-3, "gap": 2e-3, "spin": 1e3})
    return replicate, drag.run(replicate, make_bed(replicate))


def test_a_run_draws_two_cylinders_to_the_right(pair):
    """Drag is against the motion, wherever it goes, and both are where the displacement says."""
    replicate, values = pair
    assert values["drag"][10:].mean() > 0.0
    assert values["solid_drag"].shape == (2, 20) and (values["solid_drag"][:, 10:] > 0.0).any()
    assert_allclose(values["drag"], values["solid_drag"][0])
    assert_allclose(values["transverse_force"], values["solid_side_force"][0])
    assert np.ptp(values["cylinder_y"]) == 0.0
    assert_allclose(
        values["box_height"], height_of_box(replicate.configuration, values["granule_diameter"])
    )


def test_a_second_cylinder_that_turns_is_drawn_and_exported_at_its_angle(pair, tmp_path):
    """1000 rad/s over 1 mm at 2 m/s, which is half a radian; the first stays at zero."""
    replicate, values = pair
    layout = replicate.configuration.module.layout
    assert "second_orientation" in layout and "cylinder_orientation" not in layout
    motion = snapshots_of(replicate, values | drag.axes(replicate.configuration))
    assert_allclose(of_motion(motion).turn, [[0.0, 0.0], [0.0, 0.25], [0.0, 0.5]], atol=1e-9)
    export(motion, tmp_path / "bed.pvd")
    mesh = meshio.read(tmp_path / "bed0002.vtu")
    numbers, angles = (np.concatenate(mesh.cell_data[name]) for name in ("granule", "angle"))
    solids = [numbers.tolist().index(number) for number in (-1, -2)]
    assert_allclose(angles[solids], [0.0, 0.5], atol=1e-9)
    polygons = [corners for block in mesh.cells for corners in block.data]
    ring = mesh.points[polygons[solids[1]]][:, :2]
    first, second = ring[0], ring.mean(axis=0)
    assert_allclose(np.arctan2(*(first - second)[::-1]), 0.5, atol=1e-6)


REFUSED = {
    "aspect_ratio is 2 and outline circle": {"cylinder.aspect_ratio": 2.0},
    "cylinder.outline is 'star'; it must be": {"cylinder.outline": "star"},
    "cylinder.spin is 'fast'; it must be an angular velocity or free": {"cylinder.spin": "fast"},
    "the cylinder would leave it during its stroke; at most": {
        "cylinder.direction": 0.0,
        "cylinder.stroke": 9e-3,
        "record.window": [1e-3, 5e-3],
    },
    "second.gap is 0.02 m: with shapes.c1": {"second": SECOND | {"gap": 20e-3}},
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_drawn_is_refused_in_one_sentence(words):
    changes = {path: value for path, value in REFUSED[words].items() if "." in path}
    sections = {name: value for name, value in REFUSED[words].items() if "." not in name}
    with pytest.raises(dem.InputError, match=words):
        run(changes, **sections)


SETTLED = {
    "packing.preparation": "settled",
    "packing.fraction": 0.6,
    "packing.friction": 0.3,
    "gravity": 9.81,
    "shapes.c1.granules": 60,
    "box_width": 9e-3,
}


def test_a_settled_bed_rests_on_its_floor_below_a_free_surface():
    replicate = run(SETTLED | {"cylinder.start": 0.3})
    bed = make_bed(replicate)
    scene = make_scene(replicate, bed)
    diameter = 2.0 * scene.shape.radius
    assert (bed.position[:, 1] + 0.5 * diameter).max() < 0.9 * bed.height
    resting = replace(scene, solids=[replace(solid, velocity=(0.0, 0.0)) for solid in scene.solids])
    simulation = dem.Simulation(resting, bed.state)
    simulation.advance(5e-3)  # in which a granule that nothing holds falls by a tenth of a diameter
    assert np.abs(simulation.state.position - bed.position).max() < 0.01 * diameter.mean()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gravity": 0.0}, "give gravity"),
        ({"packing.fraction": 0.84}, "at most 0.75"),
        ({"packing.fraction": None, "packing.pressure": 3e7}, "relaxed without friction"),
    ],
)
def test_a_bed_that_cannot_settle_is_refused(changes, words):
    with pytest.raises(dem.InputError, match=words):
        run(SETTLED | changes)


def test_a_settled_bed_is_known_by_what_decides_it():
    heavy = run(SETTLED).configuration.replicate("c1", 7800.0, 1)
    assert heavy.bed_key() != run(SETTLED).bed_key()
    assert run(SETTLED | {"material.young_modulus": 7e9}).bed_key() != run(SETTLED).bed_key()
    assert run({"material.young_modulus": 7e9}).bed_key() == run().bed_key()
