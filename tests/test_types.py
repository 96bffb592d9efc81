"""Annotations of the public modules hold, and an editor tells a user the right types."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytest.importorskip("mypy")
ROOT = Path(__file__).parent.parent
# of --strict, what the modules do without; a script asks for it in its first line
LOOSE = [
    "--allow-untyped-calls",
    "--allow-untyped-defs",
    "--no-warn-return-any",
    "--allow-any-generics",
]
STRICT = "# mypy: disallow-untyped-calls, disallow-untyped-defs, warn-return-any, disallow-any-generics\n"

USER = """
from typing import assert_type

import numpy as np
import xarray as xr

import dem

cylinder = dem.Cylinder(2e-3, (5e-3, 4e-3), velocity=(0.0, 1.0))
shape = dem.Ellipse.of_size([1e-3, 2e-3], 1.5, contact="geometric_potential")
assert_type(shape, dem.Ellipse)
assert_type(dem.Ellipse([2e-3], [1e-3], hertz_radius="local").area, np.ndarray)
assert_type(dem.Disc(np.ones(2)).scaled(2.0), dem.Disc)
bed = dem.pack(shape, 1e-2, 1e-2, cylinder, seed=1)
assert_type(bed, dem.Bed)
scene = dem.Scene(shape, friction=dem.Friction(), walls=bed.walls, solids=cylinder)
assert_type(scene.thickness, float)
state = dem.State([[0.0, 0.0], [1.0, 0.0]], angle=[0, 1])
assert_type(state.velocity, np.ndarray)
result = dem.simulate(scene, bed.state, 1e-3, frames=10, step_fraction=0.4, threads=2)
assert_type(result.state, dem.State)
assert_type(result.to_dataset(), xr.Dataset)
run = dem.Simulation(scene, state, ledger=True)
assert_type(run.advance(1e-6), float)
error: type[ValueError] = dem.InputError
"""

WRONG = {
    "a word": 'import dem\ndem.Ellipse([1.0], [1.0], contact="chord")\n',
    "an option": "import dem\ndem.simulate(dem.Scene(None), dem.State([]), 1.0, step=1e-9)\n",
    "a scene": "import dem\ndem.Simulation(1.0, dem.State([]))\n",
    "a name": "import dem\ndem.Disk\n",
}


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What mypy says of the public modules and of a user's scripts, which it reads in one process.

    --strict is for the scripts. The modules are as strict as pyproject.toml asks, or more.
    """
    folder = tmp_path_factory.mktemp("user")
    scripts = {"user": USER} | WRONG
    for name, text in scripts.items():
        (folder / f"{name.replace(' ', '_')}.py").write_text(f"{STRICT}{text}")
    environment = os.environ | {"MYPYPATH": str(ROOT)}
    command = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", "--strict", *LOOSE]
    modules = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["mypy"]["files"]
    found = subprocess.run(
        [*command, *modules, *folder.iterdir()],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert f"{len(modules) + len(scripts)} source files" in found.stdout, (
        found.stdout + found.stderr
    )
    return found.stdout


def test_public_modules_are_typed(told):
    """Without an error, at the strictness that pyproject.toml asks for."""
    wrong = [line for line in told.splitlines() if line.startswith("dem/")]
    assert not wrong, wrong


def test_a_user_is_told_the_right_types(told):
    """Also under --strict, and what cannot be right is told."""
    assert "user.py:" not in told, told
    assert all(f"{name.replace(' ', '_')}.py:3: error" in told for name in WRONG), told
