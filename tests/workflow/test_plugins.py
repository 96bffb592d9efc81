"""Shapes, observables and experiments in files of a user: swept, cached, known by their code, and run only to
make runs.

The recipes of docs/howto/shape.md and docs/howto/experiment.md, followed to the letter.
"""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from project import FILES, PAGE, SHAPE, SHORT_LINE, posix
from workflows import run, snakemake

import dem
from dem.base.source_hash import ROOT
from dem.experiment.config import of_values
from dem.figures.catalogue import draw
from dem.report.build import build
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store

(SWEEP,) = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)
SWEEP = SWEEP.replace("seed: 1 to 5", "seed: [1, 2]") + "batch: 1\n"  # fewer runs, in two processes
SWEEP += "record: {observables: [drag, snapshots, rotation.py]}\n"
TELLING = "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"


def write(folder: Path, shape: str = SHAPE, sweep: str = SWEEP) -> Path:
    """A folder with a shape and a sweep of it; returns the file of the sweep."""
    folder.mkdir()
    (folder / "pebbles.py").write_text(shape)
    (folder / "rotation.py").write_text(FILES["rotation.py"])
    (folder / "sweep.yaml").write_text(sweep)
    return folder / "sweep.yaml"


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A folder where the sweep of the page was made, in one process: two would both compile."""
    folder = tmp_path_factory.mktemp("swept")
    write(folder / "mine")
    run("-m", "dem", "sweep", "mine/sweep.yaml", "-j1", cwd=folder)
    return folder


def test_a_shape_in_a_file_of_ones_own_is_swept(swept):
    """Beds, runs, how they move: all is there, and nothing was written beside the sweep file."""
    for name in ("drag.nc", "rotation.nc"):
        assert (swept / "results/pebbles" / name).is_file()
    assert len(list((swept / "mine").iterdir())) == 3


ASK = """
import sys
from numba.core.event import install_recorder
import dem
from dem.jit.compilation import CODE

values = next(dem.load_sweep(sys.argv[1]))
with install_recorder("numba:compile") as recorder:
    found = dem.run_experiment(values)
print(len(recorder.buffer), float(found["drag"].mean()), [each.__name__ for each in CODE])
"""


def test_the_next_process_compiles_nothing(swept, tmp_path):
    """Nor where the class was imported by the user, nor in another folder; after an edit it compiles."""
    write(tmp_path / "copy")
    imported = f"from pebbles import Pebble\n{ASK}"
    (answer,) = {
        run("-c", ASK, "mine/sweep.yaml", cwd=swept),
        run("-c", imported, "mine/sweep.yaml", cwd=swept, path=[swept / "mine"]),
        run("-c", ASK, "copy/sweep.yaml", cwd=tmp_path),
    }
    assert answer.startswith("0 ") and answer.endswith("['Pebble']\n")


def known_by(*folders: Path) -> list[str]:
    """What the runs of sweeps are known by, in a process of its own."""
    words = (
        "import sys; from dem.sweep.config import load\n"
        "for path in sys.argv[1:]:\n"
        "    run = next(load(path).block('drag').unique())\n"
        "    print(run.id, run.bed_id)"
    )
    return run("-c", words, *(folder / "sweep.yaml" for folder in folders), cwd=ROOT).splitlines()


EDITS = {  # file, what is there, what is put instead; whether runs are made again
    "a comment": ("pebbles.py", "import numpy as np", "import numpy as np  # arrays", False),
    "a constant": ("pebbles.py", "0.08", "0.07", True),
    "the aspect ratio": ("sweep.yaml", "aspect_ratio: 1.0", "aspect_ratio: 1.1", True),
    "what an observable measures": ("rotation.py", "angle - angle[0]", "angle[0] - angle", True),
    "a docstring of an observable": ("rotation.py", "Values of VARIABLES", "Values", False),
    "what it imports": ("lengths.py", "0.5", "0.50001", True),
    "what that imports": ("more/units.py", "1.0", "1.5", True),
    "what it does not import": ("other.py", "1", "2", False),
}
WITH_IMPORTS = SHAPE.replace(
    "import numpy as np\n", "import numpy as np\nfrom lengths import HALF\n"
)


def test_runs_are_known_by_the_code_of_their_shape_and_not_by_its_folder(tmp_path):
    first = tmp_path / "first"
    write(first, WITH_IMPORTS.replace("0.5 *", "HALF *"))
    (first / "lengths.py").write_text("from more.units import M\n\nHALF = 0.5 * M\n")
    (first / "more").mkdir()
    (first / "more/units.py").write_text("M = 1.0\n")
    (first / "other.py").write_text("A = 1\n")
    for edit, (name, old, new, _) in EDITS.items():
        shutil.copytree(first, tmp_path / edit)
        text = (first / name).read_text()
        assert old in text, edit
        (tmp_path / edit / name).write_text(text.replace(old, new))
    reference, *keys = known_by(first, *(tmp_path / edit for edit in EDITS))
    assert {edit: key != reference for edit, key in zip(EDITS, keys, strict=True)} == {
        edit: changed for edit, (*_, changed) in EDITS.items()
    }


def test_a_plan_finds_shapes_that_were_moved_since(tmp_path, monkeypatch):
    """A sweep that was stopped, and started again in another place."""
    monkeypatch.chdir(tmp_path)
    store, places = Store(tmp_path / "store"), []
    for name in ("one", "two"):
        work = SweepState(load(write(tmp_path / name)), store)
        places.append({chunk.id for chunk in work.batches("drag")})
        work.begin("drag")
        for chunk in places[-1]:
            (replicate,) = store.replicates(chunk)
            assert replicate.configuration.beside == str(tmp_path / name)
        shutil.rmtree(tmp_path / name)
    assert places[0] == places[1]


def test_readers_run_no_code_that_a_sweep_names(swept):
    """A dry run, compiled nothing: the files of shapes are read, and only those who make runs run them."""
    folder = swept / "telling"
    write(folder, TELLING + SHAPE)
    (folder / "rotation.py").write_text(TELLING + FILES["rotation.py"])
    sweep = folder / "sweep.yaml"
    sweep.write_text(sweep.read_text().replace("results/pebbles", "results/telling"))
    for name in ("pebbles.py", "rotation.py"):  # those of the results
        with (swept / "mine" / name).open("a") as file:
            file.write(f"\n{TELLING}")
    results = swept / "results/pebbles"
    try:
        for words in (
            ("sweep", "telling/sweep.yaml", "-n"),
            ("info", results / "rotation.nc"),
            ("store",),
            ("figure", "all", results / "drag.nc"),
            ("report", results / "drag.nc", "-o", "page.html"),
        ):
            run("-m", "dem", *words, cwd=swept)
        picture = "-m", "dem", "draw", results / "drag.nc", "seed=1", "-o"
        output = run(*picture, "plain.png", cwd=swept, status=2)
        assert (
            "--shapes FOLDER on the command line" in output and not (swept / "plain.png").exists()
        )
        assert not (folder / "ran").exists() and not (swept / "mine/ran").exists()
        run(*picture, "true.png", "--shapes", "telling", cwd=swept)
        assert (folder / "ran").exists() and not (swept / "mine/ran").exists()
    finally:
        (swept / "mine/pebbles.py").write_text(SHAPE)
        (swept / "mine/rotation.py").write_text(FILES["rotation.py"])


WRONG = {
    "stone.Pebble": "there is no file",
    "pebbles.Peble": "has no class Peble; it defines support, Pebble, Bare.",
    "pebbles.Bare": "its class has no of_size; give it",
    "broken.Stone": "cannot be read (",
    "../mine/pebbles.Pebble": "it must be 'clump', 'disc', 'dumbbell', 'ellipse' or 'superellipse'",
    "/etc/passwd.X": "it must be 'clump'",
    "os.system": "there is no file",
    "dem.shapes.disc.Disc": "it must be 'clump'",
    "pebble": "it must be 'clump', 'disc', 'dumbbell', 'ellipse' or 'superellipse'",
}
BARE = "\n\nclass Bare:\n    pass\n"


@pytest.mark.parametrize("kind", WRONG)
def test_a_kind_that_is_none_gets_one_sentence(tmp_path, kind):
    write(tmp_path / "mine", TELLING + SHAPE + BARE, SWEEP.replace("pebbles.Pebble", kind))
    (tmp_path / "mine/broken.py").write_text("def\n")
    with pytest.raises(dem.InputError) as error:
        load(tmp_path / "mine/sweep.yaml")
    message = str(error.value)
    assert f"shapes.pebble.kind is '{kind}'; " in message and WRONG[kind] in message
    assert message.endswith(".") and "\n" not in message
    assert not (tmp_path / "mine/ran").exists()


def test_what_is_wrong_with_a_file_of_a_shape_ends_with_status_2(tmp_path):
    write(tmp_path / "mine", SHAPE.replace("@smooth(support)\n", ""))
    output = run("-m", "dem", "sweep", "sweep.yaml", cwd=tmp_path / "mine", status=2)
    assert re.match(
        r"shapes\.pebble \(pebbles\.Pebble\): .*Pebble is no shape; decorate it with smooth",
        output.splitlines()[-1],
    )


RESTING = """
SECTIONS = {"cylinder": False, "record": False}
VALUES = {"margin": (0.0, "m", 'width', {'ge': 0}), "layers": (4, "1", "layers")}
VARIABLES = {'count': (("layer",), "1", "granules")}
SIZES = {"layer": "rest.layers"}
def run(replicate):
    pass
""".replace('"margin"', "'margin'")
WRONG_FILES = {  # what a sweep says: which file is there, and what is told
    "experiment: rests.py": ("", "experiment is 'rests.py'; there is no file"),
    "experiment: mine.rest": ("", "experiment is 'mine.rest'; it must be one of drag"),
    "experiment: rest.py": ("VARIABLES = {}\n", "rest.py has no function run."),
    "experiment: drag.py": ("", "drag is a name of this package"),
    "record: {observables: [drag, rest.py]}": (
        "VARIABLES = {'drag': ((), 'N', 'force')}\ndef look(it):\n    pass\n",
        "drag has two meanings in files of its runs; rename yours.",
    ),
    "experiment: rest.py  # labels": (
        "VARIABLES = {'density': ((), '1', 'words')}\ndef run(it):\n    pass\n",
        "density has two meanings in files of its runs; rename yours.",
    ),
    "experiment: rest.py  # axis": (
        "VARIABLES = {'at': ((), '1', 'words')}\nSIZES = {'at': 2}\nAXIS = {'at': (('at',), '1', 'words')}\n"
        "def run(it):\n    pass\n",
        "at has two meanings in files of its runs; rename yours.",
    ),
    "experiment: rest.py\nrest: {margn: 0}": (
        RESTING,
        "rest.margn is not a known key; the nearest is margin",
    ),
    "experiment: rest.py\nrest: {margin: -1}": (
        RESTING,
        "rest.margin is -1; it must be at least 0, in m.",
    ),
    "experiment: drag\nrest: {margin: 0}": (RESTING, "rest is not a known key"),
    "experiment: title.py": (
        RESTING,
        "experiment is 'title.py'; its VALUES need a section title, which is another key",
    ),
    "experiment: rest.py\n# limit": (
        RESTING.replace("'ge'", "'least'"),
        "its VALUES must be plain values, name: (default",
    ),
    "experiment: rest.py\n# no path": (
        RESTING.replace("rest.layers", "rest.layer"),
        "the dimension layer of SIZES has the length None",
    ),
    "experiment: rest.py\nsweep: {shape: c1, density: 3900, seed: 1, rest.layers: [2, 3]}": (
        RESTING,
        "sweep varies rest.layers, which runs of one block share; use blocks.",
    ),
    "experiment: rest.py\nsweep: {shape: c1, density: 3900, seed: 1, rest.margin: [0, 1]}": (
        RESTING.replace("'count'", "'rest_margin'"),
        "sweep gives files of results two things named rest_margin; rename one.",
    ),
    "experiment: rest.py\nsweep: {shape: c1, count: {a: {}, b: {gravity: 1}}}": (
        RESTING,
        "two things named count; rename one",
    ),
    "experiment: rest.py\nsweep: {shape: c1, layer: {a: {}, b: {gravity: 1}}}": (
        RESTING,
        "two things named layer; rename one",
    ),
    "record: {observables: [rest.py, drag]}": (
        "VARIABLES = {'turn': (('snap',), 'N', 'force')}\ndef look(it):\n    pass\n",
        "the variable turn is over snap; its dimensions may be bound, displacement",
    ),
}


@pytest.mark.parametrize("words", WRONG_FILES)
def test_what_is_wrong_with_a_file_of_an_experiment_is_one_sentence(tmp_path, words):
    """Which comes without running it."""
    text, reason = WRONG_FILES[words]
    for name in ("rest.py", "drag.py", "title.py"):
        (tmp_path / name).write_text(TELLING + text)
    (tmp_path / "sweep.yaml").write_text(
        f"extends: config/smoke.yaml\nresults: results/mine\n{words}\n"
        + "sweep: {shape: c1, density: 3900, seed: 1}\n" * ("sweep" not in words)
    )
    with pytest.raises(dem.InputError) as error:
        load(tmp_path / "sweep.yaml")
    message = str(error.value)
    assert reason in message and message.endswith(".") and "\n" not in message
    assert not (tmp_path / "ran").exists()


def test_an_experiment_in_a_file_of_ones_own_is_swept(tmp_path):
    """As the page has it; it is known by its code and not by its folder, and read by all but who makes runs."""
    folder = tmp_path / "mine"
    folder.mkdir()
    for name in ("rest.py", "rest.yaml"):
        (folder / name).write_text(FILES[name])
    dry = "-m", "dem", "sweep", "mine/rest.yaml", "-n"
    (folder / "rest.py").write_text(TELLING + FILES["rest.py"])
    assert "0 finished" in run(*dry, cwd=tmp_path)
    assert not (folder / "ran").exists()
    (folder / "rest.py").write_text(FILES["rest.py"])
    run("-m", "dem", "sweep", "mine/rest.yaml", cwd=tmp_path)
    with xr.open_dataset(tmp_path / "results/rest/rest.nc") as dataset:
        runs = {"shape": 2, "rest_margin": 2, "seed": 2}
        assert dict(dataset["rest_load"].sizes) == runs
        assert dict(dataset["rest_granules"].sizes) == runs | {"layer": 3}
        granules = dataset["rest_granules"].sum("layer")
        assert (granules == dataset["granules"]).all()
        assert dataset["layer"].values == pytest.approx([1 / 6, 1 / 2, 5 / 6])
        assert dataset["rest_margin"].attrs["units"] == "m"
        # at rest each contact between granules is one of the list, and walls have the others
        everywhere, above = (
            dataset["rest_force"].sel(rest_margin=margin).count("contact") for margin in (0.0, 1e-3)
        )
        assert (everywhere >= 0.5 * (dataset["rest_contacts"] * dataset["granules"])).all()
        assert (above < everywhere).all()
    data = tmp_path / "results/rest/rest.nc"
    draw("sweep", data, data.parent / "figures", of="rest_force")
    build(data, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert page.count("rest_granules") >= 1 and 'id="sweep"' in page and "Mean drag" not in page
    folder = folder.rename(tmp_path / "moved")
    dry = *dry[:3], "moved/rest.yaml", "-n"
    assert "8 finished" in run(*dry, cwd=tmp_path)
    (folder / "rest.py").write_text(
        TELLING + FILES["rest.py"].replace("bed.pressure", "2.0 * bed.pressure")
    )
    assert "0 finished" in run(*dry, cwd=tmp_path)
    for words in (["info", "results/rest/rest.nc"], ["store"]):
        run("-m", "dem", *words, cwd=tmp_path)
    assert not (folder / "ran").exists()


NEAR = '''
"""Which contacts carry most, and how granules are turned."""

import numpy as np

SIZES = {"contact": 900, "sector": 4}
AXIS = {"sector": (("sector",), "rad", "middle of the sector")}
VARIABLES = {
    "contact_force": (("snapshot", "contact"), "N", "normal force of a contact"),
    "contact_number": (("snapshot",), "1", "number of contacts"),
    "sector_granules": (("sector",), "1", "granules that are turned into a sector"),
}


def axes(configuration):
    return {"sector": (np.arange(4) + 0.5) * np.pi / 2}


def look(simulation):
    force = simulation.contacts().force
    return {"contact_force": force, "contact_number": len(force)}


def measure(run):
    turned = run.snapshots.angle[-1] % (2 * np.pi)
    return {"sector_granules": np.histogram(turned, 4, (0, 2 * np.pi))[0]}
'''


@pytest.mark.parametrize("length", [900, 3])
def test_an_observable_gives_grids_and_lists_of_any_length(tmp_path, length):
    """Rows end in NaN; a list that is longer than it may be is refused and not cut."""
    (tmp_path / f"near{length}.py").write_text(NEAR.replace("900", str(length)))
    values = {
        "extends": "config/smoke.yaml",
        "shape": "c1",
        "beside": str(tmp_path),
        "record": {"observables": ["drag", f"near{length}.py"]},
    }
    if length == 3:
        with pytest.raises(
            dem.RunError,
            match=r"contact_force is an array of float64 with shape \(\d+,\); it must be numbers, at most 3",
        ):
            dem.run_experiment(values)
        return
    result = dem.run_experiment(values)
    assert (result["contact_force"].count("contact") == result["contact_number"]).all()
    assert len(np.unique(result["contact_number"])) > 1
    assert result["sector"].attrs["units"] == "rad"
    assert result["sector_granules"].sum() == result["granules"]


def test_values_of_ones_own_are_read_where_the_file_is_away(tmp_path):
    """As the values of runs are, which name no folder; and they are part of what a run is known by."""
    (tmp_path / "rest.py").write_text(RESTING)
    (tmp_path / "sweep.yaml").write_text(
        "extends: config/smoke.yaml\nresults: results/mine\nexperiment: rest.py\nrest: {layers: 2}\n"
        "sweep: {shape: c1, density: 3900, seed: 1, rest.margin: [0, 1e-3]}\n"
    )
    one, two = load(tmp_path / "sweep.yaml").block("drag").unique()
    assert one.id != two.id
    away = {name: value for name, value in two.values().items() if name != "beside"}
    assert of_values(away).configuration.rest.margin == two.configuration.rest.margin == 1e-3
    assert of_values(away | {"beside": str(tmp_path)}).id == two.id


def test_beside_names_another_folder(tmp_path):
    write(tmp_path / "shapes")
    path = write(tmp_path / "sweeps", "", SWEEP + "beside: ../shapes\n")
    assert load(path).beside == str(tmp_path / "shapes")
    assert parse(load(path).dump()).beside == str(tmp_path / "shapes")


@posix
def test_a_shape_in_a_file_of_ones_own_is_swept_by_the_workflow(swept, copy, tmp_path):
    """The runs are those of `dem sweep`, and so are their combined files."""
    shutil.copytree(copy, tmp_path, dirs_exist_ok=True)
    write(tmp_path / "mine")
    targets = "all", "results/pebbles/rotation.nc"
    process = snakemake(tmp_path, *targets, "-c2", configfile="mine/sweep.yaml")
    assert process.returncode == 0, process.stderr
    for name in ("drag.nc", "rotation.nc"):
        assert (tmp_path / "results/pebbles" / name).is_file()
    plans = [
        sorted(path.name for path in (folder / "results/store/batches").glob("*.nc"))
        for folder in (swept, tmp_path)
    ]
    assert plans[0] == plans[1]
    shutil.move(tmp_path / "mine", tmp_path / "elsewhere")
    rerun = snakemake(tmp_path, *targets, "-n", configfile="elsewhere/sweep.yaml")
    assert "Nothing to be done" in rerun.stdout + rerun.stderr


def test_a_shape_in_the_package_is_one_file(tmp_path):
    """No other file is touched."""
    shutil.copytree(ROOT / "dem", tmp_path / "dem", ignore=shutil.ignore_patterns("__pycache__"))
    words = (
        "import dem, json; from dem.sweep.config import parse\n"
        "sweep = parse(json.loads('''DATA'''))\n"
        "run = next(sweep.block('drag').unique())\n"
        "made = run.kind.shape.of_size([1e-3], run.shape.ratio)\n"
        "print(dem.__file__, type(made).__name__, round(float(made.area[0]) * 1e6, 6))"
    )
    last = SHAPE.rindex("import smooth\n") + len("import smooth\n")
    (tmp_path / "dem/shapes/pebbles.py").write_text(f"{SHAPE[:last]}\n{SHORT_LINE}{SHAPE[last:]}")
    data = (
        f'{{"extends": "{ROOT}/config/smoke.yaml", "results": "results/x", "shapes": {{"p": {{"kind": '
        '"pebbles", "diameter": 1e-3, "granules": 60}}, "sweep": {"shape": "p", "density": [3900], "seed": 1}}'
    )
    file, name, area = run("-c", words.replace("DATA", data), cwd=tmp_path, path=[tmp_path]).split()
    assert (file, name, float(area)) == (str(tmp_path / "dem/__init__.py"), "Pebble", 0.785398)


def test_only_a_class_of_an_imported_file_is_known_by_its_code(tmp_path):
    """A class in a script or a function may depend on more than its file."""
    words = "from dem.jit.compilation import CODE; print(len(CODE))"
    (tmp_path / "script.py").write_text(f"{SHAPE}\n{words}\n")
    assert run("script.py", cwd=tmp_path).strip() == "0"
    (tmp_path / "pebbles.py").write_text(SHAPE)
    assert run("-c", f"import pebbles\n{words}", cwd=tmp_path).strip() == "1"
    inside = "".join(f"    {line}\n" for line in SHAPE.splitlines())
    (tmp_path / "pebbles.py").write_text(f"def make():\n{inside}\nmake()\n")
    assert run("-c", f"import pebbles\n{words}", cwd=tmp_path).strip() == "0"
