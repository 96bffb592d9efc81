"""How the kernels are compiled, and where the machine code is kept.

Numba keeps machine code on disk too, but it does not notice an edit of another file that a
function depends on, and of two processes that save at once the index of one may name the code of
the other. Here the folder is named after the hash of all code that is compiled, and there is no
index: a file is named after the function and the types of its arguments.
"""

import functools
import gc
import multiprocessing
import pickle
import sys
import time
from contextlib import ExitStack, suppress
from pathlib import Path

import numba
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.compiler import CompileResult
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps

from dem.base.errors import InputError
from dem.base.files import lock, write_bytes
from dem.base.messages import say
from dem.base.plugins import note
from dem.base.source_hash import (
    PACKAGE,
    UNREADABLE,
    cache_folder,
    code_hash,
    digest,
    kernel_hash,
    plugin_codes,
)
from dem.jit.address import handed
from dem.jit.compilers import KernelCompiler, PartCompiler, RolledCompiler

# nnan and ninf stay off: they would remove the very tests that find a NaN.
# reassoc stays off: a sum has one order, so a seed has one result.
OPTIONS = {"error_model": "numpy", "fastmath": {"contract", "arcp", "nsz"}}
NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
INLINED = {"forceinline": True, "pipeline_class": PartCompiler, **NO_WRAPPERS, **OPTIONS}
ROLLED = INLINED | {"pipeline_class": RolledCompiler}


def classes_in(kind):
    """Classes of the named tuples in a type of Numba."""
    kind = getattr(kind, "held", kind)
    if isinstance(kind, types.BaseNamedTuple):
        yield kind.instance_class
    for part in kind.types if isinstance(kind, types.BaseTuple) else ():
        yield from classes_in(part)


CODE: dict[type, str] = {}  # hash of the code of each class that is not of this package


def remember(cls: type) -> None:
    """Note by which code a class is known, while Python imports its file.

    Not of a class in a script, a notebook or a function: such a class may depend on more than is
    written in its file.
    """
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    is_whole = cls.__module__ != "__main__" and "<locals>" not in cls.__qualname__
    if file and is_whole and not _is_of_package(cls):
        with suppress(*UNREADABLE):
            CODE[cls] = code_hash(note(Path(file).resolve()))


def _is_of_package(cls: type) -> bool:
    return cls.__module__.partition(".")[0] == PACKAGE.name


class KernelCache(FunctionCache):
    """Machine code of a function on disk: a file for each combination of types of its arguments.

    Where the source lies does not count, so that all copies of it share machine code. A file that
    is damaged counts as absent. Of processes that want the same at once one compiles it, and the
    others wait: Kernel.compile gives up the locks.
    """

    def __init__(self, function):
        file = Path(function.__code__.co_filename).resolve()
        code = kernel_hash()
        if not file.is_relative_to(PACKAGE):
            code = digest(code, code_hash(plugin_codes(file)))
        self._py_func, self._cache_path = function, cache_folder() / "kernels" / code

    def load_overload(self, sig, target_context):
        target_context.refresh()
        file = self._file(sig, target_context.codegen())
        if file is not None:
            # a disk may be full or lack locks, and damage makes pickle and LLVM raise many errors
            with suppress(Exception):
                if not file.is_file():
                    self.locks.enter_context(lock(Path(f"{file}.lock")))
                return CompileResult._rebuild(target_context, *pickle.loads(file.read_bytes()))
        _say_compiling()
        return None

    def save_overload(self, sig, data):
        file = self._file(sig, data.codegen)
        if file is None or data.library.has_dynamic_globals:
            return
        with suppress(OSError, InputError):  # else the next process compiles
            write_bytes(file, dumps(data._reduce()))

    def _file(self, sig, codegen) -> Path | None:
        """The file for some types of arguments; None where the code of a class is unknown."""
        classes = [cls for kind in sig for cls in classes_in(kind)]
        if not all(_is_of_package(cls) or cls in CODE for cls in classes):
            return None
        code = [f"{cls.__module__}.{cls.__qualname__} {CODE.get(cls, '')}" for cls in classes]
        key = (numba.__version__, sys.implementation.cache_tag, *self._index_key(sig, codegen))
        name = f"{self._py_func.__module__}.{self._py_func.__qualname__}".replace("<locals>.", "")
        return self._cache_path / f"{name}-{digest(*map(str, key), *code)}.nbc"


def spare_blas():
    """Keep Numba from importing scipy.linalg: it looks for a BLAS that no kernel here uses.

    That search is a sixth of the time in which a short process starts. For processes of our own:
    a user's Numba code might want BLAS.
    """
    import numba.np.linalg

    def absent():
        raise ImportError("not looked for, see dem.jit.compilation.spare_blas")

    numba.np.linalg.ensure_blas = absent


class Part(CPUDispatcher):
    """A function that is a part of kernels; Python that calls it runs its own code."""

    def __init__(self, function, **options):
        super().__init__(
            function, targetoptions={"nopython": True, **options}, pipeline_class=PartCompiler
        )

    def __call__(self, *arguments):
        return self.py_func(*arguments)


class Kernel(CPUDispatcher):
    """A compiled function: a kernel where Python calls it, a part where compiled code does."""

    compiling = 0.0  # processor time (s) that this process has compiled, or loaded, kernels

    def __init__(self, function, allocates: bool):
        options = {"nogil": True, "_nrt": allocates, "forceinline": False, **OPTIONS, **NO_WRAPPERS}
        self.part = Part(function, **options)
        options |= {"nopython": True, "no_cpython_wrapper": False}
        super().__init__(function, targetoptions=options, pipeline_class=KernelCompiler)

    def compile(self, sig):
        """Without garbage collection, which takes a sixth of the time and finds little."""
        enabled, started = gc.isenabled(), time.process_time()
        gc.disable()
        try:
            with ExitStack() as self._cache.locks:
                return super().compile(sig)
        finally:
            Kernel.compiling += time.process_time() - started
            if enabled:
                gc.enable()

    def typeof_pyval(self, val):
        """What Numba asks of an argument that Python hands over."""
        return handed(super().typeof_pyval(val))

    def get_call_template(self, args, kws):
        """What Numba asks of a function that compiled code calls."""
        return self.part.get_call_template(args, kws)

    def get_overload(self, sig):
        return self.part.get_overload(sig)


def computing() -> float:
    """Processor time (s) of this process without that of compiling."""
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


def compiled(function=None, *, allocates=False):
    """Decorator: compile for each combination of argument types, and keep the kernels on disk.

    allocates: whether the function, or one that it calls, makes arrays. Others are compiled
    without reference counts, in half the time: a World holds some sixty arrays.
    """
    if function is None:
        return functools.partial(compiled, allocates=allocates)
    dispatcher = Kernel(function, allocates)
    file = Path(function.__code__.co_filename)
    if file.suffix == ".py" and file.is_file():  # else nothing tells one text from another
        dispatcher._cache = KernelCache(function)
    return dispatcher


def inlined(function):
    """Decorator for scalar helpers: always part of the kernel that calls them."""
    return Part(function, forceinline=True, **NO_WRAPPERS, **OPTIONS)
