"""Files are written whole or not at all, whatever happens to the process, and to the disk."""

import os
import re
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


def _why(path: Path, error: Exception) -> str:
    """What keeps a file from being written, as far as it can be told."""
    with suppress(OSError):
        if shutil.disk_usage(path.parent).free < FULL:
            return "the disk is full"
    return (getattr(error, "strerror", None) or str(error)).lower()


def clear_parts(folder: Path) -> int:
    """Remove what killed processes of this computer left half-written below a folder; how many."""
    gone, here = 0, socket.gethostname()
    for part in Path(folder).rglob(".*.part"):
        owner = re.fullmatch(rf"\..*\.{re.escape(here)}\.(\d+)\.part", part.name)
        if owner and not _lives(int(owner[1])):
            with suppress(OSError):
                part.unlink()
                gone += 1
    return gone


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True
