"""The kinds of kernels that the suite compiles: a budget, and which tests ask for more. A plugin of pytest.

A kernel is compiled for each shape and law, and for each combination of what a scene has: friction, damping, an energy
ledger, ... (dem/dynamics/kinds.py). A kind takes 5 to 10 s of a processor. A test that needs none of its own takes a scene of
those that are there: the limit of little friction and damping (LEAST, ELASTIC), or a ledger that nothing asks. Walls, round
solids, gravity, paths, held granules and sizes of a bed add no kind.
"""

import os

import pytest

from dem.jit.kernel import Kernel

# Kinds of the kernels of a shape and a law, in all processes of pytest. Jobs of sweeps and of the workflow are
# not counted: they draw beds.
BUDGET = {"advance": 24, "fire": 10, "scan": 8}

# by kernel, and what it has: the first test that asked
uses: dict[tuple[str, str], str] = {}


compile_kernel = Kernel.compile


def noted(kernel, signature):
    """Compile, and note who asks."""
    name, test = kernel.function.__name__, os.environ.get("PYTEST_CURRENT_TEST", "")
    if name in BUDGET and test:
        has = [cls.__name__ for cls in kernel.binding.classes]
        has += [flag for flag, value in kernel.binding.given.items() if value is True]
        uses.setdefault((name, ", ".join(has)), test)
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
