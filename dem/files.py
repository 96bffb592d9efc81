"""Files are written whole or not at all, whatever happens to the process, and to the disk."""

import errno
import os
import socket
from contextlib import contextmanager, suppress
from pathlib import Path

FULL = 100_000  # bytes that a disk that is full can not take


@contextmanager
def atomic(path: Path):
    """A path to write to beside `path`; it takes the place of `path` only when all went well.

    Raises OSError, with what to do, where the file can not be written.
    """
    path = Path(path)
    part = path.with_name(f".{path.name}.{socket.gethostname()}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield part
        part.replace(path)
    except (OSError, RuntimeError) as error:
        if not _of_disk(error, path):
            raise
        raise OSError(
            f"{path}: it can not be written ({_why(path, error)}); mend that and run the same command again."
        ) from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def _of_disk(error: Exception, path: Path) -> bool:
    """Whether an error is about writing this file, and not one of the work that makes its content."""
    if isinstance(error, OSError):
        if error.filename is None:
            return True
        name = Path(os.fsdecode(error.filename))
        return name.parent == path.parent or name in path.parents
    return type(error) is RuntimeError and str(error).startswith("NetCDF")


def is_full(folder: Path) -> bool:
    """Whether nothing more can be written to a folder, because of its disk or of a quota."""
    probe = Path(folder) / f".probe.{os.getpid()}"
    try:
        probe.write_bytes(bytes(FULL))
        return False
    except OSError as error:
        return error.errno in (errno.ENOSPC, errno.EDQUOT)
    finally:
        with suppress(OSError):
            probe.unlink(missing_ok=True)


def _why(path: Path, error: Exception) -> str:
    """What keeps a file from being written, as far as it can be told."""
    if is_full(path.parent):
        return "the disk is full"
    return (getattr(error, "strerror", None) or str(error)).lower()
