"""Files are written whole or not at all, and none of another kind is overwritten."""

import os
import re
import shutil
import socket
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dem.base.errors import InputError
from dem.base.validate import Kind, refuse

NO_BITS = "writes files"

FOLDER, ANY = "folder", "any"  # kinds of outputs, beside those of _BEGINNINGS

# How files of a kind begin: what begins otherwise is somebody's, and is not overwritten.
_BEGINNINGS = {
    ".nc": rb"\x89HDF\r\n\x1a\n|CDF",
    ".html": rb"(?i)\s*<(!doctype )?html",
    ".png": rb"\x89PNG",
    ".svg": rb"\s*<(\?xml|svg)",
    ".pdf": rb"%PDF",
    ".mp4": rb"(?s).{4}ftyp",
    ".gif": rb"GIF8",
    ".txt": rb"[^\0]*\Z",
}


def check_output(
    path: Path, kind: str = "", name: str = "the file to write", inputs: Iterable[Path] = ()
) -> None:
    """Raise InputError where a command must not write, OSError where it cannot.

    To be called before any work is done.

    Parameters
    ----------
    path : Path
        What is to be written.
    kind : str
        FOLDER, ANY, or the suffix of the files that may be overwritten; that of the path if empty.
    name : str
        Its option, for the sentence.
    inputs : iterable of Path
        The other files of the command, none of which this may replace.
    """
    words, real = f"{name} is {str(path)!r}", Path(path).resolve()
    if real.exists() and not (real.is_dir() if kind == FOLDER else real.is_file()):
        raise InputError(f"{words}; it must be {'a folder' if kind == FOLDER else 'a file'}.")
    if real in (Path(each).resolve() for each in inputs):
        raise InputError(f"{words}; the command uses this file already: name another one.")
    near = next(each for each in (real, *real.parents) if each.exists())
    folder = near.parent if near == real and kind != FOLDER else near
    if not folder.is_dir():
        raise InputError(f"{words}; {folder} is a file, and must be a folder.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OSError(_cannot(path, f"{folder} is read-only or belongs to another user"))
    if kind == ".nc" and real.suffix != kind:
        raise InputError(f"{words}; it must end in .nc, because it will be a netCDF file.")
    if real.is_file() and not _is_of_kind(real, kind or real.suffix.lower()):
        raise InputError(
            f"{words}; that file holds something else than this command writes: delete it or name "
            "another file."
        )


def file_path(*suffixes: str) -> Kind:
    """Kind of value: a path with one of these suffixes at which a file can be written."""

    def take(name: str, value: Any) -> Path:
        if not isinstance(value, str | Path) or Path(value).suffix.lower() not in suffixes:
            refuse(name, value, f"be the path of a file that ends in {' or '.join(suffixes)}")
        check_output(Path(value), name=name)
        return Path(value)

    return take


def _is_of_kind(path: Path, kind: str) -> bool:
    """Whether a file is empty, or begins as those of its kind do."""
    with path.open("rb") as file:
        head = file.read(512)
    if not head or kind not in _BEGINNINGS:
        return True
    # any text begins like text
    named = kind != ".txt" or path.suffix.lower() == kind
    return named and re.match(_BEGINNINGS[kind], head) is not None


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """A path to write to beside `path`; it takes the place of `path` only when all went well.

    Of a link, the file that it leads to is written. Raises OSError, with what to do, where it cannot
    be.
    """
    path = Path(path).resolve()
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: it must be a file.")
    part = path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.dem.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        part.replace(path)
    except (OSError, RuntimeError) as error:
        # HDF5 raises RuntimeErrors, which do not say why
        of_disk = isinstance(error, OSError) or str(error).startswith("NetCDF")
        name = Path(os.fsdecode(getattr(error, "filename", None) or part))
        if not of_disk or name not in (part, path, *path.parents):
            raise  # it is about a file that the content is made of
        why = "the disk is full" if is_full(path.parent) else reason(error)
        raise OSError(_cannot(path, why)) from None
    finally:
        part.unlink(missing_ok=True)


# Only half-written files of ours have such names, so that what killed processes left can be removed.
PART = re.compile(r"\.(.+\..+)\.(\d+)\.dem\.part")  # file and host, process


def _cannot(path: Path, why: str) -> str:
    return f"{path}: it cannot be written ({why}); mend that and run the same command again."


def is_full(folder: Path) -> bool:
    """Whether the disk of a folder is full."""
    return folder.is_dir() and shutil.disk_usage(folder).free < 1_000_000  # bytes


def reason(error: Exception) -> str:
    """Why the system refuses, in words."""
    return (getattr(error, "strerror", None) or str(error)).lower()
