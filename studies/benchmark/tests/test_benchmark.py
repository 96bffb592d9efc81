"""The benchmark without other codes, and on other processors."""

import re

import numpy as np
import pytest
import xarray as xr
from made import SMOKE, assert_shown_and_drawn

from studies.benchmark.findings import elsewhere, speed
from studies.common.peers import lammps
from studies.common.results import write_results


def test_without_other_codes_the_benchmark_times_this_one(monkeypatch, tmp_path):
    """In its smallest form: every number of ours is there, and what is missing is named."""
    monkeypatch.setattr(lammps, "available", lambda: "LAMMPS is not installed.")
    path = tmp_path / "benchmark.nc"
    write_results("benchmark", path, SMOKE)
    with xr.open_dataset(path) as found:
        assert np.isfinite(found["granule_steps_per_second"].sel(code="dem")).all()
        assert "not run" in str(found["code_status"].sel(code="LAMMPS").values)
        assert (found["variant_code_size"] > 1000).all()
    assert_shown_and_drawn("benchmark", path)


@pytest.mark.parametrize("file", elsewhere, ids=lambda each: each.name)
def test_a_benchmark_of_another_processor_is_named_after_it(file):
    family, model = re.search(r"family(\d+)_model(\d+)", file.name).groups()
    processor = file.dataset.attrs["processor"]
    assert f"(family {family}, model {model})" in processor != speed.dataset.attrs["processor"]
