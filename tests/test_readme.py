"""The README's examples run as they are, and the files that documents name exist."""

import re
from pathlib import Path

import pytest
from mutants import MUTANTS

ROOT = Path(__file__).parent.parent
BLOCKS = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
LIBRARY = [block for block in BLOCKS if "dem.Scene" in block or "dem.pack" in block]


def run(block):
    names = {}
    exec(compile(block, "README.md", "exec"), names)
    return names


def test_discs_part_with_the_coefficient_of_restitution():
    """The first example: two discs collide in empty space."""
    velocity = run(LIBRARY[0])["result"].state.velocity[:, 0]
    assert velocity == pytest.approx([-0.5, 0.5], rel=0.01)


def test_floor_and_sides_carry_the_weight():
    """The second example: ellipses come to rest; friction at the sides carries or adds little."""
    names = run(LIBRARY[1])
    floor = names["result"].wall_force[-5:, 2] / (9.81 * names["scene"].mass.sum())
    assert floor == pytest.approx(1.0, abs=0.1)
    assert floor == pytest.approx(floor.mean(), rel=1e-3)


def test_a_bed_resists_the_cylinder():
    """The third example: a cylinder in a packed bed; there are no more."""
    names = run(LIBRARY[2])
    assert -names["result"].cylinder_force[1:, 1].mean() > 0.0
    assert len(LIBRARY) == 3


HOWTO = [f"docs/howto/{page}.md" for page in ("sweep", "shape", "cluster", "recovery")]


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "pyproject.toml", *HOWTO])
def test_the_files_that_a_document_names_exist(name):
    named = re.findall(r"\b(?:dem|tests|rules|config|docs)/[\w/.]*\w", (ROOT / name).read_text())
    assert [each for each in named if not (ROOT / each).exists()] == []


def test_a_mutant_finds_the_line_that_it_breaks():
    for mutant in MUTANTS:
        assert (ROOT / mutant.file).read_text().count(mutant.right) == 1, mutant.fault
