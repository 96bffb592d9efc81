"""Files of a user's own that change, or fail, while a process lives: a notebook, workers, a sweep."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext, suppress
from multiprocessing import get_context
from pathlib import Path

import pytest
import xarray as xr
from pictures import text_of
from project import CONFIG, SHAPE, posix

import dem
from dem.base import plugins, source_hash
from dem.base.source_hash import PACKAGE
from dem.experiment.run import Replicate
from dem.report.info import summary
from dem.report.status import status
from dem.sweep.config import load
from dem.sweep.state import SweepState

SEEDS = [1, 2, 3]
EXPERIMENT = """
from factors import FACTOR

SECTIONS = {"cylinder": False, "record": False}
VARIABLES = {"product": ((), "1", "seed times a factor")}


def run(replicate, bed=None, progress=None):
    return {"product": FACTOR * replicate.seed}
"""
SWEEP = f"""
extends: {CONFIG}/smoke.yaml
results: results/product
experiment: product.py
failures: 0.5
batch: 1
sweep: {{shape: c1, density: 3900, seed: [1, 2, 3]}}
"""


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A sweep of an experiment that takes no time, and imports a file beside it, in a process that has not
    imported them."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plugins, "_imported", {})
    monkeypatch.setattr(sys, "path", sys.path.copy())
    for name in ("product", "factors", "less", "more"):
        sys.modules.pop(name, None)
    folder = tmp_path / "mine"
    folder.mkdir()
    write(folder, "product.py", EXPERIMENT)
    write(folder, "factors.py", "FACTOR = 2\n")
    return write(folder, "sweep.yaml", SWEEP)


def write(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    return folder / name


def products(file, executor=None) -> list[float]:
    """What a sweep gives; the dataset stays open, as in a notebook."""
    return dem.run_sweep(file, executor)["product"].values.ravel().tolist()


OLD = r"{}.* has changed since this process read it; start Python, or the workers, again\.$"
EDITS = {  # files that are written
    "the file": {"product.py": EXPERIMENT.replace("FACTOR *", "3 *")},
    "a helper": {"factors.py": "FACTOR = 5\n"},
    "a new helper": {"factors.py": "from more import FACTOR\n", "more.py": "FACTOR = 7\n"},
}


@pytest.mark.parametrize("edit", EDITS)
@pytest.mark.parametrize("in_workers", [False, True])
def test_a_process_that_lives_on_returns_no_numbers_of_old_code(file, edit, in_workers):
    """An edited file is one sentence; a comment is no edit, and the old file is good again."""
    with ProcessPoolExecutor(1, get_context("spawn")) if in_workers else nullcontext() as pool:
        expected = [2 * seed for seed in SEEDS]
        assert products(file, pool) == expected
        for name, text in EDITS[edit].items():
            write(file.parent, name, text)
        words = "workers that live on, again" if in_workers else OLD.format(r"product\.py")
        with pytest.raises(dem.InputError, match=words):
            products(file, pool)
        write(file.parent, "product.py", f"{EXPERIMENT}# a comment\n")
        write(file.parent, "factors.py", "FACTOR = 2\n")
        assert products(file, pool) == expected


def test_a_file_that_could_not_be_imported_is_imported_once_it_is_mended(file):
    write(file.parent, "factors.py", "FACTOR = 2 / 0\n")
    with pytest.raises(dem.InputError, match=r"product\.py: it cannot be imported \(ZeroDivision"):
        products(file)
    write(file.parent, "factors.py", "FACTOR = 2\n")
    assert products(file) == [2 * seed for seed in SEEDS]


def test_an_edited_file_that_was_only_planned_is_run_as_it_is_now(file):
    (values, *_) = dem.load_sweep(file)
    write(file.parent, "factors.py", "FACTOR = 3\n")
    assert float(dem.run_experiment(values)["product"]) == 3
    write(file.parent, "sweep.yaml", SWEEP.replace("[1, 2, 3]", "[5]"))
    assert products(file) == [15]


def test_files_of_one_name_in_two_folders_are_two(file, tmp_path):
    """Also where only a helper has the name of another."""
    folders = [(file.parent, 2)]
    for name, factor in (("product.py", 3), ("other.py", 4)):
        folder = tmp_path / name.partition(".")[0]
        folder.mkdir()
        write(folder, name, EXPERIMENT)
        write(folder, "factors.py", f"FACTOR = {factor}\n")
        write(folder, "sweep.yaml", SWEEP.replace("product.py", name))
        folders.append((folder, factor))
    for folder, factor in folders * 2:
        (values, *_) = dem.load_sweep(folder / "sweep.yaml")
        assert float(dem.run_experiment(values)["product"]) == factor


def test_a_file_with_the_name_of_an_installed_module_is_refused(file):
    write(file.parent, "json.py", EXPERIMENT)
    write(file.parent, "sweep.yaml", SWEEP.replace("product", "json"))
    with pytest.raises(
        dem.InputError, match=r"json\.py: Python has another module named json, which is installed"
    ):
        dem.run_sweep(file)


def test_an_edited_shape_is_one_sentence_and_nothing_is_written(file):
    """Numba would not tell the old class from the new one; the old file is good again."""
    text = SHAPE.replace("Pebble", "EditedPebble")
    write(file.parent, "edited_pebbles.py", text)
    shape = "{kind: edited_pebbles.EditedPebble, diameter: 1e-3, granules: 60, aspect_ratio: 1.0}"
    write(
        file.parent,
        "sweep.yaml",
        SWEEP.replace("shape: c1", "shape: p") + f"shapes: {{p: {shape}}}\n",
    )
    first = of_first(file).kind.shape
    write(file.parent, "edited_pebbles.py", text.replace("0.08", "0.07"))
    with pytest.raises(
        dem.InputError, match=r"edited_pebbles\.py .*start Python, or the workers, again\.$"
    ):
        dem.run_sweep(file)
    assert not Path("results").exists()
    write(file.parent, "edited_pebbles.py", f"{text}# a comment\n")
    assert of_first(file).kind.shape is first


def of_first(file) -> Replicate:
    return next(load(file).block("drag").unique())


def test_an_edited_package_is_one_sentence_and_nothing_is_written(file, monkeypatch):
    """Its old code goes on in this process."""
    source_hash.run_hash()
    path = PACKAGE / "scene.py"
    monkeypatch.setitem(source_hash._first_read, path, b"EDITED = True")
    for call in (dem.run_sweep, dem.load_sweep):
        with pytest.raises(dem.InputError, match=OLD.format(r"scene\.py")):
            call(file)
    assert not Path("results").exists()


WRONG = {  # what is put instead of the result: why the run failed
    "1 / 0": "product.py, line 9: ZeroDivisionError: division by zero",
    "replicate.grains": "product.py, line 9: AttributeError: 'Replicate' object has no attribute 'grains'",
    "dem.Friction(-1.0).granule": "product.py, line 9: InputError: Friction.granule is -1.0; it must be",
    "exit(3)": "product.py, line 9: SystemExit: 3",
    "helped()": "factors.py, line 4: KeyError: 'a'",
    "'four'": "the variable product is 'four'; it must be a number.",
    "[1.0, 2.0]": "the variable product is an array of float64 with shape (2,); it must be a number.",
    "1} and {'other': 1": "the variable other must be both in VARIABLES and in what product.py gives.",
    "1} and None or {0": "the variable product must be both in VARIABLES and in what product.py gives.",
    "1, 'other': set()": "the variable other must be both in VARIABLES and in what product.py gives.",
}


@pytest.mark.parametrize("wrong", WRONG)
def test_an_error_in_an_experiment_of_ones_own_fails_its_run_only(file, wrong):
    """With the line of the file that is wrong, in the terminal and in the files."""
    write(file.parent, "factors.py", "FACTOR = 2\n\ndef helped():\n    return {}['a']\n")
    text = EXPERIMENT.replace("import FACTOR", "import FACTOR, helped").replace(
        'return {"product": FACTOR * replicate.seed}',
        f'return {{"product": 1}} if replicate.seed != 2 else {{"product": {wrong}}}',
    )
    write(file.parent, "product.py", f"import dem{text}")
    dem.run_sweep(file).close()
    with xr.open_dataset("results/product/product.nc") as dataset:
        failed = dataset["failure"].values.ravel().astype(bool).tolist()
        assert failed == [False, True, False]
    assert WRONG[wrong] in text_of(summary(Path("results/product/product.nc")))
    assert f"1 failed: {WRONG[wrong]}" in text_of(status(SweepState.of(file)))


OBSERVABLE = """
VARIABLES = {"turn": ((), "rad", "a number")}


def measure(run):
    seed = run.replicate.seed
    return {"turn": run.missing} if seed == 2 else None if seed == 3 else {"turn": 1.0}
"""


def test_an_error_in_an_observable_of_ones_own_fails_its_run_only(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "turn.py", OBSERVABLE)
    sweep = f"extends: {CONFIG}/smoke.yaml\nresults: results/turn\nfailures: 0.9\n"
    sweep += "record: {observables: [drag, turn.py]}\nsweep: {case: [c1], seed: [1, 2, 3]}\n"
    data = dem.run_sweep(write(tmp_path, "sweep.yaml", sweep))
    assert data["failure"].values.ravel().astype(bool).tolist() == [False, True, True]
    assert "turn.py, line 7: AttributeError: 'RunData' object has no" in data["failure"].comment
    assert "drag.py, line " in data["failure"].comment and "NoneType" in data["failure"].comment


@posix
@pytest.mark.parametrize("compiles", [False, True])
def test_workers_end_with_the_process_that_started_them(tmp_path, compiles):
    """However it ends: they would keep memory, and a pipe that somebody reads."""
    write(
        tmp_path,
        "sweep.yaml",
        f"extends: {CONFIG}/smoke.yaml\nresults: results/many\nsweep: {{case: [c1], seed: 1 to 400}}\n",
    )
    cache = tmp_path / "cache" if compiles else source_hash.cache_folder()
    command = [sys.executable, "-m", "dem", "sweep", "sweep.yaml", "-j2"]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(source_hash.ROOT)}
    options = {"cwd": tmp_path, "env": environment, "start_new_session": True}
    with subprocess.Popen(
        command, **options, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    ) as process:
        try:
            ended = time.monotonic() + 120.0
            while not any((tmp_path / "results/store/runs").rglob("*.lock")):
                assert process.poll() is None and time.monotonic() < ended
                time.sleep(0.05)
            process.kill()
            process.communicate(timeout=30.0)  # until nobody has the pipe
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
