"""Precisions, executors and blocks of a sweep that cannot be."""

from pathlib import Path
from tempfile import TemporaryDirectory

from sweeps import DRAWN, VALUES

import dem
from dem.sweep.config import parse


def until(words: str, seed: dict | None = None, **more):
    """Seeds of config/paper.yaml until a mean is known."""
    return {"sweep.seed": seed or {"until": "5 %"} | more}, words


POSITIVE = "it must be a positive number with its unit"
FILES = {
    "a precision of zero": until(f"sweep.seed.until is 0; {POSITIVE}", until=0),
    "a precision without a unit": until(f"sweep.seed.until is 5; {POSITIVE}", until=5),
    "a negative precision": until(f"sweep.seed.until is '-5 %'; {POSITIVE}", until="-5 %"),
    "a precision of more than all": until("until is 500 %; it must be below 100 %", until="500 %"),
    "a precision in other units": until("it must be a percentage, or a number of N", until="12 kg"),
    "a ratio in units": until("it must be a percentage.", until="5 N", of="drag / c1"),
    "a negative cap": until("sweep.seed.most is -1; it must be at least 3", most=-1),
    "a first round above the cap": until("least is 50, above most, 20", least=50, most=20),
    "seeds beyond the last": until("the last seed must be below 2147483648", first=2147483640),
    "a level below the least": until(
        "it must be a percentage between 50 % and 99.99 %", confidence=5
    ),
    "what is not recorded": until("dragg is no number that these runs record", of="dragg"),
    "the time of a run": until("run_time is no number that these runs record", of="run_time"),
    "an unknown reference": until("'z' is no case or shape that this block varies", of="drag / z"),
    "an unknown key of seeds": until(
        "sweep.seed.untl is not a known key; the nearest is until", {"untl": "5 %"}
    ),
    "replicates of a derived block": (
        {
            "sweep": {
                "blocks": {
                    "first": {"case": "c1", "seed": 1},
                    "second": {"needs": "first", "case": "c1", "seed": {"until": "5 %"}},
                }
            }
        },
        "seed has until, and needs first; list the seeds",
    ),
    **{
        f"a point named {name!r}": (
            {"sweep.rough": {name: {"friction.granule": 0.3}, "b": {"friction.granule": 0.4}}},
            "sweep.rough has a point without a name; give it one",
        )
        for name in (None, "", " ")
    },
}


def granules_for_a_size():
    """An experiment whose SIZES have the granules, whose number each run has of its own."""
    with TemporaryDirectory() as folder:
        Path(folder, "drawn.py").write_text(f"{DRAWN}\nSIZES = {{'granule': 5}}\n")
        parse(VALUES | {"beside": folder})


CALLS = {
    "granules as a size": (
        granules_for_a_size,
        "SIZES has granule, the number of granules of a run",
    ),
    "an executor that is none": (
        lambda: dem.run_sweep("config/smoke.yaml", 4),
        "executor is 4; it must be one of",
    ),
    "a block that is not there": (
        lambda: dem.run_sweep("config/smoke.yaml", block="wide"),
        "block is",
    ),
}
RUN = "simulate --config config/smoke.yaml --shape c1 --seed 1 --density"
COMMANDS = {
    f"{RUN} nan -o OUT": "density is nan",
    f"{RUN} inf -o OUT": "density is inf",
    f"{RUN} 3900 --checkpoint README.md -o OUT": "README.md",
}
