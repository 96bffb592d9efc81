"""What depends on a line of code is found: a table of edits against what each makes again."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import studies  # noqa: F401 its code counts
from conftest import needs_study
from dem.base import sources
from dem.base.sources import ROOT, ROOTS, closure
from dem.figures.catalogue import FIGURES
from dem.shapes import KINDS

pytestmark = needs_study("claims")
DISC, ELLIPSE = KINDS["disc"].module, KINDS["ellipse"].module
RUN = (
    "dem.experiment.kinds.drag",
    *(f"dem.experiment.observables.{name}" for name in ("drag", "snapshots")),
)
# What a result depends on, by its name in the table below.
RESULTS = {
    "disc run": (*RUN, DISC),
    "ellipse run": (*RUN, ELLIPSE),
    "superellipse run": (*RUN, KINDS["superellipse"].module),
    "ledger run": (*RUN, "dem.experiment.observables.ledger", DISC),
    "jamming": ("dem.experiment.kinds.jamming", DISC),
    "bed": ("dem.experiment.bed", DISC),
    "drag.nc": ("dem.sweep.combine",),
    "figure": ("dem.figures.figure13",),
    "claims": ("studies.claims.results",),
    "claims.txt": ("dem.report.info", "studies.claims.findings"),
    "page": ("dem.report.build",),
    "kernel": ("dem.contacts.loops",),
}
BEDS = {"jamming", "bed"}
RUNS = {"disc run", "ellipse run", "superellipse run", "ledger run"}
MADE = {"claims"}  # by what can make runs too
MOVING = RUNS | BEDS | MADE | {"claims.txt", "page"}
KERNELS = MOVING | {"kernel"}
LINE = "\nEDITED = True\n"

# (file, what is there and what is put instead, or a line that is added): what is made again
EDITS = {
    "a line of a kernel": ("dem/contacts/force_law.py", LINE, KERNELS),
    "a line of columns": ("dem/jit/columns.py", LINE, KERNELS),
    "a line of every shape's questions": ("dem/shapes/protocol.py", LINE, KERNELS),
    "a line of a shape": ("dem/shapes/superellipse.py", LINE, {"superellipse run"}),
    "a line of discs": ("dem/shapes/disc.py", LINE, {"disc run", "ledger run"} | BEDS),
    "a line of ellipses": ("dem/shapes/ellipse.py", LINE, {"ellipse run"}),
    "a line of the dynamics": ("dem/dynamics/stepping.py", LINE, MOVING),
    "a line of packing": ("dem/packing/minimise.py", LINE, MOVING),
    "a line of the layout": ("dem/io/dataset.py", LINE, MOVING | {"drag.nc"}),
    "a line of the experiment": ("dem/experiment/kinds/drag.py", LINE, RUNS | {"claims"}),
    "a line of an observable": ("dem/experiment/observables/ledger.py", LINE, {"ledger run"}),
    "a line of growing beds": ("dem/experiment/kinds/jamming.py", LINE, {"jamming"}),
    "a line of the store": ("dem/sweep/store.py", LINE, MADE | {"claims.txt", "page"}),
    "a line of a batch": ("dem/sweep/batch.py", LINE, MADE),
    "a line of the sweep": ("dem/sweep/combine.py", LINE, MADE | {"drag.nc", "claims.txt", "page"}),
    "a line of statistics": (
        "dem/analysis/statistics.py",
        LINE,
        {"figure", "page", "claims.txt"},
    ),
    "a line of a study": ("studies/claims/results.py", LINE, {"claims"}),
    "a line of style": ("dem/figures/style.py", LINE, {"figure", "page"}),
    "a line of a figure": ("dem/figures/figure13.py", LINE, {"figure"}),
    "a line of the report": ("dem/report/build.py", LINE, {"page"}),
    "a line of the command line": ("dem/cli/app.py", LINE, set()),
    "one more shape": ("dem/shapes/triangle.py", 'SHAPE = "Triangle"\n', set()),
    "a comment": ("dem/contacts/force_law.py", "\n# edited\n", set()),
    "empty lines": ("dem/experiment/kinds/drag.py", "\n\n\n", set()),
    "a docstring": (
        "dem/experiment/scene.py",
        ('"""The scene of the run."""', '"""Another word."""'),
        set(),
    ),
    "an error sentence": (
        "dem/experiment/config.py",
        ("has no such shape", "knows no such shape"),
        set(),
    ),
    "an annotation": (
        "dem/experiment/kinds/drag.py",
        ("checkpoint: Path | None", "checkpoint: str | None"),
        set(),
    ),
    "another error": (
        "dem/experiment/config.py",
        ('raise InputError(f"shape is', 'raise ValueError(f"shape is'),
        MOVING | {"drag.nc"},
    ),
    "a default": (
        "dem/experiment/kinds/drag.py",
        ("SAVED_EVERY = 60.0", "SAVED_EVERY = 61.0"),
        RUNS | {"claims"},
    ),
}

ASK = """
import json, sys
import studies
from dem.base.sources import code_hash
print(json.dumps({name: code_hash(*modules) for name, modules in json.loads(sys.argv[1]).items()}))
"""


def hashes(folder, python=sys.executable) -> dict[str, str]:
    """Hash of the code of each of RESULTS, of the package in a folder."""
    command = [python, "-c", ASK, json.dumps(RESULTS)]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    ran = subprocess.run(command, cwd=folder, env=environment, text=True, capture_output=True)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy of the package."""
    folder = tmp_path_factory.mktemp("copy")
    for name, path in ROOTS.items():
        shutil.copytree(path, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def before(copy):
    return hashes(copy)


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_makes_again_what_depends_on_it_and_nothing_else(copy, before, edit):
    name, change, again = EDITS[edit]
    path = copy / name
    text = path.read_text() if path.exists() else None
    if isinstance(change, tuple):
        assert text.count(change[0]) == 1
        path.write_text(text.replace(*change))
    else:
        path.write_text((text or "") + change)
    after = hashes(copy)
    path.unlink() if text is None else path.write_text(text)
    assert {name for name in RESULTS if after[name] != before[name]} == again


def test_each_room_has_an_edit():
    rooms = {path.name for path in ROOTS["dem"].iterdir() if (path / "__init__.py").is_file()}
    assert rooms - {Path(name).parts[1] for name, *_ in EDITS.values()} == {"base"}


def test_a_figure_depends_on_its_own_file_and_not_on_another():
    for name in FIGURES:
        assert {f"dem.figures.{name}", "dem.figures.style"} <= set(closure(f"dem.figures.{name}"))
    assert "dem.analysis.onset" in closure("dem.figures.onset")
    assert "dem.figures.figure08" not in closure("dem.figures.figure07")


@pytest.mark.parametrize(
    "name", ["dem.figures.figure09", "studies.claims.verdicts", "dem.experiment.kinds.drag"]
)
def test_all_that_python_loads_is_found(name):
    """What importing a module loads of the package is in its closure."""
    words = f"import sys, {name}; print(*[n for n in sys.modules if n.partition('.')[0] == 'dem'])"
    run = subprocess.run(
        [sys.executable, "-c", words], cwd=ROOT, text=True, capture_output=True, check=True
    )
    assert set(run.stdout.split()) <= set(closure(name))


def test_no_module_takes_a_name_from_the_package_itself():
    """Public names are loaded by a table that the closure does not follow."""
    for path in ROOTS["dem"].rglob("*.py"):
        assert not re.search(r"^\s*(import dem$|from dem import )", path.read_text(), re.M), path


def test_a_module_that_is_not_of_the_package_is_refused():
    for name in ("numpy", "dem.nothing", "dem.base.errors.InputError"):
        with pytest.raises(ValueError, match="module is"):
            closure(name)


WRITTEN = '''
"""A docstring."""

def f(x: int = 1) -> "float":  # a comment
    """Another."""
    if x > 2:
        raise ValueError(f"x is {x}, too great.")
    return (x, u"é", None)
'''
SAID = (
    "Module(body=[FunctionDef(name='f',args=arguments(args=[arg(arg='x')],defaults=[Constant(value=1)]),"
    "body=[If(test=Compare(left=Name(id='x'),ops=[Gt()],comparators=[Constant(value=2)]),"
    "body=[Raise(exc=Name(id='ValueError'))]),"
    "Return(value=Tuple(elts=[Name(id='x'),Constant(value='\\xe9'),Constant()]))])])"
)


def test_the_text_of_code_holds_no_words_and_nothing_that_a_version_of_python_adds():
    assert sources._code(ast.parse(WRITTEN)) == SAID


def other_pythons():
    """Supported versions of Python that are installed beside this one."""
    names = [f"python3.{minor}" for minor in range(11, 15)]
    places = [*map(shutil.which, names), *Path.home().glob(".pyenv/versions/3.1[1-9]*/bin/python")]
    return [str(place) for place in places if place]


# Without the two packages that it imports, which other installations may not have.
TREES = """
import sys, types
sys.modules["platformdirs"] = types.SimpleNamespace(user_cache_path=None)
sys.modules["lazy_loader"] = types.SimpleNamespace(attach_stub=lambda *_: (None, None, None))
from pathlib import Path
from dem.base import sources
files = sorted(sources.ROOTS["dem"].rglob("*.py"))
print(sys.version_info[:2], *(sources._parse(path.read_bytes(), path).code for path in files), sep="\\n")
"""


def test_hashes_are_those_of_every_python():
    said = {}
    for python in {sys.executable, *other_pythons()}:
        command, environment = [python, "-c", TREES], os.environ | {"PYTHONPATH": str(ROOT)}
        ran = subprocess.run(command, cwd=ROOT, env=environment, text=True, capture_output=True)
        if ran.returncode == 0:  # else a version that is named but cannot be started
            version, _, codes = ran.stdout.partition("\n")
            said[version] = codes
    if len(said) == 1:
        pytest.skip("there is one version of Python only")
    assert len(set(said.values())) == 1, said.keys()


@pytest.mark.parametrize("damage", [b"", b"{", b"0" * 64 + b'\n[[], "0"]'])
def test_a_damaged_note_of_a_source_is_made_again(tmp_path, monkeypatch, damage):
    """And one that is there is used: hashes come without parsing."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    path = ROOTS["dem"] / "scene.py"
    right = sources._source(path.read_bytes(), path)
    (note,) = tmp_path.rglob("*.json")
    whole = note.read_bytes()
    note.write_bytes(damage)
    assert sources._source(path.read_bytes(), path) == right and note.read_bytes() == whole
    monkeypatch.setattr(sources, "_parse", None)
    assert sources._source(path.read_bytes(), path) == right
