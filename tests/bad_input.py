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
import time
from datetime import date
from pathlib import Path
from unittest import mock

import yaml
from command_line import called
from hypothesis import given
from hypothesis import strategies as st
from project import ROOT
from sweeps import SMOKE, Killed, contents, differing, killed_at

import dem
from dem.base.refusals import LISTED
from dem.sweep.config import load, parse

NASTY = (
    *(math.nan, math.inf, -1, 0, -0.0, 2**31, 2**63, 10**400, 1e15),
    *(1e-300, 5e-324, True, None, [], [[]], [math.nan], list(range(200))),
    *("", "nan", "1e400", "c1", "../../etc", "results/../..", "é\u0000x", "a" * 5000),
    *({"low": 1, "high": 0}, {"a": {"b": {}}}, date(2000, 1, 1), b"bytes"),
)
SIMULATE = "simulate --config q.yaml --shape c1 --density 3900 --seed 1 -o new.nc"


def make_good(folder):
    """Put a configuration into a folder, and what the verbs make of it."""
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
    with contextlib.chdir(folder):
        for line in SIMULATE.replace("new", "rep"), "sweep q.yaml -j 1":
            result = called(line)
            assert result.exit_code == 0, result.output
        shutil.copy("results/drag.nc", ".")
        make_checkpoint()
    return folder


def make_checkpoint():
    """run.npz: of a run that was stopped in the middle. It saves itself once a minute, and minutes are short."""
    replicate, clock = load("q.yaml").replicate("c1", 3.9e3, 1), time.monotonic
    run = replicate.configuration.module.run
    with mock.patch("time.monotonic", lambda: 1e6 * clock()), contextlib.suppress(Killed):
        run(replicate, None, killed_at(0.5), checkpoint=Path("run.npz"))
    assert Path("run.npz").is_file()


def bytes_of(folder):
    """The bytes of all files below a folder."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def check_sentences(text):
    """What a user reads are sentences, one a line, after the progress lines of a log; or what Python says of
    a file."""
    lines = [line.rstrip() for line in text.strip().splitlines()]
    lines = [line for line in lines if not re.match(r"\d{4}-\d\d-\d\d |\[Errno ", line)]
    assert text.strip() and len(lines) <= LISTED + 1, text
    assert all(line.endswith((".", "?")) and line.isprintable() for line in lines), text


def command(folder, line, bad=False):
    """Result of a command that keeps its promises: status, sentences, no file lost or left over.

    A file that it names it may make, replace or remove if it succeeds; bad: whether it must be refused.
    """
    files_before = bytes_of(folder)
    result = called(line)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code in (0, 1, 2), line
    assert result.exit_code or not bad, (line, result.output)
    free = {"new", "new.nc", "run.npz"} & set(line.split())
    if result.exit_code:
        check_sentences(result.stderr)
        free = set()
    files_after = bytes_of(folder)
    for path in files_before.keys() | files_after.keys():
        if path.relative_to(folder).parts[0] not in free:
            assert files_before.get(path) == files_after.get(path), (path, line)
    return result


# Kinds of input


def places(tree):
    """All places in a tree of dictionaries and lists: what has a value, and its key."""
    for key in tree if isinstance(tree, dict) else range(len(tree)):
        yield tree, key
        if isinstance(tree[key], dict | list):
            yield from places(tree[key])


def a_configuration(rng, folder):
    """A configuration with a few values replaced, removed or added."""
    data = yaml.safe_load(SMOKE.read_text())
    for _ in range(rng.randint(1, 3)):
        at, key = rng.choice(list(places(data)))
        change = rng.choice(["value", "value", "key", "removal"])
        if change == "key" and isinstance(at, dict):
            key = rng.choice(["x", "Cylinder", "", 3, None])
        if change == "removal":
            del at[key]
        else:
            at[key] = copy.deepcopy(rng.choice(NASTY))
    parse(data)


STRANGE = b"&a [*a]", b"\t", b"{", b": :", b"<<: *a", b"\xff\xfe", b"- -", b"? "


def a_text(rng, folder):
    """A configuration with characters changed, lines lost or strange bytes in it."""
    text = bytearray(SMOKE.read_bytes())
    for _ in range(rng.randint(1, 20)):
        at = rng.randrange(len(text))
        lost = rng.choice([0, 1, rng.randint(1, 40)])
        text[at : at + lost] = rng.choice([b"", rng.randbytes(1), *STRANGE])
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
    density = rng.choice(["3900", "3900", "5e-324", "1e300"])
    command(folder, SIMULATE.replace("3900", density))


# a file, and the command that reads it
DAMAGED = {
    "run.npz": f"{SIMULATE} --checkpoint run.npz",
    "drag.nc": "info drag.nc",
    "rep.nc": "figure figure13 rep.nc -o new",
    "batch": "combine --config q.yaml --block drag --observable drag -o new.nc",
}
WHOLE = {"run.npz": "rep.nc", "batch": "drag.nc"}  # the file with what is then made


def a_damaged_file(rng, folder):
    """A file that is cut off, has some bits turned round, or is something else. What is made of it is right."""
    name = rng.choice(list(DAMAGED))
    (batch,) = (folder / "results/store/batches").glob("*.nc")
    file = batch if name == "batch" else folder / name
    content, whole = bytearray(file.read_bytes()), contents(folder / WHOLE.get(name, name))
    how = rng.choice(["cut", "flipped", "foreign"])
    if how == "cut":
        del content[rng.randrange(len(content)) :]
    elif how == "foreign":
        head = [b"", b"CDF\x01", b"\x89HDF\r\n\x1a\n", b"PK\x03\x04", b"\x93NUMPY"]
        content = rng.choice(head) + rng.randbytes(3000)
    else:
        for _ in range(rng.choice([1, 1, 10])):
            content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)
    bad = how == "foreign" or (name == "rep.nc" and how == "cut")
    result = command(folder, DAMAGED[name], bad)
    if result.exit_code == 0 and name in WHOLE:
        assert differing(contents(folder / "new.nc"), whole) == []


KINDS = a_configuration, a_text, an_extreme_value, a_damaged_file


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
                except (dem.InputError, dem.RunError) as error:
                    check_sentences(str(error))

    one()
