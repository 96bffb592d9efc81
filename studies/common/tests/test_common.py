"""What all studies share: an interval, and what a page says of its file."""

import numpy as np
import pytest
import xarray as xr
from intervals import assert_held

from studies.common.findings import Findings
from studies.common.statistics import log_ratio_interval

pytestmark = pytest.mark.quick


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


@pytest.mark.parametrize("revisions", ["2222222bbb", "1111111aaa; 2222222bbb"])
def test_a_page_states_the_revision_of_the_newest_runs(revisions):
    """It is the last of several, and contains the others."""
    attributes = {"git_revision": revisions, "made_with": "dem 1", "history": "2026-01-02T03: made"}
    made = Made().of(xr.Dataset(attrs=attributes))
    assert made.revision == "2222222"
    for word in ("`dem 1`", "`2222222`", "on 2026-01-02", "`studies/made.nc`"):
        assert word in made.origin
