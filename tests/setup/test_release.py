"""A release: its number, and its wheel where there is no clone."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import netCDF4
import pytest
import yaml
from project import ROOT

import dem

SWEEP = """
extends: config/paper.yaml
results: results/mine
box_width: 8.0e-3
cylinder: {diameter: 1.5e-3, stroke: 1.2e-3}
shapes: {c1: {granules: 60}}
record: {bins: 120, window: [0.4e-3, 1.0e-3]}
sweep: {shape: c1, density: 3900, seed: 1}
"""


def test_version_citation_and_changelog_name_one_release():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    heading = re.search("^## (.*)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)[1]
    number, _, unreleased = dem.__version__.partition(".dev")
    assert heading == f"{number} ({'unreleased' if unreleased else citation['date-released']})"
    assert unreleased or citation["version"] == number


def run(folder, *words):
    bare = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    process = subprocess.run(words, cwd=folder, env=bare, capture_output=True, text=True)
    assert process.returncode == 0, process.stdout + process.stderr
    return process.stdout


@pytest.fixture
def programs(tmp_path):
    """Where the programs are of an environment that has the wheel and the packages of this one, but no clone."""
    sources, environment = tmp_path / "sources", tmp_path / "environment"
    for name in ("dem", "config"):  # without build/, whose old files the wheel would take
        shutil.copytree(ROOT / name, sources / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, sources)
    venv.create(environment)
    places = sysconfig.get_paths("venv", vars={"base": environment, "platbase": environment})
    Path(places["purelib"], "others.pth").write_text(sysconfig.get_path("purelib"))
    pip, programs = [sys.executable, "-m", "pip"], Path(places["scripts"])
    offline = "--quiet", "--no-deps", "--no-index"
    run(tmp_path, *pip, "wheel", *offline, "--no-build-isolation", "-w", "dist", sources)
    (wheel,) = tmp_path.glob("dist/*.whl")
    run(tmp_path, *pip, "--python", programs / "python", "install", *offline, wheel)
    shutil.rmtree(sources)
    return programs


def test_a_wheel_works_without_the_clone(programs, tmp_path):
    """The library, a sweep that extends that of the paper, and its figures. Results name the release."""
    assert run(tmp_path, programs / "python", "-c", "import dem; print(dem.__file__)").startswith(
        str(tmp_path / "environment")
    )
    (tmp_path / "mine.yaml").write_text(SWEEP)
    run(tmp_path, programs / "dem", "sweep", "mine.yaml", "-j1")
    run(tmp_path, programs / "dem", "figure", "all", "results/mine/drag.nc")
    assert (tmp_path / "results/mine/figures/sweep.svg").stat().st_size
    with netCDF4.Dataset(tmp_path / "results/mine/drag.nc") as file:
        assert file.git_revision == f"v{dem.__version__}"
