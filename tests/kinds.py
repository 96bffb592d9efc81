"""The kinds of kernels that the suite compiles: a budget, and which tests ask for more. A plugin of pytest.

Numba compiles a kernel for each combination of types of its arguments: for each shape, with friction or
without, with held granules or without, ... A kind of run_steps takes 10 to 40 s of a processor. A test that needs
none of its own takes a scene of those that are there: the limit of little friction and damping (LEAST, ELASTIC)
for none, a held granule that rests (scenes.ANCHOR), heavy walls that nothing pushes (scenes.lids), or
a ledger that nothing asks. Walls, round solids, gravity and paths add no kind.
"""

import hashlib
import os

import pytest

from dem.jit.compilation import Kernel

# Kinds of the kernels that take longest, in all processes of pytest. Jobs of sweeps and of the workflow are
# not counted: they draw beds.
# Of run_steps two are for solids, and five for laws, clumps and rolling resistance.
BUDGET = {"run_steps": 24, "settle": 11, "forces": 12}

# by kernel and hash of the types: the first test that asked
uses: dict[tuple[str, str], str] = {}


compile_kernel = Kernel.compile


def noted(kernel, signature):
    """Compile, and note who asks."""
    name, test = kernel.py_func.__name__, os.environ.get("PYTEST_CURRENT_TEST", "")
    if name in BUDGET and test:
        types = str(getattr(signature, "args", signature))
        digest = hashlib.sha256(types.encode()).hexdigest()
        uses.setdefault((name, digest), test)
    return compile_kernel(kernel, signature)


Kernel.compile = noted


def excess() -> dict[str, list[str]]:
    """Tests that asked for kinds of a kernel, where there are more than may be."""
    tests = {name: [uses[key] for key in uses if key[0] == name] for name in BUDGET}
    return {name: tests[name] for name in BUDGET if len(tests[name]) > BUDGET[name]}


def pytest_sessionfinish(session):
    """The session fails where there are too many; a process of pytest-xdist only says what it has."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["kinds"] = [(*key, test) for key, test in uses.items()]
    elif excess():
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    for *key, test in getattr(node, "workeroutput", {}).get("kinds", ()):
        uses.setdefault(tuple(key), test)


def pytest_terminal_summary(terminalreporter):
    for name, tests in excess().items():
        terminalreporter.section(f"{len(tests)} kinds of {name}: at most {BUDGET[name]} may be")
        terminalreporter.line("\n".join(tests))
