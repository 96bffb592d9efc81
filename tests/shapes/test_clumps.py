"""Clumps of discs, and mixtures: areas of unions, and what a file says of them."""

import math

import numpy as np
import pytest
from beds import area_of, replicate
from forms import CLUMPS, TRIMER
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from project import CONFIG, ROOT
from sweeps import sheared_values

import dem
from dem.experiment.bed import make_bed
from dem.experiment.config import of_values
from dem.experiment.kinds import shear
from dem.experiment.scene import granules, make_scene
from dem.sweep.config import load

# Unions


@given(st.floats(0.0, 7.0), st.sampled_from([0.3, 1.0, 1.9, 2.0 - 1e-12, 2.0]))
def test_a_union_of_two_discs_has_the_area_and_inertia_of_both_without_the_lens(angle, distance):
    """Of two segments of a circle, wherever the discs are given; one of half the size inside another
    changes nothing where it touches."""
    turn = math.acos(0.5 * distance)
    sine, cosine = math.sin(turn), math.cos(turn)
    area, first = turn - sine * cosine, 2.0 / 3.0 * sine**3
    polar = 0.5 * (area + 2.0 / 3.0 * sine**3 * cosine)
    lens = 2.0 * (polar - distance * first + 0.25 * distance**2 * area)
    union = 2.0 * math.pi - 2.0 * area
    moment = math.pi + 0.5 * math.pi * distance**2 - lens
    axis = np.array([math.cos(angle), math.sin(angle)])
    discs = [[*(5.0 + np.multiply(s, axis)), r] for s, r in [(0, 1), (distance, 1), (-0.5, 0.5)]]
    clump = dem.Clump([discs])
    assert_allclose(clump.area, union, rtol=1e-14)
    assert_allclose(clump.gyration_squared, moment / union, rtol=1e-13)
    assert_allclose(
        clump.discs[:2, :2], [-0.5 * distance * axis, 0.5 * distance * axis], atol=1e-14
    )


@pytest.mark.quick
def test_area_centre_and_inertia_of_a_union_are_sums_over_its_points():
    """Of three discs, and of two of which one is twice there and one is inside another."""
    inside = [(0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.2, 0.0, 0.5), (1.1, 0.0, 0.6)]
    clumps, side = dem.Clump([TRIMER, inside]), np.linspace(-3.0, 3.0, 501)
    points = np.stack(np.meshgrid(side, side), axis=-1)
    for g in range(2):
        discs = clumps.discs[clumps.owner == g]
        distance = np.linalg.norm(points[..., None, :] - discs[:, :2], axis=-1)
        point = points[(distance < discs[:, 2]).any(axis=-1)]
        assert_allclose(clumps.area[g], len(point) * (side[1] - side[0]) ** 2, rtol=3e-3)
        assert np.abs(point.mean(axis=0)).max() < 2e-3
        assert_allclose(clumps.gyration_squared[g], (point**2).sum(axis=1).mean(), rtol=3e-3)


@pytest.mark.quick
def test_clumps_that_are_taken_scaled_or_appended_are_those_that_are_made_so():
    clumps = dem.Clump([np.multiply(form, 1e-3) for form in CLUMPS])
    other = dem.Clump([2e-3 * TRIMER, np.multiply(CLUMPS[0], 2e-3)])
    result = clumps.scaled(2.0).take([2, 0]).appended(clumps.take([1]))
    assert_allclose(result.discs, np.vstack([other.discs, clumps.discs[1:3]]), atol=1e-18)
    assert result.owner.tolist() == [0, 0, 0, 1, 2, 2] and result.first.tolist() == [0, 3, 4, 6]


# Configurations


@pytest.mark.quick
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
    assert stone.labels()["kind"] == "clump" and 1.1 < stone.shape.ratio < 1.3
    shape = granules(stone)
    assert_allclose(np.sqrt(4.0 / np.pi * shape.area).mean(), 1.1e-3, rtol=0.05)
    assert_allclose(shape.discs[:3] / shape.discs[0, 2], dem.Clump([TRIMER]).discs, rtol=1e-12)
    one, two = (sweep.replicate("mix", 2e3, seed) for seed in (1, 2))
    assert one.labels()["kind"] == "mixture"
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


def test_a_period_that_is_too_short_for_clumps_is_refused_before_a_bed_is_made():
    """By the circles about their centres of mass that hold them, as a scene is."""
    hammer = [[0.0, 0.0, 1.0], [3.0, 0.0, 0.3]]
    radius = dem.Clump.of_size([1.1e-3], hammer).bounding_radius[0]
    least = 2.5 * (radius + max(radius, 0.75e-3))
    section = {"kind": "clump", "discs": hammer, "diameter": 1.1e-3, "granules": 200}
    values = {"shapes": {"c1": section}, "packing.size_spread": 0.0, "periodic": "x"}
    sweep = load(CONFIG / "smoke.yaml")
    sweep.changed(values | {"box_width": 1.01 * least}, "c1").replicate("c1", 2e3, 1)
    with pytest.raises(dem.InputError, match=r"periodic is x: .* along x it must be at least"):
        sweep.changed(values | {"box_width": 0.99 * least}, "c1").replicate("c1", 2e3, 1)


@pytest.mark.quick
def test_what_has_the_density_of_the_bed_has_that_of_all_its_granules_together():
    """Mass over volume, whatever the density of the run: the lid, a free cylinder, and the rate of shear."""
    shapes = {
        name: {"kind": "disc", "granules": 60, "diameter": diameter}
        | {"material": {"young_modulus": 7e10, "density": density}}
        for name, diameter, density in (("light", 0.9e-3, 2.0e3), ("heavy", 1.2e-3, 7.8e3))
    }
    shapes["c1"] = {"mixture": {"light": 0.3, "heavy": 0.7}, "granules": 60}
    run = replicate(6e7, shapes=shapes, **{"cylinder.spin": "free"})
    scene = make_scene(run, make_bed(run))
    density = scene.mass.sum() / (scene.shape.area.sum() * scene.thickness)
    assert 5.0e3 < density < 7.0e3
    lid, (solid,), thickness = scene.walls[-1].motion, scene.solids, scene.thickness
    inertia = 0.5 * np.pi * density * thickness * solid.radius**4
    damping = math.sqrt(6e7 * density) * area_of(run)
    found = lid.mass / thickness, lid.damping, solid.spin.inertia
    assert_allclose(found, [density * area_of(run), damping, inertia], rtol=1e-12)
    sheared = of_values(sheared_values(shapes=shapes, shape="c1"))
    mass = 0.25 * np.pi * density * sheared.shape.diameter**2
    assert_allclose(shear.rate_of(sheared), 0.1 / math.sqrt(mass / 1e5), rtol=1e-12)
