"""Files are written whole or not at all, and only where a file may be."""

import os
import re
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dem.base.errors import InputError


def check_output(name: str, path: Any, suffixes: tuple[str, ...] = ("",)) -> Path:
    """The path of a file that can be written, checked before any work is done.

    Raises InputError where it must not be written, OSError where it cannot.

    Parameters
    ----------
    name : str
        What it is called where it was given, for the sentence.
    path : str or Path
        What is to be written.
    suffixes : tuple of str
        How its name must end, so that no file of another kind is overwritten.
    """
    words = f"{name} is {str(path)!r}"
    if not str(path).lower().endswith(suffixes):
        raise InputError(
            f"{words}; it must be the path of a file that ends in {' or '.join(suffixes)}."
        )
    real = Path(path).resolve()
    if real.exists() and not real.is_file():
        raise InputError(f"{words}; it must be a file.")
    folder = next(parent for parent in real.parents if parent.exists())
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OSError(_cannot(real, f"{folder} is read-only or belongs to another user"))
    return Path(path)


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """A path to write to beside `path`; it takes the place of `path` only when all went well.

    Of a link, the file that it leads to is written. Raises OSError, with what to do, where it cannot
    be.
    """
    path = check_output("the file to write", path).resolve()
    part = path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.dem.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        part.replace(path)
    except (OSError, RuntimeError) as error:  # of HDF5, which does not say why
        full = is_full(path.parent)
        if full or str(error).startswith("NetCDF"):
            raise OSError(_cannot(path, "the disk is full" if full else str(error))) from None
        raise
    finally:
        part.unlink(missing_ok=True)


def is_full(folder: Path) -> bool:
    """Whether a disk has less than a megabyte left."""
    return shutil.disk_usage(folder).free < 1_000_000


def write_changed(path: Path, text: str) -> None:
    """Write a text, unless the file has it already: what is made of the file stays newer."""
    if not path.is_file() or path.read_bytes() != text.encode():  # a pipe has no end
        with atomic(path) as part:
            part.write_bytes(text.encode())


# Only half-written files of ours have such names, so that what killed processes left can be removed.
PART = re.compile(r"\.(.+\..+)\.(\d+)\.dem\.part")  # file and host, process


def _cannot(path: Path, why: str) -> str:
    return f"{path}: it cannot be written ({why}); mend that and run the same command again."
