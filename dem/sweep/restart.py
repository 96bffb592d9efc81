"""What a sweep does first, also one that was killed: it holds its folder of results, in which one
process works at a time, and removes what killed processes left half-written there and in the store.
"""

import socket
import time
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from dem.base.errors import RunError
from dem.base.files import PART, check_output, lock
from dem.base.messages import say

DAY = 86400.0  # s


def prepare(folder: Path, store: Path) -> FileLock:
    """Make a folder and its store ready; returns the lock that holds it.

    The folder is held until the process ends, however it ends: no lock is left behind by a run that
    was killed. Raises RunError where another run works in it, InputError where it is a file, OSError
    where it cannot be written.
    """
    check_output("results", folder / ".lock")
    try:
        held = lock(folder / ".lock", 0).lock
    except Timeout:
        raise RunError(
            f"{folder}: another run works in this folder; wait for it or stop it, or name another folder "
            "as results in the configuration."
        ) from None
    if count := clear_parts(folder) + clear_parts(store):
        say(f"{folder}: {count} half-written files of killed processes are cleared away.")
    return held


def clear_parts(folder: Path) -> int:
    """Remove the files that killed processes left half-written below a folder; returns how many.

    Only processes on this computer can be checked; others get a day to finish.
    """
    count = 0
    for part in Path(folder).rglob(".*.dem.part"):
        if not (name := PART.fullmatch(part.name)):
            continue  # not ours
        with suppress(OSError):
            if name[1].endswith(f".{socket.gethostname()}"):
                alive = _is_alive(int(name[2]))
            else:
                alive = time.time() - part.stat().st_mtime < DAY
            if not alive:
                part.unlink()
                count += 1
    return count


def _is_alive(process: int) -> bool:
    """Whether a process of this computer still works; a container may keep the dead ones as zombies."""
    import psutil  # os.kill(process, 0) is Ctrl-C on Windows

    try:
        return psutil.Process(process).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
    except psutil.AccessDenied:
        return True
