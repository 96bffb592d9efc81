"""The benchmark without other codes."""

import numpy as np
import pytest
import xarray as xr
from made import SMOKE, assert_shown_and_drawn
from typer.testing import CliRunner

from studies.__main__ import app
from studies.common.peers import lammps


@pytest.fixture
def alone(monkeypatch):
    """A computer without LAMMPS."""

    def absent():
        raise ImportError("no module named lammps")

    monkeypatch.setattr(lammps, "_start", absent)
    lammps.available.cache_clear()
    yield
    lammps.available.cache_clear()


def test_without_other_codes_the_benchmark_times_this_one(alone, tmp_path):
    """In its smallest form: every number of ours is there, shown and drawn, and what is missing is named."""
    path = tmp_path / "benchmark.nc"
    words = ["benchmark", "measure", "--smoke", "--config", str(SMOKE), "-o", str(path)]
    run = CliRunner().invoke(app, words)
    assert run.exit_code == 0, run.output
    with xr.open_dataset(path) as found:
        ours = found["granule_steps_per_second"].sel(code="dem").values
        assert np.isfinite(ours).all()
        assert "not run" in str(found["code_status"].sel(code="LAMMPS").values)
        assert (found["variant_code_size"] > 1000).all()
    assert_shown_and_drawn("benchmark", path)
