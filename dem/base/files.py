"""Files are written whole or not at all, and only where a file may be; what cannot be read now is not
taken for damaged; locks."""

import errno
import filecmp
import os
import re
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from dem.base.errors import InputError
from dem.base.messages import say

# Of a disk without locks: none left, not of this disk (NFS, which Python has no name for), not of this system.
NO_LOCKS = dict.fromkeys(
    (errno.ENOLCK, 524, errno.ENOSYS, errno.EOPNOTSUPP),
    "this disk gives no locks; work on another, or mount it with locks",
)
NO_SPACE = errno.ENOSPC, getattr(errno, "EDQUOT", None)


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
    if not folder.is_dir():
        raise InputError(f"{words}; it must be in a folder, and {folder} is a file.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OSError(_cannot(real, "written", f"{folder} is read-only or belongs to another user"))
    return Path(path)


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """A path to write to beside `path`; it takes the place of `path` only when all went well, and
    where it is another file: what is made of the same bytes stays newer.

    Of a link, the file that it leads to is written. Raises OSError, with what to do, where it cannot
    be.
    """
    path = check_output("the file to write", path).resolve()
    part = path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.dem.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        filecmp.clear_cache()  # which knows files by their times
        if not path.exists() or not filecmp.cmp(part, path, shallow=False):
            with part.open("rb+") as file:
                os.fsync(file.fileno())  # else a file of zeros may have the name when power fails
            part.replace(path)
    except (OSError, RuntimeError) as error:  # of HDF5, which does not say why
        full, why = fullness(path.parent), str(error)
        if full or why.startswith("NetCDF") or getattr(error, "errno", 0) in NO_SPACE:
            raise OSError(_cannot(path, "written", full or why)) from None
        raise
    finally:
        part.unlink(missing_ok=True)


def fullness(folder: Path) -> str:
    """Why a disk takes no more files in a folder, which may not be there; "" where it does, as far as
    it says."""
    folder = next(place for place in (folder, *folder.absolute().parents) if place.is_dir())
    if shutil.disk_usage(folder).free < 1_000_000:
        return "the disk is full"
    if hasattr(os, "statvfs") and (disk := os.statvfs(folder)).f_files and not disk.f_favail:
        return "the disk has no inode left for another file"
    return ""


def bytes_of(path: Path) -> bytes:
    """The bytes of a file. Raises FileNotFoundError where it is not there, OSError, with what to do,
    where it cannot be read now, which is no damage."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise
    except OSError as error:
        raise OSError(_cannot(path, "read", str(error.strerror))) from None


def arrays_of(path: Path) -> dict[str, Any] | None:
    """The arrays of an .npz; None where its bytes are damaged. Raises as bytes_of."""
    from zipfile import ZipFile  # with numpy, which most verbs that only say something do not need

    import numpy as np

    content = BytesIO(bytes_of(path))
    try:
        archive = ZipFile(content)
        count = int.from_bytes(content.getvalue()[-12:-10], "little")  # of arrays; some may be lost
        # what it says of sizes is right then
        if len(archive.namelist()) == count and archive.testzip() is None:
            content.seek(0)
            with np.load(content) as file:
                return dict(file)
    except MemoryError:
        raise
    except Exception:  # zipfile and numpy raise many errors of damaged bytes
        pass
    return None


def set_aside(path: Path) -> None:
    """Give a damaged file another name, which nothing reads, and say so."""
    aside = path.replace(path.with_name(f"{path.name}.damaged"))
    say(f"{path}: it is damaged, and kept as {aside.name}; it is made again.")


def lock(path: Path, timeout: float = -1) -> Any:
    """A lock that this process has from now on, for `with`; its end gives it up too.

    timeout: s to wait for another process. Raises Timeout, and OSError, with what to do, where the
    disk gives no locks.
    """
    from filelock import FileLock

    try:
        # a lock of another kind, a file that is there or not, would outlive a process that is killed
        return FileLock(path, fallback_to_soft=False).acquire(timeout)
    except OSError as error:
        why = fullness(path.parent) if error.errno in NO_SPACE else NO_LOCKS.get(error.errno or 0)
        if why:
            raise OSError(_cannot(path, "locked", why)) from None
        raise


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file whose content is known."""
    with atomic(path) as part:
        part.write_bytes(content)


def write_arrays(path: Path, arrays: dict[str, Any]) -> None:
    """Write an .npz."""
    import numpy as np

    with atomic(path) as part, part.open("wb") as file:
        np.savez(file, **arrays)


# Only half-written files of ours have such names, so that what killed processes left can be removed.
PART = re.compile(r"\.(.+\..+)\.(\d+)\.dem\.part")  # file and host, process


def _cannot(path: Path, done: str, why: str) -> str:
    return f"{path}: it cannot be {done} ({why}); mend that and run the same command again."
