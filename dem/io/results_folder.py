"""Prepare a folder of results for a workflow: lock it, and remove what killed processes left."""

import socket
import time
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from dem.base.errors import InputError, RunError
from dem.base.files import PART, check_file, is_full, reason

DAY = 86400.0  # s


def prepare(folder: Path, store: Path) -> tuple[FileLock, list[str]]:
    """Make a folder and its store ready; returns the lock that holds it, and sentences to show.

    The folder is held until the process ends, however it ends: no lock is left behind by a run that
    was killed. Raises RunError where another run works in it, OSError where it cannot be written.
    """
    held, gone = hold(folder), clear_parts(folder) + clear_parts(store)
    words = f"{folder}: {gone} half-written files of killed processes are cleared away."
    return held, [words] if gone else []


def lock_of(path: Path, timeout: float = -1) -> FileLock:
    """A lock that is a file; raises InputError where something else is there."""
    check_file(path)
    if Path(path).is_symlink():  # the lock follows none
        raise InputError(f"{path}: it is a link, and must be a file; remove it.")
    return FileLock(path, timeout=timeout)


def is_held(path: Path) -> bool:
    """Whether a process holds a lock, which is not touched; where that cannot be asked, whether it is there."""
    try:
        import fcntl

        with Path(path).open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except (ImportError, BlockingIOError):
        return True
    return False


def hold(folder: Path) -> FileLock:
    """Hold a folder for this process; raises RunError where another does."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = lock_of(folder / ".lock", timeout=0)
        lock.acquire()
    except Timeout:
        raise RunError(
            f"{folder}: another run works in this folder; wait for it or stop it, or name another folder "
            "as results in the configuration."
        ) from None
    except OSError as error:
        raise OSError(
            f"{folder}: it cannot be written ({reason(error)}); fix that and "
            "run the same command again; snakemake -n and dem info only read."
        ) from None
    return lock


def on_failure(folder: Path, kept: str) -> str:
    """What to do after a workflow has stopped early; kept: what it has so far."""
    # Here, because jobs cannot write their logs to a full disk.
    full = "the disk is full; make room. " if is_full(folder) else ""
    return f"{folder}: {full}{kept}"


def clear_parts(folder: Path) -> int:
    """Remove the files that killed processes left half-written below a folder; returns how many.

    Only processes on this computer can be checked; others get a day to finish.
    """
    from psutil import pid_exists  # os.kill(process, 0) is Ctrl-C on Windows

    gone, here = 0, socket.gethostname()
    for part in Path(folder).rglob(".*.dem.part"):
        owner = PART.fullmatch(part.name)
        with suppress(OSError):
            if owner is None or not part.is_file() or part.is_symlink():
                continue  # not ours
            late = time.time() - part.stat().st_mtime > DAY
            if not pid_exists(int(owner[2])) if owner[1].endswith(f".{here}") else late:
                part.unlink()
                gone += 1
    return gone
