"""Beds: what was asked for, at rest, nothing outside, nothing interlocked."""

import math
import platform
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from beds import STIFF, make_small_bed
from matplotlib.path import Path
from numpy.testing import assert_allclose
from project import CONFIG
from reference import parting
from twin import Twin

import dem
from dem.contacts.force_law import effective_modulus
from dem.experiment.bed import make_bed
from dem.io.dataset import read
from dem.packing.compaction import Press
from dem.packing.random import Room, dilute_start
from dem.packing.swelling import _moved
from dem.shapes import KINDS
from dem.sweep.config import load

# At 0.84 ellipses are below jamming and touch nothing; at 0.88 they press on each other.
BEDS = [*STIFF, ("ellipse", 0.84)]


@pytest.fixture(params=BEDS, ids=lambda bed: f"{bed[0]} at {bed[1]}")
def small(request):
    kind, fraction = request.param
    return make_small_bed(kind, fraction=fraction)


@pytest.mark.quick
@pytest.mark.parametrize(("kind", "fraction"), BEDS)
def test_packing_fraction_is_exact(kind, fraction):
    """Sampled areas over the free area of the returned box are the fraction asked for."""
    small = make_small_bed(kind, fraction=fraction)
    bed = small.bed
    free = bed.width * bed.height - np.pi * small.cylinder.radius**2
    assert_allclose(0.25 * np.pi * (small.diameters**2).sum() / free, fraction, rtol=1e-12)
    assert_allclose(small.shape.area.sum() / free, fraction, rtol=1e-12)


@pytest.mark.parametrize(
    "outline",
    [dem.Disc([1e-3]), dem.Ellipse([2e-3], [1e-3]), dem.plate(4e-3, 0.6e-3),
     dem.Polygon([[-2e-3, -1e-3], [2e-3, -1e-3], [0.0, 2e-3]], 0.4e-3)],
    ids=["disc", "ellipse", "plate", "wedge"],
)  # fmt: skip
def test_granules_begin_beside_a_solid_and_none_may_end_in_it(outline):
    """The depth of a point is its distance to the outline; outside, negative, it is not more."""
    solid = dem.Solid(outline, (6e-3, 5e-3), 0.7)
    shape, room = dem.Disc(np.full(200, 0.3e-3)), Room(12e-3, 10e-3, (solid,), 1)
    factor, state = dilute_start(shape, room)
    assert room.depth(solid, state.position).max() < -0.99 * factor * 0.3e-3
    points = np.random.default_rng(1).uniform(2e-3, 10e-3, (500, 2))
    ring = solid.placed(solid.position, solid.angle)
    start, side = ring[:-1], np.diff(ring, axis=0)
    offset = points[:, None] - start
    along = (offset * side).sum(axis=-1) / np.maximum((side**2).sum(axis=-1), 1e-30)
    nearest = offset - np.clip(along, 0.0, 1.0)[..., None] * side
    distance = np.hypot(*np.moveaxis(nearest, -1, 0)).min(axis=1)
    inside, depth = Path(ring).contains_points(points), room.depth(solid, points)
    close = 1e-2 * solid.radius  # outlines are drawn with corners
    assert inside.sum() > 10
    assert_allclose(depth[inside], distance[inside], atol=close)
    assert (depth[~inside] < close).all() and (-depth <= distance + close)[~inside].all()


@pytest.mark.parametrize("seed", [1, 3, 5])
def test_no_granule_begins_between_solids_where_it_does_not_fit_at_full_size(seed):
    """Between two plates 0.75 mm apart, which it could not leave as it grows: of 20 beds at a fraction of
    0.75, 11 failed."""
    shape = dem.Disc.of_size(np.linspace(0.9e-3, 1.1e-3, 60))
    plates = tuple(dem.Solid(dem.plate(4e-3, 1e-3), (4e-3, y)) for y in (3e-3, 4.75e-3))
    factor, state = dilute_start(shape, Room(8e-3, 9e-3, plates, seed))
    x, y = state.position.T
    assert 2.0 * factor * shape.radius.max() < 0.75e-3
    assert not ((abs(x - 4e-3) < 1.5e-3) & (y > 3.5e-3) & (y < 4.25e-3)).any()


@pytest.mark.quick
@pytest.mark.parametrize("kind", ["disc", "dumbbell"])
def test_bed_is_at_rest(kind):
    """No granule feels a net force or torque, by a sum over all pairs, walls and the cylinder; and the
    pressure is the force on the walls over their length and E*."""
    small = make_small_bed(kind)
    soft = dem.Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=1.0)
    cylinder = replace(small.cylinder, velocity=(0.0, 0.0))
    scene = small.scene(material=soft, friction=dem.Friction(0.0, 0.0, 0.0), solids=cylinder)
    model = Twin(scene, small.state)
    force, torque = model.force, model.torque
    radius = small.shape.constituent_radius.mean()
    unit = 0.5 * radius**2  # E* R^2
    assert np.hypot(*force.T).max() < 1.5e-9 * unit
    assert np.abs(torque).max() < 3e-9 * unit * radius
    assert small.bed.pressure > 1e-7 * radius  # there are forces to balance
    length, modulus = 2.0 * (small.bed.width + small.bed.height), 0.5  # Pa
    pressure = np.hypot(*model.walls.force.T).sum() / (length * modulus)
    assert_allclose(small.bed.pressure, pressure, rtol=1e-6)


def test_no_centre_outside_or_in_the_cylinder(small):
    """All centres lie in the box and outside of the cylinder, and overlaps are moderate."""
    position, bed = small.bed.position, small.bed
    assert ((position > 0.0) & (position < [bed.width, bed.height])).all()
    distance = np.hypot(*(position - small.cylinder.position).T)
    assert (distance > small.cylinder.radius).all()
    assert 0.0 <= bed.max_overlap < 0.2
    assert len(position) == len(small.diameters) and np.isfinite(position).all()


def crosses(a, b, c, d):
    """Whether the segments ab and cd cross."""

    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0.0

    return side(a, b, c) != side(a, b, d) and side(c, d, a) != side(c, d, b)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_dumbbells_never_interlock(seed):
    """The lines that join the two discs of a dumbbell never cross."""
    small = make_small_bed("dumbbell", seed)
    arm = small.shape.radius[:, None] * np.column_stack(
        [np.cos(small.bed.angle), np.sin(small.bed.angle)]
    )
    ends = list(zip(small.bed.position + arm, small.bed.position - arm, strict=True))
    for i, one in enumerate(ends):
        assert not any(crosses(*one, *other) for other in ends[:i])


def test_overlaps_of_ellipses_are_as_reported():
    """The greatest overlap and the number of contacts are those of sampled outlines."""
    small = make_small_bed("ellipse", fraction=0.88)
    bed, shape = small.bed, small.shape
    granules = list(
        zip(np.cos(bed.angle), np.sin(bed.angle), shape.semi_major, shape.semi_minor, strict=True)
    )
    overlaps = []
    for i, ellipse in enumerate(granules):
        for j in range(i):
            d = bed.position[j] - bed.position[i]
            if np.hypot(*d) < ellipse[2] + granules[j][2]:
                depth, _ = parting(d, ellipse, granules[j], 300)
                size = math.sqrt(min(ellipse[2] * ellipse[3], granules[j][2] * granules[j][3]))
                overlaps.append(depth / size)
    overlaps = np.array(overlaps)
    touching = (overlaps > 1e-6).sum()
    assert abs(touching - 0.5 * bed.coordination_number * len(granules)) <= 2
    assert touching > len(granules)
    assert overlaps.max() <= bed.max_overlap * (1.0 + 1e-4)


def test_same_seed_same_bits_other_seed_other_bed(small):
    """A bed follows from its seed, to the last bit, and from nothing else."""
    repeat, other = (
        dem.pack(small.shape, small.bed.width, small.bed.height, small.cylinder, seed)
        for seed in (1, 2)
    )
    assert (repeat.position == small.bed.position).all() and (repeat.angle == small.bed.angle).all()
    displacement = np.hypot(*(other.position - small.bed.position).T)
    assert np.median(displacement) > small.diameters.mean()


@pytest.mark.parametrize(
    ("kind", "fraction"), [(kind, {"ellipse": 0.99}.get(kind, 0.97)) for kind in KINDS]
)
def test_impossible_fraction_is_refused(kind, fraction):
    """A fraction that no bed can have ends in a PackingError that names it."""
    with pytest.raises(dem.PackingError, match=f"packing fraction {fraction}"):
        make_small_bed(kind, fraction=fraction)


@pytest.mark.quick
@pytest.mark.parametrize("periodic", ["none", "x", "xy"])
def test_bed_is_sown_apart(periodic):
    """No two bounding circles overlap at the start, nor one and the image of another, or the cylinder."""
    width, height = 8e-3, 9e-3
    cylinder = dem.Cylinder(1.5e-3, (1e-3, 2e-3))
    shape = dem.Ellipse.of_size(np.linspace(0.8e-3, 1.2e-3, 60), 1.5)
    factor, state = dilute_start(shape, Room(width, height, (cylinder,), 3, periodic))
    radius = np.append(factor * shape.bounding_radius, 0.75e-3)
    position = np.vstack([state.position, cylinder.position])
    one, two = np.triu_indices(61, 1)
    separation = position[two] - position[one]
    period = [width if "x" in periodic else np.inf, height if "y" in periodic else np.inf]
    separation -= np.where(np.isfinite(period), period, 0.0) * np.rint(separation / period)
    assert factor < 1.0 and (np.hypot(*separation.T) >= radius[one] + radius[two]).all()


def test_box_too_small_to_scatter_is_refused():
    """A granule that has no room beside the cylinder finds no place, which is an error with a name."""
    shape = dem.Ellipse(np.full(1, 6e-3), np.full(1, 1e-3))
    with pytest.raises(dem.PackingError, match=r"granule 0 of 1 found no free place .* too small"):
        dem.pack(shape, 8e-3, 8e-3, dem.Cylinder(1e-3, (4e-3, 4e-3)), 1)


def test_bed_stays_at_rest_with_friction(small):
    """With friction switched on, no granule gets farther than the rest of net force can push it."""
    cylinder = replace(small.cylinder, velocity=(0.0, 0.0))
    scene, duration = small.scene(solids=cylinder), 2e-4
    run = dem.Simulation(scene, small.state)
    run.advance(duration)
    unit = (
        effective_modulus(scene.material, scene.material)
        * scene.shape.constituent_radius.mean() ** 2
    )
    push = small.bed.net_force * unit / scene.mass.min()  # m/s2
    displacement = np.abs(run.state.position - small.bed.position).max()
    assert displacement < 0.5 * push * duration**2


@pytest.mark.quick
def test_bed_packed_with_friction_jams_sooner(kind="disc"):
    """At the same packing fraction friction leaves more pressure in a bed, which is at rest too."""
    small = make_small_bed(kind)
    room = Room(small.bed.width, small.bed.height, (small.cylinder,), 1)
    rough = Press(small.shape, room, 0.5).bed()
    assert rough.pressure > small.bed.pressure
    assert rough.net_force <= 1e-4
    same = Press(small.shape, room, 0.5).bed()
    assert np.array_equal(rough.position, same.position)
    assert not np.array_equal(rough.position, small.bed.position)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_pressed_bed_jams(friction):
    """Granules that grow feel nothing at first, then ever more pressure."""
    small = make_small_bed("disc")
    press = Press(
        small.shape, Room(small.bed.width, small.bed.height, (small.cylinder,), 1), friction
    )
    pressures = [press.press(fraction) for fraction in (0.74, 0.80, 0.84, 0.88)]
    assert pressures[0] < 1e-2 * pressures[2]
    assert pressures[1] < pressures[2] < pressures[3]
    assert press.net_force <= 1e-4


RELEASED = "packing_net_force", "packing_max_overlap", "packing_coordination_number"
BELOW, ABOVE = 0.76, 0.86  # packing fractions below and above jamming of discs


@cache
def grown(fraction, seed=1):
    """A small bed of discs from `dem.grow`, in the box of the one from `dem.pack`, and the latter."""
    small = make_small_bed("disc", fraction=fraction)
    bed = dem.grow(small.shape, small.bed.width, small.bed.height, small.cylinder, seed)
    return small, bed


@pytest.mark.parametrize("seed", [2, 6])  # the first needs several stages at full size
def test_granules_of_a_grown_bed_below_jamming_are_apart(seed):
    """It carries no load and hardly any granules touch; fewer nearly touch than in a relaxed bed."""
    small, bed = grown(BELOW, seed)
    cylinder = replace(small.cylinder, velocity=(0.0, 0.0))

    def touching(packing, swollen=1.0):
        scene = dem.Scene(small.shape.scaled(swollen), walls=packing.walls, solids=cylinder)
        return (dem.Simulation(scene, packing.state).contacts().partner >= 0).sum()

    assert bed.pressure < 1e-5 * make_small_bed("disc", fraction=ABOVE).bed.pressure
    assert touching(bed) < 0.1 * len(small.diameters)
    assert touching(bed, 1.0001) < 0.75 * touching(small.bed, 1.0001)


def test_grown_bed_above_jamming_is_at_rest_under_load():
    """Like a relaxed bed of the same granules in the same box, by the same measure of rest."""
    small, bed = grown(ABOVE)
    assert bed.net_force <= 1e-9
    assert 0.5 < bed.pressure / small.bed.pressure < 2.0
    assert bed.coordination_number > 3.5


@pytest.mark.parametrize("fraction", [BELOW, ABOVE])
def test_grown_bed_follows_from_its_seed(fraction):
    """The same seed gives the same bits, inside the box; another seed gives another bed."""
    small, bed = grown(fraction)
    room = small.shape, bed.width, bed.height, small.cylinder
    repeat, (_, other) = dem.grow(*room, 1), grown(fraction, 2)
    assert (repeat.position == bed.position).all() and (repeat.angle == bed.angle).all()
    assert np.median(np.hypot(*(other.position - bed.position).T)) > small.diameters.mean()
    assert ((bed.position > 0.0) & (bed.position < [bed.width, bed.height])).all()
    distance = np.hypot(*(bed.position - small.cylinder.position).T)
    assert (distance > small.cylinder.radius).all()


def test_grown_bed_of_an_impossible_fraction_is_refused():
    """It ends in a PackingError that names the fraction."""
    sizes = np.random.default_rng(1).uniform(0.9e-3, 1.1e-3, 60)
    shape = dem.Disc.of_size(sizes)
    cylinder = dem.Cylinder(2e-3, (4e-3, 3e-3))
    height = (shape.area.sum() / 1.10 + np.pi * 1e-6) / 8e-3
    with pytest.raises(dem.PackingError, match=r"packing fraction 1\.1 .* cannot be made"):
        dem.grow(shape, 8e-3, height, cylinder, 1)


@pytest.mark.quick
def test_a_stage_of_growth_keeps_half_of_the_velocities():
    """Of ellipses that meet nothing: they go on, and turn on, at half of the speed."""
    small = make_small_bed("ellipse", fraction=0.80)
    room = Room(small.bed.width, small.bed.height, (small.cylinder,), 1)
    factor, start = dilute_start(small.shape, room)
    rng = np.random.default_rng(1)
    slow = 1e-9 * rng.standard_normal((len(small.diameters), 3))  # no stage ends at a neighbour
    start = dem.State(start.position, slow[:, :2], start.angle, slow[:, 2])
    shape = small.shape.scaled(0.5 * factor)._replace(contact=dem.GeometricPotential())
    end, _ = _moved(room, shape, start, 1)
    assert_allclose(end.velocity, 0.5 * start.velocity, rtol=1e-12)
    assert_allclose(end.angular_velocity, 0.5 * start.angular_velocity, rtol=1e-12)


def test_angles_go_from_stage_to_stage_of_growth_and_into_the_bed(monkeypatch):
    """Each stage turns ellipses that are far apart by 0.1 rad; the bed has the sum."""
    stages = []

    def turned(_, shape, state, threads):
        stages.append(replace(state, angle=state.angle + 0.1))
        return stages[-1], 0.0  # net force

    def half_grown(*room):
        return 0.5, dilute_start(*room)[1]

    monkeypatch.setattr("dem.packing.swelling._moved", turned)
    monkeypatch.setattr("dem.packing.swelling.dilute_start", half_grown)
    shape = dem.Ellipse.of_size(np.full(5, 1e-3), 1.375)
    bed = dem.grow(shape, 30e-3, 30e-3, dem.Cylinder(2e-3, (4e-3, 3e-3)), 1)
    assert len(stages) > 10 and bed.coordination_number == 0.0
    assert_allclose(stages[-1].angle - stages[0].angle, 0.1 * (len(stages) - 1), rtol=1e-9)
    assert_allclose(bed.angle, stages[-1].angle % (2.0 * np.pi), rtol=1e-12)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="bits of another processor")
@pytest.mark.parametrize(("case", "seed"), [("c1", 1), ("d1", 2), ("e1", 2), ("e3", 5)])
def test_a_bed_of_one_patch_keeps_the_bits_of_the_released_ones(case, seed):
    """Net force, overlap and contacts of beds of the paper, to the last bit; of shapes that turn, those that
    change most with the last digit of a step."""
    values, _ = read(CONFIG.parent / "docs/data/drag.nc", ("case", *RELEASED))
    row = [str(name) for name in values["case"]].index(case)
    bed = make_bed(load(CONFIG / "paper.yaml").replicate(case, 3900.0, seed))
    for name in RELEASED:
        assert getattr(bed, name.removeprefix("packing_")) == values[name][row, seed - 1], name


def test_preparation_is_part_of_what_a_bed_is():
    """Beds grown in motion are other beds and runs; the default, written or not, is the old one."""
    sweep = load(CONFIG / "smoke.yaml")

    def replicate(**changes):
        changes = {"fraction": BELOW} | changes
        changes = {f"packing.{name}": value for name, value in changes.items()}
        return sweep.changed(changes, "c1").replicate("c1", 3900.0, 1)

    ways = {}, {"preparation": "relaxed"}, {"preparation": "grown"}
    silent, relaxed, grown = (replicate(**way) for way in ways)
    for name in ("id", "bed_id", "bed_family"):
        assert getattr(silent, name) == getattr(relaxed, name) != getattr(grown, name)
    bed = make_bed(grown)
    assert bed.coordination_number < 0.5 * make_bed(relaxed).coordination_number
    rough = make_bed(replicate(preparation="grown", friction=0.3))
    assert not np.array_equal(rough.position, make_bed(replicate(friction=0.3)).position)
    with pytest.raises(dem.InputError, match=r"packing.preparation is 'shaken'; it must be 'rel"):
        replicate(preparation="shaken")
