"""Files of a user: what a run is known by, and files that change, or fail, while a process lives."""

import shutil
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from multiprocessing import get_context
from pathlib import Path

import pytest
from project import CONFIG, FILES, LAW, PRODUCT, PRODUCTS, SHAPE, quick, write

import dem
from dem.base import plugins
from dem.experiment.config import of_values
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store


def first_run(file: Path):
    return load(file).block("drag").first


PEBBLES = "{shapes: {p: {kind: pebbles.Pebble, diameter: 1e-3, granules: 60, aspect_ratio: 1.0}}}"
SMOKE = f"extends: {CONFIG}/smoke.yaml\nresults: results/mine\n"
OF_DISCS = SMOKE + "sweep: {shape: c1, density: 3900, seed: 1}\n"
OF_PEBBLES = SMOKE + f"sweep: {{shape: p, density: 3900, seed: 1}}\n{PEBBLES[1:-1]}\n"
KINDS = {  # of files of a user: the name of one, its text, and a sweep that names it
    "experiment": ("product", PRODUCT, PRODUCTS),
    "observable": (
        "rotation",
        FILES["rotation.py"],
        f"{OF_DISCS}record: {{observables: [drag, rotation.py]}}",
    ),
    "shape": ("pebbles", SHAPE, OF_PEBBLES),
    "law": ("cones", LAW, f"{OF_DISCS}contact: {{law: cones.Cone}}"),
}
IMPORTS = """
import one
import json, two as other
from three import F
from four import *
import five.six
from seven import eight, A
from nine.ten import F
import eleven.twelve
from thirteen import fourteen
OWN = 2.0
try:
    import absent
except ImportError:
    import fifteen

def late():
    from sixteen import F
"""
BESIDE = {  # eleven and thirteen have no __init__.py
    "eight": "from . import near\nfrom .close import F\n",
    "sixteen": "import further\n",
}
IMPORTED = (
    "one two three four five.__init__ five.six seven.__init__ seven.eight seven.near seven.close "
    "nine.__init__ nine.ten eleven.twelve thirteen.fourteen fifteen sixteen further"
)


@quick
@pytest.mark.parametrize("kind", KINDS)
def test_a_run_is_known_by_each_file_that_its_own_imports(tmp_path, kind):
    """In any form, directly or not, and by no other, nor by the folder, comments and docstrings."""
    name, text, sweep = KINDS[kind]
    modules = [*IMPORTED.split(), "unused", "five.unused"]
    files = {module: BESIDE.get(module.split(".")[-1], "") + "F = A = 2.0\n" for module in modules}
    files[name] = f"{IMPORTS}{text}"
    reference = first_run(write(tmp_path / "first", sweep=sweep, **files)).id
    changed = set()
    for edited, old in files.items():
        file = write(tmp_path / edited, sweep=sweep, **files | {edited: old.replace("2.0", "3.0")})
        if first_run(file).id != reference:
            changed.add(edited)
    assert changed == {name, *IMPORTED.split()}
    words = {edited: f"'''Words.'''\n{old}  # a comment\n" for edited, old in files.items()}
    assert first_run(write(tmp_path / "words", sweep=sweep, **words)).id == reference


def products(file, executor=None) -> list[float]:
    """What a sweep gives; the dataset stays open, as in a notebook."""
    return dem.run_sweep(file, executor)["product"].values.ravel().tolist()


HELPED = PRODUCT.replace("FACTOR = 2", "from factors import FACTOR").replace(
    "    return", "    import factors\n    assert factors.FACTOR == FACTOR\n    return"
)


@pytest.fixture
def file(folder):
    """A sweep of an experiment that takes no time, and imports a file beside it."""
    return write(folder / "mine", product=HELPED, factors="FACTOR = 2\n", sweep=PRODUCTS)


EDITS = {  # files that are written
    "the file": {"product": HELPED.replace("FACTOR *", "5 *")},
    "a helper": {"factors": "FACTOR = 5\n"},
    "new helpers": {"factors": "from more.json import FACTOR\n", "more.json": "FACTOR = 5\n"},
}


@pytest.mark.parametrize("edit", EDITS)
@pytest.mark.parametrize("in_workers", [False, True])
def test_a_process_that_lives_on_runs_files_as_they_are_now(file, edit, in_workers):
    """Also what they import late. Those of the same names that it had before, of another folder, are others."""
    other = {"product": HELPED, "factors": "FACTOR = 3\n", "sweep": PRODUCTS}
    assert products(write(file.parents[1] / "other", **other)) == [3, 6, 9]
    with ProcessPoolExecutor(1, get_context("spawn")) if in_workers else nullcontext() as pool:
        assert products(file, pool) == [2, 4, 6]
        write(file.parent, **EDITS[edit])
        assert products(file, pool) == [5, 10, 15]
        write(file.parent, product=HELPED, factors="FACTOR = 2\n")
        assert products(file, pool) == [2, 4, 6]


@quick
def test_a_file_that_could_not_be_imported_is_imported_once_it_is_mended(file):
    write(file.parent, factors="FACTOR = 2 / 0\n")
    with pytest.raises(dem.InputError, match=r"product\.py: it cannot be imported \(ZeroDivision"):
        products(file)
    write(file.parent, factors="FACTOR = 2\n")
    assert products(file) == [2, 4, 6]


@quick
def test_an_edited_file_that_was_only_planned_is_run_as_it_is_now(file):
    (values, *_) = dem.load_sweep(file)
    write(file.parent, factors="FACTOR = 3\n", sweep=PRODUCTS.replace("[1, 2, 3]", "[5]"))
    assert float(dem.run_experiment(values)["product"]) == 3
    assert products(file) == [15]


@quick
def test_files_of_one_name_in_two_folders_are_two(file, tmp_path):
    """Also where only a helper has the name of another."""
    files = [file]
    for factor, name in (3, "product"), (4, "other"):
        texts = {name: HELPED, "factors": f"FACTOR = {factor}\n"}
        sweep = PRODUCTS.replace("product.py", f"{name}.py")
        files.append(write(tmp_path / name, sweep=sweep, **texts))
    values = [next(dem.load_sweep(path)) for path in files]
    results = [dem.run_experiment(each)["product"].item() for each in 2 * values]
    assert results == 2 * [2, 3, 4]


@quick
def test_a_file_may_have_the_name_of_an_installed_module(file):
    write(file.parent, json=HELPED, sweep=PRODUCTS.replace("product", "json"))
    assert dem.run_sweep(file)["product"].sum() == 12


def shape_of(file: Path):
    return first_run(file).configuration.kind_of("p").shape


@quick
def test_an_edited_shape_is_another_class(file):
    """A comment is no edit, and the class is one for all who import it from its folder."""
    product = f"from pebbles import Pebble\n{PRODUCT}"
    write(file.parent, pebbles=SHAPE, sweep=OF_PEBBLES, product=product)
    first = shape_of(file)
    assert plugins.load(file.with_name("product.py")).Pebble is first
    write(file.parent, pebbles=SHAPE.replace("0.08", "0.07"))
    assert shape_of(file).of_size([1e-3], 1.0).bulge == 0.07
    write(file.parent, pebbles=f"{SHAPE}# a comment\n")
    assert shape_of(file) is first


BULGING = "raise dem.InputError('bulge is 1.0; it must lie in 0 to 0.12.')\n        unit = cls"
BAD_SHAPES = {  # by name of a class: what is put for what is there, and what the sentence says after shape and class
    "Undecorated": ("@smooth(support)\n", "", "Undecorated is no shape; decorate it with smooth"),
    "Bulging": ("unit = cls", BULGING, "bulge is 1.0;"),
    "Larger": ("(0.5 *", "(0.5005 *", "Larger.of_size gives a granule of "),
}


@quick
@pytest.mark.parametrize("wrong", BAD_SHAPES)
def test_what_is_wrong_with_granules_is_said_before_any_bed_is_packed(file, wrong):
    """Such as a size that a class does not take; others would make a bed of another packing fraction."""
    old, new, words = BAD_SHAPES[wrong]
    text = SHAPE.replace(old, new).replace("Pebble", wrong)
    sweep = OF_PEBBLES.replace("Pebble", wrong)
    write(file.parent, sweep=sweep, pebbles=f"import dem\n{text}")
    with pytest.raises(dem.InputError, match=rf"^shapes\.p \(pebbles\.{wrong}\): .*{words}"):
        dem.run_experiment(next(dem.load_sweep(file)))


WRONG = {  # what is put instead of the result: why the run failed
    "exit(3)": "product.py, line LINE: SystemExit: 3",
    "failing()": "helping.py, line 2: KeyError: 'a'",
    "edited()": "late.py has changed since its run was planned",
    "'four'": "the variable product is 'four'; it must be a number.",
    "1} and {'other': 1": "the variable other must be both in VARIABLES and in what product.py gives.",
}


HELPING = """def failing():
    return {}['a']

def edited():
    open(__file__.replace("helping", "late"), "w").write("NEW = True")
    import late
"""


@quick
def test_an_error_in_an_experiment_of_ones_own_fails_its_run_only(file):
    """With the line of the file that is wrong."""
    start = "from helping import edited, failing\n" + PRODUCT.partition("    return")[0].rstrip()
    lines = [
        f"    if replicate.seed == {k}: return {{'product': {x}}}"
        for k, x in enumerate([*WRONG, "7"])
    ]
    text = "\n".join([start, *lines, ""])
    sweep = PRODUCTS.replace("[1, 2, 3]", f"0 to {len(WRONG)}").replace("0.5", "0.95")
    write(file.parent, product=text, helping=HELPING, late="", sweep=sweep)
    data = dem.run_sweep(file)
    *failed, whole = data["failure"].values.ravel()
    assert all(failed) and not whole and data["product"].values.ravel()[-1] == 7
    for line, reason in enumerate(WRONG.values(), start.count("\n") + 2):
        assert reason.replace("LINE", str(line)) in data["failure"].comment


OBSERVABLE = """
VARIABLES = {"turn": ((), "rad", "a number")}


def measure(run):
    seed = run.replicate.seed
    return {"turn": run.missing} if seed == 2 else None if seed == 3 else {"turn": 1.0}
"""


def test_an_error_in_an_observable_of_ones_own_fails_its_run_only(file):
    sweep = OF_DISCS.replace("seed: 1", "seed: [1, 2, 3]") + "failures: 0.9\n"
    sweep += "record: {observables: [drag, turn.py]}\n"
    failure = dem.run_sweep(write(file.parent, turn=OBSERVABLE, sweep=sweep))["failure"]
    assert failure.values.ravel().astype(bool).tolist() == [False, True, True]
    assert "turn.py, line 7: AttributeError: 'RunData' object has no" in failure.comment
    assert "phases.py, line " in failure.comment and "NoneType" in failure.comment


NEAR = '''
"""Which contacts carry most."""

SIZES = {"contact": 900}
VARIABLES = {
    "contact_force": (("snapshot", "contact"), "N", "normal force of a contact"),
    "contact_number": (("snapshot",), "1", "number of contacts"),
}


def look(simulation):
    force = simulation.contacts().force
    return {"contact_force": force, "contact_number": len(force)}
'''


def test_an_observable_gives_lists_of_any_length(file):
    """Rows end in NaN; a list that is longer than it may be is refused and not cut."""
    write(file.parent, near900=NEAR, near3=NEAR.replace("900", "3"))
    values = {"extends": f"{CONFIG}/smoke.yaml", "shape": "c1", "beside": str(file.parent)}
    words = (
        r"contact_force is an array of float64 with shape \(\d+,\); it must be numbers, at most 3"
    )
    with pytest.raises(dem.RunError, match=words):
        dem.run_experiment(values | {"record": {"observables": ["drag", "near3.py"]}})
    result = dem.run_experiment(values | {"record": {"observables": ["drag", "near900.py"]}})
    assert (result["contact_force"].count("contact") == result["contact_number"]).all()
    assert result["contact_number"].std() > 0


@quick
def test_values_of_ones_own_are_read_where_the_file_is_away(file, tmp_path):
    """As the values of runs are, which name no folder; and they are part of what a run is known by. A sweep may
    be in another folder than its files."""
    sweep = f"{SMOKE}experiment: rest.py\nrest: {{layers: 2}}\nbeside: ../mine\n"
    sweep += "sweep: {shape: c1, density: 3900, seed: 1, rest.margin: [0, 1e-3]}\n"
    write(file.parent, rest=FILES["rest.py"])
    elsewhere = load(write(tmp_path / "sweeps", sweep=sweep))
    assert elsewhere.beside == parse(elsewhere.dump()).beside == str(file.parent)
    one, two = elsewhere.block("drag").unique()
    assert one.id != two.id
    away = {name: value for name, value in two.values().items() if name != "beside"}
    assert of_values(away).configuration.rest.margin == two.configuration.rest.margin == 1e-3
    assert of_values(away | {"beside": str(file.parent)}).id == two.id


@quick
def test_a_plan_finds_shapes_that_were_moved_since(tmp_path):
    """A sweep that was stopped, and started again in another place."""
    store = Store(tmp_path / "store")
    for name in ("one", "two"):
        work = SweepState(load(write(tmp_path / name, pebbles=SHAPE, sweep=OF_PEBBLES)), store)
        (chunk,) = work.batches("drag")
        work.begin("drag")
        (replicate,) = store.replicates(chunk.id)
        assert replicate.configuration.beside == str(tmp_path / name)
        shutil.rmtree(tmp_path / name)
    assert len([*(tmp_path / "store").rglob(f"{chunk.id}.*")]) == 1
