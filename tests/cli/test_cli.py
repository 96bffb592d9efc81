"""The command line's promises: exit status, one sentence, nothing written."""

import importlib.metadata
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from project import ROOT, posix
from typer.main import get_command
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.cli.app import app
from dem.figures import film
from dem.io.progress import bar
from dem.sweep.axis import is_written

RUN = "simulate --config config/smoke.yaml --shape c1 --density 3900 --seed 1 -o OUT"


def dem(*arguments):
    command = [sys.executable, "-m", "dem", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, text=True, capture_output=True)


def test_a_person_has_at_most_ten_verbs_to_learn():
    assert len(get_command(app).commands) <= 10


def test_a_failed_run_says_what_where_and_when(tmp_path):
    """A run that overlaps too much stops with status 1, naming granule, step and time."""
    text = (ROOT / "config/smoke.yaml").read_text() + "\nnumerics: {max_overlap: 0.08}\n"
    config = tmp_path / "tight.yaml"
    config.write_text(text)
    output = tmp_path / "run.nc"
    run = dem(*RUN.split(), "--config", config, "-o", output)
    assert run.returncode == 1, run.stderr
    assert re.search("^granule .* overlaps [gsw].* by .* step .* time .* 0.08", run.stderr, re.M)
    assert "Error" not in run.stderr
    assert not output.exists() and not list(tmp_path.glob(".*"))


COMBINE = "combine --config config/smoke.yaml -o OUT"
REFUSED = {  # a command: a part of the sentence that refuses it
    f"{RUN} --density -1": "density is -1.0",
    f"{RUN} --seed -4": "seed is -4",
    f"{RUN} --seed {2**31}": f"seed is {2**31}",
    f"{RUN} --seed {2**63}": f"seed is {2**63}",
    f"{RUN} --config config/none.yaml": "config/none.yaml",
    f"{RUN} gravity": "'gravity' is no value; write PATH=VALUE",
    f"{RUN} gravty=1": "the nearest is gravity",
    f"{RUN} shape=d1": "write --shape d1",
    f"{RUN} --shape C1": "the nearest is c1",
    f"{RUN} box_width=8mm": "it must be a number, in m",
    f"{RUN} gravity=1,2,3": "it must be a number, in m s-2",
    f"{RUN} cylinder.speed=1": "cylinder.speed is no value that can vary; the nearest is cylinder.",
    f"{RUN} record.window=[1,2]": "record.window is no value that can vary",
    f"{RUN} -o OUT.txt": "it must be the path of a file that ends in .nc",
    f"{COMBINE} --block drg": "block is 'drg'; the sweep has no such block; the nearest is drag",
    f"{COMBINE} --observable zz": "observable is 'zz'",
    "figure figure13 pyproject.toml": "pyproject.toml",
    "figure 13 config/smoke.yaml -o OUT": "there are figure07, figure08",
    "figure figure07 docs/data/flow.nc -o OUT": "it holds no drag, and figure07 is drawn from that",
    "figure figure09 docs/data/drag.nc -o OUT": "figure09 is drawn from that; name snapshots.nc.",
    "figure figure07 docs/data/drag.nc --of drag -o OUT": "only the figure sweep shows another",
    "figure all docs/data/flow.nc -o OUT": "it holds nothing that a figure shows; name drag.nc.",
    "figure sweep studies/onset/onset.nc --of drag -o OUT": "it has no drag; it has onset_fraction",
    "draw docs/data/drag.nc -o OUT.avi": "ends in .mp4 or .gif or .png or .svg or .pdf or .pvd",
    "draw docs/data/drag.nc point=0 -o OUT.png": "no value named point; they differ in case",
    "info config/smoke.yaml": "it is not a readable netCDF file",
    "sweep config/smok.yaml": "cannot read it ([Errno 2] No such file or directory: 'config/smok.",
    "report studies/shear/shear.nc -o OUT.html": "there are no figures; draw them first",
}


@pytest.mark.parametrize("command", REFUSED)
def test_a_value_that_no_verb_can_use_is_refused(tmp_path, monkeypatch, command):
    """Status 2, the value is named, and nothing is written."""
    monkeypatch.chdir(ROOT)
    words = command.replace("OUT", str(tmp_path / "out.nc")).split()
    if any(word.startswith("studies/") and not Path(word).exists() for word in words):
        pytest.skip("needs a study that is removed")
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 2, (result.output, result.exception)
    assert REFUSED[command] in result.stderr and not list(tmp_path.iterdir())
    lines = [line for line in result.stderr.splitlines() if not re.match(r"\d{4}-\d\d-\d\d ", line)]
    assert len(lines) == 1  # after what a slow computer says of its progress


@pytest.mark.parametrize(
    ("value", "text", "same"),
    [
        (1.5581123456, "1.55811", True),
        (1.5581123456, "1.5581", True),
        (1.5581123456, "1.558112", True),
        (1.5581123456, "1.558", False),
        (2.3, "2", False),
        (0.3, "0.30", True),
        (0.3, "3e-1", True),
        (5e6, "5e6", True),
        (1_000_001, "1e6", False),
        (400, "400", True),
        (0.3, "much", False),
        (7.66e10, "7.66e+10", True),
        (-0.5, "0.5", False),
    ],
)
def test_a_run_is_found_by_a_value_as_it_was_printed(value, text, same):
    """Tables print five digits, a dry run six, files all; fewer are another value."""
    assert is_written(value, text) == same


def test_the_version_is_said():
    """It is that of the package, and it has the revision of a checkout."""
    result = CliRunner().invoke(app, ["--version"])
    assert result.exit_code == 0
    assert result.stdout.startswith(
        f"granular-drag {importlib.metadata.version('granular-drag')}, "
    )


@pytest.mark.parametrize("displacement", [np.nan, np.inf, -1.0, -1e-9, 1e9, 6.1e-3])
def test_a_picture_is_of_the_stroke(tmp_path, displacement):
    motion = SimpleNamespace(displacement=np.linspace(0.0, 6e-3, 5))
    with pytest.raises(InputError, match=r"displacement is .* between 0 and the stroke, 0.006 m"):
        film.picture(motion, tmp_path / "bed.png", displacement, "layer", False)
    assert not list(tmp_path.iterdir())


def test_a_log_has_a_line_of_progress_now_and_then(capsys, monkeypatch):
    monkeypatch.setattr("dem.io.progress.EVERY", 0.0)
    with bar("runs", 4.0) as update:
        update(1)
        update(2, "runs, 1 failed")
    assert capsys.readouterr() == ("", "runs: 25% done\nruns, 1 failed: 50% done\n")


def test_a_sweep_ends_with_the_file_of_its_runs_and_what_to_do_next(tmp_path, monkeypatch):
    """A sweep with nothing to make says so; what was asked for is on stdout, and nothing was."""
    (tmp_path / "results/store").mkdir(parents=True)  # a new one is said

    def make(work, jobs, progress):
        work.begin("drag")
        for run in work.block("drag").points:
            work.store.keep(run, {"failure": 0})

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("dem.sweep.state.SweepState.make", make)
    commands = r"dem info results/smoke/drag.nc or dem figure all results/smoke/drag.nc\n"
    for words in (
        r"results/smoke holds 10 runs, 10 of them new\. ",
        r"results/smoke holds 10 runs, 0 of them new\. ",
    ):
        result = CliRunner().invoke(app, ["sweep", str(ROOT / "config/smoke.yaml")])
        assert result.exit_code == 0 and result.stdout == ""
        assert re.fullmatch(f"{words}Next: {commands}", result.stderr), result.stderr


def test_the_console_script_is_the_application():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    module, _, name = project["scripts"]["dem"].partition(":")
    assert getattr(import_module(module), name) is app


@pytest.mark.parametrize(
    "command",
    ["dem sweep config/paper.yaml -n", pytest.param("snakemake -n -d {}", marks=posix)],
)
def test_a_plan_waits_for_neither_kernels_nor_datasets(tmp_path, command):
    words = [sys.executable, "-X", "importtime", "-m", *command.format(tmp_path).split()]
    process = subprocess.run(words, cwd=ROOT, text=True, capture_output=True)
    assert process.returncode == 0, process.stderr[-1000:]
    loaded = {line.rpartition("|")[2].strip() for line in process.stderr.splitlines()}
    assert "dem.sweep.state" in loaded and not loaded & {"numba", "xarray", "pandas", "scipy"}
