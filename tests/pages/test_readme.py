"""The examples of README and tutorial run as they are and obey their laws; files that documents name exist."""

import re

import matplotlib
import numpy as np
import pytest
from project import ROOT, code

TUTORIAL = "docs/tutorials/library.md"


def test_the_scenes_of_the_tutorial_obey_their_laws(folder):
    """Its sections run one after another, with the names of those before."""
    names, after = {}, {}
    with matplotlib.rc_context({"backend": "agg"}):
        for heading, block in code(TUTORIAL).items():
            exec(compile(block, TUTORIAL, "exec"), names)
            after[heading] = dict(names)

    # discs part with the coefficient of restitution
    velocity = after["Two discs collide"]["result"].velocity[-1, :, 0]
    assert velocity == pytest.approx([-0.5, 0.5], rel=0.01)

    # the floor carries the weight of ellipses at rest; friction at the sides carries or adds little
    box = after["Ellipses settle in a box"]
    floor = box["result"].wall_force[-5:, 2] / box["weight"]
    assert floor == pytest.approx(1.0, abs=0.1)

    # walls of a wedge at 60 degrees push with W / (2 cos 60 degrees) = W each
    wedge = after["Discs settle in a wedge"]
    weight = 9.81 * wedge["scene"].mass.sum()
    assert wedge["result"].wall_force[-1] / weight == pytest.approx([1.0, 1.0], rel=1e-2)

    ledger = after["Control the run between steps"]["ledger"]
    assert ledger.work > 0.0 and np.abs(ledger.residual) < 1e-2


HOWTO = [f"docs/howto/{page}.md" for page in ("sweep", "shape", "cluster", "recovery")]


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "pyproject.toml", *HOWTO])
def test_the_files_that_a_document_names_exist(name):
    text = (ROOT / name).read_text()
    named = re.findall(r"\b(?:dem|tests|rules|config|docs(?!/_build))/[\w/.]*\w", text)
    assert [path for path in named if not (ROOT / path).exists()] == []
