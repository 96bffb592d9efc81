"""Configurations: the published one says where each number is from, wrong ones are named."""

import json
import re

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from project import CONFIG, changed_file

from dem.base.errors import InputError
from dem.base.yaml_file import read
from dem.experiment.bed_description import sample_diameters
from dem.sweep.config import load, parse
from dem.sweep.json_schema import schema

pytestmark = pytest.mark.quick

FILES = [
    path
    for path in [*CONFIG.glob("*.yaml"), *CONFIG.parent.glob("studies/**/*.yaml")]
    if path.name not in ("catalogue.yaml", "calibration.yaml")  # no sweeps
]
PAPER = CONFIG / "paper.yaml"


def test_all_faults_are_told_at_once_but_of_many_only_twenty():
    with pytest.raises(InputError) as error:
        parse(changed_file(PAPER, {"cases": {f"c{n}": 1 for n in range(21)}}), "my.yaml")
    lines = str(error.value).splitlines()
    assert "cases.c19 is 1;" in lines[19] and lines[20:] == ["my.yaml: and 1 more."]


def test_files_that_extend_each_other_without_end_are_refused(tmp_path):
    for name, base in ("0", "1"), ("1", "0"):
        (tmp_path / f"{name}.yaml").write_text(f"extends: {base}.yaml\nresults: results/own\n")
    words = "more than 64 files extend each other, perhaps in a circle"
    with pytest.raises(InputError, match=words):
        load(tmp_path / "0.yaml")


def test_a_file_extends_another(tmp_path):
    """Values beside those of the other file; what varies is its own, and results must be. Keys for anchors are
    ignored at the top of both, also by editors; elsewhere they are no keys. Null takes a label out."""
    (tmp_path / "base.yaml").write_text("x-notes: [1, 2]\n" + PAPER.read_text(encoding="utf-8"))
    path = tmp_path / "own.yaml"
    text = "x-rough: &rough {granule: 0.5, wall: 0.5}\nextends: base.yaml\nresults: results/own\nfriction: {<<: *rough, wall: 0.1}\n"
    text += "cases: {e0: null}\n"
    path.write_text(f"{text}sweep: {{shape: c1}}\n")
    sweep = load(path)
    assert len(sweep.cases) == 10 and "e0" not in sweep.cases
    friction = sweep.friction
    assert (friction.granule, friction.wall, friction.cylinder) == (0.5, 0.1, 0.3)
    assert sweep.blocks == {"drag": {"shape": "c1"}} and "x-rough" not in sweep.dump()
    assert not list(Draft202012Validator(schema()).iter_errors(read(path)))
    for wrong, words in (
        (text + "numerics: {x-a: 1}\n", r"numerics\.x-a is not a known key"),
        (text.replace("results: results/own\n", ""), "results is missing"),
    ):
        path.write_text(wrong)
        with pytest.raises(InputError, match=words):
            load(path)


def test_paper_has_eleven_cases_and_55_replicates():
    """The published sweep: 11 cases of five seeds, at two densities, as in Table 1."""
    sweep = load(PAPER)
    block = sweep.block("drag")
    assert block.shape == (11, 5) and len(block.points) == 55
    assert {case.density for case in sweep.cases.values()} == {3.9e3, 3.9e4}
    ratios = {"c1": 1, "d1": 2, "c2": 1, "e1": 1.125, "e2": 1.25, "e3": 1.375, "e0": 1}
    assert {label: shape.ratio for label, shape in sweep.shapes.items()} == ratios
    assert sweep.record.window == (1e-3, 5e-3) and sweep.packing.fraction == 0.84


def test_every_number_of_the_paper_says_where_it_is_from():
    """A line with a number is marked reported, derived, assumed or calibrated."""
    for line in PAPER.read_text(encoding="utf-8").split("\nsweep:")[0].splitlines():
        value, _, comment = line.partition("#")
        if re.search(r":.*(?<![\w.])\d", value):
            assert re.search(r"\b(reported|derived|assumed|calibrated)\b", comment), line


def test_diameters_are_within_the_spread():
    """Seed by seed others."""
    section = load(PAPER).shapes["c1"]
    off = (
        np.array(
            [
                sample_diameters(section.diameter, section.granules, 0.2, seed)
                for seed in range(1, 6)
            ]
        )
        / 1092e-6
        - 1.0
    )
    assert abs(off).max() <= 0.2 and abs(off.mean(axis=1)).max() < 0.03
    assert off.std(axis=1).min() > 0.1 and len({*off[:, 0]}) == 5


def test_the_schema_of_editors_is_that_of_the_code():
    """After a change: python -m dem.sweep.json_schema."""
    assert json.loads((CONFIG / "schema.json").read_text(encoding="utf-8")) == schema()


def test_editors_take_each_file_that_comes_with_the_code():
    """Its first line names the schema for them; they refuse what is mistyped."""
    validator = Draft202012Validator(schema())
    for path in FILES:
        data = json.loads(json.dumps(read(path)))  # whose keys are texts
        head = path.read_text(encoding="utf-8").partition("\n")[0]
        named = path.parent / head.removeprefix("# yaml-language-server: $schema=")
        assert named.samefile(CONFIG / "schema.json") and not [*validator.iter_errors(data)], path
        for wrong in ({"gravity": -1}, {"shapes": {"c1": {"kin": "disc"}}}):
            assert not validator.is_valid(data | wrong)


@pytest.mark.parametrize(
    ("words", "seeds"), [("7, 1 to 3", [1, 2, 3, 7]), ([3, "089"], [3, 89]), (4, [4])]
)
def test_seeds_may_be_words(words, seeds):
    """And are kept as words: a sweep of a million has a short file. A whole number may be a text, as those of a group
    are that Snakemake's --config changes."""
    sweep = parse(changed_file(PAPER, {"sweep.seed": words, "batch": "20"}))
    assert sweep.block("drag").axes[-1].coordinate == seeds and sweep.batch == 20
    assert sweep.dump()["sweep"]["seed"] == words
