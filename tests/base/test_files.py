"""Files are written whole or not at all, where they may be; what a disk lacks is one sentence; what killed processes left goes."""

import errno
import os
import socket
import subprocess
import time
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import psutil
import pytest
from project import posix, quick

import dem
from dem.base.files import arrays_of, atomic, check_output, lock, write_arrays, write_bytes
from dem.sweep.restart import clear_parts, prepare

FULL = OSError(errno.ENOSPC, "No space left on device")
WRONG = {
    "a fault of the code": (ZeroDivisionError("a fault"), {}, "^a fault$"),
    "a full disk of netCDF": (
        RuntimeError("NetCDF: HDF error"),  # all that it says
        {"f_bavail": 0},
        r"file\.txt: it cannot be written \(the disk is full\).* run the same command again",
    ),
    "a disk without inodes": (
        FULL,
        {"f_favail": 0},
        r"\(the disk has no inode left for another file\)",
    ),
    "a disk that counts none": (
        FULL,
        {"f_files": 0, "f_favail": 0},
        r"\(\[Errno 28\] No space left",
    ),
}


def set_disk(monkeypatch, **lacks):
    """A disk with room for bytes and files, but for what it lacks."""
    disk = {"f_frsize": 4096, "f_bavail": 10**6, "f_blocks": 10**7, "f_bfree": 10**6}
    disk |= {"f_files": 9, "f_favail": 9} | lacks
    monkeypatch.setattr(
        "os.statvfs", lambda folder: Path(folder).stat() and SimpleNamespace(**disk)
    )


@posix
@quick
@pytest.mark.parametrize("wrong", WRONG)
def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch, wrong):
    """What is wrong with the disk is one sentence with the file, whatever netCDF says of it."""
    error, lacks, words = WRONG[wrong]
    set_disk(monkeypatch, **lacks)
    file = tmp_path / "file.txt"
    file.write_text("before")
    with pytest.raises((ZeroDivisionError, OSError), match=words), atomic(file) as part:
        part.write_text("half")
        raise error
    assert file.read_text() == "before" and [file] == list(tmp_path.iterdir())


@posix
@quick
@pytest.mark.parametrize("act", [lock, lambda path: write_bytes(path, b"")])
def test_a_disk_that_takes_no_folder_is_named_with_the_file(tmp_path, monkeypatch, act):
    set_disk(monkeypatch, f_favail=0)
    monkeypatch.setattr("os.mkdir", mock.Mock(side_effect=FULL))
    with pytest.raises(OSError, match=r"new/file: it cannot be .* \(the disk has no inode left"):
        act(tmp_path / "new/file")


@quick
def test_a_file_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    """Else the name may be that of a file of zeros when power fails."""
    file, named = tmp_path / "file.txt", []
    monkeypatch.setattr("os.fsync", lambda fd: named.append((os.fstat(fd).st_size, file.exists())))
    with atomic(file) as part:
        part.write_text("whole")
    assert named == [(5, False)] and file.read_text() == "whole"


@quick
def test_a_file_for_which_there_is_no_memory_is_not_damaged(tmp_path, monkeypatch):
    """What a disk cannot give now is in test_store.py."""
    file, memory = tmp_path / "run.npz", mock.Mock(side_effect=MemoryError)
    file.write_bytes(b"half")
    assert arrays_of(file) is None
    monkeypatch.setattr("zipfile.ZipFile", memory)
    with pytest.raises(MemoryError):
        arrays_of(file)


@quick
def test_arrays_are_read_as_they_were_written_or_not_at_all(tmp_path):
    """With one bit changed anywhere."""
    file = tmp_path / "run.npz"
    write_arrays(file, {"drag": np.arange(3.0), "failure": 0, "failure_reason": "none"})
    whole, content = str(arrays_of(file)), file.read_bytes()
    for at in range(len(content)):
        changed = bytearray(content)
        changed[at] ^= 1 << at % 8
        file.write_bytes(changed)
        assert str(arrays_of(file)) in (whole, "None"), at


@posix
@pytest.mark.parametrize("number", [errno.ENOLCK, 524])
def test_a_disk_without_locks_is_one_sentence_that_says_what_to_do(tmp_path, monkeypatch, number):
    """Also where files of locks are left from a time when it had them."""
    prepare(tmp_path, tmp_path).release()
    error = OSError(number, os.strerror(number))
    monkeypatch.setattr("fcntl.flock", mock.Mock(side_effect=error))
    words = r"/.lock: it cannot be locked \(this disk gives no locks; work on another, or mount it"
    with pytest.raises(OSError, match=words):
        prepare(tmp_path, tmp_path)


@quick
def test_what_killed_processes_left_is_cleared_away(tmp_path):
    """Half-written files of processes that are no more go, those of living ones stay, and those of
    other computers for a day. What anybody else left is not touched, however old it is."""
    with atomic(tmp_path / "a.nc") as part:
        living = tmp_path / part.name
        part.touch()
    end, dead, host = f".{os.getpid()}.", f".{2**22 + 1}.", socket.gethostname()
    stale = tmp_path / living.name.replace(end, dead)
    other, old = (tmp_path / living.name.replace(host, name) for name in ("one", f"x{host}.org"))
    names = "notes.part", ".thesis.doc.part", ".77.dem.part", f"a.nc.host{dead}dem.part"
    theirs = [tmp_path / name for name in names]
    for file in (stale, living, other, old, *theirs):
        file.touch()
    for file in (stale, old, *theirs):
        os.utime(file, (time.time() - 2e5,) * 2)
    assert clear_parts(tmp_path) == 2
    assert {*tmp_path.iterdir()} == {tmp_path / "a.nc", living, other, *theirs}


@posix
def test_what_a_dead_process_left_goes_before_its_parent_asks_for_its_end(tmp_path):
    """In a container nobody may ever ask."""
    with subprocess.Popen(["true"], stdout=subprocess.PIPE) as zombie:
        zombie.stdout.read()  # until it has ended
        while psutil.Process(zombie.pid).status() != psutil.STATUS_ZOMBIE:
            time.sleep(0.001)
        (tmp_path / f".a.nc.{socket.gethostname()}.{zombie.pid}.dem.part").touch()
        assert clear_parts(tmp_path) == 1


def test_a_folder_that_cannot_be_written_is_named_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere
    with pytest.raises(OSError, match=f"{tmp_path} is read-only"):
        check_output("output", tmp_path / "out.nc")


def test_a_file_is_written_through_a_link(tmp_path):
    """The link stays; its folder may be a link too, to another disk."""
    (tmp_path / "disk").mkdir()
    (tmp_path / "folder").symlink_to("disk")
    (tmp_path / "disk/link.txt").symlink_to("aim.txt")
    with atomic(tmp_path / "folder/link.txt") as part:
        part.write_text("ours")
    assert (tmp_path / "disk/link.txt").is_symlink()
    assert (tmp_path / "disk/aim.txt").read_text() == "ours"


def test_no_device_is_replaced_by_a_file():
    with pytest.raises(dem.InputError, match="it must be a file"), atomic(os.devnull):
        pass
