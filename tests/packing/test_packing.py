"""Beds of all ways of packing keep one table of promises; then what each way promises beside these."""

import platform
from contextlib import suppress
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from beds import PRESSURE, STIFF, make_small_bed, section_of
from matplotlib.path import Path
from numpy.testing import assert_allclose, assert_array_equal
from outlines import parting
from project import CONFIG
from sweeps import smoke
from twin import Twin

import dem
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene
from dem.io.dataset import read
from dem.packing.random import Room, dilute_start
from dem.shapes import KINDS
from dem.sweep.config import load

WIDTH = 11e-3  # m: boxes are two thirds as high
BELOW, DENSE = 0.76, 0.84  # packing fractions below and above jamming of discs
WEIGHT = 9.81e3  # m/s2
STEEL = {"young_modulus": 200e9, "poisson_ratio": 0.3, "density": 7800.0}
SHAPES = {kind: section_of(kind).model_dump(exclude_none=True) for kind in KINDS} | {
    "many": {"kind": "disc", "diameter": 1e-3, "granules": 1100},  # more than a patch
    "soft": {"kind": "disc", "diameter": 1.2e-3, "granules": 60},
    "steel": {"kind": "disc", "diameter": 0.8e-3, "granules": 60, "material": STEEL},
    "mixture": {"mixture": {"soft": 0.5, "steel": 0.5}, "granules": 60},
}
# shape of the granules, and what differs from the small bed of config/smoke.yaml
BEDS = {
    **{kind: (kind, {"packing.fraction": fraction}) for kind, fraction in STIFF},
    "below jamming": ("disc", {"packing.fraction": BELOW}),
    "grown": ("disc", {"packing.preparation": "grown"}),
    "grown below jamming": ("disc", {"packing.preparation": "grown", "packing.fraction": BELOW}),
    "with friction": ("disc", {"packing.friction": 0.5}),
    "under a pressure": ("disc", {"packing.fraction": None, "packing.pressure": PRESSURE}),
    "settled": (
        "disc",
        {"packing.preparation": "settled", "packing.fraction": 0.6, "gravity": WEIGHT},
    ),
    "along x": ("disc", {"periodic": "x"}),
    "without walls": ("disc", {"periodic": "xy"}),
    "around two cylinders": ("disc", {"second": {"diameter": 1e-3, "gap": 3e-4, "bearing": 0.5}}),
    "around a wedge": (
        "disc",
        {"cylinder.outline": "wedge", "cylinder.diameter": 3e-3, "cylinder.start": 0.4},
    ),
    "of springs": ("disc", {"periodic": "x", "contact.law": "linear"}),
    "mixture": ("mixture", {}),
    "large": ("many", {"packing.fraction": 0.86, "box_width": 40e-3}),
}
# around a wedge they are not this simple
OF_DISCS = [name for name in BEDS if name == "disc" or name not in (*KINDS, "around a wedge")]
QUICK = pytest.mark.quick


@cache
def run_of(name, seed=1, **more):
    """The run of a bed."""
    shape, changes = BEDS[name]
    sweep = smoke(shapes=SHAPES, cases={"one": {"shape": shape, "density": 3900.0}})
    return sweep.changed({"box_width": WIDTH} | changes | more, shape).replicate(
        shape, 3900.0, seed
    )


class Packed(NamedTuple):
    """A bed; the scene of its run with solids at rest; that scene in plain numpy; E* (Pa), or the
    stiffness (N/m) of contacts that are springs, of two of the stiffest granules."""

    bed: dem.Bed
    scene: dem.Scene
    model: Twin
    modulus: float

    @property
    def unit(self):
        """Of forces (N)."""
        radius = self.scene.shape.constituent_radius.mean()
        return self.modulus * radius ** (1 if isinstance(self.scene.law, dem.Linear) else 2)

    @property
    def contacts(self):
        """Pairs (k, 2) of discs that touch and their overlap (k,) in m; and the overlaps over their radii
        (n, m) of discs with walls and solids."""
        radius, position = self.scene.shape.radius, self.bed.position
        one, two = np.triu_indices(len(radius), 1)
        apart = self.model.nearest(position[two] - position[one])
        overlap = radius[one] + radius[two] - np.hypot(*apart.T)
        touch = overlap > 0.0
        normal, offset = self.scene.planes[:, :2], self.scene.planes[:, 2]
        aside = (position @ normal.T + radius[:, None] - offset) / radius[:, None]
        around = [
            (radius + s.radius - np.hypot(*self.model.nearest(position - s.position).T))
            / np.minimum(radius, s.radius)
            for s in self.scene.solids
        ]
        pairs = np.column_stack([one, two])[touch]
        return pairs, overlap[touch], np.column_stack([aside, *around])


@cache
def packed(name, seed=1):
    run = run_of(name, seed)
    bed = make_bed(run)
    scene = make_scene(run, bed)
    scene = replace(scene, solids=[replace(s, velocity=(0.0, 0.0)) for s in scene.solids])
    young, poisson = (200e9, 0.3) if name == "mixture" else (70e9, 0.22)
    modulus = 0.5 * young / (1.0 - poisson**2)
    if name == "of springs":
        modulus *= 0.25 * np.pi * run.thickness
    return Packed(bed, scene, Twin(scene, bed.state), modulus)


@QUICK
@pytest.mark.parametrize("name", BEDS)
def test_a_bed_fills_its_box_as_asked_for(name):
    """Areas of the granules over the box beside the solids; none is outside or in a solid."""
    bed, scene, model, _ = packed(name)
    asked = run_of(name).configuration
    free = bed.width * bed.height - sum(solid.area for solid in scene.solids)
    if asked.packing.fraction is not None:
        assert_allclose(scene.shape.area.sum() / free, asked.packing.fraction, rtol=1e-9)
    assert bed.width == asked.box_width
    assert ((bed.position >= 0.0) & (bed.position <= [bed.width, bed.height])).all()
    assert len(bed.position) == scene.granules and np.isfinite(bed.angle).all()
    for solid in scene.solids:
        ring = solid.placed((0.0, 0.0), solid.angle, 513)
        assert not Path(ring).contains_points(model.nearest(bed.position - solid.position)).any()
    assert 0.0 <= bed.max_overlap < 0.2


@QUICK
@pytest.mark.parametrize("name", BEDS)
def test_a_bed_is_at_rest_as_it_says(name):
    """By a sum over all pairs, walls and solids, with the weight: no net force or torque, in units of E* R^2.
    Friction holds granules of a bed packed with it."""
    bed, scene, model, _ = small = packed(name)
    force = model.force + np.multiply.outer(scene.mass, scene.gravity or (0.0, 0.0))
    net = np.hypot(*force.T).max() / small.unit
    moving = {"with friction": 2e-4, "settled": 1e-6, "large": 1e-6}
    assert bed.net_force <= moving.get(name, 1e-9)
    if name != "with friction":
        assert_allclose(bed.net_force, net, rtol=5e-2 if name == "settled" else 1e-4, atol=1e-14)
        radius = scene.shape.constituent_radius.mean()
        assert np.abs(model.torque).max() < 3.0 * max(1e-9, bed.net_force) * small.unit * radius
    if name == "large":  # also next to its own forces
        pairs, overlap, _ = small.contacts  # of two equal spheres: 4/3 E* sqrt(R/2) overlap^(3/2)
        radius = 1.0 / (1.0 / scene.shape.radius[pairs]).sum(axis=1)
        force = 4.0 / 3.0 * small.modulus * np.sqrt(radius) * overlap**1.5
        assert net * small.unit < 5.5e-3 * force.mean()


@QUICK
@pytest.mark.parametrize("name", BEDS)
def test_the_pressure_is_the_force_on_the_walls_over_their_length(name):
    """Over E* too. Without walls it is the mean normal stress of the contacts."""
    bed, scene, model, modulus = packed(name)
    if scene.walls:
        normal = scene.planes[:, :2]
        force = (model.walls.force * normal).sum()
        length = np.where(normal[:, 0] != 0.0, bed.height, bed.width).sum()
        expected = force / length / modulus
    else:
        contacts = dem.Simulation(scene, bed.state).contacts()
        centre = np.vstack([bed.position, scene.solids[0].position])  # the last is partner -1
        branch = model.nearest(centre[contacts.partner] - bed.position[contacts.granule])
        work = contacts.force @ np.hypot(*branch.T)
        expected = 0.5 * work / (bed.width * bed.height) / modulus
    assert_allclose(bed.pressure, expected, rtol=2e-3, atol=1e-15)
    loose = "below jamming", "grown below jamming", "settled"
    assert name in loose or bed.pressure > 1e-8
    if name == "under a pressure":
        top = model.walls.force[-1, 1] / (bed.width * scene.thickness)
        assert_allclose(top, PRESSURE, rtol=2e-3)


@QUICK
@pytest.mark.parametrize("name", ["ellipse", *OF_DISCS])
def test_overlaps_and_contacts_are_as_a_bed_says(name):
    """Those of ellipses by their sampled outlines."""
    bed, scene, _, _ = small = packed(name)
    shape = scene.shape
    if name == "ellipse":
        turn, (c, s) = np.linspace(0.0, 2.0 * np.pi, 2001), (np.cos(bed.angle), np.sin(bed.angle))
        across = np.multiply.outer(shape.semi_major, np.cos(turn))
        along = np.multiply.outer(shape.semi_minor, np.sin(turn))
        c, s, size = c[:, None], s[:, None], np.sqrt(shape.semi_major * shape.semi_minor)
        outlines = np.stack([c * across - s * along, s * across + c * along], axis=-1)
        away = bed.position - bed.position[:, None]
        near = np.hypot(*away.T) < shape.semi_major + shape.semi_major[:, None]
        shares = np.array(
            [
                parting(away[i, j], outlines[i], outlines[j])[0] / min(size[i], size[j])
                for i, j in np.argwhere(np.triu(near, 1))
            ]
        )
        shares = shares[shares > 1e-6]
        # the deepest of all may be at a wall
        assert 0.5 * bed.max_overlap < shares.max() <= bed.max_overlap * (1.0 + 1e-4)
    else:
        pairs, overlap, beside = small.contacts
        shares = overlap / shape.radius[pairs].min(axis=1)
        deepest = max(shares.max(initial=0.0), beside.max())
        assert_allclose(bed.max_overlap, deepest, rtol=1e-6, atol=1e-12)
    assert_allclose(bed.coordination_number, 2.0 * len(shares) / scene.granules, atol=0.05)


@pytest.mark.parametrize("name", BEDS)
def test_a_bed_follows_from_its_seed_and_not_from_threads(name):
    """To the last bit; another seed gives another bed."""
    bed = packed(name)[0]
    same = make_bed(run_of(name, threads=2 if name == "large" else 1))
    for one, two in zip(bed, same, strict=True):
        assert_array_equal(one, two)
    if name != "large":
        other = make_bed(run_of(name, seed=2))
        moved = np.hypot(*(other.position - bed.position).T)
        assert np.median(moved) > 1e-3


@pytest.mark.parametrize("pieces", [3, 14])
@pytest.mark.parametrize("name", ["large", "under a pressure", "with friction"])
def test_a_bed_that_is_stopped_goes_on_to_the_same_bits(tmp_path, name, pieces):
    """While granules grow, while the top wall comes down, and at full size."""
    path, resumed, reports = tmp_path / "bed.npz", None, []

    def report(*progress):
        reports.append(progress)
        if len(reports) % (pieces + 1) == 0:
            raise KeyboardInterrupt

    while resumed is None:
        with suppress(KeyboardInterrupt):
            resumed = make_bed(run_of(name), path, report)
        assert path.is_file()
    assert len(reports) > pieces
    for one, two in zip(packed(name)[0], resumed, strict=True):
        assert_array_equal(one, two)
    with pytest.raises(dem.InputError, match=r"bed\.npz: it is damaged or of another bed"):
        make_bed(run_of(name, seed=2), path)


def test_what_was_reached_is_kept_of_a_bed_that_does_not_come_to_rest(tmp_path, monkeypatch):
    """The same call goes on from there, with as many iterations again; here there are few, to be quick."""
    monkeypatch.setattr("dem.packing.random.most_iterations", lambda *bed: 500)
    bed, refused = None, []
    while bed is None and len(refused) < 40:
        try:
            bed = make_bed(run_of("large"), tmp_path / "bed.npz")
        except dem.PackingError as error:
            refused.append("not at rest after 500 iterations: net force" in str(error))
    assert refused and all(refused) and bed.net_force < 1e-6


def test_what_finds_no_place_is_refused():
    """A granule in a box that is too small, granules that meet while they grow, and too many."""
    cylinder = dem.Cylinder(1e-3, (4e-3, 4e-3))
    shape = dem.Ellipse([6e-3], [1e-3])
    with pytest.raises(dem.PackingError, match=r"granule 0 of 1 found no free place .* too small"):
        dem.pack(shape, 8e-3, 8e-3, cylinder, 1)
    shape = dem.Disc.of_size(np.linspace(0.9e-3, 1.1e-3, 60))
    height = (shape.area.sum() / 1.10 + cylinder.area) / 8e-3
    with pytest.raises(dem.PackingError, match=r"packing fraction 1\.1 .* cannot be made"):
        dem.grow(shape, 8e-3, height, cylinder, 1)
    with pytest.raises(dem.PackingError, match=r"packing fraction 0\.97.*\.$"):
        make_small_bed("disc", fraction=0.97)


# Where granules begin

CYLINDER = dem.Cylinder(1.5e-3, (1e-3, 2e-3))
PLATES = tuple(dem.Solid(dem.plate(4e-3, 1e-3), (4e-3, y)) for y in (3e-3, 4.75e-3))
WEDGE = dem.Polygon([[-2e-3, -1e-3], [2e-3, -1e-3], [0.0, 2e-3]], 0.4e-3)
ROOMS = {
    "box": Room(8e-3, 9e-3, (CYLINDER,), 3),
    "along x": Room(8e-3, 9e-3, (CYLINDER,), 3, "x"),
    "without walls": Room(8e-3, 9e-3, (CYLINDER,), 3, "xy"),
    "wedge": Room(12e-3, 10e-3, (dem.Solid(WEDGE, (6e-3, 5e-3), 0.7),), 1),
    "plates": Room(8e-3, 9e-3, PLATES, 5),
}


@QUICK
@pytest.mark.parametrize("name", ROOMS)
def test_granules_begin_apart_from_each_other_and_from_solids(name):
    """Their bounding circles, and those of images; none between two solids where it will not fit."""
    room = ROOMS[name]
    shape = dem.Ellipse.of_size(np.linspace(0.8e-3, 1.2e-3, 60), 1.5)
    factor, state = dilute_start(shape, room)
    period = np.where([side in room.periodic for side in "xy"], room.size, 1e9)

    def nearest(away):
        return away - period * np.rint(away / period)

    radius, (one, two) = factor * shape.bounding_radius, np.triu_indices(60, 1)
    apart = np.hypot(*nearest(state.position[two] - state.position[one]).T)
    assert factor < 1.0 and (apart >= radius[one] + radius[two]).all()
    gaps = []
    for solid in room.solids:
        away = nearest(state.position - solid.position)
        ring = solid.placed((0.0, 0.0), solid.angle, 2049)
        gaps.append(np.hypot(*np.moveaxis(away[:, None] - ring, -1, 0)).min(axis=1))
        assert not Path(ring).contains_points(away).any()
        assert (gaps[-1] >= radius - 1e-2 * solid.radius).all()  # outlines are drawn with corners
    if len(gaps) == 2:
        assert (np.add(*gaps) > 2.0 * np.sqrt(shape.area / np.pi) - 2e-5).all()


# Shapes


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_dumbbells_never_interlock(seed):
    """The lines that join the two discs of a dumbbell never cross."""
    bed, scene, _, _ = packed("dumbbell", seed)
    arm = scene.shape.radius * np.exp(1j * bed.angle)
    middle = bed.position @ [1.0, 1j]
    # on which sides of the line of another the ends of each are
    sides = [((middle + arm * end)[:, None] - middle) / arm for end in (-1.0, 1.0)]
    across = sides[0].imag * sides[1].imag < -1e-12
    assert across.any() and not (across & across.T).any()


# Ways of packing


@QUICK
def test_ways_of_packing_differ_as_they_say():
    """Grown below jamming, granules are apart; at one packing fraction friction leaves more pressure; grown
    above jamming a bed bears a load like a relaxed one."""
    relaxed, loose = packed("below jamming"), packed("grown below jamming")
    assert loose.bed.pressure < 1e-5 * packed("disc").bed.pressure
    assert relaxed.bed.pressure < 1e-2 * packed("disc").bed.pressure
    assert len(loose.contacts[0]) < 0.1 * loose.scene.granules
    assert loose.bed.coordination_number < 0.5 * relaxed.bed.coordination_number
    assert packed("with friction").bed.pressure > packed("disc").bed.pressure
    assert 0.5 < packed("grown").bed.pressure / packed("disc").bed.pressure < 2.0
    assert packed("grown").bed.coordination_number > 3.0


@QUICK
def test_granules_grow_as_the_page_of_grow_says():
    """In steps of 2 %, after each of which they move for 300 sqrt(m / (E* R)) without friction at a
    restitution of 0.5, and keep their angles and half of their velocities. Here by simulations of the
    library."""
    rng, cylinder = np.random.default_rng(1), dem.Cylinder(1.5e-3, (2e-3, 2e-3))
    shape = dem.Disc.of_size(rng.uniform(0.9e-3, 1.1e-3, 60))
    room = Room(8e-3, 12e-3, (cylinder,), 1)
    factor, state = dilute_start(shape, room)
    soft = dem.Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=0.5)
    walls, moved = dem.box(8e-3, 12e-3), False
    while True:
        grown = shape.scaled(factor)
        scene = dem.Scene(grown, soft, None, walls, cylinder, thickness=1.0)
        run = dem.Simulation(scene, state, step_fraction=0.9)
        stiffness = 0.5 * grown.radius.mean()  # E* R in N/m
        run.advance(300.0 * np.sqrt(scene.mass.mean() / stiffness))
        end = run.state
        state = dem.State(end.position, 0.5 * end.velocity, end.angle, 0.5 * end.angular_velocity)
        moved |= np.abs(end.velocity).max() > 0.0
        if factor == 1.0 and run.diagnose().max_overlap < 1e-12:
            break
        factor = min(1.02 * factor, 1.0)
    bed = dem.grow(shape, 8e-3, 12e-3, cylinder, 1)
    assert moved and np.ptp(bed.angle) > 1.0
    assert_allclose(bed.position, state.position, atol=1e-9)
    assert_allclose(bed.angle, state.angle % (2.0 * np.pi))


RELEASED = "packing_net_force", "packing_max_overlap", "packing_coordination_number"


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
