"""The command line's promises: exit status, one sentence, nothing written, and files whose labels are true."""

import json
import operator
import re
import time
from functools import reduce
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest
import xarray as xr
import yaml
from command_line import called
from project import CONFIG, PRODUCT, PRODUCTS, ROOT, changed_file, posix, quick
from sweeps import contents, differing, simulate
from typer.main import get_command
from workflows import run

import dem
from dem.cli.app import app
from dem.io.progress import bar
from dem.sweep.axis import is_written
from dem.sweep.estimate import outcome
from dem.sweep.state import SweepState


def test_a_failed_run_says_what_where_and_when(tmp_path):
    """A run that overlaps too much stops with status 1, naming granule, step and time."""
    result = called(simulate(tmp_path / "run.nc", "numerics.max_overlap=0.08"))
    assert result.exit_code == 1
    assert re.search("^granule .* overlaps [gsw].* by .* step .* time .* 0.08", result.stderr, re.M)
    assert "Error" not in result.stderr and not list(tmp_path.iterdir())


def paths():
    """Each argument and option that takes a path: its verb, its name, whether it is an option, and words with a
    folder in its place."""
    given = {"shape": "c1", "density": 3900, "seed": 1, "name": "figure13", "file": "smoke.yaml"}
    data, ends = ROOT / "docs/data/drag.nc", {"report": ".html", "draw": ".png"}
    for verb, command in get_command(app).commands.items():
        kinds = get_type_hints(command.callback)
        given |= {"data": data, "run": data, "output": f"OUT{ends.get(verb, '.nc')}"}
        for parameter in command.params:
            if kinds.get(parameter.name) in (Path, Path | None):
                words = [verb]
                for other in command.params:
                    value = "FOLDER" if other is parameter else given.get(other.name)
                    if other is parameter or other.required:
                        is_option = other.param_type_name == "option"
                        words += [f"--{other.name}"] * is_option + [str(value)]
                name = parameter.name
                yield pytest.param(
                    name, parameter.param_type_name, " ".join(words), id=f"{verb} {name}"
                )


@quick
@pytest.mark.parametrize(("name", "kind", "line"), [*paths()])
def test_a_path_that_cannot_be_is_called_what_it_is_called_where_it_was_given(
    tmp_path, name, kind, line
):
    """A folder, a file of another kind, or a file in place of a folder: what is to be written by the name of its
    option, what is to be read by its own name. Nothing is written or replaced."""
    if line.startswith("figure") and name == "output":
        pytest.skip("it is a folder")
    written, note = kind == "option" and name != "config", tmp_path / "note.md"
    note.write_text("a note")
    bad = [tmp_path / f"folder{end}" for end in ("", ".nc", ".html", ".png", ".txt")]
    for folder in bad:
        folder.mkdir()
    for path in [*bad, note / "out.nc", *[note] * (name != "checkpoint")] if written else bad[:1]:
        out = str(tmp_path / "out")
        result = called(line.replace("FOLDER", str(path)).replace("OUT", out))
        assert result.exit_code == 2, result.output
        assert result.stderr.startswith(f"{name} is '{path}'; " if written else f"{path}: ")
        assert {*tmp_path.rglob("*")} == {note, *bad} and note.read_text() == "a note"


ASKED = {  # of each kind of value: a number, a whole one, a truth value, a word, of a shape, of a section that is absent
    "friction.granule": 0.2,
    "record.bins": 40,
    "numerics.allow_unstable": True,
    "packing.preparation": "grown",
    "shapes.c1.granules": 48,
    "gravity": 9.81,
    "cylinder.direction": 0.5,
}


@quick
def test_a_run_is_labelled_with_the_values_of_the_command_line(tmp_path):
    """As the same values in a file would: all arrays, the identity and the attributes, and the numbers of the
    library."""
    values = changed_file(CONFIG / "smoke.yaml", ASKED)
    (tmp_path / "same.yaml").write_text(yaml.safe_dump(values))
    words = " ".join(f"{path}={value}" for path, value in ASKED.items())
    files, labels = [tmp_path / name for name in ("asked.nc", "same.nc")], []
    for file, more in zip(files, (words, f"--config {tmp_path}/same.yaml"), strict=True):
        assert (run := called(simulate(file, more))).exit_code == 0, run.output
        with xr.open_dataset(file) as data:
            clocks = "history", "crc32"  # that of the time it took is in there
            labels.append({name: data.attrs[name] for name in data.attrs if name not in clocks})
    asked, same = map(contents, files)
    assert differing(asked, same) == [] and labels[0] == labels[1]
    (ran,) = json.loads(labels[0]["values"])
    for path, value in ASKED.items():
        assert reduce(operator.getitem, path.split("."), ran) == value, path
    result = dem.run_experiment(ran)
    np.testing.assert_array_equal(asked["drag"][0], result["drag"])
    assert asked["run_id"].tolist() == [result.attrs["run_id"]]


PRINTED = {  # a value: as it is written, and what is another one
    1.5581123456: ("1.55811 1.5581 1.558112", "1.558"),
    2.3: ("2.3 2.30", "2"),
    1_000_001: ("1000001", "1e6"),
    7.66e10: ("7.66e+10", "7.7e10"),
    -0.5: ("-0.5", "0.5"),
    True: ("true True", "false"),
}


@quick
@pytest.mark.parametrize("value", PRINTED)
def test_a_run_is_found_by_a_value_as_it_was_printed(value):
    """Tables print five digits, a dry run six, files all; fewer are another value."""
    same, other = PRINTED[value]
    assert all(is_written(value, text) for text in same.split()) and not is_written(value, other)


@quick
def test_a_log_has_a_line_of_progress_each_half_a_minute(capsys, monkeypatch):
    now = 0.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    with bar("runs", 4.0) as update:
        for now, words in (20.0, "early"), (31.0, "runs"), (60.0, "early"), (62.0, "1 failed"):
            update(now / 31.0, words)
    assert capsys.readouterr() == ("", "runs: 25% done\n1 failed: 50% done\n")


def test_a_sweep_ends_with_the_file_of_its_runs_and_what_to_do_next(folder):
    """A sweep with nothing to make says so; what was asked for is on stdout, and nothing was."""
    Path("results/store").mkdir(parents=True)  # a new one is said
    Path("product.py").write_text(PRODUCT)
    Path("sweep.yaml").write_text(PRODUCTS)
    file = "results/product/product.nc"
    for new in 3, 0:
        result = called("sweep sweep.yaml -j1")
        assert (result.exit_code, result.stdout) == (0, "")
        assert result.stderr.endswith(
            f"results/product holds 3 runs, {new} of them new. Next: dem info {file}\n"
        )
    file, words = "results/smoke/drag.nc", outcome(SweepState.of(CONFIG / "smoke.yaml"))
    assert words.endswith(f" Next: dem info {file} or dem figure all {file}")


@pytest.mark.parametrize(
    "command",
    ["dem sweep config/paper.yaml -n", pytest.param("snakemake -n -d {}", marks=posix)],
)
def test_a_plan_waits_for_neither_kernels_nor_datasets(tmp_path, command):
    text = run("-X", "importtime", "-m", *command.format(tmp_path).split(), cwd=ROOT)
    loaded = {line.rpartition("|")[2].strip() for line in text.splitlines()}
    assert "dem.sweep.state" in loaded and not loaded & {"numba", "xarray", "pandas", "scipy"}


@quick
def test_a_described_run_is_printed_and_not_made(tmp_path, monkeypatch):
    """As a sweep file, which another simulate would take."""
    monkeypatch.chdir(tmp_path)
    words = "simulate --shape c1 --density 3900 --seed 7 friction.granule=0.2"
    config = f"--config {CONFIG / 'smoke.yaml'}"
    described = called(f"{words} {config} --describe")
    assert described.exit_code == 0 and not [*tmp_path.iterdir()]
    values = yaml.safe_load(described.output)
    assert values["experiment"] == "scene" and values["sweep"]["seed"] == [7]
    assert values["friction"]["granule"] == 0.2
    assert "output is missing" in called(f"{words} {config}").output
