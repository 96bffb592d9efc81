"""What cannot be is refused in one sentence that names the value and what would be right.

One file beside this one for each room, with any of three tables:

CALLS     what is called, a function without arguments, by words of the sentence
FILES     what is wrong, {path: value} put into config/paper.yaml, by words of the sentence; a dot within a key
          is written as a slash: sweep.friction/granule
COMMANDS  words of the sentence, by words of `dem`, entered where the project is; OUT is a file that is not there
"""

import re
import warnings
from importlib import import_module
from pathlib import Path

import pytest
from command_line import called
from project import CONFIG, ROOT, changed_file

from dem.base.errors import InputError
from dem.sweep.config import parse

pytestmark = pytest.mark.quick
ROOMS = [import_module(f"refusals.{file.stem}") for file in Path(__file__).parent.glob("[!t]*.py")]


def rows(table):
    """The rows of a table of all rooms; none has the words of another."""
    rows = [row for room in ROOMS for row in getattr(room, table, {}).items()]
    assert len(dict(rows)) == len(rows)
    return rows


@pytest.mark.parametrize(("words", "call"), rows("CALLS"))
def test_a_call_that_cannot_be_is_refused_in_one_sentence(words, call):
    with warnings.catch_warnings(), pytest.raises(InputError) as error:
        warnings.simplefilter("error")
        call()
    sentence = str(error.value)
    assert words in sentence and sentence.endswith(".") and "\n" not in sentence, sentence


@pytest.mark.parametrize(("words", "changes"), rows("FILES"))
def test_a_value_of_a_file_that_cannot_be_is_refused_with_its_key(monkeypatch, words, changes):
    """Of all that is wrong one line says what is asked here; each line begins with the name of the file."""
    monkeypatch.chdir(ROOT)
    with pytest.raises(InputError) as error:
        parse(changed_file(CONFIG / "paper.yaml", changes), "my.yaml")
    lines = str(error.value).splitlines()
    assert any(words in line for line in lines), lines
    assert all(re.match(r"my\.yaml: |config/", line) and line.endswith(".") for line in lines)


@pytest.mark.parametrize(("command", "words"), rows("COMMANDS"))
def test_a_command_that_cannot_be_ends_with_2_and_writes_nothing(
    tmp_path, monkeypatch, command, words
):
    monkeypatch.chdir(ROOT)
    result = called(command.replace("OUT", str(tmp_path / "out.nc")))
    assert result.exit_code == 2, (result.output, result.exception)
    assert words in result.stderr and not list(tmp_path.iterdir())
    lines = [line for line in result.stderr.splitlines() if not re.match(r"\d{4}-\d\d-\d\d ", line)]
    assert len(lines) == 1  # after what a slow computer says of its progress
