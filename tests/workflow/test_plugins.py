"""Shapes, observables and experiments in files of a user: swept, cached, and run only to make runs.

The recipes of docs/howto/shape.md and docs/howto/experiment.md, followed to the letter.
"""

import re
import shutil

import numpy as np
import pytest
import xarray as xr
from pictures import assert_not_blank
from project import FILES, PAGE, SHAPE, SHORT_LINE, posix, write
from refusals.user_files import TELLING
from sweeps import contents, differing
from workflows import completed, run

from dem.base.source_hash import ROOT
from dem.figures.catalogue import draw
from dem.report.build import build

(SWEEP,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)
SWEEP = SWEEP.replace("seed: 1 to 5", "seed: [1, 2]") + "batch: 1\n"  # fewer runs, in two processes
SWEEP += "record: {observables: [drag, snapshots, rotation.py]}\n"


# A shape, an observable and a sweep of them.
MINE = {"pebbles": SHAPE, "rotation": FILES["rotation.py"], "sweep": SWEEP}


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A folder where the sweep of the page was made, in one process: two would both compile."""
    folder = tmp_path_factory.mktemp("swept")
    write(folder / "mine", **MINE)
    run("-m", "dem", "sweep", "mine/sweep.yaml", "-j1", cwd=folder)
    return folder


ASK = """
import sys
from numba.core.event import install_recorder
import dem

values = next(dem.load_sweep(sys.argv[1]))
with install_recorder("numba:compile") as recorder:
    found = dem.run_experiment(values)
print(len(recorder.buffer), float(found["drag"].mean()))
"""


def test_a_shape_in_a_file_of_ones_own_is_swept_and_compiled_once(swept, tmp_path):
    """Beds, runs, how they move and are drawn: all is there, and nothing was written beside the sweep file. The next process
    compiles nothing, nor where the class was imported by the user, nor in another folder."""
    for name in ("drag.nc", "rotation.nc"):
        assert (swept / "results/pebbles" / name).is_file()
    assert len(list((swept / "mine").iterdir())) == 3
    picture = "draw", "results/pebbles/drag.nc", "seed=1", "-o", "true.png", "--shapes", "mine"
    run("-m", "dem", *picture, cwd=swept)
    assert_not_blank(swept / "true.png")
    write(tmp_path / "copy", **MINE)
    imported = f"from pebbles import Pebble\n{ASK}"
    (answer,) = {
        run("-c", ASK, "mine/sweep.yaml", cwd=swept),
        run("-c", imported, "mine/sweep.yaml", cwd=swept, path=[swept / "mine"]),
        run("-c", ASK, "copy/sweep.yaml", cwd=tmp_path),
    }
    assert answer.startswith("0 ")


def test_an_experiment_in_a_file_of_ones_own_is_swept(tmp_path):
    """As the page has it; it is known by its code and not by its folder, and read by all but who makes runs."""
    folder = tmp_path / "mine"
    write(folder, rest=FILES["rest.py"], sweep=FILES["rest.yaml"])
    run("-m", "dem", "sweep", "mine/sweep.yaml", cwd=tmp_path)
    data = tmp_path / "results/rest/rest.nc"
    dataset = xr.load_dataset(data)
    sizes = {"shape": 2, "rest_margin": 2, "seed": 2, "layer": 3}
    assert dataset["rest_granules"].sizes == sizes
    assert (dataset["rest_granules"].sum("layer") == dataset["granules"]).all()
    assert dataset["layer"].values == pytest.approx([1 / 6, 1 / 2, 5 / 6])
    # at rest each contact between granules is one of the list, and walls have the others
    listed = dataset["rest_force"].count("contact")
    most = 0.5 * dataset["rest_contacts"] * dataset["granules"]
    assert (listed.sel(rest_margin=0.0) >= most).all()
    draw("sweep", data, data.parent / "figures", of="rest_force")
    build(data, tmp_path / "page.html")
    assert "rest_granules" in (tmp_path / "page.html").read_text()
    folder = folder.rename(tmp_path / "moved")
    dry = "-m", "dem", "sweep", "moved/sweep.yaml", "-n"
    assert "8 finished" in run(*dry, cwd=tmp_path)
    edited = FILES["rest.py"].replace("bed.pressure", "2.0 * bed.pressure")
    (folder / "rest.py").write_text(TELLING + edited)
    assert "0 finished" in run(*dry, cwd=tmp_path)
    run("-m", "dem", "info", data, cwd=tmp_path)
    assert not (folder / "ran").exists()


@posix
def test_a_shape_in_a_file_of_ones_own_is_swept_by_the_workflow(swept, copy, tmp_path):
    """The runs are those of `dem sweep`, and so are their combined files."""
    shutil.copytree(copy, tmp_path, dirs_exist_ok=True)
    write(tmp_path / "mine", **MINE)
    targets = "all", "results/pebbles/rotation.nc"
    completed(tmp_path, *targets, "-c2", configfile="mine/sweep.yaml")
    for name in ("drag.nc", "rotation.nc"):
        files = (folder / "results/pebbles" / name for folder in (swept, tmp_path))
        assert differing(*map(contents, files)) == []
    shutil.move(tmp_path / "mine", tmp_path / "elsewhere")
    rerun = completed(tmp_path, *targets, "-n", configfile="elsewhere/sweep.yaml")
    assert "Nothing to be done" in rerun


PACKAGED = """
import dem, pathlib
file = pathlib.Path(dem.__file__)
values = next(dem.load_sweep("packaged.yaml"))
from dem.shapes.pebbles import Pebble
print(file, Pebble.of_size([1e-3], 1.0).area[0], values["shapes"]["pebble"]["kind"])
file.with_name("scene.py").write_text("EDITED = True")
for call in dem.load_sweep, dem.run_sweep:
    try:
        list(call("packaged.yaml"))
    except dem.InputError as error:
        print(error)
"""


def test_a_shape_in_the_package_is_one_file_and_an_edited_package_is_one_sentence(tmp_path):
    """No other file is touched; the old code of an edited one would go on in this process."""
    for room in ("dem", "config"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / room, tmp_path / room, ignore=ignored)
    last = SHAPE.rindex("import smooth\n") + len("import smooth\n")
    (tmp_path / "dem/shapes/pebbles.py").write_text(f"{SHAPE[:last]}\n{SHORT_LINE}{SHAPE[last:]}")
    (tmp_path / "packaged.yaml").write_text(
        SWEEP.replace("pebbles.Pebble", "pebbles").replace(", rotation.py", "")
    )
    answer, *refusals = run("-c", PACKAGED, cwd=tmp_path, path=[tmp_path]).splitlines()
    file, area, kind = answer.split()
    assert (file, kind) == (str(tmp_path / "dem/__init__.py"), "pebbles")
    assert float(area) == pytest.approx(0.25e-6 * np.pi)
    words = "has changed since this process read it; start Python, or the workers, again."
    assert refusals == 2 * [f"{tmp_path / 'dem/scene.py'} {words}"]
    assert not (tmp_path / "results").exists()
