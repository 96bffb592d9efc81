"""Clumps of discs, and mixtures: areas of unions, and what a file says of them."""

import math

import numpy as np
import pytest
from beds import area_of, replicate
from forms import CLUMPS, TRIMER
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from project import CONFIG, ROOT, quick
from sweeps import sheared_values

import dem
from dem.experiment.bed import make_bed
from dem.experiment.config import of_values
from dem.experiment.kinds import shear
from dem.experiment.scene import granules, make_scene
from dem.sweep.config import load

# Unions


@given(st.floats(0.0, 7.0), st.sampled_from([0.3, 1.0, 1.9, 2.0 - 1e-12, 2.0]))
def test_a_union_of_two_discs_has_the_area_of_both_without_the_lens(angle, distance):
    """Of two segments of a circle, wherever the discs are given; one of half the size inside another
    changes nothing where it touches."""
    turn, axis = math.acos(0.5 * distance), np.array([math.cos(angle), math.sin(angle)])
    discs = [[*(5.0 + s * axis), r] for s, r in [(0.0, 1.0), (distance, 1.0), (-0.5, 0.5)]]
    clump = dem.Clump([discs])
    assert_allclose(clump.area, 2.0 * (math.pi - turn) + math.sin(2.0 * turn), rtol=1e-14)
    ends = [-0.5 * distance * axis, 0.5 * distance * axis]
    assert_allclose(clump.discs[:, :2], ends, atol=1e-14)


INSIDE = [(0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.2, 0.0, 0.5), (1.1, 0.0, 0.6)]


@quick
@pytest.mark.parametrize(("form", "count"), [(TRIMER, 3), (INSIDE, 2)])
def test_area_centre_and_inertia_of_a_union_are_sums_over_its_points(form, count):
    """Of three discs, and of two of which one is given twice and one is inside another."""
    clump, side = dem.Clump([form]), np.linspace(-3.0, 3.0, 501)
    points = np.stack(np.meshgrid(side, side), axis=-1)
    distance = np.linalg.norm(points[..., None, :] - clump.discs[:, :2], axis=-1)
    point = points[(distance < clump.discs[:, 2]).any(axis=-1)]
    assert len(clump.discs) == count
    assert_allclose(clump.area, len(point) * (side[1] - side[0]) ** 2, rtol=3e-3)
    assert np.abs(point.mean(axis=0)).max() < 2e-3
    assert_allclose(clump.gyration_squared, (point**2).sum(axis=1).mean(), rtol=3e-3)


@quick
def test_clumps_that_are_taken_scaled_or_appended_are_those_that_are_made_so():
    clumps = dem.Clump(CLUMPS)
    result = clumps.scaled(2.0).take([2, 0]).appended(clumps.take([1]))
    expected = dem.Clump([2.0 * TRIMER, np.multiply(2.0, CLUMPS[0]), CLUMPS[1]])
    for one, two in zip(result, expected, strict=True):
        assert_allclose(one, two, atol=1e-15)


# Configurations


@quick
def test_clumps_and_mixtures_of_a_file_by_the_page(tmp_path):
    """docs/howto/clumps.md: granules of the area of a disc of the diameter, in their shares and in another order
    for each seed, known by their discs and not by the name of a file, and by no other shapes."""
    page = (ROOT / "docs/howto/clumps.md").read_text()
    text = page.partition("```yaml\n")[2].partition("```")[0].replace("config/", f"{CONFIG}/")
    (tmp_path / "my.yaml").write_text(text.replace("1.1e-3", "0.9e-3", 1))  # of drop
    np.savetxt(tmp_path / "stone.csv", TRIMER, delimiter=",", header="x,y,radius")
    sweep = load(tmp_path / "my.yaml")
    stone = sweep.replicate("stone", 2e3, 1)
    listed = sweep.changed({"shapes.stone.discs": TRIMER.tolist()}, "stone")
    assert listed.replicate("stone", 2e3, 1).id == stone.id
    shape = granules(stone)
    assert_allclose(shape.discs[:3] / shape.discs[0, 2], dem.Clump([TRIMER]).discs, rtol=1e-12)
    one, two = (sweep.replicate("mix", 2e3, seed) for seed in (1, 2))
    assert set(one.values()["shapes"]) == {"drop", "mix", "stone"}
    shape, other = granules(one), granules(two)
    stones, others = (np.isclose(s.discs[1::3, 2] / s.discs[::3, 2], 0.8) for s in (shape, other))
    assert stones.sum() == others.sum() == 42 and (stones != others).any()
    sizes = np.sqrt(4.0 / np.pi * shape.area)
    means = [sizes[~stones].mean(), sizes[stones].mean()]
    assert_allclose(means, [0.9e-3, 1.1e-3], rtol=0.05)
    assert_allclose(one.shape.diameter, 0.3 * 0.9e-3 + 0.7 * 1.1e-3)
    (tmp_path / "stone.csv").unlink()
    with pytest.raises(dem.InputError, match=r"discs is 'stone\.csv'; it must be a file"):
        load(tmp_path / "my.yaml")


@quick
def test_what_has_the_density_of_the_bed_has_that_of_all_its_granules_together():
    """Mass over volume, whatever the density of the run: the lid, a free cylinder, and the rate of shear."""
    shapes = {"c1": {"mixture": {"light": 0.3, "heavy": 0.7}, "granules": 60}}
    for name, diameter, density in (("light", 0.9e-3, 2.0e3), ("heavy", 1.2e-3, 7.8e3)):
        material = {"young_modulus": 7e10, "density": density}
        shapes[name] = {"kind": "disc", "diameter": diameter, "material": material}
    run = replicate(6e7, shapes=shapes, **{"cylinder.spin": "free"})
    scene = make_scene(run, make_bed(run.bed_description))
    density = scene.mass.sum() / (scene.shape.area.sum() * scene.thickness)
    lid, (solid,) = scene.walls[-1].motion, scene.solids
    inertia = 0.5 * np.pi * density * scene.thickness * solid.radius**4
    found = lid.mass / scene.thickness, solid.spin.inertia
    assert_allclose(found, [density * area_of(run), inertia], rtol=1e-12)
    sheared = of_values(sheared_values(shapes=shapes, shape="c1"))
    mass = 0.25 * np.pi * density * sheared.shape.diameter**2
    assert_allclose(shear.rate_of(sheared), 0.1 / math.sqrt(mass / 1e5), rtol=1e-12)
