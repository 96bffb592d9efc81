"""Small sweeps that several tests share, made whole in a folder; runs that cost nothing."""

import json
from contextlib import chdir
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
import yaml
from command_line import called
from pictures import assert_not_blank
from project import CONFIG

from dem.figures.catalogue import draw
from dem.sweep.config import load, parse
from dem.sweep.state import SweepState
from dem.sweep.workers import Workers

SMOKE = CONFIG / "smoke.yaml"


CLOCKS = {"run_time", "spent"}


def contents(path: Path, without=CLOCKS) -> dict:
    """All values of a netCDF file but times of processors."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        return {n: np.array(v[...]) for n, v in file.variables.items() if n not in without}


def bytes_of_results() -> dict[Path, bytes]:
    """The bytes of the files of runs, beds and results below the working folder."""
    return {path: path.read_bytes() for path in Path("results").rglob("*.n*")}


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

    run = called(f"{study} info {path}", app)
    assert run.exit_code == 0, run.output
    for name in [name for name, figure in figures().items() if figure.file == study]:
        assert_not_blank(draw(name, path, path.parent, figures())[1])


def make_sweep(folder: Path, **values) -> None:
    """A sweep of config/smoke.yaml with other values, made in `folder`/results, with the figures of its drag."""
    with chdir(folder):
        work = SweepState(parse({"extends": str(SMOKE), "results": "results", **values}))
        work.make(Workers())
        draw("all", Path("results/drag.nc"), Path("results/figures"))


def smoke(**changes):
    return parse(load(SMOKE).dump() | changes)


# An experiment that costs nothing
DRAWN = '''
"""Numbers that are drawn, with the density as their mean. A curve is far off outside the window.

orders.json: errors by density and seed, and `left`, the runs until the process ends. runs.txt: those that were made.
"""
import builtins
import json
import os
import time
from pathlib import Path

import numpy as np

from dem.base import errors
from dem.experiment.kinds import drag

SECTIONS = {"cylinder": True, "record": True}
VARIABLES = {"force": ((), "N", "a drawn number"), "offset": ((), "N", "one about zero")}


def run(replicate, bed=None, progress=lambda done: None, checkpoint=None):
    c = replicate.configuration
    rough = "rough " if c.friction.granule > 0.4 else ""
    key = f"{rough}{replicate.density:g} {replicate.seed}"
    generator = np.random.default_rng([replicate.seed, int(replicate.density)])
    number = generator.standard_normal()
    if checkpoint:
        np.savez(checkpoint, number=number)
    orders = json.loads(Path("orders.json").read_text())
    if "left" in orders:
        orders["left"] -= 1
        if orders["left"] < 0:
            del orders["left"]
        Path("orders.json").write_text(json.dumps(orders))
        if "left" not in orders:
            raise KeyboardInterrupt
    if "sleeps" in orders:
        Path("begun").touch()
        time.sleep(orders["sleeps"])
    force = replicate.density * (1.0 + 0.3 * number)
    with open("runs.txt", "a") as file:
        file.write(f"{replicate.id} {force} {key}\\n")
    if key in orders.get("fails", {}):
        name = orders["fails"][key]
        if name == "death":
            os._exit(1)
        raise {**vars(builtins), **vars(errors)}[name](f"{name} of {key}")
    sizes = c.module.sizes(replicate)
    values = {
        name: np.full([sizes[dim] for dim in dims], force)
        for name, (dims, *_) in c.module.layout.items()
    }
    if "drag" in values:
        at, (start, stop) = drag.axes(c)["displacement"], c.record.window
        off = 1e3 * force * generator.standard_normal(len(at))
        values["drag"] = np.where((start <= at) & (at <= stop), force, off)
    if "granule_x" in values:
        places = {"granule_x": bed.position[:, 0], "granule_y": bed.position[:, 1]}
        values |= {name: np.tile(x, (c.record.snapshots, 1)) for name, x in places.items()}
        values["granule_diameter"] = np.full(len(bed.position), 1e-3)
        values |= {"box_height": bed.height, "cylinder_y": [0.5 * bed.height] * c.record.snapshots}
    offset = number + (50.0 if replicate.density == 200.0 else 0.0)
    return values | {"force": force, "offset": offset}
'''
OBSERVED = """
OBSERVED = ("drag", "snapshots")
AXIS = {
    "displacement": (("displacement",), "m", "displacement"),
    "displacement_bounds": (("displacement", "bound"), None, None),
    "wall": (("wall",), None, "wall of the box"),
    "snapshot_displacement": (("snapshot",), "m", "displacement at the snapshot"),
}
SIZES = {"displacement": "record.bins", "snapshot": "record.snapshots", "bound": 2, "wall": 4}


def axes(configuration):
    return drag.axes(configuration)
"""
DISC = {"kind": "disc", "granules": 14}
VALUES = {
    "extends": str(SMOKE),
    "results": "results/drawn",
    "experiment": "drawn.py",
    "box_width": 6e-3,
    "packing": {"fraction": 0.4, "size_spread": 0.2},
    "shapes": {"c1": DISC | {"diameter": 1e-3}, "c2": DISC | {"diameter": 1.1e-3}},
    "cases": {
        "a": {"shape": "c1", "density": 100},
        "b": {"shape": "c2", "density": 200},  # of other beds
        "c": {"shape": "c1", "density": 300},
    },
    "record": {"bins": 12, "snapshots": 3, "observables": ["drag"]},
    "sweep": {"case": ["a", "b"], "seed": [1, 2]},
}


def drawn(observed: bool = False, **values) -> Path:
    """A sweep file of drawn numbers in the working folder.

    observed: whether the runs have a bed and a checkpoint, and record what those of the paper do.
    """
    Path("drawn.py").write_text(DRAWN + observed * OBSERVED)
    Path("sweep.yaml").write_text(yaml.safe_dump(VALUES | values))
    if not Path("orders.json").exists():
        order()
    return Path("sweep.yaml")


def varied(*cases: str, seed) -> dict:
    """What varies in a sweep of drawn numbers."""
    return {"case": list(cases), "seed": seed}


def order(**orders) -> None:
    """What runs of drawn numbers do: `left` and `fails`, as drawn.py says."""
    Path("orders.json").write_text(json.dumps(orders))


def made() -> list[str]:
    """The runs that were made, also those that failed: identity, force, density and seed."""
    return Path("runs.txt").read_text().splitlines() if Path("runs.txt").exists() else []


def interrupted(file: Path, left: int) -> SweepState:
    """A sweep that is stopped after so many runs."""
    orders = json.loads(Path("orders.json").read_text())
    order(**orders, left=left)
    with pytest.raises(KeyboardInterrupt):
        of_file(file)
    return SweepState.of(file)


def simulate(output, options=""):
    """A command line that runs one replicate."""
    words = f"simulate --config {CONFIG}/smoke.yaml --shape c1 --density 3900 --seed 1 -o {output}"
    return f"{words} {options}"


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
    data = xr.load_dataset(CONFIG.parent / "docs/data" / name)
    few = {"case": slice(3), "seed": slice(2), "displacement": slice(0, None, 40)}
    small = data.isel(few, missing_dims="ignore")
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
