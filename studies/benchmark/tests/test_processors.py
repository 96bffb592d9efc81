"""Benchmarks of other processors say so."""

import re

import pytest

from studies.benchmark.findings import elsewhere, speed


@pytest.mark.parametrize("file", elsewhere, ids=lambda each: each.name)
def test_a_benchmark_of_another_processor_is_named_after_it(file):
    family, model = re.search(r"family(\d+)_model(\d+)", file.name).groups()
    assert f"(family {family}, model {model})" in file.machine() != speed.machine()
