"""Where files may be written, and how: whole or not at all, even if a process or disk fails."""

import errno
import os
import re
import socket
import stat
import tempfile
from collections.abc import Iterable
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from dem.base.errors import InputError

FULL = 100_000  # bytes that a full disk cannot take
FOLDER, ANY = "folder", "any"  # kinds of targets, beside those of _BEGINNINGS

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


class Place(NamedTuple):
    """A path that a command reads or writes, with the name of its option and the kind of file.

    kind: FOLDER, ANY, a suffix, or "" for the suffix of the path.
    """

    name: str
    path: Path
    kind: str = ""

    @property
    def words(self) -> str:
        return f"{self.name} is {str(self.path)!r}"


def check_paths(targets: Iterable[Place], sources: Iterable[Place] = ()) -> None:
    """Raise InputError where a command must not write to a target or cannot read a source.

    Raises OSError for a folder that cannot be written. To be called before any work is done.
    """
    taken = {}
    for source in sources:
        kind = _kind_of(source)
        if kind and kind != "a file":
            raise InputError(f"{source.words}; it is {kind}, and must be a file.")
        taken.setdefault(_identity(source.path), source)
    targets = list(targets)
    files = {os.path.realpath(each.path): each for each in targets if each.kind != FOLDER}
    for target in targets:
        _check_target(target)
        for parent in Path(os.path.realpath(target.path)).parents:
            if above := files.get(str(parent)):
                raise InputError(f"{target.words}; it lies below {above.name}, which is a file.")
        other = taken.setdefault(_identity(target.path), target)
        if other is not target:
            raise InputError(
                f"{target.words}; {other.name} is the same file, which would be lost: name another file."
            )


def _identity(path):
    """Equal for all paths of one file: links are followed, and names of one file are one."""
    with suppress(OSError):
        status = Path(path).stat()
        return status.st_dev, status.st_ino
    return os.path.realpath(path)


def _kind_of(place: Place) -> str:
    """What a path leads to, links followed: "a file", "a folder", another kind, "" for nothing."""
    if not str(place.path).isprintable():  # sentences name it, in one line
        raise InputError(
            f"{place.words}; its name must have no line ends or other unseen characters."
        )
    try:
        str(place.path).encode()  # netCDF takes no other names
        status = place.path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return ""
    except PermissionError as error:
        raise OSError(f"{place.words}; cannot look at it ({reason(error)}).") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{place.words}; it is no name of a file ({reason(error)}).") from None
    if stat.S_ISREG(status.st_mode):
        return "a file"
    return "a folder" if stat.S_ISDIR(status.st_mode) else "a device, pipe or socket"


def check_own(target: Place) -> str:
    """Raise InputError where a target is something else than a command would write there, a link
    included; returns what it is, as _kind_of. Nothing need be written."""
    found, wanted = _kind_of(target), "a folder" if target.kind == FOLDER else "a file"
    if found not in ("", wanted):
        raise InputError(f"{target.words}; it is {found}, and must be {wanted}.")
    if target.kind != FOLDER and target.path.is_symlink():
        raise InputError(
            f"{target.words}; it is a link to {target.path.readlink()}, and must be a file: remove the link "
            "or name another file."
        )
    if found == "a file":
        _check_kind(target)
    return found


def _check_target(target: Place) -> None:
    found = check_own(target)
    path = Path(os.path.realpath(target.path))
    if target.kind != FOLDER:
        _kind_of(target._replace(path=_part_of(path)))  # a name may be too long for that alone
    there = path if found == "a folder" else next(p for p in path.parents if os.path.lexists(p))
    if not there.is_dir():
        raise InputError(f"{target.words}; {there} is a file, and must be a folder.")
    if not os.access(there, os.W_OK | os.X_OK):
        raise OSError(_cannot(target.path, f"{there} is read-only or belongs to another user"))
    if target.kind == ".nc" and target.path.suffix != target.kind:
        raise InputError(f"{target.words}; it must end in .nc, because it will be a netCDF file.")


def _check_kind(target: Place) -> None:
    """Refuse to overwrite a file of another kind, such as a configuration by results."""
    kind = target.kind or target.path.suffix.lower()
    if kind not in _BEGINNINGS:
        return
    with target.path.open("rb") as file:
        head = file.read(512)
    alike = re.match(_BEGINNINGS[kind], head)
    if kind == ".txt":  # any text begins like text
        alike = alike and target.path.suffix.lower() == kind
    if head and not alike:
        raise InputError(
            f"{target.words}; that file holds something else than this command writes ({kind}): delete it "
            "or name another file."
        )


@contextmanager
def atomic(path: Path):
    """A path to write to beside `path`; it takes the place of `path` only when all went well.

    The folder may be a link. Raises InputError for a folder, a device or a link, because what a
    link leads to, and the link itself, are somebody's; OSError, with what to do, where the file cannot
    be written.
    """
    check_own(Place("the file to write", Path(path), ANY))
    path = Path(os.path.realpath(path))
    part = _part_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        part.replace(path)
    except (OSError, RuntimeError) as error:
        if not _of_disk(error, path):
            raise
        why = "the disk is full" if is_full(path.parent) else reason(error)
        raise OSError(_cannot(path, why)) from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


# Only half-written files of ours have such names, so that what killed processes left can be removed.
PART = re.compile(r"\.(.+\..+)\.(\d+)\.dem\.part")  # file and host, process


def _part_of(path: Path) -> Path:
    return path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.dem.part")


def _cannot(path: Path, why: str) -> str:
    return f"{path}: it cannot be written ({why}); mend that and run the same command again."


def _of_disk(error: Exception, path: Path) -> bool:
    """Whether an error is about writing this file, and not one of the work that makes its content."""
    if isinstance(error, OSError):
        if error.filename is None:
            return True
        name = Path(os.fsdecode(error.filename))
        return name.parent == path.parent or name in path.parents
    return type(error) is RuntimeError and str(error).startswith("NetCDF")


def check_file(path: Path) -> None:
    """Raise InputError where something else is in the place of a file: a folder, or a pipe, for which
    a reader would wait for ever."""
    found = _kind_of(Place("the file", Path(path)))
    if found not in ("", "a file"):
        raise InputError(f"{path}: it is {found}, and must be a file; remove it.")


def is_full(folder: Path) -> bool:
    """Whether nothing more can be written to a folder, because of its disk or of a quota."""
    try:
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(bytes(FULL))
        return False
    except OSError as error:
        return error.errno in (errno.ENOSPC, errno.EDQUOT)


def reason(error: Exception) -> str:
    """Why the system refuses, in words."""
    return (getattr(error, "strerror", None) or str(error)).lower()
