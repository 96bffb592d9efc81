"""Bad input at random: it is taken, or refused in a sentence; no traceback, no file lost, no damage unseen.

Hypothesis chooses seeds; what fails names its seed. Each kind of input is a function of a random
number generator and of the folder that it works in.
"""

import contextlib
import copy
import math
import random
import re
import shutil
import tempfile
from datetime import date
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from sweeps import contents, differing
from typer.testing import CliRunner

import dem
from dem.base.errors import InputError, RunError
from dem.base.types import LISTED
from dem.cli.app import app
from dem.sweep.config import load, parse

ROOT = Path(__file__).parents[2]
SMOKE = ROOT / "config/smoke.yaml"
NASTY = (
    *(math.nan, math.inf, -math.inf, -1, 0, -0.0, 1, 3, 0.5, 2**31, 2**63, 10**400, 1e15),
    *(1e-300, 1e300, 5e-324, True, None, [], {}, [[]], [1, 2, 3], [math.nan], list(range(200))),
    *("", " ", "nan", "1e400", "c1", "../../etc", "results/../..", "é\u0000x", "a" * 5000),
    *({"low": 1, "high": 0}, {"a": {"b": {}}}, date(2000, 1, 1), b"bytes"),
)
EVIL = "<script>evil()</script>[red]evil[/red]\x1b[31m\x07"
RUN = {"--config": "q.yaml", "--shape": "c1", "--density": "3900", "--seed": "1"}
# verb: its options and arguments (those without a dash), all good
GOOD = {
    "simulate": RUN | {"--checkpoint": "run.npz", "-o": "new.nc"},
    "combine": {"--config": "q.yaml", "--block": "drag", "--observable": "drag", "-o": "new.nc"},
    "info": {"file": "drag.nc", "-o": "new.txt"},
    "figure": {"name": "figure13", "file": "drag.nc", "-o": "new"},
}
NUMBER = ("nan", "inf", "-1", "x", "")
BAD = {
    "--config": ("rep.nc", "README.md", "none.yaml", "."),
    "--shape": ("zz", "", "é", "c1 "),
    "--density": ("0", "-inf", *NUMBER),
    "--seed": (str(2**63), str(2**70), "1.5", *NUMBER),
    "--checkpoint": ("q.yaml", "note.txt", "."),
    "--block": ("zz",),
    "--observable": ("zz", ""),
    "-o": ("q.yaml", "rep.nc/new.nc", "note.txt/new.nc"),
    "file": ("q.yaml", "run.npz", "none.nc", "."),
    "name": ("figure99", "", "../figure13"),
}


def words(verb, options):
    """A command line."""
    pairs = ([name, word] if name.startswith("-") else [word] for name, word in options.items())
    return [verb, *(word for pair in pairs for word in pair)]


@pytest.fixture(scope="session")
def good(tmp_path_factory):
    """A folder with a configuration, and what the verbs make of it."""
    folder = tmp_path_factory.mktemp("good")
    data = yaml.safe_load(SMOKE.read_text())
    data |= {
        "sweep": {"case": "all", "seed": [1]},
        "results": "results",
        "shapes": {"c1": data["shapes"]["c1"]},
        "cases": {"c1": data["cases"]["c1"]},
        "record": data["record"] | {"snapshots": 3},
    }
    (folder / "q.yaml").write_text(yaml.safe_dump(data))
    (folder / "note.txt").write_text("A note that nobody may lose.\n")
    shutil.copy(ROOT / "README.md", folder)
    simulate = {k: v for k, v in GOOD["simulate"].items() if k != "--checkpoint"}
    with contextlib.chdir(folder):
        for line in (
            words("simulate", simulate | {"-o": "rep.nc"}),
            ["sweep", "q.yaml", "-j", "1"],
        ):
            result = CliRunner().invoke(app, line)
            assert result.exit_code == 0, result.output
        shutil.copy("results/drag.nc", ".")
        _make_checkpoint()
    return folder


def _make_checkpoint():
    """run.npz: of a run that was stopped in the middle."""
    from dem.experiment.bed import make_bed
    from dem.experiment.kinds import drag

    def stop(progress):
        if progress >= 0.5:
            raise KeyboardInterrupt

    replicate = load("q.yaml").replicate("c1", 3.9e3, 1)
    with pytest.MonkeyPatch.context() as patch, contextlib.suppress(KeyboardInterrupt):
        patch.setattr(drag, "SAVED_EVERY", 0.0)
        drag.run(replicate, make_bed(replicate), stop, checkpoint=Path("run.npz"))
    assert Path("run.npz").is_file()


def bytes_of(folder):
    """The bytes of all files below a folder."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def check_sentences(text, most=LISTED + 1):
    """What a user reads are sentences, one a line, after the progress lines of a log; or what Python says of
    a file."""
    if text.lstrip().startswith("Usage:"):
        return  # of the command line's own parser
    lines = [line.rstrip() for line in text.strip().splitlines()]
    lines = [line for line in lines if not re.match(r"\d{4}-\d\d-\d\d |\[Errno ", line)]
    assert text.strip() and len(lines) <= most, text
    assert all(line.endswith((".", "?")) and line.isprintable() for line in lines), text


def command(folder, line, output=None, replaced=(), bad=False):
    """Result of a command that keeps its promises: status, sentences, no file lost or left over.

    output: where it writes if it succeeds; replaced: files that it may then remove or replace; bad: whether
    it must be refused.
    """
    files_before = bytes_of(folder)
    result = CliRunner().invoke(app, line)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code in (0, 1, 2), line
    assert result.exit_code or not bad, (line, result.output)
    if result.exit_code:
        check_sentences(result.stderr)
    files_after = bytes_of(folder)
    free = [] if result.exit_code else [folder / name for name in (*replaced, output) if name]
    for path in files_before.keys() | files_after.keys():
        allowed = any(path == target or target in path.parents for target in free)
        assert allowed or files_before.get(path) == files_after.get(path), (path, line)
    return result


# Kinds of input


def places(tree, path=()):
    """All places in a tree of dictionaries and lists."""
    tree = dict(enumerate(tree)) if isinstance(tree, list) else tree
    for key, value in tree.items() if isinstance(tree, dict) else ():
        yield (*path, key)
        yield from places(value, (*path, key))


def a_configuration(rng, folder):
    """A configuration with a few values replaced, removed or added."""
    data = yaml.safe_load(SMOKE.read_text())
    for _ in range(rng.randint(1, 3)):
        place = rng.choice(list(places(data)))
        at = data
        for key in place[:-1]:
            at = at[key]
        action = rng.random()
        if action < 0.7:
            at[place[-1]] = copy.deepcopy(rng.choice(NASTY))
        elif action < 0.85:
            del at[place[-1]]
        elif isinstance(at, dict):
            at[rng.choice(["x", "Cylinder", "", 3, None])] = copy.deepcopy(rng.choice(NASTY))
        if not list(places(data)):
            break
    parse(data)


def a_text(rng, folder):
    """A configuration with characters changed, lines lost or strange bytes in it."""
    text = bytearray(SMOKE.read_bytes())
    for _ in range(rng.randint(1, 20)):
        at = rng.randrange(len(text))
        action = rng.random()
        if action < 0.4:
            text[at] = rng.randrange(256)
        elif action < 0.7:
            del text[at : at + rng.randint(1, 40)]
        else:
            text[at:at] = rng.choice(
                [b"&a [*a]", b"\t", b"{", b": :", b"<<: *a", b"\xff\xfe", b"- -", b"? "]
            )
        if not text:
            break
    (folder / "fuzz.yaml").write_bytes(text)
    load(folder / "fuzz.yaml")


def an_extreme_value(rng, folder):
    """A run with one number of its configuration at the edge of what a computer can hold."""
    data = yaml.safe_load((folder / "q.yaml").read_text())
    section = data[rng.choice(["material", "friction", "cylinder", "record", "shapes"])]
    section = section.get("c1", section)
    key = rng.choice([key for key, value in section.items() if not isinstance(value, str)])
    section[key] = rng.choice([5e-324, 1e-308, 1e-200, 1e-150, 1e-30, 1e15])
    (folder / "q.yaml").write_text(yaml.safe_dump(data))
    options = GOOD["simulate"] | {"--density": rng.choice(["3900", "3900", "5e-324", "1e300"])}
    del options["--checkpoint"]
    command(folder, words("simulate", options), "new.nc")


def an_option(rng, folder):
    """A good command line with one value that must be refused."""
    verb = rng.choice(list(GOOD))
    name = rng.choice([option for option in GOOD[verb] if option in BAD])
    command(folder, words(verb, GOOD[verb] | {name: rng.choice(BAD[name])}), bad=True)


def an_array(rng, folder):
    """A scene and a state of a few discs with something wrong in it."""
    n = rng.choice([0, 1, 2, 3])
    wrong = [math.nan, math.inf, -math.inf, -1.0, 1e300, -1e300, 1e-300, 1e150]

    def often(right):
        return rng.choice([right, right, right, rng.choice(wrong)])

    def numbers(*shape, right=1e-3):
        array = np.full(shape, right)
        if array.size and rng.random() < 0.3:
            array.flat[rng.randrange(array.size)] = rng.choice(wrong)
        return rng.choice(
            [array] * 6 + [array.tolist(), array.astype(object), array[..., None], None]
        )

    scene = dem.Scene(
        dem.Disc(numbers(n)),
        dem.Material(often(3.9e3), often(70e9), often(0.22), often(0.5)),
        dem.Friction(often(0.3), often(0.3), often(0.3)),
        rng.choice([dem.box(1e-2, 1e-2)] * 4 + [numbers(2, 3), [[1, 0]]]),
        dem.Cylinder(often(1e-3), (5e-3, often(5e-3)), (0.0, often(1.0))),
    )
    position = np.random.default_rng(rng.randrange(2**31)).uniform(0.0, 1e-2, (n, 2))
    state = dem.State(
        rng.choice([position, numbers(n, 2)]),
        rng.choice([None, numbers(n, 2, right=0.1)]),
        rng.choice([None, numbers(n)]),
        rng.choice([None, numbers(n)]),
    )
    run = dem.simulate(scene, state, rng.choice([1e-9, 1e-9, *wrong]), rng.choice([None, *wrong]))
    assert np.isfinite(run.position).all() and np.isfinite(run.velocity).all()


def flip(file, rng, count=1):
    """Turn round some bits of a file."""
    content = bytearray(file.read_bytes())
    for _ in range(count):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)


def a_checkpoint(rng, folder):
    """dem simulate with a checkpoint that is cut off or damaged, or something else."""
    file = folder / "run.npz"
    damage = rng.choice(["cut", "flip", "garbage"])
    if damage == "cut":
        file.write_bytes(file.read_bytes()[: rng.randrange(file.stat().st_size)])
    elif damage == "flip":
        flip(file, rng, rng.choice([1, 1, 10]))
    else:
        file.write_bytes(
            rng.choice([b"", b"PK\x03\x04", b"\x93NUMPY", b"dem checkpoint "]) + rng.randbytes(50)
        )
    result = command(folder, words("simulate", GOOD["simulate"]), "new.nc", ["run.npz"])
    if result.exit_code == 0:
        assert differing(contents(folder / "new.nc"), contents(folder / "rep.nc")) == []


def a_flip(rng, folder):
    """A batch or drag.nc with a bit turned round, given to what reads it."""
    (batch,) = (folder / "results/store/batches").glob("*.nc")
    verb, file = rng.choice([("combine", batch), ("info", folder / "drag.nc")])
    expected = contents(folder / "drag.nc")
    flip(file, rng, rng.choice([1, 1, 1, 10]))
    result = command(folder, words(verb, GOOD[verb]), GOOD[verb]["-o"])
    if result.exit_code == 0 and verb == "combine":
        assert differing(contents(folder / "new.nc"), expected) == []


def a_file(rng, folder):
    """Bytes that are no netCDF file, or the beginning of one."""
    head = rng.choice([b"", b"CDF\x01", b"\x89HDF\r\n\x1a\n", b"PK\x03\x04"])
    content = (folder / "rep.nc").read_bytes()
    cut = content[: rng.randrange(len(content))]
    (folder / "fuzz.nc").write_bytes(rng.choice([cut, head + rng.randbytes(3000)]))
    verb = rng.choice(["info", "figure"])
    command(folder, words(verb, GOOD[verb] | {"file": "fuzz.nc"}), bad=True)


def a_tampered_file(rng, folder):
    """A file of results with other text or values in it, which a terminal does not obey."""
    verb = rng.choice(["info", "figure"])
    options = {"file": "drag.nc"} if verb == "info" else GOOD["figure"]
    with netCDF4.Dataset(folder / "drag.nc", "a") as opened:
        opened.set_auto_mask(False)
        name, variable = rng.choice(opened.ncattrs()), opened[rng.choice(list(opened.variables))]
        action = rng.choice(["remove", "number", "text", "nan", "rename"])
        if action == "remove":
            opened.delncattr(name)
        elif action == "number":
            opened.setncattr(name, rng.choice([math.nan, -1, np.arange(3), 1e300]))
        elif action == "text":
            opened.setncattr(name, rng.choice(["{", "[]", "{}", "null", EVIL]))
        elif action == "rename":
            opened.renameVariable(variable.name, "other")
        elif variable.dtype.kind == "f":
            variable[...] = rng.choice([math.nan, math.inf, -1e300, 0.0])
    command(folder, words(verb, options), options.get("-o"), ["drag.nc"])


KINDS = (
    a_configuration,
    a_text,
    an_extreme_value,
    an_option,
    an_array,
    a_checkpoint,
    a_flip,
    a_file,
    a_tampered_file,
)


def spoil(good, kind, chosen):
    """Spoil input of a kind in copies of a folder, as often as settings of hypothesis say."""

    @chosen
    @given(st.integers(0, 2**32))
    def one(seed):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(shutil.copytree(good, Path(name).resolve() / "copy"))
            with contextlib.chdir(folder):
                try:
                    kind(random.Random(seed), folder)
                except (InputError, RunError) as error:
                    check_sentences(str(error))

    one()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_bad_input_ends_in_a_sentence_and_loses_nothing(good, kind):
    spoil(good, kind, settings(settings.get_profile("night"), max_examples=500))
