"""Files are written whole or not at all, whatever happens to the process, and to the disk."""

import os
import shutil
import socket
from contextlib import contextmanager, suppress
from pathlib import Path

from dem.errors import InputError, RunError

FULL = 100_000  # bytes that are left on a disk that is full


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
    except (InputError, RunError):
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 tells of a full disk by a RuntimeError
        raise OSError(
            f"{path}: it can not be written ({_why(path, error)}); nothing that was there is lost. Mend "
            "that and run the same command again."
        ) from None
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


def is_full(folder: Path) -> bool:
    """Whether nothing more can be written to a folder."""
    with suppress(OSError):
        return shutil.disk_usage(folder).free < FULL
    return False


def _why(path: Path, error: Exception) -> str:
    """What keeps a file from being written, as far as it can be told."""
    if is_full(path.parent):
        return "the disk is full"
    return (getattr(error, "strerror", None) or str(error)).lower()
