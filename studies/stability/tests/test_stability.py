"""The study of stability: what it measures is there, and its verdicts can go either way."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from typer.testing import CliRunner

import dem
from conftest import assert_not_blank
from dem.dynamics.checkpoint import writable
from dem.dynamics.forces import forces
from dem.figures.catalogue import draw
from dem.shapes import KINDS
from dem.sweep import batch as making
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store
from studies.__main__ import app
from studies.catalogue import figures
from studies.common.table import write_part
from studies.stability import catalogue, linear, study, table
from studies.stability.figures.stability_map import title
from studies.stability.findings import stability
from studies.stability.layout import VARIABLES
from studies.stability.scenes import start
from studies.stability.watching import excess, friction_excess, momenta, unlisted

CONFIG = Path(__file__).parents[3] / "config"
HERE = Path(__file__).parent.parent
SHORT = {
    "paper": {"experiment": "draw", "shapes": ["c1"], "change": {"displacement": 5e-5},
              "limits": {"residual": 1e-2, "excess": 1e-14}},
    "impossible": {"experiment": "draw", "shapes": ["c1"], "change": {"displacement": 5e-5},
                   "limits": {"residual": 0}},
    "soft_step": {"experiment": "follow", "shapes": ["c1"], "change": {"density": 10},
                  "limits": {"scaling": 0.1}},
    "restart": {"experiment": "restart", "shapes": ["c1"], "change": {"displacement": 5e-5},
                "limits": {"difference": 0}},
    "full": {"experiment": "draw", "shapes": ["c1"], "change": {"fraction": 1.6},
             "expect": "InputError"},
    "harmless": {"experiment": "draw", "shapes": ["c1"], "change": {"displacement": 5e-5},
                 "expect": "OverlapError"},
}  # fmt: skip
LIMITS = {"shapes": ["c1"], "granules": 40}


@pytest.fixture(scope="module")
def sweep():
    """The smoke sweep with few runs."""
    data = yaml.safe_load((HERE / "smoke.yaml").read_text())
    blocks = data["sweep"]["blocks"]
    steps = {"material.restitution": 0.5, "numerics.step_fraction": [0.5, 3.0]}
    few = {"shape": "c1", "material.young_modulus": {"times": 1.0}} | steps
    blocks["map"] = {name: few.get(name, value) for name, value in blocks["map"].items()}
    blocks["paper"] |= {"case": ["c1", "c12"]}
    return parse(data)


@pytest.fixture(scope="module")
def runs(sweep, tmp_path_factory):
    """Its runs."""
    work = SweepState(
        sweep, Store(tmp_path_factory.mktemp("store")), root=tmp_path_factory.mktemp("root")
    )
    chunks = [each for name in sweep.blocks for each in work.batches(name)]
    work.begin(*work.sweep.blocks)
    for each in chunks:
        making.make(work.store, each.id)
    return work


def written(folder, cases=SHORT):
    file = folder / "catalogue.yaml"
    file.write_text(yaml.safe_dump({"cases": cases, "limits": LIMITS}))
    return file


@pytest.fixture(scope="module")
def limits(sweep, tmp_path_factory):
    """The linearised bed beside its bound."""
    return study.run_limits(sweep, catalogue.load(written(tmp_path_factory.mktemp("limits"))), "c1")


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_goes_on_from_a_checkpoint_with_the_same_bits(small_bed, tmp_path, kind):
    """Saved to disk and loaded into another simulation, which lists other pairs, a run continues as if
    never interrupted."""
    small = small_bed(kind)
    whole, second = (dem.Simulation(small.scene(), small.state) for _ in range(2))
    whole.advance(4e-4)
    partners = (run.world.pairs.partner for run in (whole, second))
    assert not np.array_equal(*partners)
    np.savez(tmp_path / "saved.npz", **whole.checkpoint())
    with np.load(tmp_path / "saved.npz") as saved:
        second.restore(saved)
    records = [run.record(5e-6, 4) for run in (whole, second)]
    for first, other in zip(*records, strict=True):
        np.testing.assert_array_equal(first, other)
    np.testing.assert_array_equal(whole.state.position, second.state.position)
    assert (whole.time, whole.steps) == (second.time, second.steps)
    assert records[0].tangential_force.any()


def test_a_checkpoint_of_another_scene_is_refused(small_bed):
    """Other granules, material or sizes are named as such, and nothing is changed."""
    disc, ellipse, other = small_bed("disc"), small_bed("ellipse"), small_bed("disc", 2)
    run = dem.Simulation(disc.scene(), disc.state)
    saved = run.checkpoint()
    soft = dem.Simulation(disc.scene(material=dem.Material(young_modulus=1e9)), disc.state)
    for bed in (ellipse, other):
        with pytest.raises(dem.InputError, match="another scene"):
            dem.Simulation(bed.scene(), bed.state).restore(saved)
    with pytest.raises(dem.InputError, match="another scene"):
        soft.restore(saved)
    del saved["world.pairs.tangential_force"]
    saved["world.bodies"] = saved["world.bodies"] + 1.0
    with pytest.raises(dem.InputError, match="the checkpoint is damaged"):
        run.restore(saved)
    np.testing.assert_array_equal(run.state.position, disc.state.position)


def test_friction_beyond_the_cap_is_seen(small_bed):
    """Friction stays within mu N; against half of mu, it exceeds."""
    small = small_bed("disc")
    run = dem.Simulation(small.scene(), small.state)
    run.advance(5e-5)
    assert abs(friction_excess(run)) < 1e-14
    world = writable(run.world)
    forces(world, 0.0, np.inf)
    contacts = world.cylinder.contacts
    half = contacts.friction._replace(coefficient=0.5 * contacts.friction.coefficient)
    cylinder = world.cylinder._replace(contacts=contacts._replace(friction=half))
    assert excess(world._replace(cylinder=cylinder)) > 0.01


def test_pairs_that_are_not_listed_are_counted(small_bed):
    """A bed's list is complete; a granule put onto another without a new list is missed."""
    small = small_bed("disc")
    world = writable(dem.Simulation(small.scene(), small.state).world)
    assert unlisted(world) == 0
    far = np.linalg.norm(world.bodies[:, :2] - world.bodies[0, :2], axis=1).argmax()
    world.bodies[0, :2] = world.bodies[far, :2]
    assert unlisted(world) > 0


def test_momenta_of_a_known_motion(small_bed):
    """Two discs that circle each other: no momentum, and 2 m r v of angular momentum plus spin."""
    shape = dem.Disc(np.full(2, 1e-3))
    state = dem.State(
        [[1e-2, 0.0], [-1e-2, 0.0]], [[0.0, 3.0], [0.0, -3.0]], angular_velocity=[5.0, 5.0]
    )
    run = dem.Simulation(
        replace(small_bed("disc").scene(walls=None, cylinder=None), shape=shape), state
    )
    mass = run.scene.mass[0]
    momentum, turning, sizes = momenta(run)
    assert np.abs(momentum).max() < 1e-15 * sizes[0]
    assert turning == pytest.approx(2.0 * mass * (1e-2 * 3.0 + 0.5 * 1e-6 * 5.0), rel=1e-12)
    assert sizes == pytest.approx((6.0 * mass, turning), rel=1e-12)


def test_verdicts_follow_limits(sweep, tmp_path):
    """Cases pass or fail by what is measured; a refusal counts where it is expected, and only there."""
    found = study.run_catalogue(sweep, catalogue.load(written(tmp_path)), "c1")
    passed = dict(zip(found["check_case"], found["check_passed"], strict=True))
    assert passed == {
        "paper": 1, "impossible": 0, "soft_step": 1, "restart": 1, "full": 1, "harmless": 0,
    }  # fmt: skip
    words = dict(zip(found["check_case"], found["check_message"], strict=True))
    assert "packing" in words["full"] and not words["paper"]


def test_the_map_tells_sound_steps_from_broken_ones(runs):
    """At the default step energy adds up, at three times the bound it does not."""
    block, modulus = table.blocks_of(runs.sweep)["map"], runs.sweep.material.young_modulus
    found = table.energy_map(runs.files("map"), block, modulus)
    assert found["map_stiffness"].tolist() == [1.0] and found["map_fraction"].tolist() == [0.5, 3.0]
    sound, broken = found["map_residual"].ravel()
    assert sound < 1e-3 and not broken < 1e-2


def test_a_bed_grows_beyond_its_limit_only(sweep, limits):
    """The bound lies below the true limit of the linearised bed."""
    bound, limit = limits["limit_bound"][0], limits["limit_limit"][0]
    small = linear.small(sweep, "c1", LIMITS["granules"], catalogue.Changes())
    matrices = linear.matrices(start(small, still=True))
    assert bound < limit
    assert linear.growth(*matrices, bound) < study.GROWN < linear.growth(*matrices, 1.05 * limit)


def test_the_study_end_to_end(runs, limits, tmp_path):
    """Runs and the parts of two jobs make one file, which is summarised and drawn."""
    sweep = runs.sweep
    cases = catalogue.load(written(tmp_path, {"paper": SHORT["paper"], "full": SHORT["full"]}))
    study.check(sweep, cases)
    made = study.run_catalogue(sweep, cases, "c1"), limits
    files = [tmp_path / "catalogue.nc", tmp_path / "limits.nc"]
    for file, values in zip(files, made, strict=True):
        write_part(file, sweep, ("studies.stability.study",), values, VARIABLES)
    whole = tmp_path / "stability.nc"
    with pytest.raises(dem.InputError, match="the parts lack limit_shape"):
        table.write_study(whole, runs, files[:1])
    table.write_study(whole, runs, files)
    with xr.open_dataset(whole) as dataset:
        assert dataset["paper_case"].values.tolist() == ["c1", "c12"]
        assert float(dataset["paper_residual"].max()) < 1e-3
    found = stability.of(xr.load_dataset(whole))
    assert (found.passed(), found.total()) == (3, 3)
    assert found.summary().renderables[-1].row_count == 1
    own = {name: each for name, each in figures().items() if each.file == "stability"}
    for name in own:
        vector, pixels = draw(name, whole, tmp_path, own)
        assert vector.is_file()
        assert_not_blank(pixels)


@pytest.mark.parametrize(
    ("block", "change", "words"),
    [
        ("paper", None, "must be map and paper"),
        ("map", {"seed": [1, 2]}, "sweep.blocks.map varies"),
        ("paper", {"cylinder.start": [0.2, 0.3]}, "sweep.blocks.paper varies"),
        (None, None, "lacks ledger"),
    ],
)
def test_a_sweep_that_is_no_study_is_refused(block, change, words):
    """Before anything runs, with the block in the sentence."""
    data = yaml.safe_load((HERE / "smoke.yaml").read_text())
    blocks = data["sweep"]["blocks"]
    if block is None:
        data["record"]["observables"] = ["drag"]
    elif change is None:
        del blocks[block]
    else:
        blocks[block] |= change
    with pytest.raises(dem.InputError, match=words):
        table.blocks_of(parse(data))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"experiment": "dance"}, "cases.paper.experiment"),
        ({"shapes": ["z9"]}, "z9"),
        ({"limits": {"beauty": 1.0}}, "beauty"),
        ({"limits": {}}, "limits or an error"),
        ({"change": {"stiffness": -1.0}}, "stiffness"),
    ],
)
def test_a_wrong_catalogue_is_refused_in_words(sweep, tmp_path, change, words):
    """A sentence names what is wrong, where nothing else is."""
    file = written(tmp_path, {"paper": SHORT["paper"] | change})
    with pytest.raises(dem.InputError, match=words):
        study.check(sweep, catalogue.load(file))


def test_the_released_catalogue_fits_the_released_configurations():
    """Every case names an experiment and shapes that are there, and every experiment is used."""
    cases = catalogue.load(HERE / "catalogue.yaml")
    for name in ("sweep.yaml", "smoke.yaml"):
        sweep = load(HERE / name)
        study.check(sweep, cases)
        assert set(table.blocks_of(sweep)) == {"map", "paper"}
    assert {case.experiment for case in cases.cases.values()} == set(study.EXPERIMENTS)


def test_edges_of_the_map_in_words():
    """Where energy is off and where runs break, failed ones included."""
    dims = "map_shape", "map_stiffness", "map_restitution", "map_fraction"
    residual = np.array([[1e-4, 0.02, 0.05, np.nan], [1e-4, 1e-3, 0.05, 0.06]])
    dataset = xr.Dataset(
        {"map_residual": (dims, residual[None, None])},
        {"map_fraction": [0.5, 1.0, 1.5, 2.0]},
        {"default_fraction": 0.5},
    )
    assert title(dataset) == (
        "Energy is off by 1% from 1 of the bound; runs break down from 2"
    )
    assert title(dataset.isel(map_fraction=[0])) == "Energy adds up at all of these steps"


def test_a_shape_that_the_catalogue_has_not_is_refused(tmp_path):
    words = ["catalogue", "--config", str(CONFIG / "smoke.yaml"), "--shape", "zz"]
    run = CliRunner().invoke(app, ["stability", *words, "-o", str(tmp_path / "out.nc")])
    assert run.exit_code == 2 and "shape is 'zz'" in run.stderr and not list(tmp_path.iterdir())
