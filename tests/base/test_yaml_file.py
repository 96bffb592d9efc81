"""YAML files mean what version 1.2 says, or are refused with their line."""

import tempfile
import time
from pathlib import Path

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st
from project import CONFIG, quick

from dem.base.errors import InputError
from dem.base.yaml_file import read, text_of
from dem.sweep.config import load
from dem.sweep.state import SweepState

PAPER = (CONFIG / "paper.yaml").read_text(encoding="utf-8")
NO_CONFIGURATION = {
    "a: [1": "line 1: expected ',' or ']'",
    "\t- x: {": "line 1: found character '\\t' that cannot start any token.",
    "a: b\n\0": "special characters are not allowed",
    "": "it must hold keys with values",
    "a: 1\n---\nb: 2": "line 2: but found another document.",
    "a: !!python/object:os.system x": "line 1: could not determine a constructor for the tag",
    "a: 1\nb: 2\n'a': 3": "line 3: 'a' is a key here and in line 1; remove one.",
    PAPER + "\ncases: {}": "'cases' is a key here and in line ",
}
TOO_MUCH = (
    "it has more than 1,000,000 values, or they are nested more than 64 deep or in themselves."
)
NO_TEXT = "it must have at most 1,000 letters, all of them printable."
LEVELS = [(n, ", ".join(9 * [f"*l{n - 1}"])) for n in range(1, 10)]
LISTS = "".join(f"\nx-{n}: &l{n} [{parts}]" for n, parts in LEVELS)
GROUPS = "".join(f"\nx-{n}: &l{n} {{<<: [{parts}]}}" for n, parts in LEVELS)
NO_CONFIGURATION |= {
    f"a: 1\nb: {'[' * 70}{']' * 70}": f"line 2: {TOO_MUCH}",
    "sweep: &s {case: *s}": f"line 1: {TOO_MUCH}",
    f"x-0: &l0 [1, 2]{LISTS}": TOO_MUCH,
    f"x-0: &l0 {{k: 2}}{GROUPS}": TOO_MUCH,
    'a: 1\nbeside: "a\\0b"': f"line 2: a text is 'a\\x00b'; {NO_TEXT}",
    'shapes: {"c\\udc00": 1}': f"line 1: a text is 'c\\udc00'; {NO_TEXT}",
    f"title: {'long ' * 1000}": f"line 1: a text is '{'long ' * 8}'; {NO_TEXT}",
}


@pytest.mark.parametrize("text", NO_CONFIGURATION, ids=range(len(NO_CONFIGURATION)))
def test_files_that_are_no_configuration_are_refused(tmp_path, text):
    """Reading any YAML file ends at once, in a sentence with its name and line."""
    path, start = tmp_path / "broken.yaml", time.perf_counter()
    path.write_text(text)
    with pytest.raises(InputError) as error:
        load(path)
    sentence = str(error.value)
    assert sentence.startswith(str(path)) and "\n" not in sentence
    assert NO_CONFIGURATION[text] in sentence
    assert time.perf_counter() - start < 60.0  # it would not end otherwise


PLAIN = {
    "1e3": 1e3,
    "0x1F": 31,
    "08": 8,
    "y": "y",
    "~": None,
    "'010'": "010",
    "010": "write 10, or '010'.",
    "1:30": "write '1:30'.",
    "no": "write 'no'.",
    "2026-11-28": "write '2026-11-28'.",
}


@quick
@pytest.mark.parametrize("text", PLAIN)
def test_a_plain_scalar_means_what_yaml_1_2_says_or_is_refused(tmp_path, text):
    """With its line, and what to write: Snakemake reads a sweep file by YAML 1.1."""
    path, meant = tmp_path / "own.yaml", PLAIN[text]
    path.write_text(f"first: 1\nvalues: [{text}]")
    if isinstance(meant, str) and meant.startswith("write"):
        with pytest.raises(InputError) as error:
            SweepState.of_values(yaml.safe_load(PAPER), [path])
        assert str(error.value).endswith(
            f"own.yaml, line 2: {text} means another value in YAML 1.1; {meant}"
        )
    else:
        (value,) = read(path)["values"]
        assert value == meant and isinstance(value, str) == isinstance(meant, str)


@given(st.text("0123456789.eE+-_:oxnyNO", max_size=5))
@example("1e3")
@example("08")
def test_a_resolved_file_has_the_same_values_for_all_readers(text):
    """Texts that only one of YAML 1.1 and 1.2 takes for numbers are in quotes."""
    values = {"title": text, text: 1e-5, "list": [1e20, 3, None, True]}
    written = text_of(values)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "config.yaml")
        path.write_text(written)
        assert read(path) == yaml.safe_load(written) == values
