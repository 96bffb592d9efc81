"""From plain functions to a kernel: what a scene lacks is decided, the rest is compiled and kept.

A kernel is a function of a module, with all functions that it calls. Names in capitals that the
caller gives are constants in its place: Numba drops `if FRICTION:` where FRICTION is False, before
it looks at types. Functions that a class answers, such as a shape or a law, come from
the classes that the caller gives. All of them stay plain functions, which Python can call.
"""

import functools
import gc
import multiprocessing
import os
import signal
import sys
import threading
import time
import uuid
import warnings
from collections.abc import Callable
from contextlib import contextmanager, suppress
from dis import get_instructions
from pathlib import Path
from types import CellType, FunctionType, ModuleType
from typing import Any

import numba
from numba.extending import register_jitable

from dem.base.messages import say
from dem.jit import cache
from dem.jit.intrinsics import INTRINSICS

# nnan and ninf stay off: they would remove the very tests that find a NaN.
# reassoc stays off: a sum has one order, so a seed has one result.
# Nothing counts references: kernels take arrays, and return numbers only.
OPTIONS = {"error_model": "numpy", "fastmath": {"contract", "arcp", "nsz"}, "_nrt": False}
PATIENCE = 20.0  # s without processor time, after which a process that compiles is given up
ONE_AT_A_TIME = threading.RLock()  # of threads that compile, so that no other holds a lock of Numba
NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class Binding:
    """Copies of functions, with constants and answers in place of what their modules have.

    Attributes
    ----------
    copies : dict of function to function
        All functions of the kernel.
    constants : dict of str to object
        What else they load from their modules, or are given, by module and name.
    """

    def __init__(self, given: dict[str, Any], classes: tuple[type, ...]):
        self.given, self.classes = given, classes
        self.copies: dict[FunctionType, FunctionType] = {}
        self.constants: dict[str, Any] = {}

    def copy(self, function: FunctionType, is_answer: bool = False) -> FunctionType:
        """A function whose globals are those that it loads, as they are in this kernel; for an
        answer of a class, as in its own file."""
        names = {"__name__": function.__module__, "__builtins__": __builtins__}
        for instruction in get_instructions(function.__code__):
            name = instruction.argval
            if instruction.opname == "LOAD_GLOBAL" and name in function.__globals__:
                names[name] = self.value(function, name, function.__globals__[name], is_answer)
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        held = (self.value(function, name, cell.cell_contents, is_answer) for name, cell in cells)
        closure = tuple(map(CellType, held))
        copy = FunctionType(
            function.__code__, names, function.__name__, function.__defaults__, closure
        )
        copy.__module__, copy.__qualname__ = function.__module__, function.__qualname__
        self.copies[function] = copy
        return copy

    def rename(self, key: str) -> None:
        """Give all functions names of this kernel alone: of two parts of one name, the linker takes
        the first for both, although they have other constants."""
        for copy in self.copies.values():
            copy.__qualname__ += f"_{key[:16]}"

    def value(self, function, name, value, is_answer):
        """What a name of a function stands for, which is a value in Python."""
        if not is_answer:
            value = self.given.get(name, value)
        if hasattr(value, "answers"):
            answers = (value.answers[cls] for cls in self.classes if cls in value.answers)
            value, is_answer = next(answers, value.__wrapped__), True
        is_function = type(value) is FunctionType
        if not is_function or value in INTRINSICS:
            self.constants[f"{function.__module__}.{name}"] = value
            if isinstance(value, ModuleType):
                for attribute in {*function.__code__.co_names} & vars(value).keys():
                    self.constants[f"{value.__name__}.{attribute}"] = vars(value)[attribute]
            return INTRINSICS[value] if is_function and not numba.config.DISABLE_JIT else value
        if value in self.copies:
            return self.copies[value]
        copy = self.copy(value, is_answer)
        register_jitable(forceinline=True, **NO_WRAPPERS, **OPTIONS)(copy)
        return copy


class Kernel:
    """A kernel: compiled, or found on disk, when it is called first.

    Attributes
    ----------
    compiling : float
        Processor time (s) that this process has compiled, or loaded, kernels.
    function : function
        What is called.
    binding : Binding
        What it is made of.
    run : function
        The dispatcher of Numba, which asks for the types of all arguments and compiles for each
        combination of them.
    entry : function
        Machine code for the first combination. A call takes a quarter of the time, because it checks
        no types but the size of a number in arrays: all must be as they were the first time.
    """

    compiling = 0.0

    def __init__(self, function, given, classes):
        self.function, self.binding = function, Binding(given, classes)
        self.run: Callable[..., Any] | None = None
        self.entry: Callable[..., Any] | None = None

    def __call__(self, *arguments):
        if self.entry is not None:
            try:
                return self.entry(*arguments)
            except TypeError:  # arrays of another type, before anything is computed
                pass
        if self.run is None:
            self.run = self.start()
        return self.run(*arguments)

    def start(self) -> Callable[..., Any]:
        """The function with its parts."""
        with compiling():
            entry = self.binding.copy(self.function)
            if numba.config.DISABLE_JIT:
                return entry
            self.binding.rename(cache.name_of(self.binding, ()) or uuid.uuid4().hex)
            dispatcher = new_dispatcher(entry, False)
            dispatcher.compile = self.compile
            return dispatcher

    def compile(self, signature):
        """Have the function for some types of arguments, from disk if it is there."""
        with ONE_AT_A_TIME, compiling(), cache.folder_of(self.binding, signature) as keeps:
            if not keeps.has_code:
                _say_compiling()
                if keeps.usable:
                    compile_apart(self.run.py_func, signature)
            once = new_dispatcher(self.run.py_func, keeps.usable)
            with suppress(OSError):  # it is compiled, and the disk is full
                once.compile(signature)
            (compiled,) = once.overloads.values()
            self.run.add_overload(compiled)
            self.entry = self.entry or compiled.entry_point
            return compiled.entry_point


def new_dispatcher(function, keeps: bool):
    """What compiles a function; keeps: whether its machine code is kept on disk."""
    return numba.njit(nogil=True, cache=keeps, no_cfunc_wrapper=True, **OPTIONS)(function)


def compile_apart(function, signature) -> None:
    """Have another process compile a function and keep its machine code, where this one can fork.

    Where LLVM compiles, it has machine code of each part beside the code of the whole kernel, and
    calls the former, of which some sums round otherwise. This process then reads the code from disk
    as all later ones do, so that the first run of a kind has the same bits. If the other process
    fails, this one compiles; also if it stands still, because it waits for a lock that another
    thread of this one held, which it lacks.
    """
    if not sys.platform.startswith("linux"):
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads
        child = os.fork()
    if child == 0:
        with suppress(BaseException):
            new_dispatcher(function, True).compile(signature)
        os._exit(0)
    spent, since = "", time.monotonic()
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        time.sleep(0.02)
        now = Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[11:13]
        if now != spent:
            spent, since = now, time.monotonic()
        elif time.monotonic() - since > PATIENCE:
            os.kill(child, signal.SIGKILL)


@contextmanager
def compiling():
    """Count the time of a block as compiling; without garbage collection, which takes a
    sixth of it and finds little."""
    enabled, started = gc.isenabled(), time.process_time()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
            gc.collect(0)  # else the run pays for it
        Kernel.compiling += time.process_time() - started


def kernel(function, classes=(), **constants) -> Kernel:
    """The kernel of a function.

    Parameters
    ----------
    function : function
        What is called, with arrays, numbers and named tuples of them; it returns numbers.
    classes : tuple of type
        Of shapes and laws, whose functions answer the questions of the kernel.
    **constants
        Names in capitals, and what they stand for.
    """
    return _made(function, classes, tuple(sorted(constants.items())))


@functools.cache
def _made(function, classes, constants):
    return Kernel(function, dict(constants), classes)


def computing() -> float:
    """Processor time (s) of this process without compiling."""
    return time.process_time() - Kernel.compiling


@functools.cache
def _say_compiling() -> None:
    """Say once that a process compiles, because a library call then takes long."""
    if multiprocessing.parent_process() is None:
        say(COMPILING)


COMPILING = (
    "Compiling for this kind of scene, up to a minute; the next process finds it compiled, unless "
    "a shape is defined in a script or a notebook."
)
