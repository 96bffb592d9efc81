"""Annotations of the public modules hold, and an editor tells a user the right types."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy")
ROOT = Path(__file__).parent.parent

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
scene = dem.Scene(shape, friction=dem.Friction(), walls=bed.walls, cylinder=cylinder)
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


def check(*arguments):
    environment = os.environ | {"MYPYPATH": str(ROOT)}
    command = [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml", *arguments]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)


def test_public_modules_are_typed():
    """Without an error, at the strictness that pyproject.toml asks for."""
    found = check()
    assert found.returncode == 0, found.stdout + found.stderr


def test_a_user_is_told_the_right_types(tmp_path):
    """Also under --strict, and what cannot be right is told."""
    script = tmp_path / "user.py"
    script.write_text(USER)
    wrong = []
    for name, text in WRONG.items():
        wrong.append(tmp_path / f"{name.replace(' ', '_')}.py")
        wrong[-1].write_text(text)
    found = check("--strict", script, *wrong)  # in one process, which reads all libraries once
    assert f"{script.name}:" not in found.stdout, found.stdout + found.stderr
    assert all(f"{each.name}:2: error" in found.stdout for each in wrong), found.stdout
