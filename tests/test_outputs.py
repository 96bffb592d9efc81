"""No command overwrites what it reads, a folder, a device or a file of another kind.

The commands and their paths are those of the command line itself, so that a new one is tested too.
"""

import inspect
import os
import shutil
import stat
import sys
from pathlib import Path
from typing import get_type_hints

import pytest
from typer.testing import CliRunner

from conftest import CONFIG, posix
from dem.base.errors import InputError
from dem.base.files import FOLDER, Place, atomic, check_paths
from dem.cli.app import app
from dem.cli.options import Writes

DEVICE = "/dev/full" if sys.platform == "linux" else "/dev/null"


def commands(verbs=app, head=()):
    """All commands below an app: their words and their function."""
    for each in verbs.registered_commands:
        yield (*head, each.name or each.callback.__name__), each.callback
    for group in verbs.registered_groups:
        yield from commands(group.typer_instance, (*head, group.name))


def parameters(function):
    """Name of each parameter with its option, type, mark of Writes and default."""
    hints = get_type_hints(function, include_extras=True)
    for name, parameter in inspect.signature(function).parameters.items():
        marks = getattr(hints[name], "__metadata__", ())
        option = any(type(mark).__name__ == "OptionInfo" for mark in marks)
        yield (
            name,
            f"--{name}" if option else "",
            str(hints[name]),
            next((mark for mark in marks if isinstance(mark, Writes)), None),
            parameter.default is parameter.empty,
        )


def words_for(function, target, path, source):
    """Arguments of a command whose path `target` is the bad one; all that it reads is `source`."""
    arguments = []
    for name, option, kind, writes, required in parameters(function):
        reads = "Path" in kind and writes is None
        if name == target:
            value = path
        elif not (required or reads):
            continue
        elif writes:
            value = source.parent / "good"
        elif reads:
            value = source
        else:
            value = "1"
        arguments += [option, str(value)] if option else [str(value)]
    return arguments


WRITTEN = [
    pytest.param(words, function, name, mark.kind, id=f"{'-'.join(words)}-{name}")
    for words, function in commands()
    for name, _, _, mark, _ in parameters(function) if mark
]  # fmt: skip


def bad_places(folder, source, kind):
    """Paths that must not be written, by what is wrong with them."""
    found = {
        "what it reads": source,
        "link to what it reads": folder / "link",
        "other name of what it reads": folder / "name",
        "device": Path(DEVICE),
        "link to a device": folder / "full",
        "pipe": folder / "pipe",
        "below a file": source / "out.nc",
        "link to itself": folder / "loop",
        "link to another file": folder / "mine.nc",
        "link to nothing": folder / "nothing.nc",
        "name that is too long": folder / ("n" * 250 + ".nc"),
    }
    (folder / "link").symlink_to(source)
    (folder / "name").hardlink_to(source)
    (folder / "full").symlink_to(DEVICE)
    (folder / "loop").symlink_to(folder / "loop")
    (folder / "results.nc").write_bytes(KINDS[".nc"])
    (folder / "mine.nc").symlink_to("results.nc")
    (folder / "nothing.nc").symlink_to("nowhere.nc")
    os.mkfifo(folder / "pipe")
    if kind == FOLDER:
        for fault in ("name that is too long", "link to nothing"):  # a folder may be a link
            del found[fault]
        return found
    (folder / "sub").mkdir()
    (folder / "note").write_text("a note")
    found |= {"a folder": folder / "sub", "here": ".", "nothing": "", "root": "/"}
    return found | ({} if kind == "any" else {"a file of another kind": folder / "note.nc"})


def content(folder):
    """All that lies below a folder: files with their bytes, links with their aim."""
    found = {}
    for path in sorted(Path(folder).rglob("*")):
        mode = path.lstat().st_mode
        if stat.S_ISREG(mode):
            found[path] = path.read_bytes()
        else:
            found[path] = path.readlink() if stat.S_ISLNK(mode) else stat.S_IFMT(mode)
    return found


@posix
@pytest.mark.parametrize(("words", "function", "name", "kind"), WRITTEN)
def test_no_command_writes_where_it_must_not(tmp_path, monkeypatch, words, function, name, kind):
    """Status 2 and one sentence, before any work; nothing is written, deleted or replaced."""
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "smoke.yaml"
    shutil.copy(CONFIG / "smoke.yaml", source)
    (tmp_path / "note.nc").write_text("a note")
    places = bad_places(tmp_path, source, kind)
    before, device = content(tmp_path), Path(DEVICE).stat()
    for fault, path in places.items():
        result = CliRunner().invoke(app, [*words, *words_for(function, name, path, source)])
        assert result.exit_code == 2, (fault, result.output, result.exception)
        assert len(result.stderr.strip().splitlines()) == 1, (fault, result.output)
        assert "Traceback" not in result.stderr
        assert content(tmp_path) == before, fault
    assert Path(DEVICE).stat().st_rdev == device.st_rdev


def test_every_output_is_marked_as_written():
    """A path called an output or a checkpoint is known as one that a command writes."""
    for words, function in commands():
        for name, _, kind, mark, _ in parameters(function):
            writes = "Path" in kind and name in ("output", "checkpoint")
            assert bool(mark) == writes, (words, name)


READ = [
    pytest.param(words, function, name, id=f"{'-'.join(words)}-{name}")
    for words, function in commands()
    for name, _, kind, mark, _ in parameters(function) if "Path" in kind and not mark
]  # fmt: skip


@posix
@pytest.mark.parametrize(("words", "function", "name"), READ)
def test_no_command_waits_for_a_pipe_or_reads_a_device(tmp_path, words, function, name):
    """What is read must be a file: a pipe never ends, and neither does /dev/zero."""
    source = tmp_path / "smoke.yaml"
    shutil.copy(CONFIG / "smoke.yaml", source)
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", tmp_path):
        result = CliRunner().invoke(app, [*words, *words_for(function, name, path, source)])
        assert result.exit_code == 2 and "must be a file" in result.stderr, result.output
    assert sorted(each.name for each in tmp_path.iterdir()) == ["pipe", "smoke.yaml"]


KINDS = {
    ".nc": b"\x89HDF\r\n\x1a\n rest", ".html": b"<!doctype html>\n", ".png": b"\x89PNG\r\n",
    ".svg": b"<?xml version", ".pdf": b"%PDF-1.4", ".gif": b"GIF89a", ".txt": b"a table\n",
    ".mp4": b"\0\0\0\x20ftypisom",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_command_overwrites_its_own_kind_of_file_only(tmp_path, kind):
    """Results may be made again over old ones or an empty file, not over anything else."""
    file = tmp_path / f"out{kind}"
    for head in (KINDS[kind], b""):
        file.write_bytes(head)
        check_paths([Place("output", file, kind)])
    for other in {*KINDS} - {kind, ".txt"}:
        file.write_bytes(KINDS[other])
        if kind != ".txt" or b"\0" in KINDS[other]:
            with pytest.raises(InputError, match="something else"):
                check_paths([Place("output", file, kind)])
    note = tmp_path / "README.md"
    note.write_text("a note")
    with pytest.raises(InputError, match="something else"):
        check_paths([Place("output", note, kind)])


def test_outputs_of_one_command_differ(tmp_path):
    """Two outputs may not be one file, nor one lie below the other."""
    one = tmp_path / "one"
    (tmp_path / "link").symlink_to(tmp_path)
    for other in (one, tmp_path / "x" / ".." / "one", tmp_path / "link/one", one / "below"):
        for pair in ((one, other), (other, one)):
            with pytest.raises(InputError, match="checkpoint"):
                check_paths([Place("output", pair[0]), Place("checkpoint", pair[1])])


@pytest.mark.parametrize("aim", ["aim.txt", "nothing.txt"])
def test_no_link_is_written_through_or_replaced(tmp_path, aim):
    """It is somebody's, and so is what it leads to; a folder may be a link, to another disk."""
    link, folder = tmp_path / "link.txt", tmp_path / "folder"
    (tmp_path / "aim.txt").write_text("mine")
    link.symlink_to(aim)
    before = content(tmp_path)
    with pytest.raises(InputError, match="is a link to"):
        check_paths([Place("output", link)])
    with pytest.raises(InputError, match="is a link to"), atomic(link) as part:
        part.write_text("ours")
    assert content(tmp_path) == before
    (tmp_path / "disk").mkdir()
    folder.symlink_to("disk")
    check_paths([Place("output", folder / "out.txt")])
    with atomic(folder / "out.txt") as part:
        part.write_text("ours")
    assert folder.is_symlink() and (tmp_path / "disk/out.txt").read_text() == "ours"


@posix
@pytest.mark.parametrize("place", [DEVICE, "pipe", "link"])
def test_the_library_replaces_no_device(tmp_path, place):
    """Not even as root, who could."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(DEVICE)
    with pytest.raises(InputError, match="must be a file"), atomic(tmp_path / place) as part:
        part.write_text("never")
    assert stat.S_ISCHR(Path(DEVICE).stat().st_mode)
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
