"""The file of results of a study, NAME.nc, and what makes it: the part that all studies share.

A study that writes a file describes it in `results.py` of its folder, by names at its top:

TITLE       what the file is about; it follows the title of the sweep where the study has one
VARIABLES   the layout of the file, as in dem.io.dataset: name: (dimensions, units, long name);
            `along` writes it for what is in a row
MEASURES    optional: True where `make` simulates or measures by itself, alone on the computer
READS       optional: other files that `make` reads, as paths below the root of the checkout
make        function: make(state, jobs, progress) -> values, attributes

state: the sweep of the study (`sweep.yaml`, or `smoke.yaml`, in its folder), whose runs are
there; the sweep of the configuration where the study has none. jobs: processes that may work side
by side. progress: called with the share done, 0 to 1. values: arrays by the names of VARIABLES.
attributes: of the file, beside those that `write_results` gives to all. Where `is_smoke(state)`,
`make` does as little as shows that it works.

Everything else follows from that: `python -m studies NAME make` and `info`, the target NAME of
Snakemake (rules/studies.smk), the check of a file before it is shown or drawn, and the page of the
reference. `runs` reads what the runs of a sweep gave. See studies/accuracy/budget/results.py for an
example.
"""

from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError, RunError
from dem.base.source_hash import run_hash
from dem.experiment.replicate import Replicate
from dem.io.dataset import global_attributes, read, write
from dem.sweep.config import Sweep
from dem.sweep.expand import Block
from dem.sweep.precision import GridPoint
from dem.sweep.state import SweepState
from studies import has_sweep, package_of, sweep_of

ORIGIN = ("versions", "git_revision", "source_hash")


def is_smoke(state: SweepState) -> bool:
    """Whether the sweep is the smallest one, which only shows that the study works."""
    return state.sweep.studies == "smoke.yaml"


def first_seed(sweep: Sweep) -> int:
    """The least seed of the first block, for what needs one bed."""
    return min(run.seed for run in sweep.block(next(iter(sweep.blocks))).runs.values())


def write_results(
    name: str,
    output: Path,
    config: Path | None = None,
    jobs: int = 1,
    progress: Callable = lambda share: None,
) -> None:
    """Write the file of a study; config: the sweep that it reads, as of `make`."""
    results = import_module(f"{package_of(name)}.results")
    state = SweepState.of(config or sweep_of(name))
    values, more = results.make(state, jobs, progress)
    sweep, sources, attributes, title = state.sweep, [], {}, results.TITLE
    if has_sweep(name):
        title, (low, high) = f"{sweep.title}: {title}", sweep.record.window
        attributes = {
            "default_fraction": sweep.numerics.step_fraction,
            "window_start": low,
            "window_stop": high,
        }
        files = [file for block in sweep.blocks for file in state.files(block)]
        sources += [read(file, ())[1] for file in dict.fromkeys(files)]
    if getattr(results, "MEASURES", False):
        measured = provenance.versions(), provenance.git_revision(), run_hash()
        sources.append(dict(zip(ORIGIN, measured, strict=True)))
    for key in ORIGIN:
        attributes[key] = "; ".join(dict.fromkeys(origin[key] for origin in sources))
    source = f"python -m studies {name} make"
    write(output, values, global_attributes(title, source, **attributes | more), results.VARIABLES)


def runs(
    state: SweepState,
    names: Iterable[str],
    blocks: Iterable[str] = (),
    progress: Callable = lambda share: None,
) -> Iterator[tuple[Block, GridPoint, Replicate, dict[str, np.ndarray]]]:
    """The runs of a sweep in order: block, grid point, run, and values by name.

    names: variables over `run`; blocks: names, all if empty. A block at a time is in memory. A run
    that failed is NaN or -1, and a RunError unless `failure` is one of names. Raises InputError for
    a file that is damaged, and for a run that no file holds.
    """
    names, blocks = tuple(names), list(blocks or state.sweep.blocks)
    for done, name in enumerate(blocks):
        block = state.block(name)
        rows = state.store.rows(block.points, *names)
        for point, run in block.runs.items():
            if run.id not in rows:
                raise InputError(f"{run.words()} is in no file of the store; run again.")
            row = rows[run.id]
            if row["failure"] and "failure" not in names:
                raise RunError(f"{run.words()} could not be made: {row['failure_reason']}")
            yield block, point, run, {key: row[key] for key in names}
        progress((done + 1) / len(blocks))


def along(dimension: str, **variables: tuple) -> dict[str, tuple]:
    """The layout of variables over a dimension, as `columns` names them: units, what they are, and
    the names of further dimensions of each."""
    return {
        f"{dimension}_{name}": ((dimension, *more), units, about)
        for name, (units, about, *more) in variables.items()
    }


def columns(dimension: str, rows: list[dict]) -> dict[str, np.ndarray]:
    """Rows as variables over a dimension: `run_drag` (run,) of the key `drag`."""
    return {f"{dimension}_{key}": np.array([row[key] for row in rows]) for key in rows[0]}
