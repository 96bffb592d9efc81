"""The command line's promises: exit status, one sentence, nothing written."""

import importlib.metadata
import os
import re
import shlex
import subprocess
import sys
import tomllib
from functools import partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer
from typer.main import get_command
from typer.testing import CliRunner

from conftest import posix
from dem.base.errors import InputError, RunError
from dem.cli.app import app
from dem.cli.terminal import reported
from dem.figures import film
from dem.io.progress import bar
from dem.sweep.axis import is_written

ROOT = Path(__file__).parent.parent
RUN = shlex.split("simulate --config config/smoke.yaml --shape c1 --density 3900 --seed 1")


def dem(*arguments):
    command = [sys.executable, "-m", "dem", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, text=True, capture_output=True)


def verbs(command, words=()):
    """The words of every verb of the command line, those of groups too."""
    if not hasattr(command, "commands"):
        return [words]
    return [verb for name, sub in command.commands.items() for verb in verbs(sub, (*words, name))]


VERBS = verbs(get_command(app))


@pytest.mark.parametrize("verb", VERBS, ids=" ".join)
def test_every_verb_has_help(verb):
    """--help says what each verb does, and what each of its options is for."""
    result = CliRunner().invoke(app, [*verb, "--help"], env={"COLUMNS": "200", "TERM": "dumb"})
    assert result.exit_code == 0, result.output
    command = get_command(app)
    for word in verb:
        command = command.commands[word]
    assert command.help.split()[0] in result.output
    assert all(option.help for option in command.params)


def test_a_person_has_at_most_ten_verbs_to_learn():
    assert len(VERBS) <= 10


def test_a_failed_run_says_what_where_and_when(tmp_path):
    """A run that overlaps too much stops with status 1, naming granule, step and time."""
    text = (ROOT / "config/smoke.yaml").read_text() + "\nnumerics: {max_overlap: 0.08}\n"
    config = tmp_path / "tight.yaml"
    config.write_text(text)
    output = tmp_path / "run.nc"
    run = dem(*RUN, "--config", config, "-o", output)
    assert run.returncode == 1, run.stderr
    assert re.search("^granule .* overlaps by .* step .* time .* 0.08", run.stderr, re.M)
    assert "Error" not in run.stderr
    assert not output.exists() and not list(tmp_path.glob(".*"))


COMBINE = ("combine", "--config", "config/smoke.yaml", "-o", "OUT")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((*RUN, "--density", "-1", "-o", "OUT"), "density is -1.0"),
        ((*RUN, "--seed", "-4", "-o", "OUT"), "seed is -4"),
        ((*RUN, "--seed", str(2**31), "-o", "OUT"), f"seed is {2**31}"),
        ((*RUN, "--seed", str(2**63), "-o", "OUT"), f"seed is {2**63}"),
        ((*RUN, "--config", "config/none.yaml", "-o", "OUT"), "config/none.yaml"),
        ((*RUN, "gravity=x", "-o", "OUT"), "gravity"),
        ((*RUN, "gravity", "-o", "OUT"), "'gravity' is no value; write PATH=VALUE"),
        ((*RUN, "gravty=1", "-o", "OUT"), "the nearest is gravity"),
        ((*RUN, "shape=d1", "-o", "OUT"), "write --shape d1"),
        ((*RUN, "--shape", "C1", "-o", "OUT"), "the nearest is c1"),
        ((*RUN, "box_width=8mm", "-o", "OUT"), "it must be a number, in m"),
        ((*RUN, "gravity=1,2,3", "-o", "OUT"), "it must be a number, in m s-2"),
        (
            (*RUN, "cylinder.speed=1", "-o", "OUT"),
            "cylinder.speed is no value that can vary; the nearest is cylinder.",
        ),
        ((*RUN, "record.window=[1,2]", "-o", "OUT"), "record.window is no value that can vary"),
        ((*RUN, "-o", "OUT.txt"), "it must be the path of a file that ends in .nc"),
        (("figure", "figure13", "pyproject.toml"), "pyproject.toml"),
        ((*COMBINE, "--block", "zz"), "block is 'zz'"),
        ((*COMBINE, "--block", "drg"), "the nearest is drag"),
        ((*COMBINE, "--observable", "zz"), "observable is 'zz'"),
        (("figure", "13", "config/smoke.yaml", "-o", "OUT"), "there are figure07, figure08"),
        (
            ("draw", "docs/data/drag.nc", "-o", "OUT.avi"),
            "it must be the path of a file that ends in .mp4 or .gif or .png or .svg or .pdf or .pvd",
        ),
        (
            ("figure", "figure07", "docs/data/flow.nc", "-o", "OUT"),
            "docs/data/flow.nc: it holds no drag, and figure07 is drawn from that; name drag.nc.",
        ),
        (
            ("figure", "figure09", "docs/data/drag.nc", "-o", "OUT"),
            "it holds no granule_x, and figure09 is drawn from that; name snapshots.nc.",
        ),
        (
            ("draw", "docs/data/drag.nc", "point=0", "-o", "OUT.png"),
            "its runs have no value named point; they differ in case",
        ),
        (("info", "config/smoke.yaml"), "it is not a readable netCDF file"),
        (
            ("sweep", "config/smok.yaml"),
            "cannot read it ([Errno 2] No such file or directory: 'config/smok.yaml')",
        ),
        (
            ("figure", "sweep", "studies/onset/onset.nc", "--of", "drag", "-o", "OUT"),
            "it has no drag; it has onset_fraction",
        ),
        (
            ("figure", "figure07", "docs/data/drag.nc", "--of", "drag", "-o", "OUT"),
            "of is 'drag'; only the figure sweep shows another",
        ),
        (
            ("figure", "all", "docs/data/flow.nc", "-o", "OUT"),
            "it holds nothing that a figure shows; name drag.nc.",
        ),
        (
            ("report", "studies/shear/shear.nc", "-o", "OUT.html"),
            "there are no figures; draw them first",
        ),
    ],
)
def test_a_value_that_no_verb_can_use_is_refused(tmp_path, monkeypatch, arguments, sentence):
    """Status 2, the value is named, and nothing is written."""
    monkeypatch.chdir(ROOT)
    if any(word.startswith("studies/") and not Path(word).exists() for word in arguments):
        pytest.skip("needs a study that is removed")
    words = [word.replace("OUT", str(tmp_path / "out.nc")) for word in arguments]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 2, (result.output, result.exception)
    assert sentence in result.stderr and not list(tmp_path.iterdir())
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


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (RunError("the bed cannot be made."), "the bed cannot be made."),
        (
            FileNotFoundError(2, "No such file or directory", "bed.nc"),
            "[Errno 2] No such file or directory: 'bed.nc'",
        ),
    ],
)
def test_a_failure_is_a_sentence_without_the_name_of_its_class(capsys, error, sentence):
    with pytest.raises(typer.Exit) as end, reported():
        raise error
    assert end.value.exit_code == 1 and capsys.readouterr().err == f"{sentence}\n"


BESIDE_A_BAR = """
import time
from dem.base.messages import say
from dem.io.progress import bar
with bar("packing c1"):
    time.sleep(0.5)
    say("compiling")
    print("result")
"""


def read_some(terminal):
    """Bytes of a terminal; none at its end, which Linux reports as an error."""
    try:
        return os.read(terminal, 1000)
    except OSError:
        return b""


@pytest.mark.skipif(os.name != "posix", reason="a terminal of its own is POSIX")
def test_a_bar_leaves_results_on_stdout_and_other_lines_whole():
    """Of a terminal that shows stderr, while stdout is a pipe."""
    try:
        parent, child = os.openpty()
    except OSError as error:
        pytest.skip(f"no terminals here: {error}")
    run = subprocess.run(
        [sys.executable, "-c", BESIDE_A_BAR],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=child,
        env=os.environ | {"TERM": "xterm"},
        text=True,
    )
    os.close(child)
    text = b"".join(iter(partial(read_some, parent), b"")).decode()
    os.close(parent)
    assert run.stdout == "result\n"
    assert "\x1b[2Kcompiling\r\n" in text  # on a line that was cleared
    assert "packing c1" in text


def test_the_console_script_is_the_application():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    module, _, name = project["scripts"]["dem"].partition(":")
    assert getattr(import_module(module), name) is app


def test_letters_that_a_terminal_lacks_are_replaced():
    run = subprocess.run(
        [sys.executable, "-m", "dem", "info", "docs/data/drag.nc"],
        cwd=ROOT,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
    )
    assert run.returncode == 0 and b"c1" in run.stdout and run.stdout.isascii(), run.stderr


@posix
def test_a_reader_that_has_seen_enough_gets_no_traceback():
    """dem info drag.nc | head -1"""
    dem = [sys.executable, "-m", "dem"]
    read, write = os.pipe()
    os.close(read)
    command = [*dem, "info", "docs/data/drag.nc"]
    process = subprocess.run(command, cwd=ROOT, stdout=write, stderr=subprocess.PIPE)
    os.close(write)
    assert (process.returncode, process.stderr) == (1, b"")


def test_a_dry_run_only_reads(tmp_path, monkeypatch):
    """Also in a folder that cannot be written."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("os.access", lambda _, mode: mode == os.R_OK)
    result = CliRunner().invoke(app, ["sweep", str(ROOT / "config/smoke.yaml"), "--dry-run"])
    assert result.exit_code == 0 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["dem sweep config/paper.yaml -n", "snakemake -n -d {}"])
def test_a_plan_waits_for_neither_kernels_nor_datasets(tmp_path, command):
    words = [sys.executable, "-X", "importtime", "-m", *command.format(tmp_path).split()]
    process = subprocess.run(words, cwd=ROOT, text=True, capture_output=True)
    assert process.returncode == 0, process.stderr[-1000:]
    loaded = {line.rpartition("|")[2].strip() for line in process.stderr.splitlines()}
    assert "dem.sweep.state" in loaded and not loaded & {"numba", "xarray", "pandas", "scipy"}
