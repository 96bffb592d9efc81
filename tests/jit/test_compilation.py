"""Machine code is found again wherever the same sources lie, and never that of others."""

import importlib
import os
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import NamedTuple

import numpy as np
import pytest
from filelock import FileLock
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.core.runtime._nrt_python import memsys_enable_stats
from project import posix

import dem
from dem.base.source_hash import ROOT
from dem.dynamics.assembly import SKIN_OF_PACKING, assemble, granule_table
from dem.dynamics.energy import kinetic
from dem.jit import compilation
from dem.jit.address import FEW, local
from dem.jit.compilation import compiled, computing, inlined
from dem.packing.minimise import settle

ASK = """
from dem.dynamics.stepping import quantised
quantised(0.1)
print(*(sum(count.values()) for count in (quantised.stats.cache_hits, quantised.stats.cache_misses)))
"""


def cache_counts(folder, cache):
    """Hits and misses of one kernel in a process that uses the sources in a folder."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(folder)}
    process = subprocess.run(
        [sys.executable, "-c", ASK], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr
    return tuple(map(int, process.stdout.split()))


@pytest.mark.quick
def test_copies_share_kernels_and_edits_do_not(tmp_path):
    """Another copy of the same sources compiles nothing, nor does a comment; a line of code does, also
    one of a shape, which no kernel imports."""
    ignore = shutil.ignore_patterns("__pycache__")
    for name in ("first", "second"):
        shutil.copytree(ROOT / "dem", tmp_path / name / "dem", ignore=ignore)
    assert cache_counts(tmp_path / "first", tmp_path / "cache") == (0, 1)
    assert cache_counts(tmp_path / "second", tmp_path / "cache") == (1, 0)
    for name, line, expected in (
        ("jit/columns.py", "# edited", (1, 0)),
        ("jit/columns.py", "EDITED = True", (0, 1)),
        ("shapes/disc.py", "EDITED = True", (0, 1)),
    ):
        with (tmp_path / "second/dem" / name).open("a") as file:
            file.write(f"{line}\n")
        assert cache_counts(tmp_path / "second", tmp_path / "cache") == expected


class Inner(NamedTuple):
    """Members of a large tuple that is itself a member."""

    numbers: tuple
    added: np.ndarray


class Outer(NamedTuple):
    """A tuple too large to be handed over by value."""

    inner: Inner
    scale: float
    numbers: tuple


NUMBERS = tuple(float(number) for number in range(1, 2 * FEW))


@compiled
def add_up(outer):
    """Stores through one address and reads through the other."""
    inner, copied = outer.inner, local(outer)
    inner.added[0] += outer.scale * sum_of(inner.numbers)
    return inner.added[0] + copied.scale * sum_of(copied.numbers)


@inlined
def sum_of(numbers):
    total = 0.0
    for number in numbers:
        total += number
    return total


@compiled
def add_up_twice(outer):
    return add_up(outer) + add_up(outer)


def test_what_is_behind_an_address_is_the_tuple_itself():
    """Members have their values, also those of a tuple in a tuple, and a store is seen outside."""
    added = np.array([0.5])
    outer = Outer(Inner(NUMBERS, added), 2.0, NUMBERS[::-1])
    expected = 2.0 * sum(NUMBERS)
    assert add_up(outer) == 0.5 + 2.0 * expected
    assert added[0] == 0.5 + expected


@compiled(allocates=True)
def grow(outer):
    """Replace an array of the tuple in a tuple, often."""
    for _ in range(9):
        outer.inner.added = np.append(outer.inner.added, outer.scale)
    return outer


def test_what_replaces_a_member_lives_on_and_what_it_replaces_does_not():
    """The tuple of Python stays as it is, and all memory is given back."""
    outer = Outer(Inner(NUMBERS, np.array([0.5])), 2.0, NUMBERS)
    memsys_enable_stats()
    start = rtsys.get_allocation_stats()
    grown = grow(outer)
    assert grown.inner.added.tolist() == [0.5, *9 * [2.0]]
    assert grown.numbers is not NUMBERS and grown.numbers == NUMBERS
    longer = grow(grown).inner.added
    assert longer.tolist() == [0.5, *18 * [2.0]] and len(grown.inner.added) == 10
    assert outer.inner.added.tolist() == [0.5]
    del grown, longer
    end = rtsys.get_allocation_stats()
    assert end.mi_alloc - start.mi_alloc == end.mi_free - start.mi_free > 0


def test_the_kernel_of_the_readme_runs(capsys):
    """As printed there, with inertia and without."""
    page = (ROOT / "dem/jit/README.md").read_text()
    code = re.search(r"```python\n(.*?)```", page, re.S).group(1)
    exec(compile(code, "README.md", "exec"), {"__name__": "kernel_of_the_readme"})
    assert capsys.readouterr().out == "1.5 7.5\n"


@compiled
def roots_of(numbers):
    for i in range(numbers.shape[0]):
        numbers[i] = np.sqrt(numbers[i])


def compiled_afresh(kernel, *arguments):
    """Library of a kernel: that of code that was kept cannot be read."""
    fresh = compilation.Kernel(kernel.py_func, allocates=False)
    fresh(*arguments)
    (overload,) = fresh.overloads.values()
    return overload.library


def test_a_kernel_and_its_parts_may_use_the_widest_vectors():
    """LLVM takes half of what processors of Intel have; results then have other bits than elsewhere."""
    whole = compiled_afresh(add_up_twice, Outer(Inner(NUMBERS, np.zeros(1)), 2.0, NUMBERS))
    parts = [code.library for part in (add_up.part, sum_of) for code in part.overloads.values()]
    assert len(parts) > 1
    for library in whole, *parts:
        text = library.get_llvm_str()
        functions = re.findall(r"^define .*", text, re.M)
        assert functions
        for function in functions:
            group = re.search(r"#\d+", function)[0]
            attributes = re.search(rf"^attributes {group} = .*", text, re.M)[0]
            assert '"prefer-vector-width"="512"' in attributes


def compiles_for():
    """Triple, processor and its features that Numba compiles for: the host's, or those it is told."""
    return cpu_target.target_context.codegen().magic_tuple()


@pytest.mark.skipif("+avx512f" not in compiles_for()[2], reason="no vectors of 512 bits here")
def test_a_loop_of_a_kernel_becomes_code_of_the_widest_vectors():
    assert re.search(r"vsqrtpd\s.*%zmm", compiled_afresh(roots_of, np.ones(3)).get_asm_str())


@compiled
def add_all(inner):
    return inner.added.sum()


def test_code_for_a_class_that_is_not_known_by_its_code_is_not_kept():
    class Unknown(NamedTuple):
        added: np.ndarray

    assert add_all(Unknown(np.ones(2))) == 2.0
    *_, signature = add_all.signatures
    assert add_all._cache._file(signature, compiles_for()) is None


@pytest.mark.quick
def test_machine_code_is_kept_for_one_code_of_a_class_of_ones_own(monkeypatch):
    """After an edit of its file it is looked for elsewhere."""
    assert add_all(Inner((), np.ones(2))) == 2.0
    *_, signature = add_all.signatures
    kept, codegen = set(), cpu_target.target_context.codegen()
    for code in ("before", "after"):
        monkeypatch.setitem(compilation.CODE, Inner, code)
        kept.add(add_all._cache._file(signature, codegen))
    assert len(kept) == 2 and None not in kept


TINY = """
from dem.jit.compilation import compiled

@compiled
def double(x):
    return 2.0 * x

@compiled
def count(x):
    return 2 * x

assert double(1.5) == 3.0 and count(2) == 4
"""
HITS = "print(*(sum(f.stats.cache_hits.values()) for f in (double, count)))"


def other_lines(hits, stderr):
    """Lines of stderr besides the one on compiling, which is there exactly if something compiles."""
    lines = stderr.splitlines()
    assert lines.count(compilation.COMPILING) == (0 in hits)
    return [line for line in lines if line != compilation.COMPILING]


@pytest.fixture
def tiny(tmp_path, monkeypatch, capsys):
    """Function that makes two small kernels as a new process would: hits of each, and what is said.

    Both come from the disk or from the compiler, because each call makes them from their source.
    """
    script = tmp_path / "tiny.py"
    script.write_text(TINY)
    monkeypatch.setattr(compilation, "cache_folder", lambda: tmp_path / "cache")
    monkeypatch.syspath_prepend(tmp_path)

    def make():
        compilation._say_compiling.cache_clear()
        sys.modules.pop("tiny", None)
        importlib.invalidate_caches()
        kernels = importlib.import_module("tiny")
        hits = [sum(f.stats.cache_hits.values()) for f in (kernels.double, kernels.count)]
        return hits, other_lines(hits, capsys.readouterr().err)

    yield make
    sys.modules.pop("tiny", None)


DAMAGE = {
    "empty": lambda content: b"",
    "truncated": lambda content: content[: len(content) // 2],
    "garbage": lambda content: b"\x80\x04garbage" * 100,
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_machine_code_is_compiled_again(tmp_path, tiny, damage):
    """The run goes on, and mends the cache."""
    assert tiny() == ([0, 0], [])
    files = list((tmp_path / "cache").rglob("*.nbc"))
    assert len(files) == 2
    for file in files:
        file.write_bytes(DAMAGE[damage](file.read_bytes()))
    assert tiny() == ([0, 0], [])
    assert tiny() == ([1, 1], [])


def test_of_processes_that_want_the_same_one_compiles_it(tmp_path, tiny):
    """The others wait for it. Here a lock stands for the process that compiles."""
    assert tiny() == ([0, 0], [])
    code = {file: file.read_bytes() for file in (tmp_path / "cache").rglob("*.nbc")}
    with ThreadPoolExecutor() as other, ExitStack() as locks:
        for file in code:
            file.unlink()
            locks.enter_context(FileLock(f"{file}.lock"))
        answer = other.submit(tiny)
        time.sleep(1.0)
        assert not answer.done()
        for file, content in code.items():
            file.write_bytes(content)
        locks.close()
        assert answer.result() == ([1, 1], [])


FULL = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"


def assert_not_kept(folder, hits, lines):
    """Code was compiled and used, and nothing is left there."""
    assert hits == [0, 0] and not lines
    assert not [*folder.rglob("*.nbc"), *folder.rglob("*.part")]


def test_a_cache_without_a_folder_does_not_stop_a_run(tmp_path, tiny):
    """The run goes on with code in memory."""
    (tmp_path / "cache").write_text("a file")
    assert_not_kept(tmp_path, *tiny())


@posix
def test_a_full_disk_does_not_stop_a_run(tmp_path):
    """As above; in a process of its own, which cannot write."""
    script = tmp_path / "tiny.py"
    script.write_text(FULL + TINY + HITS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    process = subprocess.run(
        [sys.executable, script],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert process.returncode == 0, process.stderr
    hits = list(map(int, process.stdout.split()))
    assert_not_kept(tmp_path, hits, other_lines(hits, process.stderr))


def test_the_time_of_a_run_is_without_compiling():
    """The first run of a kind of scene is not noted as one that takes a minute."""

    @compiled
    def kernel(values):
        return np.hypot(values[0], values[1])

    before, started = computing(), time.process_time()
    kernel(np.ones(2))
    assert computing() - before < 0.1 * (time.process_time() - started)


def test_ellipses_as_round_as_discs_take_the_kernels_of_others():
    """Without friction they do not turn, and their energy is that of their motion alone."""
    state = dem.State([[0.0, 0.0], [1.0, 0.0]], velocity=[[3.0, 0.0], [0.0, 0.0]])
    kinds = set()
    for ratio in (1.0, 1.25):
        scene = dem.Scene(dem.Ellipse.of_size([1e-3, 1e-3], ratio))
        world = assemble(scene, state.checked(2), granule_table(scene, SKIN_OF_PACKING))
        kinds.add(settle.typeof_pyval(world))
        energy, speed = kinetic.py_func(world, 0.0, (0.0, 0.0))
        assert energy == pytest.approx(0.5 * scene.mass[0] * 3.0**2, rel=1e-12) and speed == 3.0
        assert world.inverse_inertia.any() == (ratio > 1.0)
    assert len(kinds) == 1
