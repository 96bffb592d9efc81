"""The command line's promises: exit status, one sentence, nothing written."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
RUN = (
    "simulate",
    "--config",
    "config/smoke.yaml",
    "--shape",
    "c1",
    "--density",
    "3900",
    "--seed",
    "1",
)


def dem(*arguments):
    command = [sys.executable, "-m", "dem.cli", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, text=True, capture_output=True)


@pytest.mark.parametrize(
    "verb",
    [
        "compile",
        "pack",
        "simulate",
        "combine",
        "benchmark",
        "figure",
        "info",
        "calibrate",
        "accuracy",
    ],
)
def test_every_verb_has_help(verb):
    """--help explains each verb."""
    run = dem(verb, "--help")
    assert run.returncode == 0 and "--help" in run.stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--shape", "x9"), "shape is 'x9'"),
        (("--density", "-1"), "density is -1.0"),
        (("--seed", "-4"), "seed is -4"),
        (("--config", "config/none.yaml"), "config/none.yaml"),
        (("--bed", "README.md"), "README.md"),
    ],
)
def test_bad_input_is_one_sentence_and_status_2(tmp_path, arguments, sentence):
    """A wrong value is named, the exit status is 2 and no file appears."""
    output = tmp_path / "run.nc"
    run = dem(*RUN, *arguments, "-o", output)
    assert run.returncode == 2, run.stderr
    assert sentence in run.stderr and "Traceback" not in run.stderr
    assert len(run.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_failed_run_says_what_where_and_when(tmp_path):
    """A run that overlaps too much stops with status 1, naming granule, step and time."""
    text = (ROOT / "config/smoke.yaml").read_text() + "\nnumerics: {max_overlap: 0.08}\n"
    config = tmp_path / "tight.yaml"
    config.write_text(text)
    output = tmp_path / "run.nc"
    run = dem(*RUN, "--config", config, "-o", output)
    assert run.returncode == 1, run.stderr
    for word in ("OverlapError", "granule", "step", "time", "0.08"):
        assert word in run.stderr
    assert not output.exists() and not list(tmp_path.glob(".*"))


def test_a_foreign_file_is_refused():
    """A file that is not netCDF is named, not read."""
    for verb in (("info",), ("figure", "figure13")):
        run = dem(*verb, "pyproject.toml")
        assert run.returncode == 2 and "pyproject.toml" in run.stderr
        assert "Traceback" not in run.stderr
