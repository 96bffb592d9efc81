"""Configurations: the published one says where each number is from, wrong ones are named."""

import json
import re

import pytest
import yaml
from jsonschema import Draft202012Validator
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


@pytest.mark.parametrize(
    ("faults", "last"), [(20, "cases.c19 is 1;"), (21, "and 1 more."), (200, "and 180 more.")]
)
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
    "files", [["0"], ["1", "0"], [*map(str, range(1, 100)), "base"]], ids=["itself", "two", "many"]
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


@pytest.mark.parametrize("key", ["extends", "experiment", "shapes.c1.kind"])
def test_a_name_that_is_too_long_for_a_file_is_a_wrong_value(key):
    name = 300 * "n"
    ends = {"extends": ".yaml", "experiment": ".py"}
    with pytest.raises(InputError, match=name):
        parse(changed(key.split("."), name + ends.get(key, ".Own")) | {"results": "results/own"})


def test_keys_for_anchors_are_ignored(tmp_path):
    """At the top of a file and of that which it extends, also by editors; elsewhere they are no keys."""
    (tmp_path / "base.yaml").write_text(f"x-notes: [1, 2]\n{PAPER}")
    path = tmp_path / "own.yaml"
    text = "x-rough: &rough {granule: 0.5, wall: 0.5}\nextends: base.yaml\nresults: results/own\nfriction: {<<: *rough, wall: 0.1}\n"
    path.write_text(text)
    sweep = load(path)
    assert (sweep.friction.granule, sweep.friction.wall) == (0.5, 0.1)
    assert "x-rough" not in sweep.dump() and not list(
        Draft202012Validator(schema()).iter_errors(read(path))
    )
    path.write_text(text + "numerics: {x-a: 1}\n")
    with pytest.raises(InputError, match=r"numerics\.x-a is not a known key"):
        load(path)


def test_a_whole_number_may_be_a_text():
    """As those of a group are that Snakemake's --config changes."""
    sweep = parse(changed(["sweep"], {"case": "c1", "seed": ["3", "089"]}) | {"batch": "20"})
    assert sweep.batch == 20 and sweep.block("drag").axes[-1].coordinate == [3, 89]


def test_paper_has_eleven_cases_and_55_replicates():
    """The published sweep: 11 cases of five seeds, at two densities, as in Table 1."""
    sweep = load(CONFIG / "paper.yaml")
    assert len(sweep.cases) == 11 and sweep.block("drag").shape == (11, 5)
    assert len(list(sweep.block("drag").unique())) == 55
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
    sweep, totals = load(CONFIG / "paper.yaml"), set()
    for seed in range(1, 6):
        sizes = sample_diameters(sweep.shapes["c1"], 0.2, seed)
        assert sizes.min() >= 0.8 * 1092e-6 and sizes.max() <= 1.2 * 1092e-6
        assert abs(sizes.mean() / 1092e-6 - 1.0) < 0.03 and sizes.std() > 0.1 * 1092e-6
        totals.add(sizes.sum())
    assert len(totals) == 5


def test_the_schema_of_editors_is_that_of_the_code():
    """After a change: python -m dem.sweep.json_schema."""
    assert json.loads((CONFIG / "schema.json").read_text(encoding="utf-8")) == schema()


def as_editors_read(data):
    """Values as YAML 1.2 has them, where 3.9e3 is a number, and keys are texts."""
    if isinstance(data, dict):
        return {str(key): as_editors_read(value) for key, value in data.items()}
    if isinstance(data, list):
        return [as_editors_read(value) for value in data]
    try:
        return float(data) if isinstance(data, str) else data
    except ValueError:
        return data


@pytest.mark.parametrize("path", FILES, ids=lambda path: "/".join(path.parts[-2:]))
def test_editors_take_each_file_that_comes_with_the_code(path):
    """Its first line names the schema for them; they refuse what is mistyped."""
    data, validator = as_editors_read(read(path)), Draft202012Validator(schema())
    head = path.read_text(encoding="utf-8").partition("\n")[0]
    named = path.parent / head.removeprefix("# yaml-language-server: $schema=")
    assert named.samefile(CONFIG / "schema.json") and not list(validator.iter_errors(data))
    for wrong in ({"gravty": 0}, {"gravity": -1}, {"shapes": {"c1": {"kin": "disc"}}}):
        assert list(validator.iter_errors(data | wrong))


@pytest.mark.parametrize(
    "words, seeds",
    [
        ("1 to 5", [1, 2, 3, 4, 5]),
        ("7, 1 to 3", [1, 2, 3, 7]),
        ("12", [12]),
        ([3, 1, 2], [1, 2, 3]),
        (4, [4]),
    ],
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
