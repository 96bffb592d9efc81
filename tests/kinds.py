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
from numba.core import types

from dem.jit.address import Address
from dem.jit.compilation import Kernel

# Kinds of the kernels that take longest, in all processes of pytest. Jobs of sweeps and of the workflow are
# not counted: they draw beds.
# Of run_steps two are for solids, and five for laws, clumps and rolling resistance.
BUDGET = {"run_steps": 24, "settle": 12, "forces": 12}

# by kernel and hash of the types: what they have, and the first test that asked
uses: dict[tuple[str, str], tuple[list[str], str]] = {}


def members(name: str, kind):
    """Class names of the named tuples in a type, and which of their members are absent."""
    kind = kind.held if isinstance(kind, Address) else kind
    if isinstance(kind, types.BaseNamedTuple):
        yield kind.instance_class.__name__
        for field, member in zip(kind.fields, kind.types, strict=True):
            yield from members(f"{name}{'.' * bool(name)}{field}", member)
    elif isinstance(kind, types.NoneType):
        yield f"no {name}"


class Kinds:
    """Notes each kind that a test asks for, and fails the session where the budget is exceeded."""

    def __init__(self):
        compile_kernel = Kernel.compile

        def noted(kernel, signature):
            name, test = kernel.py_func.__name__, os.environ.get("PYTEST_CURRENT_TEST", "")
            if name in BUDGET and test:
                arguments = getattr(signature, "args", signature)
                key = name, hashlib.sha256(str(arguments).encode()).hexdigest()
                words = [word for argument in arguments for word in members("", argument)]
                uses.setdefault(key, (words, test.partition(" (")[0]))
            return compile_kernel(kernel, signature)

        Kernel.compile = noted

    def pytest_sessionfinish(self, session):
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput["kinds"] = [(*key, *value) for key, value in uses.items()]
        elif self.excess() and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node):
        for name, digest, *value in getattr(node, "workeroutput", {}).get("kinds", ()):
            uses.setdefault((name, digest), tuple(value))

    def pytest_terminal_summary(self, terminalreporter):
        for name in self.excess():
            kinds = [value for (kernel, _), value in uses.items() if kernel == name]
            common = set.intersection(*(set(words) for words, _ in kinds))
            terminalreporter.section(f"{len(kinds)} kinds of {name}: at most {BUDGET[name]} may be")
            for words, test in kinds:
                terminalreporter.line(f"{test}: {', '.join(w for w in words if w not in common)}")

    def excess(self) -> list[str]:
        """Kernels of which there are more kinds than may be."""
        counts = [name for name, _ in uses]
        return [name for name, most in BUDGET.items() if counts.count(name) > most]


def pytest_configure(config):
    config.pluginmanager.register(Kinds())
