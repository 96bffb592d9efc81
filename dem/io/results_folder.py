"""A folder of results before a workflow works in it: held against other runs, cleared of what killed
processes left, with no file from the future."""

import os
import re
import socket
import time
from contextlib import suppress
from pathlib import Path

from filelock import FileLock, Timeout

from dem.base.errors import RunError
from dem.base.files import is_full
from dem.io.progress import span

DAY = 86400.0  # s
SOON = 2.0  # s that the clocks of two computers may differ by
FOLLOWS = os.utime not in os.supports_follow_symlinks  # Windows dates only what a link leads to


def prepare(folder: Path) -> tuple[FileLock, list[str]]:
    """Make a folder ready; returns what holds it, and what there is to say about it.

    The folder is held until the process ends, however it ends: no lock is left behind by a run that
    was killed. Raises RunError where another run works in it, OSError where it cannot be written.
    """
    held = hold(folder)
    said = []
    if gone := clear_parts(folder):
        said.append(f"{folder}: {gone} half-written files of killed processes are cleared away.")
    count, ahead = redate(folder)
    if count:
        said.append(
            f"{folder}: {count} files are dated up to {span(ahead)} after now (the clock went back?); they "
            "are dated now, in the same order. Nothing is lost; at most some runs are made again."
        )
    return held, said


def hold(folder: Path) -> FileLock:
    """Hold a folder for this process; raises RunError where another does."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / ".lock", timeout=0)
        lock.acquire()
    except Timeout:
        raise RunError(
            f"{folder}: another run works in this folder; wait for it or stop it, or name another folder "
            "as results in the configuration."
        ) from None
    except OSError as error:
        raise OSError(
            f"{folder}: it cannot be written ({(error.strerror or str(error)).lower()}); mend that and "
            "run the same command again; snakemake -n and dem info only read."
        ) from None
    return lock


def on_failure(folder: Path) -> str:
    """What is to be done after a workflow has ended before its time."""
    # said here because jobs cannot write their logs to a disk that is full
    full = "the disk is full; make room. " if is_full(folder) else ""
    return (
        f"{folder}: {full}What is finished is kept and whole; the same command goes on from here."
    )


def clear_parts(folder: Path) -> int:
    """Remove what killed processes left half-written below a folder; how many files.

    Whether a process lives can be told of this computer only; others are given a day to finish.
    """
    from psutil import pid_exists  # os.kill(process, 0) is Ctrl-C on Windows

    gone, here = 0, socket.gethostname()
    for part in Path(folder).rglob(".*.part"):
        owner = re.fullmatch(rf"\..*\.{re.escape(here)}\.(\d+)\.part", part.name)
        with suppress(OSError):
            late = time.time() - part.stat().st_mtime > DAY
            if not pid_exists(int(owner[1])) if owner else late:
                part.unlink()
                gone += 1
    return gone


def redate(folder: Path) -> tuple[int, float]:
    """Date files that are later than now to now, in their order; how many, and how late (s) the last.

    Otherwise all that is made from them would be older than they are, and be made again each time.
    """
    now = time.time()
    late = []
    for file in Path(folder).rglob("*"):
        with suppress(OSError):
            status = file.lstat()
            if status.st_mtime > now + SOON and file.is_file():
                late.append((status.st_mtime, file))
    late.sort()
    for place, (_, file) in enumerate(late):
        stamp = now - 1e-3 * (len(late) - place)
        with suppress(OSError):
            os.utime(file, (stamp, stamp), follow_symlinks=FOLLOWS)
    return len(late), late[-1][0] - now if late else 0.0
