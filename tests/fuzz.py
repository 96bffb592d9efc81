"""Bad input at random: configurations, command lines, paths, arrays, files; no traceback, hang or loss.

    python tests/fuzz.py 10000 [seed] [quick]     quick: without the kinds that compile

An input may be taken, or refused with a sentence (InputError, RunError, exit status 1 or 2). A fault
is all else: a traceback, more than LONGEST seconds, the death of the process, a file of the inputs
that is lost or changed, one that nobody asked for, damage that is not noticed, nonsense that is
taken. Faults are printed with their seeds, and make the exit status 1.

Each kind of input is a function of a random number generator and of the folder that it works in.
Inputs run in a forked process, so that neither a segmentation fault nor a kernel that does not end
stops the others.
"""

import atexit
import contextlib
import copy
import decimal
import fractions
import functools
import hashlib
import importlib.util
import math
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import stat
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from pathlib import Path

import netCDF4
import numpy as np
import yaml
from numba.core import event
from typer.testing import CliRunner

import dem
from dem.base.errors import InputError, RunError
from dem.base.schema import MOST_SENTENCES
from dem.cli.app import app
from dem.experiment.warmup import compile_kernels
from dem.io.dataset import read
from dem.sweep.config import load, parse

try:  # a file of results may end with its checksum
    from dem.io.checksums import seal as reseal
except ImportError:

    def reseal(path):
        """There are none."""


ROOT = Path(__file__).parent.parent
SMOKE = ROOT / "config/smoke.yaml"
LONGEST = 20  # s: more is a hang
COMPILATION = 600  # s: more is one of the compiler
MEMORY = 6 * 2**30  # bytes of address space: an input that asks for more gets a MemoryError
MANY = MOST_SENTENCES + 1  # sentences about a configuration, the last one counting the rest
NASTY = (
    math.nan, math.inf, -math.inf, -1, 0, -0.0, 1, 2**31, 2**63, 10**400, 1e-300, 1e300, -1e300, 1e15,
    True, None, "", " ", "nan", "inf", "1e400", "c1", "../../etc", "/tmp/x", "results/../..", "é\u0000x",
    "a" * 5000, "!!python/object/apply:os.system [id]", "${HOME}", "$(id)", "; rm -rf x", [], {}, [[]],
    [1, 2, 3], {"low": 1, "high": 0}, {"a": {"b": {}}}, [math.nan], list(range(200)), -5, 0.5, 3, 5e-324,
)  # fmt: skip
EVIL = "<x-evil></script><script>evil()</script>[red]evil[/red]\x1b[31m\x07"


class Hang(BaseException):
    """It took too long; nothing but the fuzzer may catch it."""


class Fault(Exception):
    """A promise to the user is broken."""


# Good files, made once


def _kept_folder() -> Path:
    """A folder until the end of this process; those that it forks leave it alone."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-good-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.cache
def good_files() -> Path:
    """Folder with one good file of each sort: a configuration and what the verbs make of it."""
    folder = _kept_folder()
    data = yaml.safe_load(SMOKE.read_text())
    data = dict(data)
    data |= {
        "sweep": {"case": "all", "seed": [1]},
        "results": "results",
        "shapes": {"c1": data["shapes"]["c1"]},
    }
    data |= {"cases": {"c1": data["cases"]["c1"]}, "record": data["record"] | {"snapshots": 3}}
    (folder / "q.yaml").write_text(yaml.safe_dump(data))
    for name in (
        "README.md", "docs/explanation/open.md", "pyproject.toml", "config/smoke.yaml",
    ):  # fmt: skip
        shutil.copy(ROOT / name, folder)
    (folder / "note.txt").write_text("A note that nobody may lose.\n")
    (folder / "sub").mkdir()
    (folder / "sub" / "keep.txt").write_text("Another.\n")
    (folder / "figures").mkdir()
    from PIL import Image

    Image.new("RGB", (40, 30)).save(folder / "figures" / "figure10.png")
    with contextlib.chdir(folder):
        for verb, output in [("simulate", "rep.nc")]:
            options = {k: v for k, v in GOOD[verb].items() if k != "--checkpoint"}
            result = CliRunner().invoke(app, words(verb, options | {"-o": output}))
            assert result.exit_code == 0, result.output
        _make_sweep()
        _make_checkpoint()
    return folder


def _make_sweep():
    """The store of the sweep with its only run, drag.nc and snapshots.nc."""
    from dem.sweep import batch as making
    from dem.sweep.combined import combine_block
    from dem.sweep.state import SweepState

    work = SweepState(load(Path("q.yaml")))
    (chunk,) = work.batches("drag")
    work.begin("drag")
    making.make(work.store, chunk.id)
    combine_block(work, "drag", "drag", Path("drag.nc"))
    combine_block(work, "drag", "snapshots", Path("snapshots.nc"))


def _make_checkpoint():
    """The checkpoint of a run that was stopped in the middle: run.npz."""
    from dem.experiment.bed import make_bed
    from dem.experiment.kinds import drag

    def stop(done):
        if done >= 0.5:
            raise KeyboardInterrupt

    often, drag.SAVED_EVERY = drag.SAVED_EVERY, 0.0
    replicate = load("q.yaml").replicate("c1", 3.9e3, 1)
    with contextlib.suppress(KeyboardInterrupt):
        drag.run(replicate, make_bed(replicate), stop, checkpoint=Path("run.npz"))
    drag.SAVED_EVERY = often
    assert Path("run.npz").is_file()


# verb: its options and arguments (those without a dash), all good
RUN = {"--config": "q.yaml", "--shape": "c1", "--density": "3900", "--seed": "1"}
GOOD = {
    "simulate": RUN | {"--threads": "1", "--checkpoint": "run.npz", "-o": "new.nc"},
    "combine": {"--config": "q.yaml", "--block": "drag", "--observable": "drag", "-o": "new.nc"},
    "store": {"value": "shape=c1"},
    "info": {"file": "drag.nc", "-o": "new.txt"},
    "draw": {"file": "rep.nc", "--displacement": "0.001", "--color": "layer", "-o": "new.png"},
    "figure": {"name": "figure13", "file": "drag.nc", "-o": "new"},
    "report": {"file": "drag.nc", "-o": "new.html"},
}  # fmt: skip


def words(verb: str, options: dict) -> list[str]:
    """A command line."""
    found = verb.split()
    for name, word in options.items():
        found += [name, word] if name.startswith("-") else [word]
    return found


def bring(folder, *names):
    """Copies of good files (of all, if none is named) in the folder."""
    for name in names or [path.name for path in good_files().iterdir()]:
        source = good_files() / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, folder / name)


# What may come of an input


def contents(folder: Path) -> dict[str, tuple]:
    """What lies at each path below a folder; links are not followed, devices not read."""
    found = {}
    for path in folder.rglob("*"):
        mode = path.lstat().st_mode
        if stat.S_ISLNK(mode):
            about = "link", str(path.readlink())
        elif stat.S_ISREG(mode):
            about = "file", hashlib.sha256(path.read_bytes()).hexdigest()
        else:
            about = stat.S_IFMT(mode), path.lstat().st_rdev
        found[str(path)] = about
    return found


def check_sentences(text: str, most: int):
    """What a user reads are sentences, one a line, after the progress lines of a log."""
    if text.lstrip().startswith("Usage:"):
        return  # of the command line's own parser
    lines = [line.rstrip() for line in text.strip().splitlines()]
    lines = [line for line in lines if not re.match(r"\d{4}-\d\d-\d\d ", line)]
    if not 0 < len(lines) <= most or not all(
        re.search(r"[.?]$", x) and x.isprintable() for x in lines
    ):
        raise Fault(f"this is not {'one sentence' if most == 1 else 'sentences'}: {text[:500]!r}")


def check_silence(warned):
    """No numpy warning comes before the sentence."""
    for each in warned:
        if issubclass(each.category, RuntimeWarning):
            raise Fault(f"a warning before the sentence: {each.message}")


def command(folder, line, output=None, loose=(), bad=False, most=1):
    """Result of a command, which keeps its promises: status, sentences, no file lost or left over.

    output: where it may write if it succeeds; loose: files that it may then remove or replace; bad:
    whether it must be refused.
    """
    before = contents(folder)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        result = CliRunner().invoke(app, line)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    if result.exit_code not in (0, 1, 2):
        raise Fault(f"exit status {result.exit_code} of {line}")
    if result.exit_code:
        check_sentences(result.stderr, most)
        check_silence(warned)
    after = contents(folder)
    target = os.path.realpath(output) if output is not None and not result.exit_code else None
    for path in before.keys() | after.keys():
        old, new = before.get(path), after.get(path)
        if old == new or (path in loose and not result.exit_code):
            continue
        is_output = target and (
            path == target or (old is None and f"{path}/".startswith(f"{target}/"))
        )
        is_parent = target and target.startswith(f"{path}/") and old is None
        if is_parent or (is_output and (old is None or old[0] == "file") and new):
            continue
        what = "lost" if new is None else "left over" if old is None else "changed"
        raise Fault(f"{path} is {what}; status {result.exit_code} of {line}")
    if bad and not result.exit_code:
        raise Fault(f"taken: {line}; it said {result.output[:300]!r}")
    return result


def values_of(file) -> dict:
    """Values and attributes of a netCDF file, but for those that tell when it was made."""
    with netCDF4.Dataset(file) as opened:
        opened.set_auto_mask(False)
        found = {name: np.asarray(each[...]) for name, each in opened.variables.items()}
        attributes = {name: np.asarray(opened.getncattr(name)) for name in opened.ncattrs()}
    attributes = {k: v for k, v in attributes.items() if not re.search("history|digest|sum|sha", k)}
    return {k: v for k, v in found.items() if k not in ("run_time", "spent")} | attributes


def check_same(found: dict, wanted: dict):
    """Damage has changed nothing that is read."""
    for name in wanted.keys() | found.keys():
        one, two = (np.asarray(each.get(name)) for each in (found, wanted))
        same = one.shape == two.shape and one.dtype == two.dtype and one.tobytes() == two.tobytes()
        if one.dtype == object:
            same = one.shape == two.shape and (one == two).all()
        if not same:
            raise Fault(f"damage not noticed: {name} is {one!s:.100} instead of {two!s:.100}")


# Kinds of input: configurations


def places(tree, path=()):
    """All places in a tree of dictionaries and lists."""
    items = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()  # fmt: skip
    for key, value in items:
        yield (*path, key)
        yield from places(value, (*path, key))


def spoiled(data, rng):
    """A copy with one to three values replaced, removed or added."""
    data = copy.deepcopy(data)
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
            new = rng.choice(["x", "Cylinder", "", 3, None, "__class__"])
            at[new] = copy.deepcopy(rng.choice(NASTY))
        if not list(places(data)):
            break
    return data


def a_configuration(rng, folder):
    """A configuration with a few values replaced, removed or added."""
    parse(spoiled(yaml.safe_load(SMOKE.read_text()), rng))


def an_extreme_value(rng, folder):
    """A run with one number of its configuration at the edge of what a computer can hold."""
    bring(folder, "q.yaml")
    data = yaml.safe_load((folder / "q.yaml").read_text())
    section = data[rng.choice(["material", "friction", "cylinder", "record", "shapes"])]
    section = section.get("c1", section)
    key = rng.choice([key for key, value in section.items() if not isinstance(value, str)])
    section[key] = rng.choice([5e-324, 1e-308, 1e-200, 1e-150, 1e-30, 1e15])
    (folder / "q.yaml").write_text(yaml.safe_dump(data))
    options = GOOD["simulate"] | {"--density": rng.choice(["3900", "3900", "5e-324", "1e300"])}
    unwanted = "--checkpoint", "--threads"
    options = {name: word for name, word in options.items() if name not in unwanted}
    command(folder, words("simulate", options), "new.nc", most=MANY)


BYTES = (
    b"&a [*a]",
    b"\t",
    b"{",
    b"]",
    b": :",
    b"!!binary x",
    b"<<: *a",
    b"\xff\xfe",
    b"- - -",
    b"? ",
)


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
            text[at:at] = rng.choice(BYTES)
        if not text:
            break
    (folder / "fuzz.yaml").write_bytes(text)
    load(folder / "fuzz.yaml")


def _bomb(text, rng):
    """Aliases nested ten deep, of lists or of groups of keys, in any place."""
    link = rng.choice(["[{}]", "{{{}}}"])
    each = [
        ", ".join(f"k{i}: *a{n}" if "{{" in link else f"*a{n}" for i in range(9)) for n in range(10)
    ]
    lines = ["bomb: &a0 " + link.format("k: 1" if "{{" in link else "1")]
    lines += [f"bomb{n}: &a{n + 1} {link.format(each[n])}" for n in range(10)]
    place = rng.choice(list(places(yaml.safe_load(text))))[0]
    body = re.sub(rf"(?ms)^{place}:.*?(?=^\S|\Z)", f"{place}: *a10\n", text)
    return "\n".join(lines) + "\n" + body


def _twice(text, rng):
    """A key, of the whole or of a part, that is there twice."""
    lines = text.splitlines()
    simple = [n for n, line in enumerate(lines) if re.match(r" *\w+: +[^ #]", line)]
    at = rng.choice(simple)
    return "\n".join([*lines[: at + 1], lines[at], *lines[at + 1 :]])


def a_yaml(rng, folder):
    """A configuration that no one can have meant: bombs, keys twice, other encodings, no file."""
    text, file = SMOKE.read_text(), folder / "fuzz.yaml"
    texts = {
        "bomb": _bomb(text, rng), "twice": _twice(text, rng),
        "nested": text.replace("title:", "title: " + rng.choice(["[", "{a: ", "- ", "? "]) * 20_000, 1),
    }  # fmt: skip
    spelled = text.replace("Smoke", "Smöke")
    sort = rng.choice([*texts, "twice", "utf-16", "latin-1", "utf-8 cut", "fifo", "zero", "folder"])
    if sort in texts:
        file.write_text(texts[sort])
    elif sort in ("utf-16", "latin-1"):
        file.write_text(spelled, encoding=sort)
    elif sort == "utf-8 cut":
        file.write_bytes(spelled.encode().partition("ö".encode())[0] + b"\xc3")
    elif sort == "fifo":
        os.mkfifo(file)
    elif sort == "zero":
        a_device(file, 5)
    else:
        file.mkdir()
    line = words("simulate", GOOD["simulate"] | {"--config": "fuzz.yaml"})
    command(folder, line, "new.nc", bad=sort != "utf-16", most=MANY)


# Kinds of input: command lines and paths

WORDS = (
    "c1", "x9", "", "nan", "inf", "-1", "0", "1e300", "1e-300", "-5", "99999999999999999999", "3900",
    "none.yaml", "README.md", "pyproject.toml", "/", ".", "é", "--", "-h2", "a b",
    "figure13", "all", "\u202e", "q.yaml ", str(2**63), "rep.nc", "x.npy",
)  # fmt: skip


def a_command_line(rng, folder):
    """A verb with options that cannot all be right: its configuration is never a good one."""
    bring(folder, "README.md", "pyproject.toml")
    verb = rng.choice(list(GOOD))
    options = {name: rng.choice(WORDS) for name in GOOD[verb] if rng.random() < 0.8}
    if "-o" in options:
        options["-o"] = "out/file.nc"
    if "--config" in GOOD[verb]:
        options["--config"] = rng.choice(["none.yaml", "README.md", "/", "."])
    more = [rng.choice(WORDS) for _ in range(rng.randint(0, 2))]
    command(folder, words(verb, options) + more, "out/file.nc")


NUMBER = ("nan", "inf", "-1", "x", "")
BAD = {
    "--seed": ("-1", str(2**63), str(2**70), "1.5", *NUMBER), "--density": ("0", "-inf", *NUMBER),
    "--threads": ("0", "100000", str(2**40), *NUMBER), "--target": ("0", "-inf", *NUMBER),
    "--displacement": ("1e9", "-inf", *NUMBER), "--shape": ("zz", "", "é", "c1 "), "--color": ("zz", ""),
    "value": ("gravty=1", "shape", "seed=", "density=x=y", ""),
    "--block": ("zz", ""), "--observable": ("zz", "", "snapshots"), "--checkpoint": ("x.npy", "q.yaml", "note.txt", "."),
    "--config": ("rep.nc", "README.md", "none.yaml", "."), "--seeds": ("1", "0", "1.5", *NUMBER), "-j": ("0", *NUMBER),
    "file": ("q.yaml", "run.npz", "none.nc", "."), "name": ("figure99", "", "../figure13"),
}  # fmt: skip


def an_option(rng, folder):
    """A good command line with one value that must be refused."""
    bring(folder)
    np.save(folder / "x.npy", np.ones(3))
    verb = rng.choice(list(GOOD))
    name = rng.choice([each for each in GOOD[verb] if each in BAD])
    options = GOOD[verb] | {name: rng.choice(BAD[name])}
    command(folder, words(verb, options), options.get("-o"), bad=True)


def a_device(path: Path, minor: int):
    """A private null (3), zero (5) or full (7) device; a file where only root could make it."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, minor))
    except OSError:
        path.touch()


def odd_path(rng, folder) -> str:
    """One of the files of the folder, a link to it or another spelling of it; or no file at all."""
    name = rng.choice(["q.yaml", "rep.nc", "drag.nc", "run.npz", "note.txt"])
    plain = ["", ".", "sub", "figures", "note.txt/new.nc", "sub/deep/new.nc", "x" * 300, "\udcff.nc", "a\nb.nc",
             "fifo", "null", "full", "zero"]  # fmt: skip
    links = {"dangling": "nowhere.nc", "loop": "loop", "tosub": "sub", "tonull": "null", "to": name}
    made = rng.choice([name, name, "hard", "to", "spelled", *plain, *links])
    if made in links:
        (folder / made).symlink_to(links[made])
    elif made == "hard":
        (folder / made).hardlink_to(folder / name)
    elif made == "spelled":
        return rng.choice([f"sub/../{name}", f"./{name}", str(folder / name), f"sub//..//{name}"])
    elif made == "fifo":
        os.mkfifo(folder / made)
    if made in ("null", "zero", "full", "tonull"):
        minor = {"zero": 5, "full": 7}.get(made, 3)
        a_device(folder / made.removeprefix("to"), minor)
    return made


PATHS = ("-o", "-o", "--checkpoint", "--config", "file")
WRITES = {"simulate": 8, "combine": 3, "info": 4, "report": 1, "draw": 2, "figure": 1}  # fmt: skip


def a_path(rng, folder):
    """Paths that coincide, links, devices, folders and names that no file can have."""
    bring(folder)
    verb = rng.choices(list(WRITES), WRITES.values())[0]
    options = dict(GOOD[verb])
    options |= {rng.choice([p for p in PATHS if p in options]): odd_path(rng, folder)}
    if rng.random() < 0.2 and verb == "simulate":
        options["--checkpoint"] = options[rng.choice(["-o", "--config"])]
    real = {name: os.path.realpath(word) for name, word in options.items() if name in PATHS}
    written = [name for name in ("-o", "--checkpoint") if name in real]
    bad = any(real[name] == real[other] for name in written for other in real if other != name)
    saved, loose = Path(options.get("--checkpoint", ".")), ()
    with contextlib.suppress(OSError, RuntimeError):  # a loop of links, a name that is too long
        if saved.is_file() and saved.read_bytes() == (good_files() / "run.npz").read_bytes():
            loose = os.path.normpath(folder / saved), str(saved.resolve())
    command(folder, words(verb, options), options["-o"], loose, bad)


# Kinds of input: arrays and types

NUMBERS = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e300, -1e300, 1e-300, 1e-3, 1.0, 1e150)


def an_array(rng, folder):
    """A scene and a state of a few granules with something wrong in it."""
    n = rng.choice([0, 1, 2, 3])
    # one kind of machine code: what is absent or zero would be compiled, not refused
    wrong = [value for value in NUMBERS if value not in (0.0, 1.0)]

    def numbers(*shape, good=1e-3):
        array = np.full(shape, good)
        for _ in range(rng.choice([0, 0, 1, 2])):
            if array.size:
                array.flat[rng.randrange(array.size)] = rng.choice(NUMBERS)
        others = [array.tolist(), array.astype(object), array[..., None], array.astype(str), None]
        return rng.choice([array] * 6 + others)

    def often(good):
        return rng.choice([good, good, good, rng.choice(wrong)])

    kind, size = rng.choice([dem.Disc, dem.Dumbbell, dem.Ellipse]), numbers(n)
    shape = kind(size, numbers(n, good=0.7e-3)) if kind is dem.Ellipse else kind(size)
    material = dem.Material(often(3.9e3), often(70e9), often(0.22), often(0.5))
    friction = dem.Friction(often(0.3), often(0.3), often(0.3))
    walls = rng.choice([dem.box(1e-2, 1e-2)] * 4 + [numbers(2, 3), [[1, 0]]])
    if rng.random() < 0.1:
        walls = dem.box(1e-2, rng.choice(NUMBERS))
    cylinder = dem.Cylinder(often(1e-3), (5e-3, often(5e-3)), (0.0, often(1.0)))
    gravity = rng.choice([None, None, None, (0.0, rng.choice([math.nan, math.inf])), (1.0,)])
    scene = dem.Scene(shape, material, friction, walls, cylinder, gravity, often(1e-3))
    place = np.random.default_rng(rng.randrange(2**31)).uniform(0.0, 1e-2, (n, 2))
    if n and rng.random() < 0.4:
        place[0, 0] = rng.choice(NUMBERS)
    state = dem.State(
        rng.choice([place, place, numbers(n, 2)]),
        rng.choice([None, numbers(n, 2, good=0.1)]),
        rng.choice([None, numbers(n)]),
        rng.choice([None, numbers(n)]),
    )
    duration, step = rng.choice([1e-9, 1e-9, *NUMBERS[:7]]), rng.choice([None, None, *NUMBERS])
    dem.simulate(scene, state, duration, step, frames=rng.choice([1, 1, 0, -1, 1.5, np.int64(1)]))


JUNK = ("disc", 3, -1, [], {}, object(), len, math.nan, b"x", [None])
# what becomes of a good number or array; those of MUST are never to be taken
WRONG = {
    "masked": lambda x: np.ma.masked_array(np.asarray(x, float), mask=True),
    "complex": lambda x: np.asarray(x) + 1j if np.ndim(x) else complex(x, 1.0),
    "nan": lambda x: np.asarray(x) * math.nan if np.ndim(x) else math.nan,
    "infinite": lambda x: np.full(np.shape(x), math.inf) if np.ndim(x) else math.inf,
    "huge": lambda x: 10**400,
    "words": lambda x: "disc",
    "group": lambda x: {"a": x},
    "ragged": lambda x: [[1.0], [1.0, 2.0]],
    "object": lambda x: object(),
    "date": lambda x: np.full(np.shape(x), np.datetime64("2020-01-01")),
    "record": lambda x: np.zeros(np.shape(x), [("a", float)]),
    "deep": lambda x: [[[x]]],
    "text": lambda x: np.asarray(x).astype(str) if np.ndim(x) else str(x),
    "objects": lambda x: np.asarray(x, object),
    "truth": lambda x: np.asarray(x, bool) if np.ndim(x) else True,
    "decimal": lambda x: decimal.Decimal(str(x)) if np.ndim(x) == 0 else np.asarray(x).tolist(),
    "fraction": lambda x: fractions.Fraction(x) if np.ndim(x) == 0 else tuple(np.asarray(x)),
    "short": lambda x: np.asarray(x, np.float32)[()],
    "long": lambda x: np.asarray(x, np.longdouble)[()],
    "swapped": lambda x: np.asarray(x, ">f8"),
    "whole": lambda x: np.asarray(x).astype(int)[()],
    "strided": lambda x: np.repeat(np.asarray(x, float), 2, axis=0)[::2] if np.ndim(x) else -x,
    "matrix": lambda x: np.asmatrix(np.asarray(x, float)),
    "unmasked": lambda x: np.ma.masked_array(np.asarray(x, float)),
}
MUST = tuple(WRONG)[:12]
PUBLIC = ("Material", "Friction", "Cylinder", "box", "Disc", "Dumbbell", "Ellipse", "Scene", "State", "pack",
          "grow", "simulate", "Simulation", "advance", "record", "restore")  # fmt: skip


def a_wrong_type(rng, folder):
    """One argument of one public class or function that is masked, complex, text, of another type."""
    name, kind, changed = rng.choice(PUBLIC), rng.choice(list(WRONG)), []

    def make(called, function=None, **good):
        if called == name:
            key = rng.choice(list(good))
            numeric = isinstance(good[key], float | int | tuple | np.ndarray) and not hasattr(good[key], "_fields")  # fmt: skip
            good[key] = WRONG[kind](good[key]) if numeric else rng.choice(JUNK)
            changed.append(key if not numeric or kind in MUST else None)
        return (function or getattr(dem, called))(**good)

    sizes, place = np.full(3, 5e-4), np.array([[1e-3, 1e-3], [3e-3, 1e-3], [8e-3, 8e-3]])
    shape = make("Disc", radius=sizes)
    if name in ("Dumbbell", "Ellipse"):
        shape = make("Dumbbell", radius=sizes) if name == "Dumbbell" else make("Ellipse", semi_major=sizes, semi_minor=sizes / 2)  # fmt: skip
    material = make(
        "Material", density=3.9e3, young_modulus=7e10, poisson_ratio=0.22, restitution=0.5
    )
    friction = make("Friction", granule=0.3, wall=0.3, cylinder=0.3, stiffness=1.0)
    walls = make("box", width=1e-2, height=1e-2)
    cylinder = make("Cylinder", diameter=1e-3, position=(5e-3, 5e-3), velocity=(0.0, 1.0))
    scene = make("Scene", shape=shape, material=material, friction=friction, walls=walls, cylinder=cylinder, thickness=1e-3)  # fmt: skip
    state = make("State", position=place, velocity=0.1 * place, angle=np.ones(3), angular_velocity=np.ones(3))  # fmt: skip
    if name in ("pack", "grow"):
        make(name, shape=shape, width=1e-2, height=1e-2, cylinder=cylinder, seed=1)
    elif name == "simulate":
        make("simulate", scene=scene, state=state, duration=1e-9, time_step=1e-10, frames=1)
    elif name not in ("Dumbbell", "Ellipse"):  # whose kernels are those of an_array
        run = make("Simulation", scene=scene, state=state, time_step=1e-10, step_fraction=0.5, max_overlap=1.2, skin=0.12, threads=1)  # fmt: skip
        make("advance", run.advance, duration=1e-9)
        make("record", run.record, interval=1e-9, count=1)
        make("restore", run.restore, saved=run.checkpoint())
    if changed and changed[0]:
        raise Fault(f"taken: {changed[0]} of {name}, {kind}")


def three_discs(velocity=0.1, **more):
    """A simulation of three discs, of the one kind of machine code that all inputs use."""
    scene = dem.Scene(
        dem.Disc(np.full(3, 5e-4)), friction=dem.Friction(), walls=dem.box(1e-2, 1e-2),
        cylinder=dem.Cylinder(1e-3, (5e-3, 5e-3), (0.0, 1.0)), thickness=1e-3, **more,
    )  # fmt: skip
    place = np.array([[1e-3, 1e-3], [2e-3, 1e-3], [8e-3, 8e-3]])
    return dem.Simulation(scene, dem.State(place, np.full((3, 2), velocity)))


def a_long_run(rng, folder):
    """A run that would not end in days, or get no memory; also under a gravity that speeds it up."""
    pull = (
        {"gravity": (0.0, rng.choice([-1e20, -1e12, 1e20, -1e300]))} if rng.random() < 0.4 else {}
    )
    run = three_discs(rng.choice([0.1, 0.1, 1e3, 1e300]), **pull)
    long = rng.choice([1e9, 1e5, 1e300, 3e4])
    rng.choice([
        lambda: run.advance(long), lambda: run.record(long, 1), lambda: run.record(1e-9, 10**12),
        lambda: run.record(1e-3, 10**10), lambda: dem.simulate(run.scene, run.state, long),
        lambda: dem.simulate(run.scene, run.state, 1e-6, frames=10**7),
        lambda: run.advance(1e-3),
    ])()  # fmt: skip


# Kinds of input: damaged files


def flip(file: Path, rng, count=1):
    """Turn round some bits of a file."""
    content = bytearray(file.read_bytes())
    for _ in range(count):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(content)


def tampered(arrays: dict, rng) -> dict:
    """The arrays of a checkpoint, one of them replaced or gone."""
    name = rng.choice(list(arrays))
    array = np.asarray(arrays[name])
    others = [
        lambda: np.full_like(array, np.iinfo(array.dtype).max if array.dtype.kind in "iu" else 1e300),
        lambda: (-np.ones(array.shape)).astype(array.dtype), lambda: array[:0] if array.ndim else array[None],
        lambda: array.astype(complex), lambda: array.astype("f4"), lambda: array.astype(str),
        lambda: array.astype(object), lambda: np.full(array.shape, np.nan), lambda: array[None],
        lambda: np.full_like(array, np.nan) if array.dtype.kind == "f" else array[::-1] if array.ndim else -array,
        lambda: np.resize(array, 10 * array.size + 1), lambda: np.roll(array, 1), None,
    ]  # fmt: skip
    made = rng.choice(others)
    arrays = {key: value for key, value in arrays.items() if key != name or made}
    return arrays | {name: made()} if made else arrays


def a_restored_state(rng, folder):
    """A simulation that goes on from a checkpoint with an array that is not its own."""
    run = three_discs()
    run.advance(1e-9)
    saved = run.checkpoint()
    with contextlib.suppress(TypeError, ValueError):  # text of some arrays is no number
        saved = tampered(saved, rng)
    before = run.checkpoint()
    try:
        run.restore(saved)
    except InputError:
        check_same(run.checkpoint(), before)
        raise
    run.advance(1e-9)
    run.record(1e-9, 1)


def a_checkpoint(rng, folder):
    """dem simulate with a checkpoint with a strange array, or that is truncated or damaged."""
    bring(folder, "q.yaml", "run.npz")
    file = folder / "run.npz"
    damage = rng.choice(["array", "array", "cut", "flip", "header", "garbage"])
    if damage == "array":
        with file.open("rb") as raw, (folder / "other.npz").open("wb") as other:
            other.write(raw.readline())
            with np.load(raw) as opened, contextlib.suppress(TypeError, ValueError):
                np.savez(other, **tampered(dict(opened), rng))
        (folder / "other.npz").replace(file)
    elif damage == "cut":
        file.write_bytes(file.read_bytes()[: rng.randrange(file.stat().st_size)])
    elif damage == "header":
        file.write_bytes(
            re.sub(rb"\((\d+), (\d+)\)", rb"(9\2, \2)", file.read_bytes(), count=rng.randint(1, 9))
        )
    elif damage == "garbage":
        file.write_bytes(
            rng.choice([b"", b"PK\x03\x04", b"\x93NUMPY", b"\x80\x04", b"dem checkpoint "])
            + rng.randbytes(rng.choice([0, 50]))
        )
    else:
        flip(file, rng, rng.choice([1, 1, 10]))
    result = command(folder, words("simulate", GOOD["simulate"]), "new.nc", [str(file)])
    if result.exit_code == 0:
        found = values_of(folder / "new.nc")
        if damage != "array":
            check_same(found, values_of(good_files() / "rep.nc"))
        elif not all(np.isfinite(v).all() for v in found.values() if v.dtype.kind == "f"):
            raise Fault("a checkpoint with values that are not numbers is taken")


CHUNK = "the chunk of the store"


@functools.cache
def answer(verb: str, name: str):
    """What a verb makes of a good file: values by name."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        bring(Path(folder))
        return _answer(verb, Path(folder), name)


def _answer(verb, folder, name):
    if verb == "read":
        with netCDF4.Dataset(good_files() / name) as opened:
            names = tuple(opened.variables)
        values, attributes = read(folder / name, names)
        return values | {key: np.asarray(value) for key, value in attributes.items()}
    options = GOOD[verb] | {"file": name}
    if verb == "combine":
        del options["file"]
    for unwanted in ("--checkpoint", *(["-o"] if verb == "info" else [])):
        options.pop(unwanted, None)
    result = command(folder, words(verb, options), options.get("-o"))
    if result.exit_code:
        return None
    return {"text": np.asarray(result.stdout)} if verb == "info" else values_of(folder / "new.nc")


def a_flip(rng, folder):
    """A replicate, a bed or drag.nc with a bit turned round, given to all that reads it."""
    bring(folder, "q.yaml", "rep.nc", "drag.nc", "results")
    verb, name = rng.choice([
        ("read", "rep.nc"), ("info", "rep.nc"), ("combine", CHUNK),
        ("info", "drag.nc"),
    ])  # fmt: skip
    file = next((folder / "results/store/batches").glob("*.nc")) if name is CHUNK else folder / name
    flip(file, rng, rng.choice([1, 1, 1, 10]))
    wanted, found = answer(verb, name), _answer(verb, folder, name)
    if found is not None:
        check_same(found, wanted)


def a_file(rng, folder):
    """Bytes that are no netCDF file, or the beginning of one, given to readers."""
    bring(folder, "q.yaml", "rep.nc", "snapshots.nc")
    if rng.random() < 0.5:
        head = rng.choice([b"", b"CDF\x01", b"CDF\x05", b"\x89HDF\r\n\x1a\n", b"PK\x03\x04"])
        (folder / "fuzz.nc").write_bytes(head + rng.randbytes(rng.choice([0, 10, 3000])))
    else:
        content = (folder / "rep.nc").read_bytes()
        (folder / "fuzz.nc").write_bytes(content[: rng.randrange(len(content))])
    verb = rng.choice([verb for verb in GOOD if "file" in GOOD[verb]])
    options = GOOD[verb] | {"file": "fuzz.nc"}
    command(folder, words(verb, options), options.get("-o"), bad=True)


def _edit(file, rng):
    """Replace, remove or add text or values in a netCDF file."""
    with netCDF4.Dataset(file, "a") as opened:
        opened.set_auto_mask(False)
        name, variable = rng.choice(opened.ncattrs()), opened[rng.choice(list(opened.variables))]
        action = rng.choice(["remove", "number", "json", "evil", "nan", "nan", "rename", "kind"])
        if action == "remove":
            opened.delncattr(name)
        elif action in ("number", "json", "evil"):
            others = {"number": rng.choice([math.nan, -1, np.arange(3), 1e300]), "evil": EVIL}
            opened.setncattr(
                name, others.get(action, rng.choice(["{", "[]", "{}", "null", '{"record": 3}']))
            )
        elif action == "nan":
            if rng.random() < 0.5 and "drag" in opened.variables:
                variable = opened["drag"]
            if variable.dtype is not str and variable.dtype.kind == "f":
                variable[...] = rng.choice([math.nan, math.inf, -1e300, 0.0])
        elif action == "rename":
            opened.renameVariable(variable.name, "other")
        elif "kind" in opened.variables and opened["kind"].dtype is str:
            opened["kind"][...] = np.full(opened["kind"].shape, EVIL, object)
    if rng.random() < 0.8:  # as one would who means it
        reseal(file)


def _relabelled(file):
    """The file with another name of its case, as long as it needs."""
    with netCDF4.Dataset(file) as old, netCDF4.Dataset(file.with_suffix(".new"), "w") as new:
        old.set_auto_mask(False)
        new.setncatts(old.__dict__)
        for name, dimension in old.dimensions.items():
            new.createDimension(name, len(EVIL) if name == "case_length" else len(dimension))
        for name, variable in old.variables.items():
            made = new.createVariable(name, variable.dtype, variable.dimensions)
            made.setncatts({k: v for k, v in variable.__dict__.items() if k != "_FillValue"})
            for each in (variable, made):
                each.set_auto_chartostring(False)
            made[...] = np.array([list(EVIL)], "S1") if name == "case" else variable[...]
    file.with_suffix(".new").replace(file)
    reseal(file)


def a_tampered_file(rng, folder):
    """A file of results with other text or values in it; a page or a terminal never obeys its text."""
    bring(folder)
    verb = rng.choice(["info", "info", "figure", "draw", "report"])
    options = dict(GOOD[verb])
    if verb == "info":
        options = {"file": rng.choice(["rep.nc", "drag.nc", "snapshots.nc"])}
    if rng.random() < 0.3 and verb in ("info", "report"):  # text that a user may write
        text = (folder / "q.yaml").read_text()
        data = yaml.safe_load(text) | {"title": EVIL}
        (folder / "q.yaml").write_text(yaml.safe_dump(data))
        command(folder, words("combine", GOOD["combine"] | {"-o": "drag.nc"}), "drag.nc")
        (folder / "accuracy.txt").write_text(EVIL)
    elif rng.random() < 0.3:
        for name in ("drag.nc", "snapshots.nc"):
            _relabelled(folder / name)
    else:
        _edit(
            folder / (options["file"] if rng.random() < 0.8 or verb != "report" else "snapshots.nc"),
            rng,
        )
    result = command(folder, words(verb, options), options.get("-o"))
    if result.exit_code == 0:
        check_harmless(verb, folder, result)


def check_harmless(verb, folder, result):
    """Text of a file is shown, not obeyed."""
    shown = result.stdout
    if verb == "report":
        shown = (folder / "new.html").read_text(encoding="utf-8")
        if "<x-evil" in shown or "<script>evil" in shown:
            raise Fault("text of a file is part of the page's code")
    elif not shown.replace("\n", "").isprintable():
        raise Fault(f"control characters of a file reach the terminal: {shown[:300]!r}")
    elif "evil()" in shown and "</script>evil" in shown.replace("\n", ""):
        raise Fault(f"markup of a file is obeyed: {shown[:300]!r}")


TINY = """from dem.jit.compilation import compiled
@compiled
def total(array):
    return array[0] + 2.0 * array[1]
"""


def _total(folder: Path) -> tuple[int, str, str]:
    """Status and texts of a process that calls a compiled function with the cache in a folder."""
    out, pid = folder / "child.txt", os.fork()
    if not pid:
        status = 1
        with out.open("w") as file, contextlib.redirect_stderr(file):
            try:
                os.environ["NUMBA_CACHE_DIR"] = str(folder / "cache")
                spec = importlib.util.spec_from_file_location("tiny", folder / "tiny.py")
                module = sys.modules["tiny"] = importlib.util.module_from_spec(spec)
                spec.loader.exec_module(module)
                status = 0 if module.total(np.array([1.0, 2.0])) == 5.0 else 3
            except BaseException:
                traceback.print_exc()
        os._exit(status)
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    return status, out.read_text()


@functools.cache
def good_cache() -> Path:
    """A folder with the kept machine code of one small function."""
    folder = _kept_folder()
    (folder / "tiny.py").write_text(TINY)
    assert _total(folder)[0] == 0 and len(list((folder / "cache").rglob("*.nb?"))) == 2
    return folder


def a_cache(rng, folder):
    """Kept machine code that is truncated, empty, garbage or damaged: it is made again."""
    shutil.copytree(good_cache(), folder, dirs_exist_ok=True)
    file = rng.choice(sorted((folder / "cache").rglob("*.nb?")))
    content = file.read_bytes()
    action = rng.choice(["empty", "cut", "cut", "garbage", "flip", "folder", "zeros"])
    if action == "flip":
        flip(file, rng)
    elif action == "folder":
        file.unlink()
        file.mkdir()
    else:
        cut = content[: rng.randrange(len(content))]
        file.write_bytes(
            {"empty": b"", "cut": cut, "garbage": rng.randbytes(100)}.get(
                action, bytes(len(content))
            )
        )
    for _ in range(2):  # the second finds what the first has mended
        status, text = _total(folder)
        if status or len(text.splitlines()) > 2:
            raise Fault(f"{action} of {file.suffix}: status {status}, {text[-800:]}")


# kind: its weight
KINDS = {
    a_configuration: 14, an_extreme_value: 6, a_text: 6, a_yaml: 6, a_command_line: 8, an_option: 14, a_path: 14, an_array: 10,
    a_wrong_type: 16, a_long_run: 2, a_restored_state: 6, a_checkpoint: 6, a_flip: 14, a_file: 3,
    a_tampered_file: 6, a_cache: 2,
}  # fmt: skip
SLOW = (an_array, a_long_run, a_cache)  # they compile, or need all kinds of machine code


def warm_up(kinds):
    """Make files and machine code outside the limit of time."""
    good_files()
    if a_cache in kinds:
        good_cache()
    labels = ("c1", "d1", "e3") if an_array in kinds else ("c1",)
    for label in labels:
        compile_kernels(load(SMOKE).replicate(label, 3.9e3, 1))
    for more in ({}, {"gravity": (0.0, -9.8)}) if a_long_run in kinds else ({},):
        run = three_discs(**more)
        run.advance(1e-9)
        run.record(1e-9, 1)


# Runs of inputs

COMPILING, COMPILED = "compiling", "compiled"  # told instead of an outcome


class Stopwatch(event.Listener):
    """The alarm, which stands still while Numba compiles: machine code of another kind of input is
    made once, and an exception in the middle of it would be a fault of the fuzzer."""

    def __init__(self, tell):
        self.tell, self.depth, self.left = tell, 0, 0

    def on_start(self, event):
        if self.depth == 0:
            self.left = signal.alarm(0)
            self.tell(COMPILING)
        self.depth += 1

    def on_end(self, event):
        self.depth -= 1
        if self.depth == 0:
            self.tell(COMPILED)
            signal.alarm(self.left)


@contextlib.contextmanager
def limited(seconds=LONGEST, tell=lambda word: None):
    """Raise Hang after so many seconds without those of compilations, as far as a signal is answered."""

    def ring(*_):
        raise Hang

    old = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        with event.install_listener("numba:compile", Stopwatch(tell)):
            yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)


def one(seed: int, kinds=KINDS, folder: Path | None = None, tell=lambda word: None) -> str:
    """What came of one input: taken, refused, or a fault with its traceback. tell: is called when a
    compilation begins and ends."""
    rng, folder = random.Random(seed), folder or Path(tempfile.mkdtemp())
    kind = rng.choices(list(kinds), kinds.values())[0]
    folder.mkdir(exist_ok=True)
    try:
        with (
            warnings.catch_warnings(record=True) as warned,
            limited(tell=tell),
            contextlib.chdir(folder),
        ):
            warnings.simplefilter("always")
            try:
                kind(rng, folder.resolve())
            except (InputError, RunError) as error:
                check_sentences(str(error), MANY)
                check_silence(warned)
        return f"sound: {kind.__name__}"
    except Hang:
        return f"fault: {kind.__name__} hung for {LONGEST} s"
    except Fault as fault:
        return f"fault: {kind.__name__}: {fault}"
    except Exception:
        return f"fault: {kind.__name__}\n{traceback.format_exc(limit=-4)}"
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _work(pipe, seeds, kinds, folder):
    """Send what comes of each input."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for seed in seeds:
        pipe.send(one(seed, kinds, folder / str(seed), pipe.send))


def outcomes(seeds, kinds):
    """(seed, what came of it); a process that dies or does not answer is a fault, and the next goes on."""
    warm_up(kinds)
    fork, seeds = multiprocessing.get_context("fork"), list(seeds)
    with tempfile.TemporaryDirectory(prefix="fuzz-", ignore_cleanup_errors=True) as folder:
        while seeds:
            ours, theirs = fork.Pipe(duplex=False)
            worker = fork.Process(target=_work, args=(theirs, seeds, kinds, Path(folder)))
            worker.start()
            theirs.close()
            with contextlib.suppress(EOFError):
                since, patience = time.monotonic(), LONGEST + 5
                while seeds and ours.poll(patience):
                    outcome = ours.recv()
                    patience = COMPILATION if outcome == COMPILING else LONGEST + 5
                    if outcome not in (COMPILING, COMPILED):
                        yield seeds[0], outcome
                        since, seeds = time.monotonic(), seeds[1:]
            if seeds:
                kind = random.Random(seeds[0]).choices(list(kinds), kinds.values())[0].__name__
                worker.join(1)
                died = worker.exitcode
                worker.kill()
                what = f"hung for {LONGEST} s in a kernel"
                if died is not None:
                    what = f"died, status {died}, after {time.monotonic() - since:.0f} s"
                yield seeds[0], f"fault: {kind} {what}"
                seeds = seeds[1:]
            worker.join()


def main(count: int, first: int = 0, kinds=KINDS) -> int:
    """Number of faults among so many inputs, of kinds by their weights."""
    found, faults = Counter(), Counter()
    for seed, outcome in outcomes(range(first, first + count), kinds):
        sort, name = re.match(r"(\w+): (\w+)", outcome).groups()
        found[name] += 1
        faults[name] += sort == "fault"
        if sort == "fault":
            print(f"seed {seed}: {outcome}", flush=True)
    print(f"{count} inputs, {faults.total()} faults:", flush=True)
    print(*(f"  {name} {n}, faults {faults[name]}" for name, n in found.items()), sep="\n")
    return faults.total()


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    slow = () if "quick" not in sys.argv else SLOW
    kinds = {kind: weight for kind, weight in KINDS.items() if kind not in slow}
    sys.exit(main(*(numbers or [1000]), kinds=kinds) > 0)
