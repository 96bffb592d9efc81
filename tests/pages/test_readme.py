"""The examples of README and tutorial run as they are and obey their laws; files that documents name exist."""

import re

import matplotlib
import numpy as np
import pytest
from project import ROOT, code

TUTORIAL = "docs/tutorials/library.md"


@pytest.fixture(scope="module")
def tutorial(tmp_path_factory):
    """Names after each section of the tutorial, by its heading."""
    names, namespaces = {}, {}
    with pytest.MonkeyPatch.context() as patch, matplotlib.rc_context({"backend": "agg"}):
        patch.chdir(tmp_path_factory.mktemp("tutorial"))
        for heading, block in code(TUTORIAL).items():
            exec(compile(block, TUTORIAL, "exec"), names)
            namespaces[heading] = dict(names)
    return namespaces


def test_discs_part_with_the_coefficient_of_restitution(tutorial):
    velocity = tutorial["Two discs collide"]["result"].velocity[-1, :, 0]
    assert velocity == pytest.approx([-0.5, 0.5], rel=0.01)


def test_floor_and_sides_carry_the_weight(tutorial):
    """Ellipses come to rest; friction at the sides carries or adds little."""
    names = tutorial["Ellipses settle in a box"]
    floor = names["result"].wall_force[-5:, 2] / names["weight"]
    assert floor == pytest.approx(1.0, abs=0.1)
    assert floor == pytest.approx(floor.mean(), rel=1e-3)


def test_a_wedge_without_friction_carries_the_weight_on_both_sides(tutorial):
    """Walls at 60 degrees push with W / (2 cos 60 degrees) = W each."""
    names = tutorial["Discs settle in a wedge"]
    assert names["found"].kinetic_energy < 1e-9  # J, spin included
    weight = 9.81 * names["scene"].mass.sum()
    assert names["result"].wall_force[-1] / weight == pytest.approx([1.0, 1.0], rel=1e-2)


def test_the_ledger_of_a_drawn_bed_adds_up(tutorial):
    ledger = tutorial["Control the run between steps"]["ledger"]
    assert ledger.work > 0.0 and np.abs(ledger.residual) < 1e-2


HOWTO = [f"docs/howto/{page}.md" for page in ("sweep", "shape", "cluster", "recovery")]


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "pyproject.toml", *HOWTO])
def test_the_files_that_a_document_names_exist(name):
    text = (ROOT / name).read_text()
    named = re.findall(r"\b(?:dem|tests|rules|config|docs(?!/_build))/[\w/.]*\w", text)
    assert [path for path in named if not (ROOT / path).exists()] == []
