"""verification.nc: the cases, each number of them beside what is expected."""

import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from studies.common.results import along, columns, is_smoke
from studies.verification import cases
from studies.verification.row import Row

TITLE = "Verification: known cases"
MEASURES = True
READS = ("studies/onset/onset.nc", "studies/shear/shear.nc")
VARIABLES = (
    {
        "case": (("case",), None, "case: its file in studies/verification/cases"),
    }
    | along(
        "case",
        title=(None, "what the case is about"),
        source=(None, "where what is expected comes from"),
        time=("s", "time that the case took, with compiling where it was the first"),
    )
    | along(
        "row",
        case=(None, "case that the number belongs to"),
        name=(None, "what the number is"),
        units=(None, "units of the number"),
        x=("1", "where in its case the number is, such as an angle; NaN where it has none"),
        value=("1", "what came out, in row_units"),
        expected=("1", "what is expected, in row_units"),
        tolerance=("1", "largest allowed error, in row_units"),
        passed=("1", "1 where the value is within the tolerance"),
    )
)
CASES = {name: module for name, module in vars(cases).items() if hasattr(module, "SOURCE")}
QUICK = "chain", "jamming"  # the smallest form


def run(name: str) -> tuple[list[Row], float]:
    """Rows of a case, and the time that it took (s)."""
    start = time.perf_counter()
    return CASES[name].measure(), time.perf_counter() - start


def measure(names, jobs: int = 1, progress=lambda share: None) -> dict[str, np.ndarray]:
    """Variables of some cases, several of them side by side; raises InputError for an unknown
    one."""
    for name in names:
        if name not in CASES:
            raise InputError(f"case is {name!r}; there is no such case{did_you_mean(name, CASES)}.")
    rows, times = [], []
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        for name, (numbers, seconds) in zip(names, pool.map(run, names), strict=True):
            rows += [{"case": name, "passed": int(row.passed)} | row._asdict() for row in numbers]
            times.append(seconds)
            progress(len(times) / len(names))
    return {
        "case": np.array(names),
        "case_title": np.array([CASES[name].TITLE for name in names]),
        "case_source": np.array([CASES[name].SOURCE for name in names]),
        "case_time": np.array(times),
    } | columns("row", rows)


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    return measure(QUICK if is_smoke(state) else tuple(CASES), jobs, progress), {}
