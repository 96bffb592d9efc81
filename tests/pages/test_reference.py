"""The reference lacks no key, variable, verb or public name; test_pages.py asks whether it is of today."""

import json
import re

import netCDF4
import pytest
from command_line import called
from project import ROOT
from typer.main import get_command

import dem
from dem.cli.app import app
from dem.experiment.kinds import EXPERIMENTS
from dem.sweep.axis import RUN_KEYS
from dem.sweep.design import Choice, Design, Range
from dem.sweep.expand import WORDS
from dem.sweep.precision import Until

pytestmark = pytest.mark.quick
SCHEMA = json.loads((ROOT / "config/schema.json").read_text(encoding="utf-8"))


def page(name):
    return (ROOT / f"docs/reference/{name}.md").read_text(encoding="utf-8")


def tables(name):
    """Names in the first column of each table of a page, by each name of the heading above it."""
    for part in page(name).split("\n## "):
        head = part.partition("\n| ")[0]
        cells = re.findall(r"^\| (`.*?) \|", part, re.M)
        listed = {word for cell in cells for word in re.findall(r"`([^`]+)`", cell)}
        yield from ((place, listed) for place in re.findall(r"`([^`]+)`", head) or [""])


def sections(form=SCHEMA, path=""):
    """Keys of each section of the schema, by its path."""
    yield path, {*form["properties"]}
    for name, value in form["properties"].items():
        for section in {*re.findall(r"#/\$defs/(\w+)", json.dumps(value))} - {"Block"}:
            below = f"{path}.{name}" + ".LABEL" * ("patternProperties" in value)
            yield from sections(SCHEMA["$defs"][section], below.removeprefix("."))


def test_the_reference_has_every_key_of_a_sweep_file():
    listed = dict(tables("keys"))
    assert {path: listed.get(path) for path, _ in sections()} == dict(sections())


def test_the_reference_has_the_whole_grammar_of_a_sweep():
    listed = [keys for _, keys in tables("keys")]
    assert all({*model.model_fields} in listed for model in (Until, Design, Range))
    derived = EXPERIMENTS["jamming"]["DERIVES"]
    options = {name for values, _ in derived.values() for name in values}
    words = {"case", "blocks", "times", "derive", *RUN_KEYS, *WORDS, *Choice.model_fields}
    grammar = page("keys").partition("## `sweep`\n")[2]
    assert words | derived.keys() | options <= {*re.findall(r"\w+", grammar)}


KINDS = "drag", "flow", "snapshots", "scene", "onset", "shear", "intruders"
RUNS = [path for name in KINDS for path in ROOT.glob(f"*/*/{name}.nc")]


@pytest.mark.parametrize("path", RUNS, ids=lambda path: path.name)
def test_the_reference_has_every_variable_of_a_file_of_runs(path):
    """But for values that vary, which have the names of their keys, and axes that a user has named."""
    keys = "|".join(f"{head}.{key}".strip(".") for head, keys in sections() for key in keys)
    keys = keys.replace(".", "_").replace("LABEL", r"\w+")
    known = {name for _, names in tables("variables") for name in names}
    with netCDF4.Dataset(path) as file:
        for name, variable in file.variables.items():
            own = getattr(variable, "long_name", "") == "values that go together"
            assert own or name in known or re.fullmatch(f"({keys})(_swept)?", name), name


def test_the_reference_has_every_verb_with_its_options():
    listed = dict(tables("verbs"))
    for verb in get_command(app).commands:
        options = re.findall(r"(?<![\w-])--[a-z]+(?:-[a-z]+)*", called(f"{verb} --help").output)
        assert {*options} - {"--help"} <= listed[f"dem {verb}"], verb


@pytest.mark.parametrize("name", ["names", "api"])
def test_the_reference_has_every_public_name(name):
    listed = re.findall(r"^(?:   ~?|\| \[`)([A-Za-z]\w*)", page(name), re.M)
    assert {*dem.__all__} <= {*listed}
