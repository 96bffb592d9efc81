"""The benchmark without other codes, and on other processors."""

import re

import numpy as np
import pytest

from studies.benchmark.findings import elsewhere, speed
from studies.benchmark.results import SMOKE, compare_codes
from studies.benchmark.scenes import make_case
from studies.common.peers import lammps


def test_without_other_codes_the_benchmark_times_this_one(monkeypatch, small_bed):
    """What is missing is named."""
    monkeypatch.setattr(lammps, "available", lambda: "LAMMPS is not installed.")
    small = small_bed("disc")
    values = compare_codes({"disc": make_case(small.scene(), small.state)}, SMOKE)
    rates = dict(zip(values["code"], values["granule_steps_per_second"][0], strict=True))
    assert np.isfinite(rates["dem"]).all() and np.isnan(rates["LAMMPS"]).all()
    assert "not run: LAMMPS is not installed." in values["code_status"]


@pytest.mark.parametrize("file", elsewhere, ids=lambda findings: findings.name)
def test_a_benchmark_of_another_processor_is_named_after_it(file):
    family, model = re.search(r"family(\d+)_model(\d+)", file.name).groups()
    processor = file.dataset.attrs["processor"]
    assert f"(family {family}, model {model})" in processor != speed.dataset.attrs["processor"]
