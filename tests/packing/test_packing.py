"""Beds of all ways of packing keep one table of promises; then what each way promises beside these."""

import platform
from contextlib import suppress
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from beds import PRESSURE, STIFF, section_of
from matplotlib.path import Path
from numpy.testing import assert_allclose, assert_array_equal
from outlines import outside
from project import CONFIG, ROOT, quick
from sweeps import smoke
from twin import Twin

import dem
from dem.experiment.bed import make_bed
from dem.experiment.scene import make_scene
from dem.packing.cost import expected_iterations
from dem.packing.minimise import minimise
from dem.packing.random import Room, dilute_start
from dem.shapes import KINDS
from dem.sweep.config import load

WIDTH = 11e-3  # m: boxes are two thirds as high
BELOW = 0.76  # packing fraction below jamming of discs; others are above it
WEIGHT = 9.81e3  # m/s2
STEEL = {"young_modulus": 200e9, "poisson_ratio": 0.3, "density": 7800.0}
SHAPES = {kind: section_of(kind).model_dump(exclude_none=True) for kind in KINDS} | {
    "many": {"kind": "disc", "diameter": 1e-3, "granules": 1100},  # more than a patch
    "soft": {"kind": "disc", "diameter": 1.2e-3},
    "steel": {"kind": "disc", "diameter": 0.8e-3, "material": STEEL},
    "mixture": {"mixture": {"soft": 0.5, "steel": 0.5}, "granules": 60},
}
SPRINGS = {"periodic": "x", "contact.law": "linear"}
# shape of the granules, and what differs from the small bed of config/smoke.yaml
BEDS = {
    **{kind: (kind, {"packing.fraction": fraction}) for kind, fraction in STIFF},
    "below jamming": ("disc", {"packing.fraction": BELOW}),
    "grown": ("disc", {"packing.preparation": "grown"}),
    "grown below jamming": ("disc", {"packing.preparation": "grown", "packing.fraction": BELOW}),
    "with friction": ("disc", {"packing.friction": 0.5}),
    "under a pressure": (
        "disc",
        SPRINGS
        | {"contact.stiffness": 5e7, "packing.fraction": None, "packing.pressure": PRESSURE},
    ),
    "settled": (
        "disc",
        {"packing.preparation": "settled", "packing.fraction": 0.6, "gravity": WEIGHT},
    ),
    # without a cylinder: its kernels are those of the onset of jamming
    "without walls": ("disc", {"periodic": "xy", "experiment": "onset", "cylinder": None}),
    "around two cylinders": ("disc", {"second": {"diameter": 1e-3, "gap": 3e-4, "bearing": 0.5}}),
    "around a wedge": (
        "disc",
        {"cylinder.outline": "wedge", "cylinder.diameter": 3e-3, "cylinder.start": 0.4},
    ),
    "of springs": ("disc", SPRINGS),
    "mixture": ("mixture", {}),
    "large": ("many", {"packing.fraction": 0.86, "box_width": 40e-3}),
}
# around a wedge they are not this simple
OF_DISCS = [name for name in BEDS if name == "disc" or name not in (*KINDS, "around a wedge")]


@cache
def run_of(name, seed=1, **more):
    """The run of a bed."""
    shape, changes = BEDS[name]
    sweep = smoke(shapes=SHAPES, cases={"one": {"shape": shape, "density": 3900.0}})
    return sweep.changed({"box_width": WIDTH} | changes | more, shape).replicate(
        shape, 3900.0, seed
    )


def described(name, seed=1, **more):
    """What its bed is made of."""
    return run_of(name, seed, **more).bed_description


class Packed(NamedTuple):
    """A bed; the scene of its run with solids at rest; that scene in plain numpy; E* (Pa), or the
    stiffness (N/m) of contacts that are springs, of two of the stiffest granules."""

    bed: dem.Bed
    scene: dem.Scene
    model: Twin
    modulus: float

    @property
    def contacts(self):
        """Pairs (k, 2) of discs that touch, their overlaps (k,) in m and forces (k,) in N by Hertz's law."""
        pairs, radius = (
            np.column_stack(np.triu_indices(self.scene.granules, 1)),
            self.scene.shape.radius,
        )
        one, two = self.bed.position[pairs.T]
        overlap = radius[pairs].sum(axis=1) - np.hypot(*self.model.nearest(two - one).T)
        pairs, overlap = pairs[overlap > 0.0], overlap[overlap > 0.0]
        reduced = 1.0 / (1.0 / radius[pairs]).sum(axis=1)
        return pairs, overlap, 4.0 / 3.0 * self.modulus * np.sqrt(reduced) * overlap**1.5


@cache
def packed(name):
    run = run_of(name)
    bed = make_bed(run.bed_description)
    scene = make_scene(run, bed)
    scene = replace(scene, solids=[replace(s, velocity=(0.0, 0.0)) for s in scene.solids])
    young, poisson = (200e9, 0.3) if name == "mixture" else (70e9, 0.22)
    modulus = 0.5 * young / (1.0 - poisson**2)
    if isinstance(scene.law, dem.Linear):
        modulus = scene.law.stiffness or 0.25 * np.pi * run.thickness * modulus
    return Packed(bed, scene, Twin(scene, bed.state), modulus)


@quick
@pytest.mark.parametrize("name", BEDS)
def test_a_bed_fills_its_box_as_asked_for(name):
    """Areas of the granules over the box beside the solids; none is outside or in a solid."""
    bed, scene, model, _ = packed(name)
    asked = run_of(name).configuration
    free = bed.width * bed.height - sum(solid.area for solid in scene.solids)
    if asked.packing.fraction is not None:
        assert_allclose(scene.shape.area.sum() / free, asked.packing.fraction, rtol=1e-9)
    assert ((bed.position >= 0.0) & (bed.position <= [bed.width, bed.height])).all()
    for solid in scene.solids:
        ring = solid.placed((0.0, 0.0), solid.angle, 513)
        assert not Path(ring).contains_points(model.nearest(bed.position - solid.position)).any()
    assert 0.0 <= bed.max_overlap < 0.2


@quick
@pytest.mark.parametrize("name", BEDS)
def test_a_bed_is_at_rest_as_it_says(name):
    """By a sum over all pairs, walls and solids, with the weight: no net force, in units of E* R^2.
    Friction holds granules of a bed packed with it."""
    bed, scene, model, modulus = packed(name)
    radius = scene.shape.constituent_radius.mean()
    unit = modulus * radius ** (1 if isinstance(scene.law, dem.Linear) else 2)
    force = model.force + np.multiply.outer(scene.mass, scene.gravity or (0.0, 0.0))
    net = np.hypot(*force.T).max() / unit
    moving = {"with friction": 2e-4, "settled": 1e-6, "large": 1e-6}
    assert bed.net_force <= moving.get(name, 1e-9)
    if name != "with friction":
        assert_allclose(bed.net_force, net, rtol=5e-2 if name == "settled" else 1e-4, atol=1e-14)
    if name == "large":  # also next to its own forces
        assert net * unit < 5.5e-3 * packed(name).contacts[2].mean()


@quick
@pytest.mark.parametrize("name", BEDS)
def test_the_pressure_is_the_force_on_the_walls_over_their_length(name):
    """Over E* too. Without walls it is the mean normal stress of the contacts."""
    bed, scene, model, modulus = packed(name)
    if scene.walls:
        normal = scene.planes[:, :2]
        length = (np.abs(normal) @ [bed.height, bed.width]).sum()
        expected = (model.walls.force * normal).sum() / length
    else:
        pairs, overlap, force = packed(name).contacts
        branch = scene.shape.radius[pairs].sum(axis=1) - overlap
        expected = 0.5 * force @ branch / (bed.width * bed.height)
    assert_allclose(bed.pressure, expected / modulus, rtol=2e-3, atol=1e-15)
    loose = "below jamming", "grown below jamming", "settled"
    assert name in loose or bed.pressure > 1e-8
    if name == "under a pressure":
        top = model.walls.force[-1, 1] / (bed.width * scene.thickness)
        assert_allclose(top, PRESSURE, rtol=2e-3)


@quick
@pytest.mark.parametrize("name", OF_DISCS)
def test_overlaps_and_contacts_are_as_a_bed_says(name):
    """Over the smaller radius. Ellipses and dumbbells have the bits of released beds, see below."""
    bed, scene, model, _ = packed(name)
    radius, (pairs, overlap, _) = scene.shape.radius, packed(name).contacts
    shares = [np.zeros(1), overlap / radius[pairs].min(axis=1)]
    shares += [(radius + bed.position @ normal - end) / radius for *normal, end in scene.planes]
    for solid in scene.solids:
        away = np.hypot(*model.nearest(bed.position - solid.position).T)
        shares.append((radius + solid.radius - away) / np.minimum(radius, solid.radius))
    assert_allclose(bed.max_overlap, np.concatenate(shares).max(), rtol=1e-6, atol=1e-12)
    assert_allclose(bed.coordination_number, 2.0 * len(pairs) / scene.granules, atol=0.05)


@pytest.mark.parametrize("name", ["large", "under a pressure", "with friction"])
def test_a_bed_that_is_stopped_goes_on_to_the_same_bits(tmp_path, name):
    """While granules grow, while the top wall comes down, and at full size; on any number of threads."""
    path, resumed, reports = tmp_path / "bed.npz", None, []

    def report(*progress):
        reports.append(progress)
        if len(reports) % 4 == 0:
            raise KeyboardInterrupt

    while resumed is None:
        with suppress(KeyboardInterrupt):
            resumed = make_bed(described(name), 2 if name == "large" else 1, path, report)
        assert path.is_file()
    assert len(reports) > 3
    for one, two in zip(packed(name).bed, resumed, strict=True):
        assert_array_equal(one, two)
    with pytest.raises(dem.InputError, match=r"bed\.npz: it is damaged or of another bed"):
        make_bed(described(name, seed=2), checkpoint=path)


def test_what_was_reached_is_kept_of_a_bed_that_does_not_come_to_rest(tmp_path, monkeypatch):
    """The same call goes on from there, with as many iterations again; here there are few, to be quick."""
    monkeypatch.setattr("dem.packing.random.most_iterations", lambda *bed: 500)
    bed, refused = None, 0
    while bed is None and refused < 40:
        try:
            bed = make_bed(described("large"), checkpoint=tmp_path / "bed.npz")
        except dem.PackingError as error:
            assert "not at rest after 500 iterations: net force" in str(error)
            refused += 1
    assert refused and bed.net_force < 1e-6


def test_a_bed_takes_as_many_iterations_as_is_expected():
    """Within a factor of three; ten times as many near random close packing."""
    reports = []
    make_bed(described("large"), report=lambda iterations, net_force: reports.append(iterations))
    assert 1 / 3 < reports[-1] / expected_iterations(1100, 0.86) < 3
    assert expected_iterations(100_000, 0.84) > 10 * expected_iterations(100_000, 0.82)


def test_what_finds_no_place_is_refused():
    """A granule in a box that is too small, granules that meet while they grow, and too many."""
    with pytest.raises(dem.PackingError, match=r"granule 0 of 1 found no free place .* too small"):
        dem.pack(dem.Ellipse([6e-3], [1e-3]), 8e-3, 8e-3, dem.Cylinder(1e-3, (4e-3, 4e-3)), 1)
    for name, words in ("grown", r"0\.97 .* cannot be made"), ("disc", r"0\.97.*\.$"):
        with pytest.raises(dem.PackingError, match=rf"packing fraction {words}"):
            make_bed(described(name, **{"packing.fraction": 0.97}))


# Where granules begin

PLATE = dem.plate(4e-3, 1e-3)
PLACES = (4e-3, 3e-3, 0.0), (4e-3, 4.75e-3, 0.0), (0.65e-3, 8e-3, 1.5)  # m, m, rad


@quick
@pytest.mark.parametrize("periodic", ["none", "x", "xy"])
def test_granules_begin_apart_from_each_other_and_from_solids(periodic):
    """Their bounding circles, and those of images; none between two solids where it will not fit."""
    solids = tuple(dem.Solid(PLATE, (x, y), angle) for x, y, angle in PLACES)
    room = Room(8e-3, 11e-3, solids, 5, periodic)
    shape = dem.Ellipse.of_size(np.linspace(0.8e-3, 1.2e-3, 60), 1.5)
    factor, state = dilute_start(shape, room)
    period = np.where([side in periodic for side in "xy"], room.size, 1e9)

    def nearest(away):
        return away - period * np.rint(away / period)

    radius, (one, two) = factor * shape.bounding_radius, np.triu_indices(60, 1)
    apart = np.hypot(*nearest(state.position[two] - state.position[one]).T)
    assert factor < 1.0 and (apart >= radius[one] + radius[two]).all()
    gaps = []
    for solid in solids:
        c, s = np.cos(solid.angle), np.sin(solid.angle)
        away = nearest(state.position - solid.position) @ [[c, -s], [s, c]]
        gaps.append(outside(away, solid.outline.corners) - solid.outline.radius)
    assert (np.array(gaps) >= 0.999 * radius).all()
    assert (gaps[0] + gaps[1] > 1.999 * np.sqrt(shape.area / np.pi)).all()


@quick
def test_dumbbells_never_interlock():
    """The lines that join the two discs of a dumbbell never cross."""
    bed, scene, _, _ = packed("dumbbell")
    arm, middle = scene.shape.radius * np.exp(1j * bed.angle), bed.position @ [1.0, 1j]
    # on which sides of the line of another the ends of each are
    sides = [((middle + end)[:, None] - middle) / arm for end in (-arm, arm)]
    across = sides[0].imag * sides[1].imag < -1e-12
    assert across.any() and not (across & across.T).any()


@quick
def test_what_a_torque_turns_is_not_at_rest():
    """A slanted dumbbell on which floor and lid push alike turns until it fits."""
    scene = Room(1.0, 3.5e-3, (), 1).scene(dem.Dumbbell([1e-3]))
    slanted = dem.State([[0.5, 1.75e-3]], angle=[1.0])
    assert np.sin(minimise(scene, slanted, 9999).state.angle) < 0.75 + 1e-5


# Ways of packing


@quick
def test_ways_of_packing_differ_as_they_say():
    """Grown below jamming, granules are apart; at one packing fraction friction leaves more pressure; grown
    above jamming a bed bears a load like a relaxed one."""
    names = "disc", "below jamming", "grown below jamming", "with friction", "grown"
    dense, relaxed, loose, rough, grown = (packed(name).bed for name in names)
    assert loose.pressure < 1e-5 * dense.pressure and relaxed.pressure < 1e-2 * dense.pressure
    assert loose.max_overlap < 1e-5
    assert rough.pressure > dense.pressure
    assert 0.5 < grown.pressure / dense.pressure < 2.0 and grown.coordination_number > 3.0


@quick
def test_granules_grow_as_the_page_of_grow_says():
    """In steps of 2 %, after each of which they move for 300 sqrt(m / (E* R)) without friction at a
    restitution of 0.5, and keep their angles and half of their velocities. Here by simulations of the
    library."""
    shape = dem.Disc.of_size(np.linspace(0.9e-3, 1.1e-3, 60))
    cylinder = dem.Cylinder(1.5e-3, (2e-3, 2e-3))
    room = Room(8e-3, 12e-3, (cylinder,), 3)
    factor, state = dilute_start(shape, room)
    soft = dem.Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=0.5)
    overlap = 1.0
    while overlap > 1e-12:
        grown = shape.scaled(factor)
        scene = room.scene(grown, soft)
        run = dem.Simulation(scene, state, step_fraction=0.9)
        stiffness = 0.5 * grown.radius.mean()  # E* R in N/m
        run.advance(300.0 * np.sqrt(scene.mass.mean() / stiffness))
        end, overlap = run.state, run.diagnose().max_overlap if factor == 1.0 else 1.0
        state = dem.State(end.position, 0.5 * end.velocity, end.angle)
        factor = min(1.02 * factor, 1.0)
    bed = dem.grow(shape, 8e-3, 12e-3, cylinder, 3)
    assert np.abs(end.velocity).max() > 0.0
    assert_allclose(bed.position, state.position, atol=1e-9)
    assert_allclose(bed.angle, state.angle % (2.0 * np.pi))


@pytest.mark.skipif(platform.machine() != "x86_64", reason="bits of another processor")
@pytest.mark.parametrize(("case", "seed"), [("c1", 1), ("d1", 2), ("e1", 2), ("e3", 5)])
def test_a_bed_of_one_patch_keeps_the_bits_of_the_released_ones(case, seed):
    """Net force, overlap and contacts of beds of the paper, to the last bit; of shapes that turn, those that
    change most with the last digit of a step."""
    with dem.open_results(ROOT / "docs/data/drag.nc") as results:
        released = results.sel(case=case, seed=seed)
        bed = make_bed(load(CONFIG / "paper.yaml").replicate(case, 3900.0, seed).bed_description)
        for name in ("net_force", "max_overlap", "coordination_number"):
            assert getattr(bed, name) == released[f"packing_{name}"], name
