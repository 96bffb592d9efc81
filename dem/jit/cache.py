"""Where machine code is kept: a folder for each kernel, named by all that it is made of.

Numba keeps an index for each function. It does not notice an edit of another file, confuses two
functions of one name, and of two processes that save at once the index of one may name the code of
the other. Here a folder has the code of one kernel, and a checksum of it.
"""

import hashlib
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

import llvmlite.binding
import numba
import numpy as np

from dem.base.errors import InputError
from dem.base.files import lock, write_bytes
from dem.base.source_hash import PACKAGE, UNREADABLE, cache_folder, code_hash, codes, digest

CHECKSUM = "checksum"
_switch = threading.RLock()  # Numba has one list of locators for the whole process


class Keeps(NamedTuple):
    """Whether machine code can be kept, and whether there is some."""

    usable: bool
    has_code: bool


class Locator:
    """Tells Numba the folder of the kernel that is compiled: its interface of five methods."""

    path = Path()

    def __init__(self, file):
        self._py_file = file  # which Numba's warnings name

    @classmethod
    def from_function(cls, function, file):
        return cls(file)

    def ensure_cache_path(self):
        self.path.mkdir(parents=True, exist_ok=True)

    def get_cache_path(self):
        return str(self.path)

    def get_source_stamp(self):
        return 0

    def get_disambiguator(self):
        return ""


@contextmanager
def folder_of(binding, signature) -> Iterator[Keeps]:
    """Have Numba keep the code of a kernel in its folder. Of processes that want the same at once
    one compiles, and the others wait."""
    name = name_of(binding, signature)
    if name is None:
        yield Keeps(False, False)
        return
    folder = cache_folder() / "kernels" / name
    with ExitStack() as locks:
        usable = False
        with suppress(OSError, InputError):  # a disk may be full or lack locks
            folder.mkdir(parents=True, exist_ok=True)
            locks.enter_context(lock(folder / "lock"))
            usable = True
        known = usable and checked(folder)
        with _switch:
            before, Locator.path = numba.config.CACHE_LOCATOR_CLASSES, folder
            numba.config.CACHE_LOCATOR_CLASSES = f"{__name__}.Locator"
            try:
                yield Keeps(usable, known)
            finally:
                numba.config.CACHE_LOCATOR_CLASSES = before
        if usable and not known:
            with suppress(OSError, InputError):
                write_bytes(folder / CHECKSUM, checksum(folder).encode())


def checked(folder: Path) -> bool:
    """Whether a folder has the code that was written there; what is damaged is taken away."""
    with suppress(OSError):
        if (folder / CHECKSUM).read_text() == checksum(folder):
            return True
        for file in code_files(folder):
            file.unlink()
    return False


def code_files(folder: Path) -> list[Path]:
    return sorted(file for file in folder.iterdir() if file.suffix in (".nbi", ".nbc"))


def checksum(folder: Path) -> str:
    """Hash of the names and contents of the files of a folder."""
    found = hashlib.sha256()
    for file in code_files(folder):
        found.update(file.name.encode() + file.read_bytes())
    return found.hexdigest()


def name_of(binding, signature) -> str | None:
    """Name of the folder of a kernel; None where a function may depend on more than its file says."""
    files = {Path(__file__).with_name(f"{name}.py") for name in ("cache", "intrinsics", "kernel")}
    for function in binding.copies:
        file = Path(function.__code__.co_filename)
        is_whole = function.__module__ != "__main__" and "<locals>" not in function.__qualname__
        if not (is_whole and file.suffix == ".py" and file.is_file()):
            return None
        if file.resolve().is_relative_to(PACKAGE):
            files.add(file.resolve())
    if any(hasattr(value, "py_func") for value in binding.constants.values()):
        return None  # Numba compiled it, and what it calls
    try:
        code = codes(sorted(files))
    except UNREADABLE:
        return None
    processor = (
        llvmlite.binding.get_host_cpu_name(),
        sorted(llvmlite.binding.get_host_cpu_features().items()),
    )
    versions = (
        numba.__version__,
        sys.implementation.cache_tag,
        os.environ.get("NUMBA_CPU_NAME"),
        numba.config.BOUNDSCHECK,
    )
    functions = sorted(map(spelled, binding.copies))
    constants = sorted(f"{name} {spelled(value)}" for name, value in binding.constants.items())
    return digest(
        code_hash(code), *map(str, (signature, processor, versions)), *functions, *constants
    )


def spelled(value: Any) -> str:
    """A constant, or a function with the code that Python has, as a text that is the same in all
    processes; without its docstring."""
    if isinstance(value, FunctionType):
        code, words = value.__code__, value.__doc__
        parts = tuple(constant for constant in code.co_consts if constant != words)
        names = value.__module__, value.__qualname__
        value = (*names, value.__defaults__, code.replace(co_consts=parts))
    if isinstance(value, CodeType):
        value = value.co_code, value.co_names, value.co_consts
    if isinstance(value, tuple):
        return f"{type(value).__qualname__} {[*map(spelled, value)]}"
    if isinstance(value, np.ndarray):
        value = value.tolist()  # whose text is whole
    return getattr(value, "__qualname__", None) or getattr(value, "__name__", None) or repr(value)
