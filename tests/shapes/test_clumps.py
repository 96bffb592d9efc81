"""Clumps of discs, and mixtures: areas of unions, motion, beds, configurations."""

import math

import numpy as np
import pytest
from collisions import ELASTIC, LEAST
from forms import CLUMPS, TRIMER
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from project import CONFIG
from sweeps import sheared_values

import dem
from dem.base.errors import InputError
from dem.base.source_hash import ROOT
from dem.dynamics.energy import balance
from dem.experiment.bed import make_bed
from dem.experiment.config import of_values
from dem.experiment.kinds import shear
from dem.experiment.scene import granules as granules_of
from dem.experiment.scene import make_scene, start
from dem.packing.random import Bed
from dem.sweep.config import load


def mixed(n, diameter=1e-3):
    """Clumps of one, two and three discs in turn, of +-10 % in size."""
    sizes = diameter * np.random.default_rng(3).uniform(0.9, 1.1, n)
    parts = [dem.Clump.of_size(sizes[k::3], form) for k, form in enumerate(CLUMPS)]
    order = np.argsort(np.argsort(np.arange(n) % 3, kind="stable"))
    return parts[0].appended(*parts[1:]).take(order)


@pytest.fixture(scope="module")
def bed():
    shape = mixed(60)
    side = math.sqrt(shape.area.sum() / 0.86)
    return shape, dem.pack(shape, side, side, None, 1)


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
    clumps, side = dem.Clump([TRIMER, inside]), np.linspace(-3.0, 3.0, 1001)
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


# Motion


@pytest.mark.quick
def test_a_clump_in_free_fall_turns_about_its_centre_of_mass():
    shape = dem.Clump([1e-3 * TRIMER])
    scene = dem.Scene(shape, gravity=(0.0, -9.81), **LEAST)
    begin = dem.State([[1.0, 2.0]], [[0.3, 0.1]], [0.4], [200.0])
    run = dem.Simulation(scene, begin, time_step=1e-6)
    run.advance(1e-3)
    state = run.state
    assert_allclose(state.position, [[1.0 + 3e-4, 2.0 + 1e-4 - 0.5 * 9.81e-6]], rtol=1e-12)
    assert_allclose(state.angle, 0.6, rtol=1e-12)


# Beds


@pytest.mark.quick
def test_clumps_of_one_two_and_three_discs_pack_and_keep_their_energy(bed):
    shape, packed = bed
    assert packed.net_force < 1e-9 and packed.max_overlap < 0.2
    scene = dem.Scene(shape, ELASTIC, LEAST["friction"], packed.walls)
    velocity = 0.5 * np.random.default_rng(1).normal(size=(60, 2))
    run = dem.Simulation(
        scene, dem.State(packed.position, velocity, packed.angle), step_fraction=0.1
    )
    initial = sum(balance(run.world))
    moving = balance(run.world)[0]
    run.advance(1e-4)
    assert abs(balance(run.world)[0] / moving - 1.0) > 0.05
    assert_allclose(sum(balance(run.world)), initial, rtol=1e-4)


# Configurations

T3 = {"kind": "clump", "discs": TRIMER.tolist(), "diameter": 1.1e-3, "granules": 60}
ROD = {"kind": "clump", "discs": [[0, 0, 1], [1.2, 0, 1]], "diameter": 0.9e-3, "granules": 60}
MIX = {"mixture": {"t3": 0.25, "rod": 0.75}, "granules": 61}


def values_of(shape, **shapes):
    """Values of a run of small beds with other shapes."""
    values = load(CONFIG / "smoke.yaml").replicate("c1", 2e3, 1).values()
    return values | {"shapes": values["shapes"] | shapes, "shape": shape}


@pytest.mark.quick
def test_a_configuration_makes_clumps_of_the_area_of_discs_of_the_diameter():
    run = of_values(values_of("t3", t3=T3))
    shape = granules_of(run)
    assert_allclose(np.sqrt(4.0 / np.pi * shape.area).mean(), 1.1e-3, rtol=0.05)
    assert_allclose(shape.discs[:3] / shape.discs[0, 2], dem.Clump([TRIMER]).discs, rtol=1e-12)
    assert run.labels()["kind"] == "clump" and 1.1 < run.shape.ratio < 1.3


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_period_that_is_too_short_for_clumps_is_refused_before_a_bed_is_made(share):
    """By the circles about their centres of mass that hold them, as a scene is."""
    hammer = [[0.0, 0.0, 1.0], [3.0, 0.0, 0.3]]
    values = values_of(
        "h", h={"kind": "clump", "discs": hammer, "diameter": 1.1e-3, "granules": 200}
    )
    values["packing"]["size_spread"] = 0.0
    radius = dem.Clump.of_size([1.1e-3], hammer).bounding_radius[0]
    least = 2.5 * (radius + max(radius, 0.5 * values["cylinder"]["diameter"]))
    values |= {"periodic": "x", "box_width": share * least}
    if share > 1.0:
        assert of_values(values).configuration.periodic == "x"
        return
    with pytest.raises(InputError, match=r"periodic is x: .* along x it must be at least"):
        of_values(values)


@pytest.mark.quick
def test_a_mixture_has_its_shapes_in_their_shares_and_another_order_for_each_seed():
    values = values_of("mix", t3=T3, rod=ROD, mix=MIX)
    kinds = [np.bincount(granules_of(of_values(values | {"seed": seed})).owner) for seed in (1, 2)]
    for counts in kinds:
        assert np.bincount(counts).tolist() == [0, 0, 46, 15]
    assert (kinds[0] != kinds[1]).any()
    run = of_values(values)
    assert run.labels()["kind"] == "mixture"
    assert_allclose(run.shape.diameter, 0.25 * 1.1e-3 + 0.75 * 0.9e-3)
    sizes = np.sqrt(4.0 / np.pi * granules_of(run).area)
    assert_allclose(sizes[kinds[0] == 3].mean(), 1.1e-3, rtol=0.1)
    assert_allclose(sizes[kinds[0] == 2].mean(), 0.9e-3, rtol=0.05)


@pytest.mark.quick
def test_a_mixture_is_known_by_its_shapes():
    """A run of it has the values of the shapes that it is of, and reads no others."""
    values = values_of("mix", t3=T3, rod=ROD, mix=MIX)
    run = of_values(values)
    assert set(run.values()["shapes"]) == {"mix", "rod", "t3"}
    assert of_values(run.values()).id == run.id
    other = values["shapes"] | {"c1": T3, "rod": ROD | {"granules": 99}}
    assert of_values(values | {"shapes": other}).id == run.id
    other = values["shapes"] | {"rod": ROD | {"diameter": 0.8e-3}}
    assert of_values(values | {"shapes": other}).id != run.id


def test_a_bed_of_two_materials_is_at_rest_and_has_the_masses_of_both():
    disc, steel = {"kind": "disc", "granules": 60}, {"young_modulus": 200e9, "density": 7.8e3}
    values = values_of(
        "mix",
        glass=disc | {"diameter": 1.0e-3},
        steel=disc | {"diameter": 1.2e-3, "material": steel},
        mix={"mixture": {"glass": 0.5, "steel": 0.5}, "granules": 60},
    )
    run = of_values(values)
    simulation = start(run, make_bed(run))
    scene, contacts = simulation.scene, simulation.contacts()
    densities = scene.mass / scene.shape.area / scene.thickness
    assert_allclose(np.sort(densities)[[0, 29, 30, 59]], [2e3, 2e3, 7.8e3, 7.8e3])
    force, net = contacts.force[:, None] * contacts.normal, np.zeros((60, 2))
    np.add.at(net, contacts.granule, -force)
    pairs = contacts.partner >= 0
    np.add.at(net, contacts.partner[pairs], force[pairs])
    assert np.abs(net).max() < 1e-6 * contacts.force.max()
    softer = values | {"material": values["material"] | {"young_modulus": 1e9}}
    assert of_values(softer).bed_id != run.bed_id


def bodies(light, heavy):
    """Granules of two densities (kg/m3), and what has the density of the bed: mass (kg) and damping
    (N s/m) of its lid, inertia (kg m2) of a free cylinder, rate (1/s) of shear."""
    disc = {"kind": "disc", "granules": 60}
    light, heavy = ({"young_modulus": 70e9, "density": density} for density in (light, heavy))
    values = values_of(
        "mix",
        light=disc | {"diameter": 0.9e-3, "material": light},
        heavy=disc | {"diameter": 1.2e-3, "material": heavy},
        mix={"mixture": {"light": 0.3, "heavy": 0.7}, "granules": 60},
    )
    packing, cylinder = (values.pop(name) for name in ("packing", "cylinder"))
    pressed = packing | {"fraction": None, "pressure": 6e7}
    run = of_values(values | {"packing": pressed, "cylinder": cylinder | {"spin": "free"}})
    width, height = run.configuration.box_width, 10e-3
    bed = Bed(np.zeros((60, 2)), np.zeros(60), width, height, 0.0, 0.0, 0.0, 0.0, None)
    scene = make_scene(run, bed)
    lid, (solid,) = scene.walls[-1].motion, scene.solids
    sheared = of_values(sheared_values() | {name: values[name] for name in ("shapes", "shape")})
    return scene, [lid.mass, lid.damping, solid.spin.inertia, shear.rate_of(sheared)]


@pytest.mark.quick
def test_what_has_the_density_of_the_bed_has_that_of_all_its_granules_together():
    """Mass over volume, whatever the density of the run; of granules of one density it is that."""
    scene, mixed = bodies(2.0e3, 7.8e3)
    mean = scene.mass.sum() / (scene.shape.area.sum() * scene.thickness)
    assert 5.0e3 < mean < 7.0e3
    assert_allclose(mixed, bodies(mean, mean)[1], rtol=1e-12)
    (mass, *_), width = mixed, scene.planes[1, 2]
    assert_allclose(mass, mean * width * scene.thickness**2, rtol=1e-12)


@pytest.mark.quick
def test_a_run_is_known_by_the_discs_in_a_file(tmp_path):
    """And not by the name of the file; the example of docs/howto/clumps.md."""
    page = (ROOT / "docs/howto/clumps.md").read_text()
    text = page.partition("```yaml\n")[2].partition("```")[0]
    (tmp_path / "my.yaml").write_text(text.replace("config/", f"{CONFIG}/"))
    file = tmp_path / "stone.csv"
    np.savetxt(file, TRIMER, delimiter=",", header="x,y,radius")
    sweep = load(tmp_path / "my.yaml")
    assert sweep.replicate("stone", 2e3, 1).id == of_values(values_of("t3", t3=T3)).id
    assert sweep.replicate("mix", 2e3, 1).labels()["kind"] == "mixture"
    for change, sentence in (
        (
            lambda: file.write_text("0, 0\n"),
            r"stone\.discs is \[\[0\.0, 0\.0\]\]; it must be a list",
        ),
        (file.unlink, r"my\.yaml: shapes\.stone\.discs is 'stone\.csv'; it must be a file"),
    ):
        change()
        with pytest.raises(InputError, match=sentence):
            load(tmp_path / "my.yaml")
