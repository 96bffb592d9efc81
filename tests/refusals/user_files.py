"""Sweeps that name files of a user which cannot be used: read, and none of them run."""

from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from project import CONFIG, SHAPE

from dem.sweep.config import parse

TELLING = "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"


def refused(words, text="", **values):
    """A call that reads a sweep beside such files."""

    def call():
        with TemporaryDirectory() as folder:
            beside = Path(folder)
            for name in "rest", "drag", "title":
                (beside / f"{name}.py").write_text(TELLING + text)
            (beside / "pebbles.py").write_text(f"{TELLING}{SHAPE}\n\nclass Bare:\n    pass\n")
            (beside / "broken.py").write_text("def\n")
            start = {"extends": f"{CONFIG}/smoke.yaml", "results": "results/mine", "beside": folder}
            sweep = {"shape": "c1", "density": 3900, "seed": 1}
            try:
                parse(start | {"sweep": sweep} | yaml.safe_load(words) | values)
            finally:
                assert not (beside / "ran").exists()

    return call


def of_kind(kind):
    """A call that reads a sweep of granules of a kind."""
    pebble = {"kind": kind, "diameter": 1e-3, "granules": 60, "aspect_ratio": 1}
    return refused("sweep: {shape: pebble, density: 3900, seed: 1}", shapes={"pebble": pebble})


RESTING = """
SECTIONS = {'cylinder': False, 'record': False}
VALUES = {'margin': (0.0, 'm', 'width', {'ge': 0}), 'layers': (4, '1', 'layers')}
VARIABLES = {'count': (('layer',), '1', 'granules')}
SIZES = {'layer': 'rest.layers'}
def run(replicate):
    pass
"""
REST = "experiment: rest.py"
OBSERVED = "def look(it):\n    pass\nVARIABLES = "
RUN = "def run(it):\n    pass\nVARIABLES = "
SWEPT = "experiment: rest.py\nsweep: {shape: c1, density: 3900, seed: 1, "
CALLS = {
    "experiment is 'rests.py'; there is no file": refused("experiment: rests.py"),
    "experiment is 'mine.rest'; it must be one of drag": refused("experiment: mine.rest"),
    "rest.py has no function run.": refused(REST, "VARIABLES = {}\n"),
    "drag is a name of this package": refused("experiment: drag.py"),
    "drag has two meanings in files of its runs; rename yours.": refused(
        "record: {observables: [drag, rest.py]}", f"{OBSERVED}{{'drag': ((), 'N', 'force')}}"
    ),
    "at has two meanings": refused(
        REST,
        f"{RUN}{{'at': ((), '1', 'words')}}\nSIZES = {{'at': 2}}\nAXIS = {{'at': (('at',), '1', 'at')}}",
    ),
    "rest.margn is not a known key; the nearest is": refused(
        f"{REST}\nrest: {{margn: 0}}", RESTING
    ),
    "rest.margin is -1; it must be at least 0, in m.": refused(
        f"{REST}\nrest: {{margin: -1}}", RESTING
    ),
    "its VALUES need a section title, which is another": refused("experiment: title.py", RESTING),
    "its VALUES must be plain values, name: (default": refused(
        REST, RESTING.replace("'ge'", "'least'")
    ),
    "the dimension layer of SIZES has the length None": refused(
        REST, RESTING.replace("rest.layers", "rest.layer")
    ),
    "sweep varies rest.layers, which runs of one block share; use blocks.": refused(
        f"{SWEPT}rest.layers: [2, 3]}}", RESTING
    ),
    "sweep uses the name rest_margin twice in files of results; rename one.": refused(
        f"{SWEPT}rest.margin: [0, 1]}}", RESTING.replace("'count'", "'rest_margin'")
    ),
    "uses the name count twice in files of results; rename one": refused(
        f"{SWEPT}count: {{a: {{}}, b: {{gravity: 1}}}}}}", RESTING
    ),
    "the variable turn is over snap; its dimensions may be bound, displacement": refused(
        "record: {observables: [rest.py, drag]}", f"{OBSERVED}{{'turn': (('snap',), 'N', 'force')}}"
    ),
    "shapes.pebble.kind is 'stone.Pebble'; there is no file": of_kind("stone.Pebble"),
    "has no class Peble; it defines support, Pebble, Bare.": of_kind("pebbles.Peble"),
    "its class has no of_size; give it": of_kind("pebbles.Bare"),
    "cannot be read (": of_kind("broken.Stone"),
    "kind is '../mine/pebbles.Pebble'; it must be 'clump'": of_kind("../mine/pebbles.Pebble"),
    "kind is 'os.system'; there is no file": of_kind("os.system"),
    "kind is 'dem.shapes.disc.Disc'; it must be 'clump'": of_kind("dem.shapes.disc.Disc"),
}
