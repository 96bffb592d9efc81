"""What cannot be drawn, filmed or written; which run is not told from others."""

from functools import cache
from pathlib import Path

from project import ROOT

import dem
from dem.figures.catalogue import draw
from dem.figures.film import picture
from dem.figures.snapshots import motion_of
from dem.io.lazily import open_lazily
from dem.report.build import build

DATA, GONE = ROOT / "docs/data", Path("gone")
STATE = dem.State([[0.0, 3e-3], [1.4e-3, 3.75e-3]])


@cache
def result():
    scene = dem.Scene(dem.Disc([1e-3, 0.6e-3]), dem.Material(young_modulus=1e6))
    return dem.simulate(scene, STATE, 1e-5, frames=3)


def one_frame():
    return result()._replace(time=result().time[:1], position=result().position[:1])


def drawn(displacement):
    with open_lazily(DATA / "snapshots.nc") as dataset:
        motion = motion_of(dataset, "c1")
    picture(motion, GONE / "bed.png", displacement, "layer", False)


COLORS = "color is 'mauve'; it must be one of speed, force, layer."
CALLS = {
    "frame beyond the last": (
        lambda: dem.plot.bed(result(), frame=4),
        "frame is 4; it must be below 4.",
    ),
    "color of a picture": (lambda: dem.plot.bed(result(), color="mauve"), COLORS),
    "bed of a number": (lambda: dem.plot.bed(3), "result is 3; it must be an instance of Result."),
    "forces on nothing": (
        lambda: dem.plot.forces(result()),
        "result has no forces: its scene has neither solids nor walls.",
    ),
    "color of a film": (lambda: dem.film(result(), GONE / "run.mp4", color="mauve"), COLORS),
    "film of another kind": (
        lambda: dem.film(result(), "run.avi"),
        "path is 'run.avi'; it must be the path of a file that ends in .mp4 or .gif.",
    ),
    "film of a state": (lambda: dem.film(STATE, "run.gif"), "it must be an instance of Result."),
    "film of one frame": (
        lambda: dem.film(one_frame(), "run.gif"),
        "result has 1 frame; a film needs two: simulate with more frames.",
    ),
    "solid of a panel": (
        lambda: dem.film(result(), "run.gif", solid=1),
        "solid is 1; it must be below 0.",
    ),
    "panel of a film": (
        lambda: dem.film(result(), "run.gif", panel="energy"),
        "panel is 'energy'; it must be 'force' or 'torque'",
    ),
    "file of a result": (
        lambda: result().to_netcdf("run.txt"),
        "path is 'run.txt'; it must be the path of a file that ends in .nc.",
    ),
    "displacement of a picture": (
        lambda: drawn(7e-3),
        "displacement is 0.007 m; it must lie between 0 and",
    ),
    "figure that is none": (
        lambda: draw("figure3", DATA / "drag.nc", GONE),
        "figure is 'figure3'; there is no such figure",
    ),
    "figure of another file": (
        lambda: draw("figure13", DATA / "snapshots.nc", GONE),
        "it holds no drag, and figure13 is drawn from that",
    ),
    "quantity of a figure": (
        lambda: draw("figure13", DATA / "drag.nc", GONE, of="steps"),
        "of is 'steps'; only the figure sweep shows another quantity",
    ),
    "report without figures": (
        lambda: build(DATA / "drag.nc", GONE / "report.html"),
        "there are no figures; draw them first",
    ),
}
COMMANDS = {
    "draw none.nc -o bed.mp4": "none.nc",
    "draw docs/data/drag.nc -o bed.png": "choose one, such as case=c1",
    "draw docs/data/overhead.nc -o vtk.pvd": "holds no runs",
    "draw docs/data/drag.nc shape=e1 density=5 -o bed.png": "no run with density=5; density is 3900, 39000",
    "draw docs/data/drag.nc case=e3 seed=one -o bed.png": "no run with seed=one; seed is 1, 2, 3, 4, 5",
    "draw docs/data/drag.nc cse=e3 -o bed.png": "its runs have no value named cse; the nearest is case",
    "draw docs/data/drag.nc e3 -o bed.png": "'e3' selects no run; write NAME=VALUE",
    "draw docs/data/drag.nc case=e3 seed=1 -o bed.png": "is in no folder store",
}
