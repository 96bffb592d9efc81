"""Configurations: the published one says where each number is from, wrong ones are named."""

import json
import re

import numpy as np
import pytest
import yaml
from jsonschema import Draft202012Validator
from numpy.testing import assert_allclose
from project import CONFIG

from dem.base.errors import InputError
from dem.base.yaml_file import read
from dem.experiment.granule_sizes import sample_diameters
from dem.sweep.config import load, parse
from dem.sweep.json_schema import schema

pytestmark = pytest.mark.quick

FILES = [
    path
    for path in [*CONFIG.glob("*.yaml"), *CONFIG.parent.glob("studies/**/*.yaml")]
    if path.name not in ("catalogue.yaml", "calibration.yaml")  # no sweeps
]
PAPER = (CONFIG / "paper.yaml").read_text(encoding="utf-8")


def changed(path, value):
    """The paper's configuration with another value at a path of keys."""
    data = yaml.safe_load(PAPER)
    group = data
    for key in path[:-1]:
        group = group[key]
    group[path[-1]] = value
    return data


@pytest.mark.parametrize(("faults", "last"), [(20, "cases.c19 is 1;"), (21, "and 1 more.")])
def test_all_faults_are_told_at_once_but_of_many_only_twenty(faults, last):
    with pytest.raises(InputError) as error:
        parse(changed(["cases"], {f"c{n}": 1 for n in range(faults)}), "my.yaml")
    lines = str(error.value).splitlines()
    assert len(lines) == min(faults, 21) and lines[-1].startswith(f"my.yaml: {last}")


@pytest.mark.parametrize("key", ["box_width", "results", "material.young_modulus"])
def test_a_missing_value_is_described(key):
    """What is missing is named, with what it is."""
    data = yaml.safe_load(PAPER)
    *groups, last = key.split(".")
    del (data[groups[0]] if groups else data)[last]
    with pytest.raises(InputError, match=rf"my\.yaml: {key} is missing; it is the "):
        parse(data, "my.yaml")


@pytest.mark.parametrize(
    "files", [["1", "0"], [*map(str, range(1, 100)), "base"]], ids=["circle", "many"]
)
def test_files_that_extend_each_other_without_end_are_refused(tmp_path, files):
    (tmp_path / "base.yaml").write_text(PAPER)
    for number, base in enumerate(files):
        text = f"extends: {base}.yaml\nresults: results/own\n"
        (tmp_path / f"{number}.yaml").write_text(text)
    with pytest.raises(
        InputError, match=r"more than 64 files extend each other, perhaps in a circle"
    ):
        load(tmp_path / "0.yaml")


def test_a_file_extends_another(tmp_path):
    """Values beside those of the other file; what varies is its own, and results must be. Keys for anchors are
    ignored at the top of both, also by editors; elsewhere they are no keys."""
    (tmp_path / "base.yaml").write_text(f"x-notes: [1, 2]\n{PAPER}")
    path = tmp_path / "own.yaml"
    text = "x-rough: &rough {granule: 0.5, wall: 0.5}\nextends: base.yaml\nresults: results/own\nfriction: {<<: *rough, wall: 0.1}\n"
    path.write_text(f"{text}sweep: {{shape: c1}}\n")
    sweep = load(path)
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


def test_a_whole_number_may_be_a_text():
    """As those of a group are that Snakemake's --config changes."""
    sweep = parse(changed(["sweep"], {"case": "c1", "seed": ["3", "089"]}) | {"batch": "20"})
    assert sweep.batch == 20 and sweep.block("drag").axes[-1].coordinate == [3, 89]


def test_paper_has_eleven_cases_and_55_replicates():
    """The published sweep: 11 cases of five seeds, at two densities, as in Table 1."""
    sweep = load(CONFIG / "paper.yaml")
    assert sweep.block("drag").shape == (11, 5) and len(list(sweep.block("drag").unique())) == 55
    assert {case.density for case in sweep.cases.values()} == {3.9e3, 3.9e4}
    ratios = {"c1": 1, "d1": 2, "c2": 1, "e1": 1.125, "e2": 1.25, "e3": 1.375, "e0": 1}
    assert {label: shape.ratio for label, shape in sweep.shapes.items()} == ratios
    assert sweep.record.window == (1e-3, 5e-3) and sweep.packing.fraction == 0.84


def test_every_number_of_the_paper_says_where_it_is_from():
    """A line with a number is marked reported, derived, assumed or calibrated."""
    for line in PAPER.split("\nsweep:")[0].splitlines():
        value, _, comment = line.partition("#")
        if re.search(r":.*(?<![\w.])\d", value):
            assert re.search(r"\b(reported|derived|assumed|calibrated)\b", comment), line


def test_diameters_are_within_the_spread():
    """Seed by seed others."""
    section = load(CONFIG / "paper.yaml").shapes["c1"]
    sizes = np.array([sample_diameters(section, 0.2, seed) for seed in range(1, 6)]) / 1092e-6
    assert sizes.min() >= 0.8 and sizes.max() <= 1.2 and (sizes.std(axis=1) > 0.1).all()
    assert_allclose(sizes.mean(axis=1), 1.0, atol=0.03)
    assert len(set(sizes[:, 0])) == 5


def test_the_schema_of_editors_is_that_of_the_code():
    """After a change: python -m dem.sweep.json_schema."""
    assert json.loads((CONFIG / "schema.json").read_text(encoding="utf-8")) == schema()


@pytest.mark.parametrize("path", FILES, ids=lambda path: "/".join(path.parts[-2:]))
def test_editors_take_each_file_that_comes_with_the_code(path):
    """Its first line names the schema for them; they refuse what is mistyped."""
    data = json.loads(json.dumps(read(path)))  # whose keys are texts
    validator = Draft202012Validator(schema())
    head = path.read_text(encoding="utf-8").partition("\n")[0]
    named = path.parent / head.removeprefix("# yaml-language-server: $schema=")
    assert named.samefile(CONFIG / "schema.json") and not list(validator.iter_errors(data))
    for wrong in ({"gravity": -1}, {"shapes": {"c1": {"kin": "disc"}}}):
        assert list(validator.iter_errors(data | wrong))


@pytest.mark.parametrize(
    ("words", "seeds"),
    [("1 to 3", [1, 2, 3]), ("7, 1 to 3", [1, 2, 3, 7]), ("12", [12]), ([3, 1], [1, 3]), (4, [4])],
)
def test_seeds_may_be_words(words, seeds):
    """And are kept as words: a sweep of a million has a short file."""
    sweep = parse(changed(("sweep", "seed"), words))
    assert sweep.block("drag").axes[-1].coordinate == seeds
    assert sweep.dump()["sweep"]["seed"] == words


def test_only_runs_with_snapshots_need_bins_that_fit_them():
    """Runs of the onset of jamming take none; what a run of the drag needs is in tests/refusals."""
    data = changed(["record"], {"bins": 7, "snapshots": 4, "window": [1e-3, 5e-3]})
    assert parse(data | {"experiment": "onset"}).record.bins == 7
