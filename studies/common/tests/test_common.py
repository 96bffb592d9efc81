"""What all studies share: an interval, what a page says of its file, what a sweep and a figure must hold."""

import numpy as np
import pytest
import xarray as xr
from intervals import assert_held
from pictures import assert_not_blank
from project import ROOT, quick

from dem.figures.catalogue import draw, drawable_from, possible
from dem.io.lazily import open_lazily
from dem.sweep.config import load
from studies.catalogue import figures
from studies.common.findings import Findings
from studies.common.statistics import log_ratio_interval


@quick
@pytest.mark.parametrize("level", [0.5, 0.95, 0.99])
@pytest.mark.parametrize("paired", [True, False])
def test_intervals_of_ratios_hold_the_truth_as_often_as_they_say(paired, level):
    """Also where a run of either part failed."""
    rng, ends = np.random.default_rng(1), []
    for _ in range(1500):
        if paired:
            a, b = rng.normal(1.0, 0.1, 20) * rng.normal(1.0, 0.1, (2, 20))
        else:  # which differ in size and in scatter
            a, b = rng.normal(1.0, 0.02, 20), rng.normal(1.0, 0.1, 6)
        a[0], b[1] = np.nan, np.inf
        ends.append(log_ratio_interval(2.0 * a, b, paired, level)[1:])
    assert_held(ends, 2.0, level, 0.01)


class Made(Findings):
    """Findings of a file that is not there."""

    name, command = "made", "dem sweep"

    @property
    def place(self):
        return "studies/made.nc"


@quick
@pytest.mark.parametrize("revisions", ["2222222bbb", "1111111aaa; 2222222bbb"])
def test_a_page_states_the_revision_of_the_newest_runs(revisions):
    """It is the last of several, and contains the others."""
    attributes = {"git_revision": revisions, "made_with": "dem 1", "history": "2026-01-02T03: made"}
    assert Made().of(xr.Dataset(attrs=attributes)).revision == "2222222"


OF_STUDIES = {name: figure for name, figure in figures().items() if "studies" in figure.module}


@pytest.mark.parametrize(
    "name", [name for name, figure in OF_STUDIES.items() if figure.file in ("drag", "solids")]
)
def test_a_figure_shows_the_released_file_of_its_study_which_a_sweep_makes(name, tmp_path):
    """Figures of other files are drawn in their smallest form."""
    folder = (ROOT / OF_STUDIES[name].module.replace(".", "/")).parents[1]
    sweeps = [load(file) for file in folder.glob("*.yaml")]
    blocks = [sweep.block(each) for sweep in sweeps for each in sweep.blocks]
    assert name in {figure for block in blocks for figure in possible(block, OF_STUDIES)}
    shown = []
    for file in folder.glob("*.nc"):
        with open_lazily(file) as dataset:
            shown += [file] if name in drawable_from(dataset, OF_STUDIES) else []
    assert shown
    for file in shown:
        assert_not_blank(draw(name, file, tmp_path, OF_STUDIES)[1])
