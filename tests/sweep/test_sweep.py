"""What a sweep promises: any value varies, a run is known by what it reads, nothing is made twice."""

import json
import math
import os
import shutil
from itertools import permutations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from command_line import called
from pictures import text_of
from project import CONFIG
from sweeps import SMOKE, drawn, of_file, varied

import dem
from dem.analysis.tables import TextTable
from dem.base.errors import InputError
from dem.experiment.kinds.jamming import Jamming
from dem.figures.catalogue import draw
from dem.report.info import drag_table
from dem.report.status import status
from dem.sweep.batches import plan_batches
from dem.sweep.combine import combine, combine_block
from dem.sweep.config import load, merged, parse
from dem.sweep.prune import prune, sweeps, usage
from dem.sweep.state import SweepState
from dem.sweep.workers import Workers

pytestmark = [pytest.mark.quick, pytest.mark.usefixtures("folder")]

C1 = {"shape": "c1"}
SMALL = {
    "extends": str(SMOKE),
    "results": "results/small",
    "box_width": 6e-3,
    "cylinder": {"diameter": 1e-3, "stroke": 0.4e-3},
    "packing": {"fraction": 0.8},
    "record": {"bins": 8, "snapshots": 3, "window": [0.1e-3, 0.4e-3], "observables": ["drag"]},
    "shapes": {"c1": {"granules": 30}},
}
FEW = {"c7": {"kind": "disc", "diameter": 1092e-6, "granules": 30}}
SHOWN = {"observables": ["drag", "snapshots"]}


def small(sweep, **changes):
    """A sweep of beds of 30 discs, over a short stroke."""
    return parse(merged(SMALL, changes | {"sweep": sweep}))


def ids(sweep, block="drag"):
    return [run.id for run in sweep.block(block).runs.values()]


def combined(sweep, block="drag"):
    """The file of a block, all runs made."""
    work = SweepState(sweep)
    work.make(Workers())
    return xr.load_dataset(work.combined(block)[0])


# What can vary

BOX = {"same": {}, "wide": {"box_width": 9e-3, "shapes.c1.granules": 45, "seed": 5}}
SHARED = {"values": {"seed": 7, "shape": "c1", "density": 2e3}, "friction.granule": [0.1, 0.2]}
HALF = {"material.young_modulus": {"times": [0.5, 2]}}
WAYS = [  # what varies: the dimensions, paths, and their values in each run
    (C1 | HALF, "shape material_young_modulus seed", ["material.young_modulus"], [[35e9], [140e9]]),
    (SHARED, "shape friction_granule seed", ["seed", "density", "friction.granule"],
     [[7, 2e3, 0.1], [7, 2e3, 0.2]]),
    ({"shape": ["c1", "e3"], "box": BOX}, "shape box", ["shape", "box_width", "seed"],
     [["c1", 6e-3, 1], ["c1", 9e-3, 5], ["e3", 6e-3, 1], ["e3", 9e-3, 5]]),
]  # fmt: skip


@pytest.mark.parametrize(("sweep", "dims", "paths", "values"), WAYS, ids=["times", "values", "box"])
def test_runs_have_the_values_that_a_sweep_says(sweep, dims, paths, values):
    """As factors of the file's own value, of all of a block, or of named points; labels tell the same."""
    block = small({"blocks": {"a": sweep}}).block("a")
    assert block.dims == tuple(dims.split())
    assert [[run.at(path) for path in paths] for run in block.runs.values()] == values
    _, of, granules = block.labels()["granules"]
    for point, run in block.runs.items():
        place = tuple(k for dim, k in zip(block.dims, point, strict=True) if dim in of)
        assert granules[place] == run.shape.granules


X, Y = {"cylinder.direction": [0.0]}, {"cylinder.direction": [math.pi / 2.0]}
LIKELY = [
    (
        {"cylinder.velocity": [2.0, 500.0]},
        "cylinder.velocity is 500 m/s, 0.12 of the velocity of sound",
    ),
    ({"cylinder.velocity": [32.0]}, ""),
    (X | {"periodic": ["x"]}, "drawn along x, and periodic has it too: nothing but friction"),
    (Y | {"periodic": ["xy"]}, "drawn along y, and periodic has it too"),
    (Y | {"periodic": ["x"]}, ""),
]


@pytest.mark.parametrize(("values", "words"), LIKELY)
def test_what_is_likely_a_mistake_is_one_sentence(values, words):
    """A velocity in another unit, of the fastest run; a bed that no wall holds against the cylinder."""
    sentences = SweepState(small(C1 | {"seed": "1 to 3"} | values)).check()
    sentences = [text for text in sentences if "velocity" in text or "periodic" in text]
    assert len(sentences) == bool(words) and all(words in text for text in sentences)


def test_a_plate_that_rubs_holds_a_bed_against_the_cylinder():
    sweep = small(C1 | Y | {"periodic": ["xy"]}, base_plate={"friction": 0.1})
    assert not any("periodic" in sentence for sentence in SweepState(sweep).check())


def test_a_solid_of_a_scene_that_is_as_fast_as_sound_is_likely_a_mistake():
    values = load(CONFIG / "scenes/drum.yaml").dump()
    values["phases"]["turn"]["motion"]["blade"] |= {"velocity": -30.0}
    words = "phases.turn.motion.blade.velocity is 30 m/s, 0.47 of the velocity of sound"
    assert any(words in sentence for sentence in SweepState(parse(values)).check())


@pytest.mark.parametrize("kind", ["latin_hypercube", "sobol"])
def test_a_design_fills_its_ranges(kind):
    """One point in every interval of a sixteenth, for each factor; each point a bed of its own."""
    over = {
        "friction.granule": {"low": 0.1, "high": 0.5},
        "material.young_modulus": {"low": 1e9, "high": 1e11, "scale": "log"},
        "friction.wall": {"choices": [0.1, 0.4]},
    }
    spec = {"design": kind, "points": 16, "first_seed": 50, "over": over}
    runs = small(C1 | {"point": spec}).block("drag").unique()
    values = [[run.seed, *map(run.at, over)] for run in runs]
    seeds, friction, modulus, walls = np.transpose(values)
    assert seeds.tolist() == [*range(50, 66)] and {*walls} == {0.1, 0.4}
    for shares in ((friction - 0.1) / 0.4, np.log10(modulus / 1e9) / 2.0):
        assert sorted((16 * shares).astype(int)) == [*range(16)]


# What a run is known by


def test_what_a_run_does_not_read_makes_no_other_run():
    """Titles, batches, other shapes, seeds and names: the same identity; other observables, another. All other values
    are in test_every_key.py."""
    (first,) = ids(small(C1))
    unread = {"title": "other", "batch": 3, "failures": 0.5, "shapes": FEW}
    assert ids(small(C1, **unread)) == [first]
    assert ids(small({"seed": "1 to 3", "shape": ["c1"]}))[0] == first
    assert ids(small({"shape": "c7"}, shapes=FEW)) == [first]
    assert ids(small(C1, record={"observables": ["drag", "ledger"]})) != [first]


FRICTION = {"friction.granule": [0.1, 0.2]}
CONTACTS = {"ellipse.contact": ["common_normal", "geometric_potential"]}
SPIN, SIZES = {"cylinder.spin": [None, "free"]}, {"shapes.c1.granules": [30, 40]}
GROUPS = [  # what varies, how many runs a batch may have, and how many each has
    (FRICTION, 3, [3, 1]),
    (CONTACTS | {"shape": ["c1", "e3"]}, 5, [2, 4]),  # a disc reads none: its places are one run
    (SPIN | SIZES, 5, [2, 2, 2, 2]),
]


@pytest.mark.parametrize(("axes", "size", "counts"), GROUPS)
def test_batches_are_filled_with_runs_of_the_same_code_bed_by_bed(axes, size, counts):
    """A file of a batch names the code of all its runs, and has a row of each variable for all. The first batches
    compile one kind of granule each, which the others find compiled."""
    runs = small(C1 | {"seed": [1, 2]} | axes, record=SHOWN).block("drag").unique()
    _, new = plan_batches((), runs, size, "results")
    assert [*map(len, new.values())] == counts
    kinds = [(batch[0].label, batch[0].at("cylinder.spin")) for batch in new.values()]
    distinct = {*kinds}
    assert {*kinds[: len(distinct)]} == distinct
    beds = [(run.at("cylinder.spin"), run.bed_id) for batch in new.values() for run in batch]
    assert beds == sorted(beds, key=beds.index)


def test_a_sweep_keeps_to_its_batches_while_another_makes_their_runs():
    """All its jobs find the same ones, however many the other puts together."""
    runs = list(small(C1 | {"seed": [1, 2, 3, 4]}).block("drag").unique())
    first, _ = plan_batches((), runs, 1, "results/mine")
    others, _ = plan_batches((), runs, 4, "results/other")
    batches, new = plan_batches(others + first, runs, 1, "results/mine")
    assert set(batches) == set(first) and not new


# What a combined file holds


def test_a_combined_file_holds_every_run_at_its_place():
    """With the bits of the run made alone, also where seeds lie side by side in a batch. netCDF has no truth values:
    the axis holds 0 and 1."""
    pull = {"slow": C1 | {"cylinder.velocity": 1.0}, "few": {"shape": "c7"}}
    values = {"pull": pull, "numerics.allow_unstable": [True, False], "seed": [2, 1]}
    sweep = small(values, batch=3, shapes=FEW, packing={"fraction": 0.7})
    data = combined(sweep)
    assert data["drag"].dims == ("pull", "numerics_allow_unstable", "seed", "displacement")
    assert data["cylinder_velocity"].attrs["units"] == "m s-1"
    assert "cylinder_velocity" not in data.attrs
    for point, run in sweep.block("drag").runs.items():
        there = data.isel(dict(zip(data["run_id"].dims, point, strict=True)))
        assert there["run_id"] == run.id
        for path in ("shape", "seed", "numerics.allow_unstable", "cylinder.velocity"):
            assert there[path.replace(".", "_")] == run.at(path)
        if run.at("numerics.allow_unstable"):
            alone = dem.run_experiment(run.values())
            np.testing.assert_array_equal(there["drag"], alone["drag"])


def test_a_combined_file_tells_the_values_that_its_runs_had():
    """Of a block, also those that all points of a group share, and not those of the file."""
    same = {"friction.wall": 0.2, "shapes.c1.granules": 25}
    block = {
        "values": {"friction.granule": 0.1, "cylinder.velocity": 0.6, "shape": "c1"},
        "box": {"a": same, "b": same},
    }
    data = combined(small({"blocks": {"a": block}}), "a")
    config = json.loads(data.attrs["configuration"])
    assert config["friction"] == {"granule": 0.1, "wall": 0.2, "cylinder": 0.3, "stiffness": 1.0}
    assert [config["shapes"][name]["granules"] for name in ("c1", "e3")] == [25, 60]
    assert config["sweep"] == {"blocks": {"a": block}} and data.attrs["cylinder_velocity"] == 0.6
    shared = {"friction_granule": 0.1, "friction_wall": 0.2, "granules": 25}
    assert {name: data.coords[name].item() for name in shared} == shared


def test_each_number_that_varies_is_a_label_of_its_runs():
    """Of a group too, whichever value it is; where the others have none, they have a gap."""
    base = small(C1)
    paths = base.block("drag").first.configuration.entries.keys() - {"cylinder.stroke"}
    absent = {"cylinder.spin": 40.0, "cylinder.direction": 1.5, "cylinder.angle": 0.2}
    numbers = {path: base.at(path) for path in paths if isinstance(base.at(path), float)}
    changed = {path: 1.02 * value or 0.1 for path, value in numbers.items()}
    for path, new in (changed | absent).items():
        block = small(C1 | {"p": {"a": {path: new}, "b": {}}}).block("drag")
        assert [run.at(path) for run in block.runs.values()] == [new, base.at(path)]
        name = path.split(".")[-1] if "shapes" in path else path.replace(".", "_")
        _, dims, values = block.labels()[name]
        assert "p" in dims, path
        np.testing.assert_array_equal(values.ravel(), [new, numbers.get(path, np.nan)])


ECHO = """
VALUES = {"gap": (1.0, "m", "gap between two plates")}
AXIS = {"place": (("place",), "m", "place")}
SIZES = {"place": 3}
VARIABLES = {"height": (("place",), "m", "height")}

def axes(configuration):
    return {"place": [k * configuration.echo.gap for k in range(3)]}

DERIVES = {"top": ({}, {})}

def run(replicate, bed=None, progress=None):
    return {"height": [replicate.seed] * 3}

def derive(name, results, *runs):
    return results[0]["height"].max().item()
"""


def echoed(sweep):
    Path("echo.py").write_text(ECHO)
    return small(sweep, experiment="echo.py", beside=".", cylinder=None, record=None)


def test_an_experiment_gives_values_to_another_block():
    then = C1 | {"needs": "a", "values": {"gravity": {"derive": "top"}}}
    sweep = echoed({"blocks": {"a": C1 | {"seed": [2, 3]}, "b": then}})
    assert combined(sweep, "b")["gravity"] == 3


def test_runs_with_other_coordinates_are_not_combined():
    """As those of an experiment whose places depend on a value that varies; runs of one value are."""
    one, two = (echoed(C1 | {"echo.gap": gaps}) for gaps in ([2.0], [1.0, 2.0]))
    assert combined(one)["place"].values.tolist() == [0.0, 2.0, 4.0]
    words = "the coordinate place must be the same in all runs of drag; use blocks"
    with pytest.raises(InputError, match=words):
        combined(two)


def test_beds_at_equal_load_bear_the_same_force():
    """Force per length over E*: load times diameter, where load^(2/3) is slope times distance from jamming."""
    rows = ("a", 0, 0.83, 0.5, 1e-3), ("b", 0, 0.85, 0.8, 3e-3)
    beds = pd.DataFrame(rows, columns=["kind", "friction", "fraction", "slope", "diameter"])

    def force(bed, fraction):
        return bed.diameter * (bed.slope * (fraction - bed.fraction)) ** 1.5

    for bed, other in permutations(beds.itertuples()):
        fraction = Jamming(beds).at_load(bed.kind, other.kind, 0.88)
        assert force(bed, fraction) == pytest.approx(force(other, 0.88))


def test_values_on_an_axis_are_shown_apart(folder):
    """Those that hardly differ, and null beside numbers, which has no units; tables and a figure show them."""
    axes = {"material.thickness": [None, 1e-3], "friction.granule": [2, 2.0000001]}
    data = combined(sweep := small(C1 | axes))
    axis = data["material_thickness"]
    assert axis.values.tolist() == ["null", "0.001"] and "units" not in axis.attrs
    for shown in (TextTable(drag_table(data)), status(SweepState(sweep))):
        assert "2.0000001" in (text := text_of(shown)) and "null" in text
    draw("sweep", Path("results/small/drag.nc"), folder)


def test_a_run_that_no_file_holds_is_named():
    """A sweep is not combined before all its batches are there; no file is left."""
    state, output = of_file(drawn(sweep=varied("a", seed=[1, 2]), batch=1)), Path("new.nc")
    first, second = state.files("drag")
    with pytest.raises(InputError, match=r"seed [12] is in none of the 1 files; run again"):
        combine([first], state.sweep, state.block("drag"), "drawn", output)
    second.unlink()
    with pytest.raises(InputError, match=rf"{second.name}: there is no such file\.$"):
        combine_block(state, "drag", "drawn", output)
    assert not output.exists()


# What no sweep needs is removed, and nothing else


def as_if_made(seeds, name):
    """A sweep with its plans, and files in the places of its batches, beds, runs and checkpoints."""
    work = SweepState(small(C1 | {"seed": seeds}, results=f"results/{name}", batch=1))
    work.begin("drag")
    store, files = work.store, work.files("drag")
    for run in work.replicates():
        of_run = (store.run_of(run.id, end) for end in (".npz", ".checkpoint.npz"))
        files += [store.file_of_bed(run), *of_run]
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"\x89HDF\r\n\x1a\n runs")
    return work, files


@pytest.fixture
def made():
    """A sweep of two batches as if they were made, and one of a sweep whose folder was deleted; their files."""
    work, files = as_if_made([1, 2], "small")
    _, gone = as_if_made([3], "gone")
    shutil.rmtree("results/gone")
    return work, files, gone


def refused(store, words):
    """That pruning says so, and that nothing is removed."""
    files = [*Path("results").rglob("*")]
    with pytest.raises(InputError, match=words):
        prune(store)
    assert [*Path("results").rglob("*")] == files


def test_prune_removes_what_no_sweep_needs(made):
    """And what is damaged and was put aside; nothing of a sweep that is there, of unknown runs, or that the
    store does not write: a note that somebody put there is theirs."""
    work, files, gone = made
    folder = work.store.folder
    theirs = [folder / name for name in ("batches/notes.txt", "batches/mine.nc", "beds/a/b")]
    kept = [*theirs, work.store.file_of("f" * 16)]
    aside = [path.with_name(f"{path.name}.damaged") for path in files]
    for path in (*kept, *aside):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("mine")
    assert usage(work.store) == [("results/small", 2), ("no sweep", 1)]
    result = called("store --prune")
    assert result.exit_code == 0 and "13 files removed" in result.stdout
    assert all(path.is_file() for path in (*files, *kept))
    assert not any(path.exists() for path in (*gone, *aside))


def test_prune_keeps_runs_that_a_combined_file_names(made):
    """Without its configuration; their beds are not needed then."""
    work, files, _ = made
    xr.Dataset({"run_id": ("seed", ids(work.sweep))}).to_netcdf("results/small/drag.nc")
    Path("results/small/config.yaml").unlink()
    assert prune(work.store)
    beds = {*map(work.store.file_of_bed, work.replicates())}
    assert {path for path in files if not path.exists()} == beds


def test_prune_leaves_the_plans_of_a_sweep_that_starts_meanwhile(made, monkeypatch):
    """Of which it does not know when it has looked at all folders."""
    store = made[0].store
    late = SweepState(small(C1 | {"seed": [9]}, results="results/late"), store)

    def looked(store):
        yield from sweeps(store)
        late.begin("drag")

    monkeypatch.setattr("dem.sweep.prune.sweeps", looked)
    assert prune(store)
    assert all(store.plan_of(batch.id).is_file() for batch in late.batches("drag"))


def test_prune_removes_nothing_where_it_cannot_be_known_what_a_sweep_needs(made):
    """Its configuration cannot be read, or its disk is away for a moment. When the sweep starts again, it is whole
    again. Who wants none of the runs deletes the link, and the store."""
    work, files, _ = made
    results, store = Path("results/small"), work.store
    for text in (b"", b"\xff\xfe"):
        (results / "config.yaml").write_bytes(text)
        refused(store, f"{results}/config.yaml")
    work.begin("drag")
    results.rename("away")
    results.symlink_to("../away")
    assert len(prune(store)[0]) == 5 and all(path.is_file() for path in files)
    Path("away").rename("further")
    refused(store, f"{results}: it is a link to what is not there")
    results.unlink()
    refused(store, "delete the folder results/store")


def test_a_sweep_says_where_a_new_store_begins(folder, monkeypatch):
    """In a folder with a store it says nothing; neither a dry run nor a command about the store makes one."""
    Path("small.yaml").write_text(yaml.safe_dump(small(C1).dump()))
    monkeypatch.setattr("os.access", lambda _, mode: mode == os.R_OK)  # which only reads
    new = f"{folder}/results/store: this store of runs is new"
    for words, number, said in (
        ("store", 2, "there is no store"),
        ("sweep small.yaml --dry-run", 0, new),
    ):
        result = called(words)
        assert result.exit_code == number and said in result.stderr, result.output
        assert not Path("results").exists()
    Path("results/store").mkdir(parents=True)
    assert not SweepState.of(Path("small.yaml")).check()
