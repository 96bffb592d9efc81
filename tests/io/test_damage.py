"""Files whose content is damaged, foreign or hostile: noticed, refused with their name, never obeyed."""

import contextlib
import json
import re
import shutil
import warnings
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from command_line import called
from sweeps import FOREIGN, foreign, smoke

from dem.base.errors import InputError
from dem.experiment.kinds import EXPERIMENTS
from dem.io.dataset import LABELS, read, write
from dem.report.build import build
from dem.sweep.state import SweepState
from dem.sweep.workers import Workers

FILES = "runs.nc", "drag.nc", "snapshots.nc"
HOSTILE = "</script><script>alert(1)</script>"
TITLE = "a [red]title[/red] [/nothing]\x1b[2J"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with the batch of two runs, and their drag.nc and snapshots.nc."""
    folder = tmp_path_factory.mktemp("made")
    with contextlib.chdir(folder):
        state = SweepState(smoke(sweep={"case": ["c1"], "seed": [1, 2]}, results="results"))
        state.make(Workers())
        shutil.copy(state.files("drag")[0], "results/runs.nc")
    return folder / "results"


@pytest.fixture(scope="module")
def hostile(results, tmp_path_factory):
    """The same files with another title and name of the case, which no configuration may have."""
    folder = tmp_path_factory.mktemp("hostile")
    for name in ("drag.nc", "snapshots.nc"):
        with xr.open_dataset(results / name) as dataset:
            changed = dataset.load().drop_encoding().assign_coords(case=[HOSTILE])
        changed.attrs["title"] = TITLE
        changed.to_netcdf(folder / name)
    shutil.copy(results / "runs.nc", folder)
    with netCDF4.Dataset(folder / "runs.nc", "a") as file:
        file.title = TITLE
    return folder


def test_other_programs_notice_damage_to_arrays(results):
    """By netCDF's own checksums, whoever reads them."""
    for name in FILES:
        with netCDF4.Dataset(results / name) as file:
            for variable in file.variables.values():
                if variable.dtype is not str and "S" not in str(variable.dtype) and variable.ndim:
                    unguarded = (
                        variable.name in (*EXPERIMENTS["drag"]["AXIS"], *LABELS)
                        and name != "runs.nc"
                    )
                    assert variable.filters()["fletcher32"] or unguarded, variable.name


def test_values_of_a_batch_are_read_as_they_were_written_or_not_at_all(tmp_path):
    """With one bit changed where HDF5 has no checksum: texts, and the trees that say where arrays are, so that
    one is taken for another."""
    path = tmp_path / "runs.nc"
    layout = {name: (("run",), "N", name) for name in ("x", "y", "run_id")}
    values = {"x": np.arange(9.0), "y": np.arange(9.0) ** 2, "run_id": np.full(9, "8c12f6d2")}
    write(path, values, {}, layout)
    content, answers = path.read_bytes(), set()
    places = [match.start() for match in re.finditer(b"TREE|8c12f6d2", content)]
    for at in {at for place in places for at in range(place, min(place + 64, len(content)))}:
        changed = bytearray(content)
        changed[at] ^= 1 << at % 8
        path.write_bytes(changed)
        with contextlib.suppress(InputError):
            answers.add(str(read(path, tuple(values))[0]))
    assert len(places) > 9 and answers == {str(values)}


def outcome(line):
    """Exit status and output of a command; a traceback fails the test."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", RuntimeWarning)
        result = called(line)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert not [w for w in warned if issubclass(w.category, RuntimeWarning)], result.output
    return result.exit_code, result.output


VERBS = {
    "info": "info mine.nc",
    "figure": "figure all mine.nc -o out",
    "beds": "figure figure10 mine.nc -o out",
    "report": "report mine.nc -o out/r.html",
}


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("fault", FOREIGN)
def test_a_foreign_file_is_answered_with_a_sentence(folder, verb, fault):
    """Or with dashes where it has gaps; no traceback, no warning of numpy."""
    name = "snapshots.nc" if verb == "beds" else "drag.nc"
    foreign("mine.nc", FOREIGN[fault], name)
    status, output = outcome(VERBS[verb])
    assert status in (0, 2)
    if status:
        assert output and all(
            "mine.nc" in line or "snapshots.nc" in line for line in output.splitlines()
        )
    else:
        assert "nan" not in output


def test_a_sound_file_is_not_blamed_for_a_figure_that_fails(folder):
    """Of a name that matplotlib takes for a formula, and cannot read as one."""
    foreign("mine.nc", lambda data: data.assign_coords(case=["c1", "$x_{$", "e"]))
    status, output = outcome("figure sweep mine.nc -o out")
    assert status == 2 and "mine.nc: sweep cannot be drawn: " in output
    assert "damaged" not in output and not list(folder.rglob("out/*"))


@pytest.mark.parametrize("dims", [(), ("displacement", "seed", "case")])
def test_a_drag_over_other_dimensions_is_refused(folder, dims):
    def change(data):
        drag = data["drag"] if dims else data["drag"][0, 0, 0].reset_coords(drop=True)
        return data.assign(drag=drag.transpose(*dims))

    foreign("mine.nc", change)
    for verb in ("info", "figure"):
        status, output = outcome(VERBS[verb])
        assert status == 2 and "its drag is not over case, seed, displacement" in output


EVIL = """\
from pathlib import Path
Path(__file__).with_name("ran").touch()
VARIABLES = {"evil": ((), None, None)}
class Stone:
    def of_size(diameter, aspect_ratio): ...
def run(replicate): ...
def look(simulation): ...
"""
NAMED = {
    "shape": {"kind": "evil.Stone"},
    "law": {"contact": {"law": "evil.Stone"}},
    "experiment": {"experiment": "evil.py"},
    "observable": {"observables": ["drag", "snapshots", "evil.py"]},
}
DRAW = "draw runs.nc seed=1 --forces -o run.png"
READERS = (
    "store",
    "info runs.nc",
    "info drag.nc",
    "means drag.nc",
    "figure all drag.nc",
    "figure figure10 snapshots.nc",
    "report drag.nc -o page.html",
    DRAW,
    DRAW.replace("png", "gif"),
    DRAW.replace("png", "pvd"),
)


@pytest.mark.parametrize("what", NAMED)
def test_no_reader_runs_code_that_a_file_of_results_names(results, tmp_path, monkeypatch, what):
    """Only --shapes FOLDER lets code run, of that folder, and a sentence says so."""
    monkeypatch.chdir(shutil.copytree(results, tmp_path / "given"))
    (tmp_path / "given/evil.py").write_text(EVIL)

    def named(values):
        change = {"beside": str(tmp_path / "given"), **NAMED[what]}
        kind, observables = change.pop("kind", None), change.pop("observables", None)
        for shape in values["shapes"].values() if kind else ():
            shape |= {"kind": kind, "aspect_ratio": 1.0}
        if observables:
            values["record"]["observables"] = observables
        return values | change

    for name in FILES:
        with netCDF4.Dataset(name, "a") as file:
            if name == "runs.nc":
                file.setncattr("values", json.dumps([*map(named, json.loads(file.values))]))
            else:
                file.configuration = json.dumps(named(json.loads(file.configuration)))
    for line in READERS:
        status, output = outcome(line)
        assert status in (0, 2) and not Path("ran").exists(), (line, output)
    if what in ("shape", "law"):
        status, output = outcome(DRAW)
        assert status == 2 and "--shapes FOLDER" in output and not Path("run.png").exists()
        outcome(f"{DRAW} --shapes .")
        assert Path("ran").exists()


def test_text_of_a_file_is_no_script_in_the_report(hostile, tmp_path):
    """A case of any name is shown by its name."""
    from PIL import Image

    shutil.copy(hostile / "drag.nc", tmp_path)
    (tmp_path / "figures").mkdir()
    Image.new("RGB", (4, 4)).save(tmp_path / "figures/figure13.png")
    build(tmp_path / "drag.nc", tmp_path / "r.html")
    page = (tmp_path / "r.html").read_text()
    assert HOSTILE not in page and "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page


@pytest.mark.parametrize("name", FILES)
def test_text_of_a_file_is_neither_markup_nor_a_command_to_the_terminal(hostile, name):
    status, output = outcome(f"info {hostile / name}")
    assert status == 0 and r"[red]title[/red] [/nothing]\x1b[2J" in output
