"""Run the cases and write verification.nc."""

import multiprocessing
import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError
from dem.base.hints import choice
from dem.base.sources import run_hash
from dem.io.dataset import global_attributes, write
from studies.verification import cases
from studies.verification.layout import VARIABLES
from studies.verification.row import Row


def case(name: str):
    """The module of a case; raises InputError where there is none of this name."""
    if name not in cases.NAMES:
        hint = choice(name, cases.NAMES)
        raise InputError(f"case is {name!r}; there is no such case{hint}.")
    return import_module(f"{cases.__name__}.{name}")


def run(name: str) -> tuple[str, list[Row], float]:
    """Run one case; returns its name, its rows, and how long it took (s)."""
    began = time.perf_counter()
    return name, case(name).measure(), time.perf_counter() - began


def measure(names: Iterable[str], jobs: int = 1, progress=lambda done: None) -> list:
    """What `run` returns of some cases, several side by side; progress gets the share done."""
    names, found = list(names), []
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        for each in pool.map(run, names):
            found.append(each)
            progress(len(found) / len(names))
    return found


def variables(found: list) -> dict[str, np.ndarray]:
    """Variables of studies.verification.layout by name."""
    names, _, seconds = zip(*found, strict=True)
    rows = [(name, row) for name, some, _ in found for row in some]
    values = {
        "case": names,
        "case_title": [case(name).TITLE for name in names],
        "case_source": [case(name).SOURCE for name in names],
        "case_time": seconds,
        "row_case": [name for name, _ in rows],
        "row_passed": [int(row.passed) for _, row in rows],
    }
    for field in Row._fields:
        values[f"row_{field}"] = [getattr(row, field) for _, row in rows]
    return {name: np.array(each) for name, each in values.items()}


def write_verification(path: Path, found: list) -> None:
    """Write what `measure` returned."""
    attrs = global_attributes(
        "Verification: known cases",
        "python -m studies verification measure",
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
        source_hash=run_hash(),
    )
    write(path, variables(found), attrs, VARIABLES)
