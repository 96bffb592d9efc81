"""How the kernels are compiled, and where the machine code is kept.

Numba keeps machine code on disk, but its cache has three gaps. It does not notice an edit in
another file that a function depends on. Two processes that save at the same time can leave an index
that points to the wrong code. A damaged file ends every run. This module closes them: the folder of
a module is named after the hash of all code that it depends on, a file after its key, which holds the
code of the shape, so that there is no index; and files carry their digest. An edit of a comment
compiles nothing.
"""

import functools
import gc
import hashlib
import multiprocessing
import os
import pickle
import sys
from contextlib import suppress
from pathlib import Path

import numba
from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.compiler import CompileResult
from numba.core.event import Listener, register
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps

from dem.base.messages import say
from dem.base.sources import (
    IMPORTED,
    UNREADABLE,
    address,
    cache_folder,
    code_hash,
    defined_in,
    from_elsewhere,
    is_current,
    is_ours,
)
from dem.jit.compilers import KernelCompiler, PartCompiler, RolledCompiler

# nnan and ninf stay off: they would remove the very tests that find a NaN.
# reassoc stays off: a sum has one order, so a seed has one result.
OPTIONS = {"error_model": "numpy", "fastmath": {"contract", "arcp", "nsz"}}
NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
INLINED = {"forceinline": True, "pipeline_class": PartCompiler, **NO_WRAPPERS, **OPTIONS}
ROLLED = INLINED | {"pipeline_class": RolledCompiler}


def classes_in(kind):
    """Classes of the named tuples in a type of Numba."""
    if isinstance(kind, types.BaseNamedTuple):
        yield kind.instance_class
    for each in kind.types if isinstance(kind, types.BaseTuple) else ():
        yield from classes_in(each)


OUTSIDE: dict[type, str] = {}  # hashes of the code of classes of users, when Python read them


def remember(cls: type) -> None:
    """Keep by which code a class of a user is known, so that its machine code can be found again.

    Only of a class at the top of a file, while Python imports that file: anything else may depend on
    more than is written there.
    """
    OUTSIDE.pop(cls, None)
    module = sys.modules.get(cls.__module__)
    is_read = getattr(getattr(module, "__spec__", None), "_initializing", False)
    found = address(cls.__module__, getattr(module, "__file__", None)) if is_read else None
    if found is None or is_ours(found):
        return
    try:
        whole = cls.__qualname__ in defined_in(found) and not from_elsewhere(found)
        if whole and is_current(found):
            OUTSIDE[cls] = IMPORTED[cls.__module__] = code_hash(found, bits=True)
    except UNREADABLE:
        return


def _code_of(cls: type) -> str | None:
    """Hash of the code of a class, None where it is unknown."""
    return code_hash(cls.__module__, bits=True) if is_ours(cls.__module__) else OUTSIDE.get(cls)


def strangers(kinds) -> list[str]:
    """Names of the classes in some types of which it is unknown what their code depends on."""
    found = {each for kind in kinds for each in classes_in(kind)}
    return sorted(each.__qualname__ for each in found if _code_of(each) is None)


def with_classes(key) -> str | None:
    """A key of Numba's cache as text, with the code of the classes that choose what is compiled.

    A shape answers the kernels from a module that they do not import. None for a class whose code is
    unknown: its kernels are compiled in each process.
    """
    if strangers(key[0]):
        return None
    found = {each for kind in key[0] for each in classes_in(kind)}
    classes = sorted(f"{each.__module__}.{each.__qualname__} {_code_of(each)}" for each in found)
    return repr((numba.__version__, sys.implementation.cache_tag, *map(str, key), classes))


def kernel_hash(module: str, file) -> str:
    """SHA-256 of the code that the kernels of a module depend on; of its file where that is unknown."""
    try:
        name = Path(file).stem if module == "__main__" else module
        if (found := address(name, file)) is not None:
            return code_hash(found, bits=True)
    except UNREADABLE:  # an import that is written for other tools
        pass
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


class KernelCache(FunctionCache):
    """Machine code of a function on disk: a file for each combination of types of its arguments.

    Path and time stamp of the source do not count, so that all copies of it share machine code. A file
    begins with its digest, and a damaged one counts as absent, because a flipped bit of machine code is a
    crash or a wrong number. A run never fails because of a file.
    """

    def __init__(self, function):
        module, file = function.__module__, function.__code__.co_filename
        folder = f"{module}-{kernel_hash(module, file)[:16]}"
        self._py_func, self._cache_path = function, cache_folder() / "kernels" / folder

    def load_overload(self, sig, target_context):
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        if path is None:
            return None
        try:
            content = path.read_bytes()
        except OSError:
            return None
        if content[:DIGEST] != _digest(content[DIGEST:]):
            _say(DAMAGED)
            return None
        return CompileResult._rebuild(target_context, *pickle.loads(content[DIGEST:]))

    def save_overload(self, sig, data):
        path = self._path(sig, data.codegen)
        if path is None or data.library.has_dynamic_globals:
            return
        content = dumps(data._reduce())
        part = path.with_suffix(f".{os.getpid()}.part")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            part.write_bytes(_digest(content) + content)
            part.replace(path)
        except OSError as error:
            _say(UNKEPT.format(error.strerror))
            with suppress(OSError):
                part.unlink(missing_ok=True)

    def _path(self, sig, codegen) -> Path | None:
        """The file of the machine code for some types of arguments, None if it is not kept."""
        key = with_classes(self._index_key(sig, codegen))
        name = self._py_func.__qualname__.replace("<", "").replace(">", "")
        return key and self._cache_path / f"{name}-{_digest(key.encode()).hex()[:32]}.nbc"


DIGEST = 32  # bytes
DAMAGED = "the machine code that is kept here is damaged; it is compiled again."
UNKEPT = "machine code cannot be kept here ({}); this run goes on, the next one compiles again."


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


@functools.cache
def _say(sentence: str) -> None:
    """Say something about the folder of machine code, once."""
    say(f"{cache_folder() / 'kernels'}: {sentence}")


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

    def __init__(self, function, allocates: bool):
        options = {"nogil": True, "_nrt": allocates, "forceinline": False, **OPTIONS, **NO_WRAPPERS}
        self.part = Part(function, **options)
        options |= {"nopython": True, "no_cpython_wrapper": False}
        super().__init__(function, targetoptions=options, pipeline_class=KernelCompiler)

    def compile(self, sig):
        """Without Python's search for garbage meanwhile: a sixth of the time, and it finds little."""
        enabled = gc.isenabled()
        gc.disable()
        try:
            return super().compile(sig)
        finally:
            if enabled:
                gc.enable()

    def get_call_template(self, args, kws):
        """What Numba asks of a function that compiled code calls."""
        return self.part.get_call_template(args, kws)

    def get_overload(self, sig):
        return self.part.get_overload(sig)


class _Compiling(Listener):
    """Says that a process compiles, because a library call then takes long; each sentence once."""

    def on_start(self, event):
        if isinstance(event.data["dispatcher"], Kernel):
            names = " and ".join(strangers(event.data["args"]))
            _tell(STRANGE.format(names) if names else COMPILING)

    def on_end(self, event):
        """Nothing: the next call shows it."""


register("numba:compile", _Compiling())


def when_compiling(tell) -> None:
    """Call a function whenever this process compiles a kernel, with a sentence, instead of saying it."""
    global _tell
    _tell = tell


@functools.cache
def _say_compiling(sentence: str) -> None:
    if multiprocessing.parent_process() is None:
        say(sentence)


_tell = _say_compiling
COMPILING = "Compiling for this kind of scene, up to a minute; the next process finds it compiled."
STRANGE = (
    "Compiling for {}, up to a minute; every process compiles again for it, because its code is known only "
    "if it is a shape at the top of an imported file."
)


def compiled(function=None, *, allocates=False):
    """Decorator: compile for each combination of argument types, and keep the kernels on disk.

    allocates: whether the function, or one that it calls, makes arrays. Others are compiled
    without reference counts, in half the time: a World holds some sixty arrays.
    """
    if function is None:
        return functools.partial(compiled, allocates=allocates)
    dispatcher = Kernel(function, allocates)
    if Path(function.__code__.co_filename).is_file():  # no file, no way to tell one from another
        dispatcher._cache = KernelCache(function)
    return dispatcher


def inlined(function):
    """Decorator for scalar helpers: always part of the kernel that calls them."""
    return Part(function, forceinline=True, **NO_WRAPPERS, **OPTIONS)
