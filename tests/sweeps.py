"""Small sweeps that several tests share, made whole in a folder."""

from contextlib import chdir
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr
from pictures import assert_not_blank
from project import CONFIG
from typer.testing import CliRunner

from dem.figures.catalogue import FIGURES, draw, possible
from dem.sweep.combine import combine_block
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store
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


def smoke(**changes):
    return parse(load(CONFIG / "smoke.yaml").dump() | changes)


def discs(seeds, **changes):
    """The smoke sweep's discs at both densities, all runs in one chunk."""
    return smoke(**{"batch": 100, "sweep": {"case": ["c1", "c12"], "seed": seeds}} | changes)


def planned(sweep, folder):
    """A sweep at work with a store in a folder, its plan written; and its only chunk."""
    work = SweepState(sweep, Store(folder / "store"), root=folder)
    (chunk,) = work.batches("drag")
    work.begin("drag")
    return work, chunk.id


def combined(work, folder):
    """drag.nc of a sweep whose chunks are made."""
    path = folder / "drag.nc"
    combine_block(work, "drag", "drag", path)
    return path


def simulate(output, *options):
    """A command line that runs one replicate."""
    words = f"simulate --config {CONFIG}/smoke.yaml --shape c1 --density 3900 --seed 1"
    return [*words.split(), "-o", str(output), *map(str, options)]


class Killed(BaseException):
    """What takes a process away in the middle of its work."""


def killed_at(share):
    """A progress that ends what is under way where so much of it is done."""

    def progress(done, *_):
        if done >= share:
            raise Killed

    return progress


def foreign(path, change, name="drag.nc"):
    """A released file of the paper's sweep, small, as somebody may have changed it."""
    with xr.open_dataset(CONFIG.parent / "docs/data" / name) as data:
        few = {"case": slice(3), "seed": slice(2), "displacement": slice(0, None, 40)}
        small = data.isel(few, missing_dims="ignore").load()
    change(small.drop_encoding()).to_netcdf(path)
    return path


def everywhere(value):
    """All that was measured is one number."""

    def change(data):
        measured = [name for name, array in data.data_vars.items() if array.dtype.kind == "f"]
        return data.assign({name: xr.full_like(data[name], value) for name in measured})

    return change


def without_axes(data):
    """Axes have gaps alone."""
    axes = [name for name in ("seed", "displacement") if name in data.dims]
    return data.assign_coords({name: data[name] * np.nan for name in axes})


FOREIGN = {
    "gaps": everywhere(np.nan),
    "gaps on the axes": without_axes,
    "zero": everywhere(0.0),
    "no size": lambda data: data.isel(seed=[]),
    "numbers for texts": lambda data: data.assign_coords(case=np.arange(data.sizes["case"])),
    "window_start a text": lambda data: data.assign_attrs(window_start="soon"),
    "no bin in the window": lambda data: data.assign_attrs(window_start=5.0, window_stop=6.0),
    "title a number": lambda data: data.assign_attrs(title=3.0),
    "configuration no JSON": lambda data: data.assign_attrs(configuration="{"),
    "no attributes": lambda data: data.drop_attrs(),
    "no labels": lambda data: data.drop_vars(["shape", "case", "kind"]),
}


def sheared_values(**more):
    """Values of a small bed: 9 diameters long and about 8 high."""
    same = dict.fromkeys(("granule", "wall", "cylinder"), 0.4)
    cell = {
        "inertial_number": 0.1,
        "pressure": 1e5,
        "settle": 1.0,
        "strain": 3.0,
        "samples": 300,
    }
    return {
        "experiment": "shear",
        "box_width": 9e-3,
        "periodic": "x",
        "packing": {"fraction": 0.83, "size_spread": 0.2},
        "material": {"young_modulus": 5e9, "poisson_ratio": 0.3, "restitution": 0.1},
        "friction": same,
        "shapes": {"disc": {"kind": "disc", "diameter": 1e-3, "granules": 72}},
        "shear": cell,
        "shape": "disc",
        "density": 2500.0,
        "seed": 1,
    } | more
