"""Small sweeps that several tests share, made whole in a folder."""

from contextlib import chdir
from pathlib import Path

import netCDF4
import numpy as np
from typer.testing import CliRunner

from conftest import assert_not_blank
from dem.figures.catalogue import FIGURES, draw, possible
from dem.sweep import batch as making
from dem.sweep.combine import combine_block
from dem.sweep.config import parse
from dem.sweep.state import SweepState
from dem.sweep.workers import Workers

SMOKE = Path(__file__).parent.parent / "config/smoke.yaml"


CLOCKS = {"run_time", "spent"}


def contents(path: Path, without=CLOCKS) -> dict:
    """All values of a netCDF file but times of processors."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        return {n: np.array(v[...]) for n, v in file.variables.items() if n not in without}


def differing(one: dict, other: dict) -> list[str]:
    """Names of the values in which two files differ."""
    same = {
        name
        for name in one.keys() & other.keys()
        if np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f")
    }
    return sorted((one.keys() | other.keys()) - same)


def of_file(file: Path) -> SweepState:
    """The sweep of a file, made in this process."""
    work = SweepState.of(file)
    work.make(Workers())
    return work


def assert_shown_and_drawn(study: str, path: Path) -> None:
    """The file of a study can be shown, and its figures drawn."""
    from studies.__main__ import app
    from studies.catalogue import figures

    run = CliRunner().invoke(app, [study, "info", str(path)])
    assert run.exit_code == 0, run.output
    for name in [name for name, figure in figures().items() if figure.file == study]:
        assert_not_blank(draw(name, path, path.parent, figures())[1])


def run_all(work: SweepState) -> None:
    """Make the runs of all blocks in this process, round by round, and combine their drag."""
    for name in work.sweep.blocks:
        while True:
            work.begin(name)
            for batch in work.batches(name):
                if not work.store.file_of(batch.id).is_file():
                    making.make(work.store, batch.id)
            if not work.grow(name):
                break
        combine_block(work, name, "drag", work.combined(name)[0])


def make_sweep(folder: Path, beds: bool = False, **values) -> SweepState:
    """A sweep of config/smoke.yaml with other values, made in `folder`/results, with its figures.

    beds: whether the figures of snapshots.nc are drawn too.
    """
    with chdir(folder):
        work = SweepState(parse({"extends": str(SMOKE), "results": "results", **values}))
        (block,) = work.sweep.blocks
        chunks = work.batches(block)
        work.begin(block)
        for chunk in chunks:
            making.make(work.store, chunk.id)
        for name in work.observables(block):
            combine_block(work, block, name, Path(f"results/{name}.nc"))
        for name in possible(work.block(block)) if beds else ():
            if FIGURES[name].file == "snapshots":
                draw(name, Path("results/snapshots.nc"), Path("results/figures"))
        draw("all", Path("results/drag.nc"), Path("results/figures"))
    return work
