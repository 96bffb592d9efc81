"""Clumps of discs, and mixtures: areas of unions, motion, beds, configurations."""

import math

import numpy as np
import pytest
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

TRIMER = np.array([[0.0, 0.0, 1.0], [1.5, 0.2, 0.8], [0.6, 1.3, 0.7]])
FORMS = [[[0.0, 0.0, 1.0]], [[-0.8, 0.0, 0.8], [0.5, 0.1, 0.7]], TRIMER]
ELASTIC = dem.Material(restitution=1.0 - 1e-12)
# as good as none, with the kernels of all others
LEAST = dem.Friction(1e-15, 1e-15, 1e-15)


def mixed(n, diameter=1e-3):
    """Clumps of one, two and three discs in turn, of +-10 % in size."""
    sizes = diameter * np.random.default_rng(3).uniform(0.9, 1.1, n)
    parts = [dem.Clump.of_size(sizes[k::3], form) for k, form in enumerate(FORMS)]
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


def test_area_centre_and_inertia_of_a_union_are_sums_over_its_points():
    """Of three discs, and of two of which one is twice there and one is inside another."""
    inside = [(0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.2, 0.0, 0.5), (1.1, 0.0, 0.6)]
    clumps, side = dem.Clump([TRIMER, inside]), np.linspace(-3.0, 3.0, 2001)
    points = np.stack(np.meshgrid(side, side), axis=-1)
    for g in range(2):
        discs = clumps.discs[clumps.owner == g]
        distance = np.linalg.norm(points[..., None, :] - discs[:, :2], axis=-1)
        point = points[(distance < discs[:, 2]).any(axis=-1)]
        assert_allclose(clumps.area[g], len(point) * (side[1] - side[0]) ** 2, rtol=1e-3)
        assert np.abs(point.mean(axis=0)).max() < 1e-3
        assert_allclose(clumps.gyration_squared[g], (point**2).sum(axis=1).mean(), rtol=1e-3)


def test_clumps_that_are_taken_scaled_or_appended_are_those_that_are_made_so():
    clumps = dem.Clump([np.multiply(form, 1e-3) for form in FORMS])
    other = dem.Clump([2e-3 * TRIMER, np.multiply(FORMS[0], 2e-3)])
    result = clumps.scaled(2.0).take([2, 0]).appended(clumps.take([1]))
    assert_allclose(result.discs, np.vstack([other.discs, clumps.discs[1:3]]), atol=1e-18)
    assert result.owner.tolist() == [0, 0, 0, 1, 2, 2] and result.first.tolist() == [0, 3, 4, 6]


def test_a_granule_of_several_forms_in_one_bed_keeps_the_laws():
    dem.check_shape(mixed(6))


@pytest.mark.parametrize(
    "discs", [[], [[]], [(0.0, 0.0, 1e-3)], [[(0.0, 0.0, 0.0)]], [[(0.0, 1.0)]], [[(math.nan, 0, 1)]], 3]
)  # fmt: skip
def test_what_is_no_list_of_discs_is_refused(discs):
    with pytest.raises(InputError, match=r"Clump\.discs is .*; it must be one list of discs"):
        dem.Clump(discs)


# Motion


def test_a_clump_in_free_fall_turns_about_its_centre_of_mass():
    shape = dem.Clump([1e-3 * TRIMER])
    scene = dem.Scene(shape, friction=dem.Friction(), gravity=(0.0, -9.81))
    start = dem.State([[1.0, 2.0]], [[0.3, 0.1]], [0.4], [200.0])
    run = dem.Simulation(scene, start, time_step=1e-6)
    run.advance(1e-3)
    state = run.state
    assert_allclose(state.position, [[1.0 + 3e-4, 2.0 + 1e-4 - 0.5 * 9.81e-6]], rtol=1e-12)
    assert_allclose(state.angle, 0.6, rtol=1e-12)
    x, y = shape.discs[:, :2].T
    c, s = math.cos(0.6), math.sin(0.6)
    discs = state.position + np.stack([c * x - s * y, s * x + c * y], axis=-1)
    assert_allclose(run.world.constituents[:, :2], discs, rtol=1e-12)


@pytest.mark.parametrize("more", [[0.0, 0.0, 1.0], [0.0, -0.2, 0.8], [0.0, -0.5, 0.5]])
def test_a_disc_inside_another_of_its_clump_bears_no_force(more):
    """A union has the surface of its outline: what is within returns nothing to a wall."""
    shape = dem.Clump([1e-3 * np.array([[0.0, 0.0, 1.0], more])])
    damped = dem.Material(restitution=0.5)
    scene = dem.Scene(shape, damped, LEAST, [[0.0, -1.0, 0.0]])
    run = dem.Simulation(scene, dem.State([[0.0, 1.001e-3]], [[0.0, -1.0]]))
    run.advance(1e-4)
    assert_allclose(run.state.velocity[0, 1], 0.5, rtol=1e-2)
    assert scene.mass[0] == dem.Scene(dem.Clump([[[0.0, 0.0, 1e-3]]])).mass[0]


def test_an_impact_is_that_of_a_rigid_body():
    """A wall gives the impulse 2 v_n / (1/m + arm^2/I) at the disc that meets it."""
    shape = dem.Clump([1e-3 * TRIMER])
    x, y, radius = shape.discs[2]
    scene = dem.Scene(shape, ELASTIC, LEAST, [[0.0, -1.0, 0.0]])
    angle, speed = math.pi - 0.2, 0.02
    drop = math.sin(angle) * x + math.cos(angle) * y - radius
    arm = math.cos(angle) * x - math.sin(angle) * y  # of the force along y through the disc
    start = dem.State([[0.0, 1e-8 - drop]], [[0.0, -speed]], [angle])
    run = dem.Simulation(scene, start, step_fraction=0.02)
    while run.state.velocity[0, 1] + run.state.angular_velocity[0] * arm < 0.9 * speed:
        run.advance(2e-6)
    run.advance(2e-5)
    impulse = 2.0 * speed / (1.0 / scene.mass[0] + arm**2 / scene.inertia[0])
    assert abs(arm) > 0.1 * radius
    assert_allclose(run.state.velocity[0, 1], impulse / scene.mass[0] - speed, atol=1e-4 * speed)
    assert_allclose(run.state.angular_velocity[0], impulse * arm / scene.inertia[0], rtol=1e-4)


def test_a_clump_of_two_discs_that_touch_moves_as_a_dumbbell(small_bed):
    small = small_bed("dumbbell")
    one = np.array([[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])
    scene, clumps = small.scene(), dem.Clump([r * one for r in small.shape.radius])
    scenes = scene, small._replace(shape=clumps).scene()
    runs = [dem.Simulation(case, small.state, 2e-8) for case in scenes]
    for run in runs:
        run.advance(4e-6)
    (one, two), size = (run.state for run in runs), small.shape.radius.mean()
    assert np.abs(one.position - small.state.position).max() > 1e-3 * size
    assert_allclose(two.position, one.position, rtol=0.0, atol=1e-12 * size)
    assert_allclose(two.angle, one.angle, rtol=0.0, atol=1e-11)


# Beds


def test_clumps_of_one_two_and_three_discs_pack_and_keep_their_energy(bed):
    shape, packed = bed
    assert packed.net_force < 1e-9 and packed.max_overlap < 0.2
    scene = dem.Scene(shape, ELASTIC, LEAST, packed.walls)
    velocity = 0.5 * np.random.default_rng(1).normal(size=(60, 2))
    run = dem.Simulation(
        scene, dem.State(packed.position, velocity, packed.angle), step_fraction=0.1
    )
    initial = sum(balance(run.world))
    moving = balance(run.world)[0]
    run.advance(1e-4)
    assert abs(balance(run.world)[0] / moving - 1.0) > 0.05
    assert_allclose(sum(balance(run.world)), initial, rtol=1e-4)


def test_contacts_of_clumps_are_those_of_their_discs(bed):
    """Found by brute force among all discs, and named by their granules."""
    shape, packed = bed
    run = dem.Simulation(dem.Scene(shape, ELASTIC, LEAST, packed.walls), packed.state)
    point, owner = run.world.constituents[:, :2], shape.owner
    apart = np.linalg.norm(point[:, None] - point, axis=2) - np.add.outer(*2 * [shape.discs[:, 2]])
    i, j = np.nonzero(np.triu((apart < 0.0) & (owner[:, None] != owner)))
    contacts = run.contacts()
    pairs = np.sort(
        np.stack([contacts.granule, contacts.partner])[:, contacts.partner >= 0], axis=0
    )
    assert len(i) > 60
    assert sorted(zip(*pairs.tolist(), strict=True)) == sorted(
        zip(owner[i].tolist(), owner[j].tolist(), strict=True)
    )


# Configurations

T3 = {"kind": "clump", "discs": TRIMER.tolist(), "diameter": 1.1e-3, "granules": 60}
ROD = {"kind": "clump", "discs": [[0, 0, 1], [1.2, 0, 1]], "diameter": 0.9e-3, "granules": 60}
MIX = {"mixture": {"t3": 0.25, "rod": 0.75}, "granules": 61}


def values_of(shape, **shapes):
    """Values of a run of small beds with other shapes."""
    values = load(CONFIG / "smoke.yaml").replicate("c1", 2e3, 1).values()
    return values | {"shapes": values["shapes"] | shapes, "shape": shape}


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


def test_what_has_the_density_of_the_bed_has_that_of_all_its_granules_together():
    """Mass over volume, whatever the density of the run; of granules of one density it is that."""
    scene, mixed = bodies(2.0e3, 7.8e3)
    mean = scene.mass.sum() / (scene.shape.area.sum() * scene.thickness)
    assert 5.0e3 < mean < 7.0e3
    assert_allclose(mixed, bodies(mean, mean)[1], rtol=1e-12)
    (mass, *_), width = mixed, scene.planes[1, 2]
    assert_allclose(mass, mean * width * scene.thickness**2, rtol=1e-12)


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


@pytest.mark.parametrize(
    ("shapes", "sentence"),
    [
        ({"m": {"mixture": {"c1": 1.0}, "granules": 9}}, "mixture"),
        ({"m": {"mixture": {"c1": 0.5, "x": 0.5}, "granules": 9}}, r"shapes\.m\.mixture has 'x', which is not one"),
        ({"m": {"mixture": {"c1": 0.5, "t3": 0.5}, "granules": 9}, "t3": T3}, "has the kinds clump and disc"),
        ({"m": {"mixture": {"t3": 0.5, "rod": 0.4}, "granules": 9}, "t3": T3, "rod": ROD}, r"sum to 0\.9; they must"),
        ({"m": MIX, "t3": T3, "rod": ROD, "n": {"mixture": {"m": 0.5, "t3": 0.5}, "granules": 9}}, "a mixture itself"),
        ({"m": MIX | {"material": {"young_modulus": 1e9}}, "t3": T3, "rod": ROD}, "a mixture takes none, its shapes have theirs"),
        ({"m": MIX | {"diameter": 1e-3}, "t3": T3, "rod": ROD}, "diameter is given; a mixture takes none"),
        ({"t3": T3 | {"discs": None}}, r"shapes\.t3: discs is missing; kind clump needs one"),
        ({"t3": T3 | {"kind": "disc"}}, "discs is given; kind disc takes none"),
        ({"t3": T3 | {"discs": [[0, 0]]}}, r"shapes\.t3\.discs is .*; it must be a list of discs"),
        ({"t3": T3 | {"aspect_ratio": 2.0}}, "aspect_ratio is given; kind clump takes none"),
        ({"t3": {"granules": 9}}, r"shapes\.t3: kind is missing; a shape needs one"),
    ],
)  # fmt: skip
def test_what_is_no_clump_and_no_mixture_is_refused(shapes, sentence):
    with pytest.raises(InputError, match=sentence):
        of_values(values_of("c1", **shapes))
