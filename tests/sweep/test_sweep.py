"""What a sweep promises: any value varies, a run is known by what it reads, nothing is made twice."""

import json
import math
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from project import CONFIG
from rich.console import Console
from typer.testing import CliRunner

import dem
from dem.analysis.tables import TextTable
from dem.base.errors import InputError, RunError
from dem.cli.app import app
from dem.experiment.run import Replicate
from dem.report.info import drag_table
from dem.report.status import status
from dem.sweep import batch as making
from dem.sweep import store as stores
from dem.sweep.axis import changes_of_words
from dem.sweep.combine import about, combine, combine_block
from dem.sweep.config import load, merged, parse
from dem.sweep.derive import Jamming
from dem.sweep.grouping import plan_batches
from dem.sweep.prune import prune, sweeps, usage
from dem.sweep.state import SweepState

pytestmark = pytest.mark.quick

C1 = {"shape": "c1"}
FEW = {"c1": {"kind": "disc", "diameter": 1092e-6, "granules": 30}}
SMALL = {
    "extends": str(CONFIG / "smoke.yaml"),
    "results": "results/small",
    "box_width": 6e-3,
    "cylinder": {"diameter": 1e-3, "stroke": 0.4e-3},
    "packing": {"fraction": 0.8},
    "record": {"bins": 8, "snapshots": 3, "window": [0.1e-3, 0.4e-3], "observables": ["drag"]},
}


def small(sweep, **changes):
    """A sweep of beds of 30 discs, over a short stroke."""
    values = SMALL | changes | {"sweep": sweep}
    base = yaml.safe_load((CONFIG / "smoke.yaml").read_text())
    return parse(values | {"shapes": base["shapes"] | FEW | values.get("shapes", {})})


def ids(sweep, block="drag"):
    return [run.id for run in sweep.block(block).runs.values()]


def done(sweep, folder, jobs=1):
    """A sweep at work, all runs made."""
    work = SweepState(sweep, stores.Store(folder / "store"), root=folder)
    for block in sweep.blocks:
        chunks = work.batches(block)
        work.begin(block)
        for chunk in chunks:
            making.make(work.store, chunk.id)
    return work


def combined(work, folder, block="drag", observable="drag"):
    path = folder / f"{block}_{observable}.nc"
    combine_block(work, block, observable, path)
    with xr.open_dataset(path) as dataset:
        return dataset.load()


# What can vary


def test_a_product_of_any_values_is_a_dimension_each():
    """In the order of the file, with units and words of the schema."""
    block = small(
        {
            "shape": ["c1", "e3"],
            "friction.granule": [0.0, 0.3],
            "packing.fraction": [0.8, 0.82, 0.84],
            "seed": "1 to 2",
        }
    ).block("drag")
    assert block.dims == ("shape", "friction_granule", "packing_fraction", "seed")
    assert block.shape == (2, 2, 3, 2) and len(block.runs) == 24
    assert block.axes[2].entry.units == "1" and "packing fraction" in block.axes[2].entry.about
    last = list(block.runs.values())[-1]
    assert (last.label, last.seed) == ("e3", 2)
    assert last.configuration.friction.granule == 0.3
    assert last.configuration.packing.fraction == 0.84


def test_factors_are_of_the_files_own_value():
    """{times: ...} multiplies what the configuration has."""
    block = small({"shape": "c1", "material.young_modulus": {"times": [0.5, 2]}}).block("drag")
    moduli = [run.configuration.material.young_modulus for run in block.runs.values()]
    assert moduli == [35e9, 140e9] and block.axes[1].coordinate == moduli


def test_values_that_go_together_are_one_dimension():
    """Named points, each some values; what a point does not say stays."""
    box = {"same": {}, "wide": {"box_width": 9e-3, "shapes.c1.granules": 45}}
    block = small({"shape": ["c1", "e3"], "box": box}).block("drag")
    assert block.dims == ("shape", "box", "seed")
    width = {point[:2]: run.configuration.box_width for point, run in block.runs.items()}
    assert width == {(0, 0): 6e-3, (0, 1): 9e-3, (1, 0): 6e-3, (1, 1): 9e-3}
    _, dims, values = block.labels()["box_width"]
    assert dims == ("box",) and values.tolist() == [6e-3, 9e-3]
    _, dims, values = block.labels()["granules"]
    assert dims == ("shape", "box") and values.tolist() == [[30, 45], [60, 60]]


@pytest.mark.parametrize(
    ("sweep", "expected"),
    [
        ({"cylinder.velocity": [0.6, 6.0]}, None),
        ({"pull": {"slow": {"cylinder.velocity": 0.6}, "fast": {"cylinder.velocity": 6.0}}}, None),
        ({"values": {"cylinder.velocity": 0.6}}, 0.6),
        ({"friction.wall": [0.1, 0.3]}, 2.0),
    ],
)
def test_what_varies_is_no_attribute(sweep, expected):
    """And what all runs share is told as they have it, also where the file has another value."""
    parsed = small({"shape": "c1"} | sweep)
    block = parsed.block("drag")
    assert about(parsed, block, {}).get("cylinder_velocity") == expected
    if expected != 2.0 and "pull" not in sweep:
        named = {**{axis.name: axis.coordinate for axis in block.axes}, **block.labels()}
        assert "cylinder_velocity" in named


X, Y = {"cylinder.direction": [0.0]}, {"cylinder.direction": [math.pi / 2.0]}
LIKELY = [
    ({"cylinder.velocity": [2.0, 500.0]}, "velocity is 500 m/s, 0.12 of the velocity of sound"),
    ({"cylinder.velocity": [32.0]}, ""),
    ({"material.young_modulus": [1e3]}, "cylinder.velocity is 2 m/s, 3.9 of"),
    (X | {"periodic": ["x"]}, "drawn along x, and periodic has it too: nothing but friction"),
    (Y | {"periodic": ["xy"]}, "drawn along y, and periodic has it too"),
    (Y | {"periodic": ["x"]}, ""),
    (X, ""),
]


@pytest.mark.parametrize(("values", "words"), LIKELY)
def test_what_is_likely_a_mistake_is_one_sentence(values, words):
    """A velocity in another unit, of the fastest run; a bed that no wall holds against the cylinder."""
    sentences = SweepState(small(C1 | {"seed": "1 to 3"} | values)).check()
    sentences = [text for text in sentences if "velocity" in text or "periodic" in text]
    assert len(sentences) == bool(words) and all(words in text for text in sentences)


def test_a_name_that_a_variable_has_gets_a_suffix():
    """So that both stand in one file."""
    points = {"steps": {"few": {}}, "wall": {"rough": {}}, "replicates": {"one": {}}}
    dims = small({"shape": "c1"} | points).block("drag").dims
    assert dims == ("shape", "steps_swept", "wall_swept", "replicates_swept", "seed")


@pytest.mark.parametrize("kind", ["latin_hypercube", "sobol"])
def test_a_design_fills_its_ranges(kind):
    """One point in every interval of a sixteenth, for each factor; each point a bed of its own."""
    over = {
        "friction.granule": {"low": 0.1, "high": 0.5},
        "material.young_modulus": {"low": 1e9, "high": 1e11, "scale": "log"},
        "friction.wall": {"choices": [0.1, 0.4]},
    }
    spec = {"design": kind, "points": 16, "first_seed": 50, "over": over}
    block = small({"shape": "c1", "point": spec}).block("drag")
    runs = list(block.runs.values())
    assert [run.seed for run in runs] == list(range(50, 66))
    places = {
        "granule": [(r.configuration.friction.granule - 0.1) / 0.4 for r in runs],
        "modulus": [np.log10(r.configuration.material.young_modulus / 1e9) / 2 for r in runs],
    }
    for shares in places.values():
        assert sorted((16 * np.array(shares)).astype(int)) == list(range(16))
    assert {r.configuration.friction.wall for r in runs} == {0.1, 0.4}


def test_values_of_a_block_hold_in_all_of_it():
    """Seed, shape and density too; they are dimensions of one point."""
    values = {"seed": 7, "shape": "c1", "density": 2e3, "friction.wall": 0.1}
    block = small({"blocks": {"a": {"values": values, "friction.granule": [0.1, 0.2]}}}).block("a")
    assert block.dims == ("shape", "friction_granule", "seed")
    for run in block.runs.values():
        assert (run.label, run.density, run.seed, run.at("friction.wall")) == ("c1", 2e3, 7, 0.1)


def test_a_point_without_a_seed_has_the_usual_one():
    block = small(C1 | {"box": {"a": {"seed": 5}, "b": {"gravity": 1}}}).block("drag")
    assert [run.seed for run in block.runs.values()] == [5, 1]
    assert block.labels()["seed"][1] == ("box",)


def test_a_value_of_the_command_line_is_the_number_that_a_file_would_give():
    """A count stays a whole number, beside others that are not."""
    words = ["shapes.c1.granules=40", "box_width=7e-3", "friction.granule=0"]
    sweep = load(CONFIG / "smoke.yaml")
    run = sweep.changed(changes_of_words(sweep, words), "c1").replicate("c1", 3.9e3, 1)
    file = {"box_width": 7e-3, "friction": {"granule": 0}, "shapes": {"c1": {"granules": 40}}}
    base = yaml.safe_load((CONFIG / "smoke.yaml").read_text())
    assert run.id == parse(merged(base, file)).replicate("c1", 3.9e3, 1).id


def test_a_file_extends_another(tmp_path):
    """Values beside those of the other file; what varies is its own; results must be."""
    (tmp_path / "base.yaml").write_text((CONFIG / "smoke.yaml").read_text())
    path = tmp_path / "own.yaml"
    text = "extends: base.yaml\nresults: results/own\nfriction: {wall: 0.1}\nsweep: {shape: c1}\n"
    path.write_text(text)
    sweep = load(path)
    assert (sweep.friction.wall, sweep.friction.granule) == (0.1, 0.3)
    assert sweep.blocks == {"drag": {"shape": "c1"}} and sweep.studies == "smoke.yaml"
    path.write_text(text.replace("results: results/own\n", ""))
    with pytest.raises(InputError, match="results is missing"):
        load(path)


# What a run is known by


def test_what_a_run_does_not_read_makes_no_other_run():
    """Titles, other seeds, names, windows, chunks, order of keys: the same identity; other observables, another."""
    sweep = {"shape": "c1", "seed": [1]}
    first = ids(small(sweep))
    same = [
        small(sweep, title="other", batch=3, failures=0.5),
        small({"seed": "1 to 3", "shape": ["c1"]}),
        small(sweep, record=SMALL["record"] | {"window": [0.2e-3, 0.3e-3]}),
        small(sweep, ellipse={"contact": "geometric_potential"}),
        small(sweep, shapes={"c7": FEW["c1"]}),
        small({"shape": "c7"}, shapes={"c7": FEW["c1"]}),
    ]
    assert all(ids(other)[0] == first[0] for other in same)
    record = SMALL["record"] | {"observables": ["drag", "ledger"]}
    assert ids(small(sweep, record=record)) != first


SWEEPS = [
    CONFIG / "paper.yaml",
    *(
        CONFIG.parent / f"studies/{name}/sweep.yaml"
        for name in ("calibration", "onset", "preparation", "pressure", "shear", "velocity")
    ),
]
SWEEPS = [path for path in SWEEPS if path.is_file()]


@pytest.mark.parametrize("file", SWEEPS, ids=lambda path: "/".join(path.parts[-2:]))
def test_every_place_of_a_sweep_that_comes_with_the_code_is_a_run_of_its_own(file):
    """Whatever the experiment: no value that varies is left out of what a run is known by."""
    sweep = load(file)
    for block in sweep.blocks:
        run_ids = ids(sweep, block)
        assert len(run_ids) == len(set(run_ids)) > 1


def test_an_ellipse_reads_how_its_contacts_are_found():
    """A disc does not: its places on that axis are one run, made once."""
    contacts = ["common_normal", "geometric_potential"]
    block = small({"shape": ["c1", "e3"], "ellipse.contact": contacts}).block("drag")
    assert len(block.runs) == 4 and len(list(block.unique())) == 3
    assert sorted(map(len, block.points.values())) == [1, 1, 2]


def test_chunks_are_filled_and_runs_of_one_bed_follow_each_other(tmp_path):
    """Two beds of two runs, in chunks of at most so many."""
    block = small({"shape": "c1", "seed": [1, 2], "friction.granule": [0.1, 0.2]}).block("drag")
    for size, runs in ((5, [4]), (4, [4]), (3, [3, 1]), (2, [2, 2]), (1, [1, 1, 1, 1])):
        chunks, _ = plan_batches((), block.unique(), size, "results")
        assert [len(chunk.runs) for chunk in chunks] == runs
        if size == 2:
            beds = {run.id: run.bed_id for run in block.unique()}
            assert all(len({beds[run] for run in chunk.runs}) == 1 for chunk in chunks)


def test_the_first_batches_compile_each_kind_of_granule_once():
    """The others find it compiled. Those of the paper, whose c1 and c2 share kernels."""
    runs = {run.id: run for run in load(CONFIG / "paper.yaml").block("drag").unique()}
    chunks, _ = plan_batches((), runs.values(), 10, "results")
    kinds = [runs[chunk.runs[0]].shape.kind for chunk in chunks]
    assert sorted(kinds[:3]) == ["disc", "dumbbell", "ellipse"] and len(kinds) == 6
    axes = {"shape": "c1", "cylinder.spin": [None, "free"], "shapes.c1.granules": [60, 70]}
    record = SMALL["record"] | {"observables": ["drag", "snapshots"]}
    block = small(axes | {"seed": [1]}, record=record).block("drag")
    runs = {run.id: run for run in block.unique()}
    chunks, _ = plan_batches((), runs.values(), 10, "results")
    spins = [runs[chunk.runs[0]].configuration.cylinder.spin for chunk in chunks]
    assert spins == [None, "free", None, "free"]


@pytest.mark.parametrize(
    "axis",
    [
        {"shape": ["c1", "e3"]},
        {"shape": "c1", "contact.law": ["hertz", "linear"]},
        {"shape": "c1", "cylinder.spin": [None, "free"]},
    ],
    ids=["kind", "law", "variables"],
)
def test_runs_of_other_code_or_with_other_variables_are_in_other_batches(axis):
    """A file of a batch names the code of all its runs, and has a row of each variable for all."""
    record = SMALL["record"] | {"observables": ["drag", "snapshots"]}
    runs = small(axis | {"seed": [1, 2]}, record=record).block("drag").unique()
    chunks, _ = plan_batches((), runs, 5, "results")
    assert [len(chunk.runs) for chunk in chunks] == [2, 2]


def test_a_sweep_keeps_to_its_batches_while_another_makes_their_runs():
    """All its jobs find the same ones, however many the other puts together."""
    runs = list(small({"shape": "c1", "seed": [1, 2, 3, 4]}).block("drag").unique())
    first, _ = plan_batches((), runs, 1, "results/mine")
    others, _ = plan_batches((), runs, 4, "results/other")
    batches, new = plan_batches(others + first, runs, 1, "results/mine")
    assert set(batches) == set(first) and not new


# What is there is not made again


def test_a_value_that_is_added_makes_only_its_runs(tmp_path):
    """In chunks of their own; the old ones are as they were, and beds are packed once."""
    work = done(small({"shape": "c1", "friction.granule": [0.1, 0.3], "seed": [1, 2]}), tmp_path)
    chunks = {path: path.stat().st_mtime_ns for path in work.files("drag")}
    beds = list((tmp_path / "store/beds").rglob("*.npz"))
    assert len(beds) == 2
    other = SweepState(
        small({"seed": [2, 1], "friction.granule": [0.5, 0.1, 0.3], "shape": "c1"}, batch=1),
        work.store,
    )
    new = [chunk for chunk in other.batches("drag") if not other.store.file_of(chunk.id).exists()]
    assert [len(chunk.runs) for chunk in new] == [1, 1]
    done(other.sweep, tmp_path)
    assert chunks == {path: path.stat().st_mtime_ns for path in chunks}
    assert list((tmp_path / "store/beds").rglob("*.npz")) == beds


def test_an_n_dimensional_file_holds_every_run(tmp_path):
    """At its place, with the bits of the run made alone; also where seeds lie side by side in a batch."""
    few = {"c7": {"kind": "disc", "diameter": 1e-3, "granules": 20}}
    sweep = {"shape": ["c1", "c7"], "friction.granule": [0.3, 0.1], "seed": [1, 2]}
    sweep = small(sweep, batch=3, shapes=few, packing={"fraction": 0.7})
    dataset = combined(done(sweep, tmp_path), tmp_path)
    assert dataset["drag"].dims == ("shape", "friction_granule", "seed", "displacement")
    assert dataset["friction_granule"].attrs["long_name"] == "friction between granules"
    for point, run in sweep.block("drag").runs.items():
        alone = dem.run_experiment(run.values())
        np.testing.assert_array_equal(dataset["drag"][point].values, alone["drag"].values)
        assert dataset["run_id"][point] == alone.attrs["run_id"]


def test_a_combined_file_tells_the_values_that_its_runs_had(tmp_path):
    """Of a block, also those that all points of a group share, and not those of the file."""
    same = {"friction.wall": 0.2, "shapes.c1.granules": 25, "material.thickness": 1e-3}
    block = {
        "values": {"friction.granule": 0.1, "shape": "c1"},
        "box": {"a": same, "b": same},
        "gravity": [0.0, 1.0],
    }
    data = combined(done(small({"blocks": {"a": block}}), tmp_path), tmp_path, "a")
    config = json.loads(data.attrs["configuration"])
    assert config["friction"] == {"granule": 0.1, "wall": 0.2, "cylinder": 0.3, "stiffness": 1.0}
    assert config["shapes"]["c1"]["granules"] == 25 and config["material"]["thickness"] == 1e-3
    assert config["sweep"] == {"blocks": {"a": block}} and config["shapes"]["e3"]["granules"] == 60
    shared = {"friction_granule": 0.1, "friction_wall": 0.2}
    assert {name: data.coords[name].item() for name in shared} == shared
    assert data["gravity"].values.tolist() == [0.0, 1.0]
    assert data.coords["granules"].values.tolist() == [25]


def test_coordinates_of_a_combined_file_are_the_values_of_its_runs(tmp_path):
    """Along each dimension, of several values at once; what is absent is a gap, and not zero.

    netCDF has no truth values: the axis holds 0 and 1."""
    slow = {"cylinder.velocity": 1.0, "material.thickness": 1e-3, "friction.granule": 0.1}
    pull = {"slow": slow, "fast": {"cylinder.velocity": 3.0, "gravity": 9.81}}
    sweep = small(
        {"shape": "c1", "numerics.allow_unstable": [True, False], "pull": pull, "seed": [2, 1]}
    )
    data = combined(done(sweep, tmp_path), tmp_path)
    made = {"cylinder_velocity": [1.0, 3.0], "material_thickness": [1e-3, np.nan],
            "friction_granule": [0.1, 0.3], "gravity": [0.0, 9.81]}  # fmt: skip
    assert data["numerics_allow_unstable"].values.tolist() == [1, 0]
    for name, values in made.items():
        assert data[name].dims == ("pull",), name
        np.testing.assert_array_equal(data[name], values)
    for (_, stable, pulled, seed), run in sweep.block("drag").runs.items():
        assert data["run_id"].values[0, stable, pulled, seed] == run.id
        assert run.seed == data["seed"].values[seed]
        at = run.configuration.at
        assert at("numerics.allow_unstable") == data["numerics_allow_unstable"].values[stable]
        assert at("cylinder.velocity") == data["cylinder_velocity"].values[pulled]


def test_each_number_that_varies_is_a_label_of_its_runs():
    """Of a group too, whichever value it is; where the others have none, they have a gap."""
    base = small(C1)
    paths = base.block("drag").first.configuration.entries.keys() - {"cylinder.stroke"}
    absent = {"cylinder.spin": 40.0, "cylinder.direction": 1.5, "cylinder.angle": 0.2}
    numbers = {path: base.at(path) for path in paths if isinstance(base.at(path), float)}
    for path, value in (numbers | absent).items():
        new = absent.get(path, 1.02 * value if value else 0.1)
        block = small(C1 | {"p": {"a": {path: new}, "b": {}}}).block("drag")
        assert [run.at(path) for run in block.runs.values()] == [new, base.at(path)]
        _, dims, values = block.labels()[
            path.split(".")[-1] if "shapes" in path else path.replace(".", "_")
        ]
        assert "p" in dims, path
        np.testing.assert_array_equal(values.ravel(), [new, np.nan if path in absent else value])


ECHO = """
VALUES = {"gap": (1.0, "m", "gap between two plates")}
AXIS = {"place": (("place",), "m", "place")}
SIZES = {"place": 3}
VARIABLES = {"height": (("place",), "m", "height")}

def axes(configuration):
    return {"place": [k * configuration.echo.gap for k in range(3)]}

def run(replicate, bed=None, progress=None):
    return {"height": [replicate.seed] * 3}
"""


def test_runs_with_other_coordinates_are_not_combined(tmp_path):
    """As those of an experiment whose places depend on a value that varies; runs of one value are."""
    (tmp_path / "echo.py").write_text(ECHO)
    values = {"experiment": "echo.py", "beside": str(tmp_path), "cylinder": None, "record": None}
    sweep = small(
        {"blocks": {"a": C1 | {"echo.gap": [2.0]}, "b": C1 | {"echo.gap": [1.0, 2.0]}}}, **values
    )
    work = done(sweep, tmp_path)
    assert combined(work, tmp_path, "a", "echo")["place"].values.tolist() == [0.0, 2.0, 4.0]
    with pytest.raises(
        InputError, match="the coordinate place must be the same in all runs of b; use blocks"
    ):
        combined(work, tmp_path, "b", "echo")


def test_beds_at_equal_load_bear_the_same_force():
    """Force per length over E*: load times diameter, where load^(2/3) is slope times distance from jamming."""
    beds = {
        "kind": ["a", "b"],
        "friction": 0.0,
        "fraction": [0.83, 0.85],
        "slope": [0.5, 0.8],
        "diameter": [1e-3, 3e-3],
    }
    jamming = Jamming(pd.DataFrame(beds))

    def force(kind, fraction):
        row = {name: values[kind] for name, values in beds.items() if name != "friction"}
        return row["diameter"] * (row["slope"] * (fraction - row["fraction"])) ** 1.5

    for kind, other in ((0, 1), (1, 0)):
        fraction = jamming.at_load("ab"[kind], "ab"[other], 0.88)
        assert force(kind, fraction) == pytest.approx(force(other, 0.88))


def test_null_beside_numbers_is_a_label_of_its_axis(tmp_path):
    """Without units, as texts have none; a table and a figure show it."""
    work = done(small({"shape": "c1", "material.thickness": [None, 1e-3]}), tmp_path)
    axis = combined(work, tmp_path)["material_thickness"]
    assert axis.values.tolist() == ["null", "0.001"] and "units" not in axis.attrs
    for words in (["info"], ["figure", "sweep", "-o", str(tmp_path)]):
        result = CliRunner().invoke(app, [*words, str(tmp_path / "drag_drag.nc")])
        assert result.exit_code == 0, result.output
        assert words != ["info"] or "null" in result.output


def test_values_that_hardly_differ_are_told_apart(tmp_path):
    work = done(small({"shape": "c1", "friction.granule": [2, 2.0000001]}), tmp_path)
    table = drag_table(combined(work, tmp_path))
    assert [2.0, 2.0000001] in [table[name].tolist() for name in table]
    for shown in (TextTable(table), status(work)):
        with (console := Console(width=200)).capture() as text:
            console.print(shown)
        assert "2.0000001" in text.get()


def test_a_run_that_no_file_holds_is_named(tmp_path):
    """A sweep is not combined before all its batches are there; no file is left."""
    sweep = small({"shape": "c1", "seed": [1, 2]}, batch=1)
    work = done(sweep, tmp_path)
    first, second = work.files("drag")
    output = tmp_path / "drag.nc"
    with pytest.raises(InputError, match=r"seed [12] is in none of the 1 files; run again"):
        combine([first], sweep, sweep.block("drag"), "drag", output)
    second.unlink()
    with pytest.raises(InputError, match=rf"{second.name}: there is no such file\.$"):
        combine_block(work, "drag", "drag", output)
    assert not output.exists()


def test_failed_runs_have_the_same_gaps_whichever_chunk_comes_first(tmp_path):
    """NaN, and -1 for the number of steps; where too many failed, the first is named by its place."""
    sweep = {"shape": "c1", "numerics.max_overlap": [1e-6, 1.2], "seed": [1, 2]}
    work = done(small(sweep, batch=1, failures=0.9), tmp_path)
    dataset = combined(work, tmp_path)
    steps = dataset["steps"].fillna(-1).values[0]
    assert (steps[0] == -1).all() and (steps[1] > 0).all()
    strict, files = small(sweep), work.files("drag")
    for order in (files, files[::-1]):
        named = [shutil.copy(path, tmp_path / f"{n}.nc") for n, path in enumerate(order)]
        with pytest.raises(
            RunError, match=r"2 of 4 runs .* The first is c1 at 3900 kg/m3, seed 1:"
        ):
            combine(named, strict, strict.block("drag"), "drag", tmp_path / "drag.nc")


def test_prune_removes_what_no_sweep_needs(tmp_path, monkeypatch):
    """Batches of a value that was taken out, with their beds; nothing of a sweep that is there."""
    monkeypatch.chdir(tmp_path)
    work = done(small({"shape": "c1", "packing.fraction": [0.8, 0.84]}, batch=1), tmp_path)
    assert prune(work.store) == ([], 0)
    left = done(small({"shape": "c1", "packing.fraction": [0.84]}, batch=1), tmp_path)
    assert usage(left.store) == [(f"{tmp_path}/results/small", 1), ("no sweep", 1)]
    removed, size = prune(left.store)
    assert sorted(path.suffix for path in removed) == [".json", ".nc", ".npz"] and size > 0
    combine = tmp_path / "results/small"
    assert combined(left, combine)["drag"].shape == (1, 1, 1, 8)
    (combine / "config.yaml").unlink()
    assert all(path.suffix == ".npz" for path in prune(left.store)[0])  # drag.nc names its runs


def test_prune_leaves_the_plans_of_a_sweep_that_starts_meanwhile(tmp_path, monkeypatch):
    """Of which it does not know when it has looked at all folders."""
    monkeypatch.chdir(tmp_path)
    work = done(small({"shape": "c1"}), tmp_path)
    late = SweepState(small({"shape": "c1", "seed": [9]}, results="results/late"), work.store)

    def looked(store):
        yield from sweeps(store)
        late.begin("drag")

    monkeypatch.setattr("dem.sweep.prune.sweeps", looked)
    assert prune(work.store) == ([], 0)
    assert all(work.store.plan_of(batch.id).is_file() for batch in late.batches("drag"))


# The store, when something is wrong with it


def listed(folder):
    """All that lies below a folder, with the bytes of files."""
    return {path: path.read_bytes() if path.is_file() else None for path in Path(folder).rglob("*")}


def places(work):
    """Where a sweep has its beds, its runs under way and their checkpoints."""
    store, runs = work.store, work.sweep.block("drag").runs.values()
    of_runs = [store.run_of(run.id, end) for run in runs for end in (".npz", ".checkpoint.npz")]
    return [*map(store.file_of_bed, runs), *of_runs]


def as_if_made(work):
    """Write the plans of a sweep, and files in the places of what they ask for."""
    work.begin("drag")
    for path in work.files("drag"):
        path.write_bytes(b"\x89HDF\r\n\x1a\n runs")
    for file in places(work):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"a bed, or a run")


@pytest.fixture
def pruned(tmp_path, monkeypatch):
    """A sweep of two batches as if they were made, and one of a sweep whose folder was deleted."""
    monkeypatch.chdir(tmp_path)
    work = SweepState(small({"shape": "c1", "seed": [1, 2]}, batch=1))
    as_if_made(work)
    as_if_made(SweepState(small({"shape": "c1", "seed": [3]}, results="results/gone")))
    shutil.rmtree("results/gone")
    return work


def pruning():
    return CliRunner().invoke(app, ["store", "--prune"])


def refused(words):
    """That pruning says so, in sentences, and that nothing is removed."""
    files = listed("results")
    result = pruning()
    assert result.exit_code == 2 and words in result.stderr, (result.output, result.exception)
    assert listed("results") == files


def test_prune_keeps_beds_and_checkpoints_of_runs_under_way(pruned):
    """And removes those of a sweep whose folder was deleted."""
    gone = SweepState(small({"shape": "c1", "seed": [3]}, results="results/gone"))
    assert all(path.is_file() for path in places(pruned) + places(gone))
    assert pruning().exit_code == 0
    assert all(path.is_file() for path in places(pruned))
    assert not any(path.exists() for path in places(gone))


def test_prune_removes_what_is_damaged_and_was_put_aside(pruned):
    """Also of runs that a sweep needs: these are made again."""
    aside = [path.with_name(f"{path.name}.damaged") for path in places(pruned)]
    for path in aside:
        path.touch()
    assert pruning().exit_code == 0
    assert all(path.is_file() for path in places(pruned))
    assert not any(path.exists() for path in aside)


@pytest.mark.parametrize("text", ["", "results: results/small\nsweep:", "[]", b"\xff\xfe"])
def test_prune_removes_nothing_while_a_sweep_cannot_be_read(pruned, text):
    """What the sweep needs is unknown then. When the sweep starts again, it is whole again."""
    config = Path("results/small/config.yaml")
    config.write_bytes(text.encode() if isinstance(text, str) else text)
    refused(str(config))
    SweepState(pruned.sweep).begin("drag")
    result = pruning()
    assert result.exit_code == 0 and "5 files removed" in result.stdout, result.output
    assert all(path.is_file() for path in pruned.files("drag"))


def test_prune_removes_nothing_of_a_sweep_whose_folder_is_away(pruned):
    """Its disk may be away for a moment. Who wants none of the runs deletes the link, and the store."""
    results = Path(pruned.sweep.results)
    results.rename("away")
    results.symlink_to("../away")
    assert pruning().exit_code == 0 and all(path.is_file() for path in pruned.files("drag"))
    Path("away").rename("further")
    refused(f"{results}: it is a link to what is not there")
    results.unlink()
    refused("delete the folder results/store")


def test_prune_removes_nothing_whose_runs_are_unknown(pruned):
    """Nor what the store does not write: a note that somebody put there is theirs."""
    unknown = pruned.store.file_of("f" * 16)
    notes = [
        pruned.store.folder / name for name in ("batches/notes.txt", "batches/mine.nc", "beds/a/b")
    ]
    for note in (unknown, *notes):
        note.parent.mkdir(parents=True, exist_ok=True)
        note.write_text("mine")
    assert pruning().exit_code == 0 and all(note.is_file() for note in (unknown, *notes))


def test_a_command_about_the_store_says_where_there_is_none(tmp_path, monkeypatch):
    """And makes none."""
    monkeypatch.chdir(tmp_path)
    for words in ([], ["--prune"]):
        result = CliRunner().invoke(app, ["store", *words])
        assert result.exit_code == 2 and "there is no store" in result.stderr, result.output
    assert not list(tmp_path.iterdir())


def test_a_plan_that_was_changed_is_written_again(pruned):
    """By the next start of its sweep, which then makes the runs that it says."""
    batch = pruned.batches("drag")[0].id
    pruned.store.file_of(batch).unlink()
    path = pruned.store.plan_of(batch)
    text = path.read_text()
    path.write_text(re.sub(r'"fraction": 0\.\d+', '"fraction": 0.77', text))
    assert path.read_text() != text
    with pytest.raises(InputError, match="start the sweep, and workers"):
        pruned.store.replicates(batch)
    SweepState(pruned.sweep).begin("drag")
    assert path.read_text() == text and len(pruned.store.replicates(batch)) == 1


def test_a_sweep_says_where_a_new_store_begins(tmp_path, monkeypatch):
    """In a folder with a store it says nothing; a dry run makes none."""
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(small({"shape": "c1"}).dump()))
    command = ["sweep", "small.yaml", "--dry-run"]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("os.access", lambda _, mode: mode == os.R_OK)  # which only reads
    result = CliRunner().invoke(app, command)
    assert f"{tmp_path}/results/store: this store of runs is new" in result.stderr, result.output
    assert not (tmp_path / "results").exists()
    (tmp_path / "results/store").mkdir(parents=True)
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0 and "store" not in result.stderr


# The library


def test_a_sweep_is_a_loop_in_python(tmp_path):
    """load_sweep gives what run_experiment takes, in the order of the axes."""
    path = tmp_path / "own.yaml"
    sweep = {"shape": "c1", "friction.granule": [0.1, 0.3]}
    path.write_text(yaml.safe_dump(SMALL | {"shapes": FEW, "sweep": sweep}))
    values = list(dem.load_sweep(path))
    assert [run["friction"]["granule"] for run in values] == [0.1, 0.3]
    dataset = xr.concat([dem.run_experiment(run) for run in values], "friction_granule")
    assert dataset["drag"].dims == ("friction_granule", "displacement")
    assert dataset["drag"].attrs["units"] == "N" and dataset["shape"] == "c1"


def test_a_run_extends_a_file():
    """The values of the file, but for those that are said."""
    values = {"extends": str(CONFIG / "smoke.yaml"), "shape": "c1", "seed": 2}
    default = dem.run_experiment(values)
    rough = dem.run_experiment(values | {"friction": {"granule": 0.5}})
    assert float(rough["drag"].mean()) > float(default["drag"].mean()) > 0.0
    sweep = load(CONFIG / "smoke.yaml")
    assert default.attrs["run_id"] == Replicate(sweep, "c1", 3.9e3, 2).id
