"""Precisions, executors and blocks of a sweep that cannot be."""

from pathlib import Path
from tempfile import TemporaryDirectory

from sweeps import DRAWN, VALUES

import dem
from dem.sweep.config import parse


def until(precision="5 %", **more):
    """Seeds of config/paper.yaml until a mean is known."""
    return {"sweep.seed": {"until": precision} | more}


POSITIVE = "it must be a positive number with its unit"
FILES = {
    f"sweep.seed.until is 5; {POSITIVE}": until(5),
    f"sweep.seed.until is '0 %'; {POSITIVE}": until("0 %"),
    "until is 500 %; it must be below 100 %": until("500 %"),
    "it must be a percentage, or a number of N": until("12 kg"),
    "it must be a percentage.": until("5 N", of="drag / c1"),
    "sweep.seed.most is -1; it must be at least 3": until(most=-1),
    "least is 50, above most, 20": until(least=50, most=20),
    "the last seed must be below 2147483648": until(first=2147483640),
    "it must be a percentage between 50 % and 99.99 %": until(confidence="49 %"),
    "dragg is no number that these runs record": until(of="dragg"),
    "run_time is no number that these runs record": until(of="run_time"),
    "'z' is no case or shape that this block varies": until(of="drag / z"),
    "sweep.seed.untl is not a known key; the nearest is until": until(untl="5 %"),
}


def granules_for_a_size():
    """An experiment whose SIZES have the granules, whose number each run has of its own."""
    with TemporaryDirectory() as folder:
        Path(folder, "drawn.py").write_text(f"{DRAWN}\nSIZES = {{'granule': 5}}\n")
        parse(VALUES | {"beside": folder})


CALLS = {
    "SIZES has granule, the number of granules of a run": granules_for_a_size,
    "executor is 4; it must be one of": lambda: dem.run_sweep("config/smoke.yaml", 4),
    "block is 'wide'": lambda: dem.run_sweep("config/smoke.yaml", block="wide"),
}
