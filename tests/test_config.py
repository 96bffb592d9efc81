"""Configurations: the published one says where each number is from, wrong ones are named."""

import copy
import re

import pytest
import yaml
from conftest import CONFIG
from hypothesis import example, given
from hypothesis import strategies as st

from dem.config import Sweep, load, parse, save
from dem.errors import InputError
from dem.room import height_of_box, sample_diameters

PAPER = (CONFIG / "paper.yaml").read_text(encoding="utf-8")


def changed(path, value):
    """The paper's configuration with another value at a path of keys."""
    data = yaml.safe_load(PAPER)
    place = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return data


WRONG = [
    ("colour", "red", "colour is not a known key"),
    ("material.young", 1e9, "material.young is not a known key"),
    ("shapes.c1.density", 1e3, "shapes.c1.density is not a known key"),
    ("box_width", "wide", "box_width is 'wide'"),
    ("seeds", 3, "seeds is 3"),
    ("seeds.0", 1.5, "seeds.0 is 1.5"),
    ("record.bins", "many", "record.bins is 'many'"),
    ("cylinder", [1, 2], "cylinder is [1, 2]"),
    ("gravity", True, "gravity is True"),
    ("seeds.1", True, "seeds.1 is True"),
    ("material.restitution", False, "material.restitution is False"),
    ("gravity", float("nan"), "gravity is nan"),
    ("cylinder.velocity", float("inf"), "cylinder.velocity is inf"),
    ("friction.wall", -0.1, "friction.wall is -0.1"),
    ("material.restitution", 0.0, "material.restitution is 0.0"),
    ("material.restitution", 1.5, "material.restitution is 1.5"),
    ("material.poisson_ratio", 0.7, "material.poisson_ratio is 0.7"),
    ("packing.fraction", 1.0, "packing.fraction is 1.0"),
    ("packing.size_spread", 1.0, "packing.size_spread is 1.0"),
    ("shapes.e1.aspect_ratio", 0.8, "shapes.e1.aspect_ratio is 0.8"),
    ("shapes.e1.aspect_ratio", None, "shapes.e1: aspect_ratio is missing"),
    ("shapes.c1.aspect_ratio", 1.5, "shapes.c1: aspect_ratio is 1.5"),
    ("shapes.c1.kind", "cube", "shapes.c1.kind is 'cube'"),
    ("shapes.c1.granules", 0, "shapes.c1.granules is 0"),
    ("shapes.c1.diameter", 0.03, "shapes.c1.diameter is 0.03"),
    ("cylinder.stroke", 0.05, "cylinder.stroke is 0.05"),
    ("cylinder.start", 0.02, "cylinder.start is 0.02"),
    ("cylinder.diameter", 0.021, "cylinder.diameter is 0.021"),
    ("record.window", [1e-3, 7e-3], "record.window ends at 0.007"),
    ("record.window", [5e-3, 1e-3], "window [0.005, 0.001]"),
    ("record.window", [1e-3], "record.window.1 is missing"),
    ("record.snapshots", 8, "snapshots - 1 (7)"),
    ("cases.c1.shape", "c9", "cases.c1.shape is 'c9'"),
    ("cases.c12.density", 3.9e3, "cases.c12 repeats cases.c1"),
    ("cases", {}, "cases is {}"),
    ("seeds", [1, 2, 1], "seeds has a seed twice"),
    ("seeds", [], "seeds is []"),
    ("seeds.0", -1, "seeds.0 is -1"),
    ("results", "results/../..", "results is 'results/../..'"),
    ("results", "/tmp/results", "results is '/tmp/results'"),
    ("results", "elsewhere", "results is 'elsewhere'"),
    ("ellipse.contact", "guess", "ellipse.contact is 'guess'"),
    ("numerics.step_fraction", 1.0, "numerics.step_fraction is 1.0"),
    ("numerics.time_step", 0.0, "numerics.time_step is 0.0"),
]


@pytest.mark.parametrize(("key", "value", "words"), WRONG, ids=[f"{k}={v}" for k, v, _ in WRONG])
def test_wrong_values_are_named(key, value, words):
    """What can not be simulated is refused with a sentence that names key and value."""
    path = [int(part) if part.isdigit() else part for part in key.split(".")]
    with pytest.raises(InputError) as error:
        parse(changed(path, value), "my.yaml")
    lines = str(error.value).splitlines()
    assert any(words in line for line in lines), lines
    assert all(line.startswith("my.yaml: ") and line.endswith(".") for line in lines)


def test_all_faults_are_told_at_once():
    """Two mistakes give two sentences."""
    data = changed(["gravity"], -1)
    del data["box_width"]
    with pytest.raises(InputError) as error:
        parse(data)
    assert len(str(error.value).splitlines()) == 2


@pytest.mark.parametrize("text", [
    "a: [1", "\t- x: {", "\0", "just words", "", "a: !!python/object:os.system x",
    "title: 2024-13-45", "title: 2001-01-01 99:99:99", "seeds: [" + "9" * 5000 + "]", "[" * 5000,
])  # fmt: skip
def test_files_that_are_no_configuration_are_named(tmp_path, text):
    """Whatever stands in a file, reading it ends in an InputError with the file's name."""
    path = tmp_path / "broken.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"broken\.yaml"):
        load(path)


def test_files_that_can_not_be_read_are_named(tmp_path):
    """No file, a folder and bytes that are no text are errors with a name."""
    (tmp_path / "bytes.yaml").write_bytes(b"\xff\xfe\xfa")
    for name in ("none.yaml", "", "bytes.yaml"):
        with pytest.raises(InputError, match=re.escape(str(tmp_path / name))):
            load(tmp_path / name)


def test_paper_has_eleven_cases_and_55_replicates():
    """The published sweep: 11 cases of five seeds, at two densities, as in Table 1."""
    sweep = load(CONFIG / "paper.yaml")
    assert len(sweep.cases) == 11 and len(sweep.cases) * len(sweep.seeds) == 55
    assert {case.density for case in sweep.cases.values()} == {3.9e3, 3.9e4}
    assert {k: s.ratio for k, s in sweep.shapes.items()} == {
        "c1": 1.0, "d1": 2.0, "c2": 1.0, "e1": 1.125, "e2": 1.25, "e3": 1.375, "e0": 1.0,
    }  # fmt: skip
    assert sweep.record.window == (1e-3, 5e-3) and sweep.packing.fraction == 0.84


@pytest.mark.parametrize("line", [
    line for line in PAPER.split("\naccuracy:")[0].splitlines() if re.search(r":.*(?<![\w.])\d", line.split("#")[0])
])  # fmt: skip
def test_every_number_of_the_paper_says_where_it_is_from(line):
    """A line with a number is marked reported, derived, assumed or calibrated."""
    comment = line.partition("#")[2]
    assert re.search(r"\b(reported|derived|assumed|calibrated)\b", comment)


def test_box_holds_the_sampled_granules_and_the_cylinder():
    """Granules of diameters within the spread fill the asked share of the box, seed by seed."""
    sweep = load(CONFIG / "paper.yaml")
    heights = set()
    for seed in sweep.seeds:
        sizes = sample_diameters(sweep.shapes["c1"], 0.2, seed)
        assert sizes.min() >= 0.8 * 1092e-6 and sizes.max() <= 1.2 * 1092e-6
        assert abs(sizes.mean() / 1092e-6 - 1.0) < 0.03 and sizes.std() > 0.1 * 1092e-6
        height = height_of_box(sweep, sizes)
        holes = 20e-3 * height - 3.14159265358979 * (3.175e-3 / 2) ** 2
        assert abs(3.14159265358979 / 4 * (sizes**2).sum() / holes - 0.84) < 1e-12
        heights.add(height)
    assert len(heights) == 5


def test_saved_configuration_is_the_same(tmp_path):
    """Writing a configuration and reading it again changes nothing."""
    for name in ("paper.yaml", "smoke.yaml"):
        sweep = load(CONFIG / name)
        save(sweep, tmp_path / name)
        assert load(tmp_path / name) == sweep


@pytest.mark.parametrize("words, seeds", [
    ("1 to 5", (1, 2, 3, 4, 5)), ("7, 1 to 3", (7, 1, 2, 3)), ("12", (12,)), ([3, 1, 2], (3, 1, 2)),
])  # fmt: skip
def test_seeds_may_be_words(words, seeds):
    """And are saved as words, in their order: a sweep of a million has a short file."""
    sweep = parse(changed(("seeds",), words))
    assert sweep.seeds == seeds
    assert parse(changed(("seeds",), sweep.model_dump()["seeds"])).seeds == seeds


@pytest.mark.parametrize("words", ["5 to 1", "1 to", "one to two", "1 to 99999999999", "0 to 999999999", "1, 1", "", "-1 to 3", "2147483648 to 2147583647"])  # fmt: skip
def test_words_that_are_no_seeds_are_refused(words):
    with pytest.raises(InputError, match="seeds") as error:
        parse(changed(("seeds",), words))
    assert "\n" not in str(error.value)


def leaves(data, path=()):
    """Paths of all values and groups of a configuration."""
    if path:
        yield path
    if isinstance(data, dict | list):
        for key, value in data.items() if isinstance(data, dict) else enumerate(data):
            yield from leaves(value, (*path, key))


JUNK = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**6), 10**6) | st.floats() | st.text(max_size=20)
    | st.dates() | st.binary(max_size=5)
    | st.sampled_from([10**400, -(10**30), 1e308, 5e-324, "1e9", "nan", "c1", "results/../x"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)  # fmt: skip


@given(st.sampled_from(list(leaves(yaml.safe_load(PAPER)))), JUNK)
@example(("cylinder", "diameter"), 1e308)
@example(("shapes", "c1", "diameter"), 1e308)
@example(("record", "window", 1), 10**400)
def test_any_corruption_is_read_or_refused(path, junk):
    """Junk in place of any value is a configuration or an InputError, never anything else."""
    data = changed(path, copy.deepcopy(junk))
    try:
        sweep = parse(data, "my.yaml")
    except InputError as error:
        assert str(error).startswith("my.yaml: ")
    else:
        assert isinstance(sweep, Sweep)
