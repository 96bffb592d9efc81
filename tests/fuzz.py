"""Bad input at random: configurations, texts, command lines, arrays, files; never a traceback or a hang.

    python tests/fuzz.py 10000 [seed]

An input may be taken or refused with a sentence (InputError, RunError, exit status 1 or 2); anything
else counts as a fault, is printed with its seed, and makes the exit status 1.
"""

import copy
import faulthandler
import math
import random
import shutil
import signal
import sys
import tempfile
import traceback
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

import netCDF4
import numpy as np
import yaml
from typer.testing import CliRunner

import dem
from dem.cli import app
from dem.config import load, parse
from dem.dataset import VARIABLES
from dem.errors import InputError, RunError

ROOT = Path(__file__).parent.parent
LONGEST = 60  # s: more is a hang
NASTY = (
    math.nan, math.inf, -math.inf, -1, 0, -0.0, 1, 2**31, 2**63, 10**400, 1e-300, 1e300, -1e300, 1e15,
    True, None, "", " ", "nan", "inf", "1e400", "c1", "../../etc", "/tmp/x", "results/../..", "é\u0000x",
    "a" * 5000, "!!python/object/apply:os.system [id]", "${HOME}", "$(id)", "; rm -rf x", [], {}, [[]],
    [1, 2, 3], {"low": 1, "high": 0}, {"a": {"b": {}}}, [math.nan], list(range(200)), -5, 0.5, 3,
)  # fmt: skip


class Hang(Exception):
    """It took too long."""


@contextmanager
def limited(seconds=LONGEST):
    def ring(*_):
        raise Hang

    old = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, old)


def places(tree, path=()):
    """All places in a tree of dictionaries and lists."""
    items = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
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
            at[rng.choice(["x", "Cylinder", "", 3, None, "__class__"])] = copy.deepcopy(
                rng.choice(NASTY)
            )
        if not list(places(data)):
            break
    return data


def a_configuration(rng, folder):
    parse(spoiled(yaml.safe_load((ROOT / "config/smoke.yaml").read_text()), rng))


def a_text(rng, folder):
    """The file with characters changed, lines lost or strange bytes in it."""
    text = bytearray((ROOT / "config/smoke.yaml").read_bytes())
    for _ in range(rng.randint(1, 20)):
        at = rng.randrange(len(text))
        action = rng.random()
        if action < 0.4:
            text[at] = rng.randrange(256)
        elif action < 0.7:
            del text[at : at + rng.randint(1, 40)]
        else:
            text[at:at] = rng.choice(
                [
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
                ]
            )
        if not text:
            break
    file = folder / "fuzz.yaml"
    file.write_bytes(bytes(text))
    load(file)


VERBS = {
    "simulate": ("--config", "--shape", "--density", "--seed", "--bed", "--threads", "-o"),
    "pack": ("--config", "--shape", "--seed", "-o"),
    "batch": ("--config", "--shape", "--number", "-o"),
    "combine": ("--config", "-o"),
    "flow": ("--config", "-o"),
    "figure": ("-o",),
    "info": (),
    "calibrate": ("--config", "--shape", "--density", "--target", "--seeds", "-j"),
    "compile": ("--config", "--shape"),
    "film": ("-o", "--color"),
    "picture": ("-o", "--displacement", "--color"),
    "export": ("-o",),
    "report": ("-o", "--flow", "--readme"),
    "benchmark": ("--config", "-o"),
}
WORDS = (
    "c1", "x9", "", "nan", "inf", "-1", "0", "1e300", "1e-300", "-5", "99999999999999999999", "3900",
    "config/none.yaml", "README.md", "pyproject.toml", "/dev/null", "/", ".", "é", "--", "-h2", "a b",
    "figure13", "all", "\u202e", "config/smoke.yaml\n",
)  # fmt: skip


def a_command_line(rng, folder):
    """A verb with options that can not all be right: its configuration is never a good one."""
    verb = rng.choice(list(VERBS))
    arguments = [verb]
    for option in VERBS[verb]:
        if rng.random() < 0.8:
            word = rng.choice(WORDS)
            arguments += [option, str(folder / "out" / "file.nc") if option == "-o" else word]
    arguments += [rng.choice(WORDS) for _ in range(rng.randint(0, 2))]
    if "--config" in VERBS[verb]:
        arguments += ["--config", rng.choice(["config/none.yaml", "README.md", "/", str(folder)])]
    result = CliRunner().invoke(app, arguments)
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    if result.exit_code not in (0, 1, 2):
        raise AssertionError(f"exit status {result.exit_code} of {arguments}")
    if (folder / "out").exists() and result.exit_code:
        raise AssertionError(f"{arguments} wrote {list((folder / 'out').rglob('*'))}")


NUMBERS = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e300, -1e300, 1e-300, 1e-3, 1.0, 1e150)


def an_array(rng, folder):
    """A scene and a state of a few granules with something wrong in it."""
    n = rng.choice([0, 1, 2, 3])
    # one kind of machine code: what is absent or zero would be compiled anew, not refused
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

    kind = rng.choice(["disc", "dumbbell", "ellipse"])
    size = numbers(n)
    if kind == "disc":
        shape = dem.Disc(size)
    elif kind == "dumbbell":
        shape = dem.Dumbbell(size)
    else:
        shape = dem.Ellipse(size, numbers(n, good=0.7e-3))
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
    dem.simulate(scene, state, duration, step, frames=rng.choice([1, 1, 0, -1, 1.5]))


def a_damaged_file(rng, file):
    """A netCDF file with the variables of drag.nc and of a replicate, some of its bytes turned round."""
    with netCDF4.Dataset(file, "w") as made:
        made.setncatts(
            {"configuration": "{}", "window_start": 0.0, "window_stop": 1.0, "run_key": "x"}
        )
        for name, (dims, _, _) in VARIABLES.items():
            for dim in dims:
                if dim not in made.dimensions:
                    made.createDimension(dim, 40)
            made.createVariable(name, "f8", dims, zlib=bool(dims))[...] = rng.random()
    content = bytearray(file.read_bytes())
    for _ in range(rng.choice([0, 1, 10, 1000])):
        content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    file.write_bytes(bytes(content))


def a_file(rng, folder):
    """Bytes that are no replicate, the beginning of a netCDF file, or a damaged one, given to readers."""
    file = folder / "fuzz.nc"
    if rng.random() < 0.5:
        a_damaged_file(rng, file)
    else:
        head = rng.choice([b"", b"CDF\x01", b"CDF\x05", b"\x89HDF\r\n\x1a\n", b"PK\x03\x04"])
        file.write_bytes(head + rng.randbytes(rng.choice([0, 10, 3000])))
    verb = rng.choice(
        [
            ["info"],
            ["figure", "figure13"],
            ["picture", "-o", str(folder / "a.png")],
            ["claims", "test"],
            ["combine", "--config", "config/smoke.yaml", "-o", str(folder / "o.nc")],
        ]
    )
    result = CliRunner().invoke(app, [*verb, str(file)])
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    if result.exit_code not in (0, 1, 2):
        raise AssertionError(f"exit status {result.exit_code} of {verb}")


KINDS = {a_configuration: 10, a_text: 5, a_command_line: 3, an_array: 6, a_file: 1}


def one(seed: int, kinds=KINDS) -> str:
    """What came of one input: taken, refused, or a fault with its traceback."""
    rng, folder = random.Random(seed), Path(tempfile.mkdtemp())
    # a signal is answered only between kernels: one that never ends stops all, with a trace of where
    faulthandler.dump_traceback_later(2 * LONGEST, exit=True)
    kind = rng.choices(list(kinds), kinds.values())[0]
    try:
        with limited(), np.errstate(all="ignore"):
            kind(rng, folder)
        return "taken"
    except (InputError, RunError) as error:
        return "refused" if str(error).strip() else "fault: refused without a word"
    except Hang:
        return f"fault: {kind.__name__} hung for {LONGEST} s"
    except Exception:
        return f"fault: {kind.__name__}\n{traceback.format_exc(limit=-4)}"
    finally:
        faulthandler.cancel_dump_traceback_later()
        shutil.rmtree(folder, ignore_errors=True)


def main(count: int, first: int = 0, kinds=KINDS) -> int:
    """Number of faults among so many inputs, of kinds by their weights."""
    found = Counter()
    for seed in range(first, first + count):
        outcome = one(seed, kinds)
        found[outcome.partition(":")[0]] += 1
        if outcome.startswith("fault"):
            print(f"seed {seed}: {outcome}", flush=True)
    print(f"{count} inputs:", ", ".join(f"{n} {what}" for what, n in found.items()))
    return found["fault"]


if __name__ == "__main__":
    arguments = [int(word) for word in sys.argv[1:]]
    sys.exit(main(*(arguments or [1000])) > 0)
