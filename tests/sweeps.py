"""Small sweeps that several tests share, made whole in a folder."""

from contextlib import chdir
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr
from typer.testing import CliRunner

from conftest import assert_not_blank
from dem.figures.catalogue import FIGURES, draw, possible
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


def dataset_of(drag, axes: dict) -> xr.Dataset:
    """Runs with some drag (*axes, seed) in N, the same along the stroke."""
    dims = *axes, "seed"
    axes = axes | {"seed": np.arange(drag.shape[-1]), "displacement": [1e-3, 2e-3, 3e-3]}
    variables = {
        "drag": ((*dims, "displacement"), np.stack(3 * [drag], axis=-1)),
        "run_id": (dims, np.full(drag.shape, "x")),
    }
    return xr.Dataset(variables, axes, {"window_start": 0.5e-3, "window_stop": 3.5e-3})


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


def make_sweep(folder: Path, beds: bool = False, **values) -> SweepState:
    """A sweep of config/smoke.yaml with other values, made in `folder`/results, with its figures.

    beds: whether the figures of snapshots.nc are drawn too.
    """
    with chdir(folder):
        work = SweepState(parse({"extends": str(SMOKE), "results": "results", **values}))
        work.make(Workers())
        for name in possible(work.block("drag")) if beds else ():
            if FIGURES[name].file == "snapshots":
                draw(name, Path("results/snapshots.nc"), Path("results/figures"))
        draw("all", Path("results/drag.nc"), Path("results/figures"))
    return work
