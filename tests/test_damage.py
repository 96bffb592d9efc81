"""Files whose content is damaged, foreign or hostile: noticed, refused with their name, never obeyed."""

import contextlib
import shutil
import warnings

import netCDF4
import numpy as np
import pytest
import xarray as xr
from test_stopping import combined, planned, smoke
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.cli.app import app
from dem.experiment.observables.drag import VARIABLES as DRAG
from dem.experiment.observables.snapshots import VARIABLES as SNAPSHOTS
from dem.io.dataset import AXES, LABELS, OF_RUN, OF_STORE, OF_SWEEP, read
from dem.io.lazily import open_lazily
from dem.report.build import build
from dem.sweep import batch as making
from dem.sweep.combine import combine_block

HOSTILE = "</script><script>alert(1)</script>"
TITLE = "a [red]title[/red] [/nothing]"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A folder with the batch of two runs, and their drag.nc and snapshots.nc."""
    folder = tmp_path_factory.mktemp("made")
    with contextlib.chdir(folder):
        sweep = smoke(sweep={"case": ["c1"], "seed": [1, 2]}, results="results")
        work, chunk = planned(sweep, folder)
        shutil.copy(making.make(work.store, chunk), folder / "runs.nc")
        combined(work, folder)
        combine_block(work, "drag", "snapshots", folder / "snapshots.nc")
    return folder


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


@pytest.mark.parametrize("name", ["runs.nc", "drag.nc", "snapshots.nc"])
def test_a_file_that_is_cut_off_is_refused(results, tmp_path, name):
    cut = tmp_path / name
    cut.write_bytes((results / name).read_bytes()[:-1000])
    with pytest.raises(InputError, match=f"{cut}: its content cannot be used .* run again"):
        read(cut, ("run_id",))
    with (
        pytest.raises(
            InputError, match=f"{cut}: it is not a readable netCDF.*make it again, or copy it again"
        ),
        open_lazily(cut),
    ):
        pass


def test_other_programs_notice_damage_to_arrays(results):
    """By netCDF's own checksums, whoever reads them."""
    for name in ("runs.nc", "drag.nc", "snapshots.nc"):
        with netCDF4.Dataset(results / name) as file:
            for variable in file.variables.values():
                if variable.dtype is not str and "S" not in str(variable.dtype) and variable.ndim:
                    unguarded = variable.name in (*AXES, *LABELS) and name != "runs.nc"
                    assert variable.filters()["fletcher32"] or unguarded, variable.name


def outcome(*words):
    """Exit status and output of a command; a traceback fails the test."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", RuntimeWarning)
        result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert not [w for w in warned if issubclass(w.category, RuntimeWarning)], result.output
    return result.exit_code, result.output


NUMBERS = "displacement_bounds", "failure"  # without a unit
RISING = "displacement", "displacement_bounds", "seed"
CASE_AND_SEED = "case", "seed"
COMBINED = (
    AXES
    | {name: (("case",), *LABELS[name][1:]) for name in LABELS}
    | {
        name: ((name,), *entry[1:])
        for name, entry in (LABELS | OF_SWEEP).items()
        if name in CASE_AND_SEED
    }
    | {name: ((*CASE_AND_SEED, *dims), *rest) for name, (dims, *rest) in (DRAG | OF_RUN).items()}
    | {name: (CASE_AND_SEED, *OF_STORE[name][1:]) for name in ("run_id",)}
)


def foreign(path, layout, skip=(), text_as_number=False, attrs=(), size=3, fill=0.5, axes=0.5):
    """A file of the user's own making, after a layout, of one value everywhere but on its axes."""
    with netCDF4.Dataset(path, "w") as file:
        file.setncatts(dict(attrs))
        for name, (dims, *_) in layout.items():
            for dim in dims:
                if dim not in file.dimensions:
                    file.createDimension(dim, size)
            if name in skip:
                continue
            text = layout[name][1] is None and name not in NUMBERS and not text_as_number
            variable = file.createVariable(name, str if text else "f8", dims)
            value = "c1" if text else axes if name in RISING else fill
            variable[...] = np.full([size] * len(dims), value, object if text else float)
    return path


BEDS = {name: entry for name, entry in COMBINED.items() if name not in DRAG} | {
    name: ((*CASE_AND_SEED, *dims), *rest) for name, (dims, *rest) in SNAPSHOTS.items()
}
ATTRS = {
    "title": "t",
    "history": "h",
    "git_revision": "g",
    "source_hash": "s",
    "versions": "v",
    "references": "r",
    "configuration": "{}",
    "window_start": 0.0,
    "window_stop": 1.0,
    "cylinder_velocity": 1.0,
}
VERBS = {
    "info": lambda file, out: ("info", file),
    "figure": lambda file, out: ("figure", "all", file, "-o", out),
    "beds": lambda file, out: ("figure", "figure10", file, "-o", out),
    "report": lambda file, out: ("report", file, "-o", out / "r.html"),
}
FOREIGN = {
    "gaps": {"fill": np.nan},
    "gaps on the axes": {"axes": np.nan},
    "zero": {"fill": 0.0},
    "no size": {"size": 0},
    "numbers for texts": {"text_as_number": True},
    "window_start a text": {"attrs": ATTRS | {"window_start": "soon"}},
    "no bin in the window": {"attrs": ATTRS | {"window_start": 5.0, "window_stop": 6.0}},
    "title a number": {"attrs": ATTRS | {"title": 3.0}},
    "configuration no JSON": {"attrs": ATTRS | {"configuration": "{"}},
    "no attributes": {"attrs": {}},
    "no labels": {"skip": ("shape", "case", "kind")},
}


@pytest.mark.parametrize("verb", VERBS)
@pytest.mark.parametrize("fault", FOREIGN)
def test_a_foreign_file_is_answered_with_a_sentence(tmp_path, verb, fault):
    """Or with dashes where it has gaps; no traceback, no warning of numpy."""
    layout = BEDS if verb == "beds" else COMBINED
    path = foreign(tmp_path / "mine.nc", layout, **({"attrs": ATTRS} | FOREIGN[fault]))
    status, output = outcome(*VERBS[verb](path, tmp_path / "out"))
    assert status in (0, 2)
    if status:
        assert str(tmp_path) in output
        assert all("mine.nc" in line or "snapshots.nc" in line for line in output.splitlines())
    else:
        assert "nan" not in output


@pytest.mark.parametrize("dims", [(), ("seed",), ("displacement", "seed", "case")])
def test_a_drag_over_other_dimensions_is_refused(tmp_path, dims):
    layout = COMBINED | {"drag": (dims, "N", "")}
    path = foreign(tmp_path / "mine.nc", layout, attrs=ATTRS)
    for verb in ("info", "figure"):
        status, output = outcome(*VERBS[verb](path, tmp_path / "out"))
        assert status == 2 and "its drag is not over case, seed, displacement" in output


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


@pytest.mark.parametrize("name", ["drag.nc", "runs.nc", "snapshots.nc"])
def test_text_of_a_file_is_no_markup_on_the_terminal(hostile, name):
    status, output = outcome("info", hostile / name)
    assert status == 0 and "[red]title[/red]" in output and "[/nothing]" in output
