"""Run the cases and write verification.nc."""

import multiprocessing
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError
from dem.base.hints import choice
from dem.base.sources import code_hash
from dem.io.dataset import global_attributes, write
from studies.verification import cases
from studies.verification.layout import VARIABLES
from studies.verification.row import Row


class Measured(NamedTuple):
    """What a case gave, and how long it took (s)."""

    name: str
    rows: list[Row]
    seconds: float


def case(name: str):
    """The module of a case; raises InputError where there is none of this name."""
    if name not in cases.NAMES:
        hint = choice(name, cases.NAMES)
        raise InputError(f"case is {name!r}; there is no such case{hint}.")
    return import_module(f"{cases.__name__}.{name}")


def run(name: str) -> Measured:
    """Run one case."""
    module, began = case(name), time.perf_counter()
    rows = module.measure()
    return Measured(name, rows, time.perf_counter() - began)


def measure(names: Iterable[str], jobs: int = 1, progress=lambda done: None) -> list[Measured]:
    """Run some cases, several side by side; progress gets the share done."""
    names = list(names)
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        found = []
        for each in pool.map(run, names):
            found.append(each)
            progress(len(found) / len(names))
    return found


def variables(found: list[Measured]) -> dict[str, np.ndarray]:
    """Variables of studies.verification.layout by name."""
    modules = [case(each.name) for each in found]
    rows = [(each.name, row) for each in found for row in each.rows]
    values = {
        "case": [each.name for each in found],
        "case_title": [module.TITLE for module in modules],
        "case_source": [module.SOURCE for module in modules],
        "case_time": [each.seconds for each in found],
        "row_case": [name for name, _ in rows],
        "row_passed": [int(row.passed) for _, row in rows],
    }
    for field in Row._fields:
        values[f"row_{field}"] = [getattr(row, field) for _, row in rows]
    return {name: np.array(each) for name, each in values.items()}


def write_verification(path: Path, found: list[Measured]) -> None:
    """Write what `measure` returned."""
    attrs = global_attributes(
        "Verification: known cases",
        "python -m studies verification measure",
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
        source_hash=code_hash(__name__, *cases.MODULES),
    )
    write(path, variables(found), attrs, VARIABLES)
