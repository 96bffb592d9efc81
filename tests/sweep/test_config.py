"""Configurations: the published one says where each number is from, wrong ones are named."""

import datetime
import json
import math
import re
import tempfile
import time
from pathlib import Path

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from project import CONFIG

from dem.base.errors import InputError
from dem.base.yaml_file import read, text_of
from dem.experiment.granule_sizes import sample_diameters
from dem.sweep.config import load, parse
from dem.sweep.json_schema import schema
from dem.sweep.state import SweepState

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


A_LABEL = (
    "it must be a label: a letter from A to Z, then letters, digits, - and _, at most 32 in all."
)
POINTS = {"design": "sobol", "points": 4}
# key, value: a part of the sentence about it
REFUSED = [
    ("colour", "red", "colour is not a known key; there are experiment, box_width,"),
    ("seeds", 5, "seeds is not a known key; the nearest is sweep."),
    ("material.young", 1e9, "material.young is not a known key; there are young_modulus,"),
    ("cylinder.speed", 2.0, "not a known key; there are diameter, velocity, start, stroke,"),
    ("box_width", "20 mm", "box_width is '20 mm'; it must be a number, in m."),
    ("gravity", True, "gravity is true; it must be a number, in m s-2."),
    ("gravity", math.nan, "gravity is nan; it must be finite, at most 1e+20 in size, in m s-2."),
    ("gravity", -1, "gravity is -1; it must be at least 0, in m s-2."),
    ("friction.granule", [0.1, 0.3], "friction.granule is [0.1, 0.3]; it must be a number."),
    ("friction", 0.3, "friction is 0.3; it must be a group of keys; its keys are granule, wall,"),
    ("material.young_modulus", 5e-324, "is 5e-324; it must be positive, at least 1e-20, in Pa."),
    ("material.restitution", 0.0, "material.restitution is 0.0; it must be at least 0.001."),
    ("packing.fraction", 84, "packing.fraction is 84; it must be below 1."),
    ("record.window", [1e-3, 7e-3], "record.window ends at 0.007"),
    ("record.window", [5e-3, 1e-3], "window [0.005, 0.001]"),
    ("record.window", [1e-3], "record.window.1 is missing"),
    ("record.window", [0, 10**400], "it must be finite, at most 1e+20 in size, in m."),
    ("record.snapshots", 8, "record.snapshots - 1, which is 7"),
    ("record.observables", "drag", "record.observables is 'drag'; it must be a list."),
    ("record.observables", ["drags"], "is 'drags'; it must be 'alignment', 'drag'"),
    ("shapes.e1.aspect_ratio", 0.8, "shapes.e1.aspect_ratio is 0.8; it must be at least 1."),
    ("shapes.e1.aspect_ratio", None, "shapes.e1: aspect_ratio is missing"),
    ("shapes.c1.aspect_ratio", 1.5, "shapes.c1: aspect_ratio is 1.5"),
    ("shapes.c1.kind", "disk", "is 'disk'; it must be 'clump', 'disc', 'dumbbell', 'ellipse' or"),
    ("shapes.c1.diameter", 0.03, "shapes.c1.diameter is 0.03"),
    ("cylinder.stroke", 0.05, "cylinder.stroke is 0.05"),
    ("cylinder.start", 0.02, "cylinder.start is 0.02"),
    ("cylinder.start", 0.99, "asks for an impossible run: cylinder.start is 0.99: with shapes.c1"),
    ("cylinder.diameter", 0.021, "cylinder.diameter is 0.021"),
    ("ellipse.contact", "geometric", "it must be 'common_normal' or 'geometric_potential'."),
    ("experiment", "darg", "experiment is 'darg'; it must be 'drag'"),
    (
        "rolling",
        {"granule": 0.1, "wall": 0.1, "cylinder": 0.1},
        "rolling is for discs, and shapes.d1.kind is dumbbell; make the coefficients of rolling",
    ),
    ("numerics.step_fraction", 1.5, "is 1.5; it must be at most 1, or allow_unstable be true."),
    ("results", "results/../..", "it must be results or a folder below it, such as results/mine"),
    ("results", "results/store", "but not that of the store"),
    ("extends", "config/papr.yaml", "config/papr.yaml: cannot read it"),
    ("cases", {"c1": 3}, "cases.c1 is 3; it must be a group of keys; its keys are shape, density."),
    ("cases", {}, "sweep must give all runs a shape or a case; there are c1, d1"),
    ("cases.c1.shape", "C1", "is 'C1', which is not one of shapes; the nearest is c1"),
    ("sweep.seed", 1.5, "sweep.seed is 1.5; it must be a whole number."),
    ("sweep.seed", [1, 2, 1], "sweep.seed has 1 twice; list each once."),
    ("sweep.friction/granule", [0.3, 0.1 + 0.2], "sweep.friction.granule has 0.3 twice; list each"),
    ("title", datetime.date(2020, 1, 1), "title is 2020-01-01; it must be text."),
    ("friction.granule", True, "friction.granule is true; it must be a number."),
    ("friction", {1: 1}, "friction.1 is not a known key; there are granule, wall, cylinder, stif"),
    ("shapes", {False: {}}, "shapes.false is false; it must be a label: a letter from A to Z"),
    ("sweep.seed", [], "sweep.seed is []; it must be a list of values."),
    ("sweep.seed", "1 to 100000", "sweep has 1,100,000 runs; it must have at most 1,000,000."),
    ("sweep.seeds", "1 to 5", "sweep: seeds is no value that can vary; the nearest is seed."),
    ("sweep.case", ["c1", "c13"], "is 'c13', which is not one of cases; the nearest is c1."),
    ("sweep.density", [1e3], "sweep varies density in two ways; name it once."),
    ("sweep.gravity", {"time": [1]}, "it must be a list of values, or factors: {times: [0.5, 2]}."),
    ("sweep.gravity", {"times": ["x"]}, "sweep.gravity is 'x'; it must be a number."),
    ("sweep.material/thickness", [None, None], "sweep.material.thickness has null twice"),
    ("sweep.numerics/allow_unstable", {"times": [2]}, "is false, which has no multiples."),
    ("sweep.friction_granule", [0.1], "no value that can vary; the nearest is friction.granule."),
    ("sweep.record/window", [[0, 1]], "no value that can vary; the nearest is record.bins."),
    ("sweep.p", {"a": {"gravity": 1}, "b": 3}, "sweep: p is no value that can vary"),
    ("sweep.p", {"a": {"gravity": [1, 2]}}, "sweep.p.a.gravity is [1, 2]; it must be a number"),
    ("sweep.p", {"a": {"density": {"times": 2}}}, "sweep.p.a.density is {'times': 2}; it must be"),
    ("sweep.m n", {"a": {"gravity": 1}}, f"a name in sweep is 'm n'; {A_LABEL}"),
    (
        "sweep.p",
        {"a": {"record.bins": 60}},
        "record.bins, which runs of one block share; use blocks.",
    ),
    ("sweep", {"blocks": {"../x": {"case": "all"}}}, f"sweep.blocks.../x is '../x'; {A_LABEL}"),
    ("sweep", {"blocks": {"store": {"case": "all"}}}, "sweep.blocks.store is a folder of results"),
    ("sweep", {"blocks": {"a": 3}}, "sweep.blocks.a is 3; it must be a group of keys."),
    ("sweep", {"blocks": {"a": {None: [1]}}}, "sweep.blocks.a: null is no value that can vary"),
    ("sweep", {"blocks": {"a": {"needs": "b"}}}, "it must be a block before it: there is none."),
    (
        "sweep.p",
        POINTS | {"points": 12, "over": {"gravity": {"low": 0, "high": 1}}},
        "sweep.p: points is 12; a Sobol sequence is even only if it is a power of two: take 8 or 16.",
    ),
    (
        "sweep.p",
        POINTS | {"over": {"gravity": {"low": 0, "high": 1, "scale": "log"}}},
        "low is 0; on a log scale it must be above 0.",
    ),
]


@pytest.mark.parametrize(
    ("key", "value", "words"), REFUSED, ids=[words[:40] for *_, words in REFUSED]
)
def test_a_wrong_value_is_refused_with_its_key_and_what_would_be_right(
    monkeypatch, key, value, words
):
    """What is wrong is said of the value that is wrong, in a sentence that begins with the file."""
    monkeypatch.chdir(CONFIG.parent)
    with pytest.raises(InputError) as error:
        parse(changed([part.replace("/", ".") for part in key.split(".")], value), "my.yaml")
    lines = str(error.value).splitlines()
    assert any(words in line for line in lines), lines
    assert all(
        line.startswith(("my.yaml: ", "config/papr")) and line.endswith(".") for line in lines
    )


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


NO_CONFIGURATION = {
    "a: [1": "line 1: expected ',' or ']'",
    "\t- x: {": "line 1: found character '\\t' that cannot start any token.",
    "a: b\n\0": "special characters are not allowed",
    "just words": "it must hold keys with values",
    "": "it must hold keys with values",
    "a: 1\n---\nb: 2": "line 2: but found another document.",
    "a: !!python/object:os.system x": "line 1: could not determine a constructor for the tag",
    "granules: !!int few": "cannot read it (invalid literal",
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
    f"b: {'[' * 5000}": TOO_MUCH,
    "sweep: &s {case: *s}": f"line 1: {TOO_MUCH}",
    "sweep: {seed: &s [1, *s]}": f"line 1: {TOO_MUCH}",
    f"x-0: &l0 [1, 2]{LISTS}": TOO_MUCH,
    f"x-0: &l0 {{k: 2}}{GROUPS}": TOO_MUCH,
    'a: 1\nbeside: "a\\0b"': f"line 2: a text is 'a\\x00b'; {NO_TEXT}",
    'title: "a \\ud83d"': f"line 1: a text is 'a \\ud83d'; {NO_TEXT}",
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
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)
    assert NO_CONFIGURATION[text] in str(error.value)
    assert time.perf_counter() - start < 60.0  # it would not end otherwise


PLAIN = {
    "1e3": 1e3,
    "8.0e9": 8e9,
    "+.5": 0.5,
    "0x1F": 31,
    "0o17": 15,
    "08": 8,
    "y": "y",
    "~": None,
    "TRUE": True,
    "'010'": "010",
    "'no'": "no",
    "1 to 20": "1 to 20",
    "5 %": "5 %",
    "010": "write 10, or '010'.",
    "-0100": "write -100, or '-0100'.",
    "!!int 010": "write 10, or '010'.",
    "1:30": "write '1:30'.",
    "1_000": "write '1_000'.",
    "0b11": "write '0b11'.",
    "no": "write 'no'.",
    "On": "write 'On'.",
    "2026-11-28": "write '2026-11-28'.",
    "2026-13-45": "write '2026-13-45'.",
}


@pytest.mark.parametrize("text", PLAIN)
def test_a_plain_scalar_means_what_yaml_1_2_says_or_is_refused(tmp_path, text):
    """With its line, and what to write: Snakemake reads a sweep file by YAML 1.1."""
    path, meant = tmp_path / "own.yaml", PLAIN[text]
    path.write_text(f"first: 1\nvalues: [{text}]")
    if isinstance(meant, str) and meant.startswith("write"):
        plain = text.removeprefix("!!int ")
        with pytest.raises(InputError) as error:
            SweepState.of_values(yaml.safe_load(PAPER), [path])
        assert str(error.value).endswith(
            f"own.yaml, line 2: {plain} means another value in YAML 1.1; {meant}"
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


@pytest.mark.parametrize(
    "line",
    [
        line
        for line in PAPER.split("\nsweep:")[0].splitlines()
        if re.search(r":.*(?<![\w.])\d", line.split("#")[0])
    ],
)
def test_every_number_of_the_paper_says_where_it_is_from(line):
    """A line with a number is marked reported, derived, assumed or calibrated."""
    comment = line.partition("#")[2]
    assert re.search(r"\b(reported|derived|assumed|calibrated)\b", comment)


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


NO_SEEDS = "5 to 1;1 to;one to two;1 to 99999999999;1, 1;;-1 to 3;2147483648;1 to 2000000000"


@pytest.mark.parametrize("words", NO_SEEDS.split(";"))
def test_words_that_are_no_seeds_are_refused(words):
    with pytest.raises(InputError, match=r"sweep\.seed") as error:
        parse(changed(("sweep", "seed"), words))
    assert "\n" not in str(error.value)


def test_only_runs_with_snapshots_need_bins_that_fit_them():
    """Runs of the onset of jamming take none."""
    data = changed(["record"], {"bins": 7, "snapshots": 4, "window": [1e-3, 5e-3]})
    data |= {"experiment": "onset"}
    assert parse(data).record.bins == 7
    with pytest.raises(InputError, match=r"record\.bins is 7; it must be a multiple of"):
        parse(data | {"experiment": "drag"})
