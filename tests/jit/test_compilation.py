"""Machine code is found again wherever the same sources lie, and never that of others: asked of a kernel in a
file of one's own, as dem/jit/README.md shows it, in processes of their own."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from project import LAW, ROOT, posix

README = (ROOT / "dem/jit/README.md").read_text()
IMPORT = re.search(r"^from \S+ import kernel$", README, re.M)[0]
KERNELS = f"""
{IMPORT}

def weight(mass, i):
    return 2.0 * mass[i]

def total(mass):
    result = 0.0
    for i in range(len(mass)):
        result += weight(mass, i)
    return result

def count(mass):
    return 3.0 * len(mass)

total, count = kernel(total), kernel(count)
"""
ASK = """
import numpy as np
from kernels import count, total
print(total(np.ones(2)), count(np.ones(2)))
"""


class Desk:
    """A folder with a user's file, and where the machine code is kept."""

    def __init__(self, folder):
        self.folder, self.cache = folder, folder / "cache"
        (folder / "kernels.py").write_text(KERNELS)

    def start(self, sources=ROOT, ask=ASK):
        """A process that uses the sources of some folder."""
        paths = f"{self.folder}{os.pathsep}{sources}"
        environment = os.environ | {"NUMBA_CACHE_DIR": str(self.cache), "PYTHONPATH": paths}
        words, pipe = [sys.executable, "-P", "-c", ask], subprocess.PIPE
        return subprocess.Popen(
            words, cwd=self.folder, env=environment, stdout=pipe, stderr=pipe, text=True
        )

    def ask(self, *args, **options):
        """What a process answers, and whether it says, once, that it compiles."""
        return answer_of(self.start(*args, **options))

    def edit(self, name, old, new):
        """A later second: Python takes a file of the same second and size for the one that it read before."""
        file = self.folder / name
        later = file.stat().st_mtime + 2
        file.write_text(file.read_text().replace(old, new))
        os.utime(file, (later, later))


def answer_of(process):
    answer, said = process.communicate()
    assert process.returncode == 0, said
    assert [line[:10] for line in said.splitlines()] in ([], ["Compiling "]), said
    return answer.split(), bool(said)


@pytest.fixture
def desk(tmp_path):
    return Desk(tmp_path)


@pytest.mark.quick
def test_copies_share_kernels_and_edits_do_not(desk):
    """Another copy of the same sources compiles nothing, nor does a comment; a line of code does, of the
    library or of one's own file, whose new numbers count."""
    ignore = shutil.ignore_patterns("__pycache__")
    for name in ("first", "second"):
        shutil.copytree(ROOT / "dem", desk.folder / name / "dem", ignore=ignore)
    assert desk.ask(desk.folder / "first") == (["4.0", "6.0"], True)
    desk.edit("second/dem/jit/kernel.py", "\nimport gc", "\n# edited\nimport gc")
    desk.edit("kernels.py", "return 2.0", "# edited\n    return 2.0")
    assert desk.ask(desk.folder / "second") == (["4.0", "6.0"], False)
    desk.edit("kernels.py", "3.0 *", "5.0 *")
    assert desk.ask(desk.folder / "second") == (["4.0", "10.0"], True)
    desk.edit("second/dem/jit/kernel.py", "\nimport gc", "\nEDITED = True\nimport gc")
    assert desk.ask(desk.folder / "second") == (["4.0", "10.0"], True)


PUSH = f"""
{IMPORT}
from dem.laws.protocol import force

def push(law, overlap):
    return force(law, 1.0, overlap, 1.0)
"""
ASK_PUSH = """
from cones import Cone
from push import kernel, push
print(kernel(push, classes=(Cone,))(Cone(), 3.0))
"""
EDITED = """
import cones, importlib
code = open("cones.py").read().replace("overlap * overlap\\n", "overlap\\n", 1)
open("cones.py", "w").write(code)
importlib.reload(cones)
print(kernel(push, classes=(cones.Cone,))(cones.Cone(), 3.0))
"""


@pytest.mark.quick
def test_machine_code_for_a_law_of_ones_own_is_known_by_the_code_of_its_file(desk):
    """Which the kernel that asks it does not import; as Python has it, which may import it again. It is not kept for a
    class of a function, which may depend on more than is written in its file."""
    law = desk.folder / "cones.py"
    law.write_text(LAW)
    (desk.folder / "push.py").write_text(PUSH)
    assert [desk.ask(ask=ASK_PUSH) for _ in range(2)] == [(["9.0"], True), (["9.0"], False)]
    assert desk.ask(ask=ASK_PUSH + EDITED) == (["9.0", "3.0"], True)
    assert desk.ask(ask=ASK_PUSH) == (["3.0"], False)
    local = LAW.replace("\n", "\n    ")
    law.write_text(f"def make():\n    {local}\n    return Cone\n\nCone = make()\n")
    assert [desk.ask(ask=ASK_PUSH) for _ in range(2)] == [(["9.0"], True)] * 2


TIMED = """
import os
from dem.jit.kernel import computing
import numpy as np
from kernels import count, total
before, started = computing(), sum(os.times()[:4])  # with the processes that compile
total(np.ones(2)), count(np.ones(2)), total(np.ones(2, "f4"))
print(computing() - before, sum(os.times()[:4]) - started)
"""


@pytest.mark.quick
def test_the_time_of_a_run_is_without_compiling(desk):
    """Of all kernels, so that the first run of a kind of scene is not noted as one that takes a minute."""
    (computed, spent), _ = desk.ask(ask=TIMED)
    assert -0.01 < float(computed) < 0.1 * float(spent)


ASK_MORE = f"{ASK}print(total(np.ones(2, 'f4')))\n"


def test_damaged_machine_code_is_compiled_again(desk):
    """The run goes on, and mends the cache: of three files one is empty, one is cut and one has a flipped bit."""
    answer = ["4.0", "6.0", "4.0"]
    assert desk.ask(ask=ASK_MORE) == (answer, True)
    files = list(desk.cache.rglob("*.nbc"))
    flipped = bytearray(files[2].read_bytes())
    flipped[len(flipped) // 2] ^= 1
    damages = b"", files[1].read_bytes()[:1000], flipped
    for file, damage in zip(files, damages, strict=True):
        file.write_bytes(damage)
    assert [desk.ask(ask=ASK_MORE) for _ in range(2)] == [(answer, True), (answer, False)]


def test_of_processes_that_want_the_same_one_compiles_it(desk):
    """The others wait for it."""
    answers = list(map(answer_of, [desk.start() for _ in range(3)]))
    assert sorted(answers) == [(["4.0", "6.0"], compiled) for compiled in (False, False, True)]


FULL = "import resource, sys; sys.dont_write_bytecode = True; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"


@posix
def test_a_cache_that_cannot_be_written_does_not_stop_a_run(desk):
    """On a full disk, or where a file is in the place of the folder; nothing is left there."""
    assert desk.ask(ask=FULL + ASK) == (["4.0", "6.0"], True)
    assert not [file for file in desk.cache.rglob("*") if file.suffix in (".nbc", ".part")]
    shutil.rmtree(desk.cache)
    desk.cache.write_text("a file")
    assert desk.ask() == (["4.0", "6.0"], True)


BOUNCE = """
import dem
import numpy as np
n, time = {}
rng = np.random.default_rng(1)
x, y = np.meshgrid(np.arange(n), np.arange(n))
scene = dem.Scene(
    dem.Disc(rng.uniform(0.7e-3, 1e-3, n * n)), dem.Material(restitution=0.5), dem.Friction(),
    walls=dem.box(n * 2e-3, n * 2e-3), gravity=(0.0, -9.81),
)
state = dem.State(1e-3 + 2e-3 * np.column_stack([x.ravel(), y.ravel()]), rng.normal(size=(n * n, 2)))
result = dem.simulate(scene, state, time)
print(*(number.hex() for number in result.velocity[-1].ravel()), result.simulation.steps)
"""
BESIDE = (
    "import threading, time; threading.Thread(target=time.sleep, args=(600,), daemon=True).start()"
)
FEW, MANY = BOUNCE.format("2, 1.5e-4"), BOUNCE.format("8, 1e-2")


def test_a_run_is_the_same_from_disk_and_as_plain_python(desk, monkeypatch):
    """Discs collide with each other and with walls: the bits are those of the process that compiled,
    beside another thread too; plain Python rounds otherwise."""
    first = desk.ask(ask=BESIDE + MANY)[0]
    assert desk.ask(ask=MANY)[0] == first
    *compiled, steps = desk.ask(ask=FEW)[0]
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    *plain, number = desk.ask(ask=FEW)[0]
    assert number == steps
    assert list(map(float.fromhex, plain)) == pytest.approx(
        list(map(float.fromhex, compiled)), 1e-9
    )


# A part so long that LLVM calls it
SHIFTED = f"""
{IMPORT}
import math
from dem.jit.intrinsics import noinline
SHIFT = 1.0

def part(x):
    noinline()
{60 * f"    x = math.cos(x) + SHIFT{chr(10)}"}
    return x

def shifted(x):
    return part(x) + part(2.0 * x)
"""
ASK_SHIFTED = """
from shifted import kernel, shifted
print(*(kernel(shifted, SHIFT=shift)(1.0) for shift in {}))
"""


@pytest.mark.quick
def test_kernels_that_other_processes_have_compiled_keep_their_own_constants(desk, monkeypatch):
    """Of two parts of one name the linker would take one for both; so named where sets have one order."""
    monkeypatch.setenv("PYTHONHASHSEED", "0")
    (desk.folder / "shifted.py").write_text(SHIFTED)
    one, two, both = (
        desk.ask(ask=ASK_SHIFTED.format(shifts))[0] for shifts in ([1.0], [2.0], [1.0, 2.0])
    )
    assert one != two
    assert both == one + two
