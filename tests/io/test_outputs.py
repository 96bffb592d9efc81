"""No command overwrites a folder or a file of another kind.

The commands and their paths are those of the command line itself, so that a new one is tested too.
"""

import inspect
import os
import shutil
from typing import get_type_hints

import pytest
from project import CONFIG
from typer.testing import CliRunner

from dem.base.errors import InputError
from dem.base.files import atomic, check_output
from dem.cli.app import app


def commands(verbs=app, head=()):
    """All commands below an app: their words and their function."""
    for command in verbs.registered_commands:
        yield (*head, command.name or command.callback.__name__), command.callback
    for group in verbs.registered_groups:
        yield from commands(group.typer_instance, (*head, group.name))


def parameters(function):
    """Name of each parameter with its option, type, end of the path that it writes and whether it is needed."""
    hints = get_type_hints(function, include_extras=True)
    for name, parameter in inspect.signature(function).parameters.items():
        marks = getattr(hints[name], "__metadata__", ())
        option = any(type(mark).__name__ == "OptionInfo" for mark in marks)
        checks = [mark.callback for mark in marks if mark.callback]
        yield (
            name,
            f"--{name}" if option else "",
            str(hints[name]),
            inspect.getclosurevars(checks[0]).nonlocals["suffix"] if checks else None,
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
        elif writes is not None:
            value = source.parent / f"good{writes}"
        elif reads:
            value = source
        else:
            value = "1"
        arguments += [option, str(value)] if option else [str(value)]
    return arguments


WRITTEN = [
    pytest.param(words, function, name, mark, id=f"{'-'.join(words)}-{name}")
    for words, function in commands()
    for name, _, _, mark, _ in parameters(function)
    if mark is not None
]


def content(folder):
    """All files below a folder with their bytes."""
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


@pytest.mark.parametrize(("words", "function", "name", "kind"), WRITTEN)
def test_no_command_writes_where_it_must_not(tmp_path, monkeypatch, words, function, name, kind):
    """Status 2 and one sentence, before any work; nothing is written, deleted or replaced."""
    monkeypatch.chdir(tmp_path)
    source = tmp_path / "smoke.yaml"
    shutil.copy(CONFIG / "smoke.yaml", source)
    (tmp_path / f"sub{kind}").mkdir()
    (tmp_path / "note.md").write_text("a note")
    files = content(tmp_path)
    for path in (tmp_path / f"sub{kind}", tmp_path / "note.md") if kind else (tmp_path / "sub",):
        result = CliRunner().invoke(app, [*words, *words_for(function, name, path, source)])
        assert result.exit_code == 2, (path, result.output, result.exception)
        assert len(result.stderr.strip().splitlines()) == 1, (path, result.output)
        assert content(tmp_path) == files, path


def test_every_output_is_checked_before_any_work():
    """A path called an output or a checkpoint is known as one that a command writes."""
    for words, function in commands():
        for name, _, kind, suffix, _ in parameters(function):
            writes = "Path" in kind and name in ("output", "checkpoint")
            writes &= words not in (("figure",), ("draw",))  # these look themselves
            assert (suffix is not None) == writes, (words, name)


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
    with pytest.raises(InputError, match="it must be a file"), atomic(os.devnull):
        pass
