"""What cannot be drawn, filmed or written; which run is not told from others."""

from functools import cache
from pathlib import Path

from project import ROOT

import dem
from dem.figures.film import picture
from dem.figures.snapshots import motion_of
from dem.io.lazily import open_lazily


@cache
def result():
    scene = dem.Scene(dem.Disc([1e-3, 0.6e-3]), dem.Material(young_modulus=1e6))
    return dem.simulate(scene, dem.State([[0.0, 3e-3], [1.4e-3, 3.75e-3]]), 1e-5, frames=3)


def one_frame():
    return result()._replace(time=result().time[:1], position=result().position[:1])


def late():
    with open_lazily(ROOT / "docs/data/snapshots.nc") as dataset:
        picture(motion_of(dataset, "c1"), Path("gone"), 7e-3, "layer", False)


CALLS = {
    "frame is 4; it must be below 4.": lambda: dem.plot.bed(result(), frame=4),
    "must be one of speed, force, layer.": lambda: dem.plot.bed(result(), color="mauve"),
    "result has no forces: its scene has neither": lambda: dem.plot.forces(result()),
    "must be the path of a file that ends in .mp4 or .gif.": lambda: dem.film(result(), "run.avi"),
    "a film needs two: simulate with more frames.": lambda: dem.film(one_frame(), "run.gif"),
    "solid is 1; it must be below 0.": lambda: dem.film(result(), "run.gif", solid=1),
    "must be 'force' or 'torque'": lambda: dem.film(result(), "run.gif", panel="energy"),
    "must be the path of a file that ends in .nc.": lambda: result().to_netcdf("run.txt"),
    "at is 0.007 m; it must lie between 0 and": late,
}
OF_RUNS = {
    "drag.nc": "choose one, such as case=c1",
    "overhead.nc": "holds no runs",
    "drag.nc shape=e1 density=5": "no run with density=5; density is 3900, 39000",
    "drag.nc case=e3 seed=one": "no run with seed=one; seed is 1, 2, 3, 4, 5",
    "drag.nc cse=e3": "its runs have no value named cse; the nearest is case",
    "drag.nc e3": "'e3' selects no run; write NAME=VALUE",
    "drag.nc case=e3 seed=1": "is in no folder store",
    "drag.nc point=0": "no value named point; they differ in case",
}
COMMANDS = {
    f"draw docs/data/{words} -o OUT.png": sentence for words, sentence in OF_RUNS.items()
} | {
    "draw none.nc -o OUT.mp4": "none.nc",
    "report docs/data/drag.nc -o OUT.html": "there are no figures; draw them first",
}
