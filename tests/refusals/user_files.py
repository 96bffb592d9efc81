"""Sweeps that name files of a user which cannot be used: read, and none of them run."""

from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from project import CONFIG, SHAPE

from dem.sweep.config import parse

TELLING = "from pathlib import Path\nPath(__file__).with_name('ran').touch()\n"


def refused(words, text):
    """A call that reads a sweep beside such files."""

    def call():
        with TemporaryDirectory() as folder:
            beside = Path(folder)
            for name in "rest", "drag", "title":
                (beside / f"{name}.py").write_text(TELLING + text)
            (beside / "pebbles.py").write_text(f"{TELLING}{SHAPE}\n\nclass Bare:\n    pass\n")
            (beside / "broken.py").write_text("def\n")
            rest = {"sweep": {"shape": "c1", "density": 3900, "seed": 1}} | yaml.safe_load(words)
            start = {"extends": f"{CONFIG}/smoke.yaml", "results": "results/mine"}
            try:
                parse(start | {"beside": folder} | rest)
            finally:
                assert not (beside / "ran").exists()

    return call


KINDS = {
    "stone.Pebble": "shapes.pebble.kind is 'stone.Pebble'; there is no file",
    "pebbles.Peble": "has no class Peble; it defines support, Pebble, Bare.",
    "pebbles.Bare": "its class has no of_size; give it",
    "broken.Stone": "cannot be read (",
    "../mine/pebbles.Pebble": "it must be 'clump', 'disc', 'dumbbell', 'ellipse' or 'superellipse'",
    "/etc/passwd.X": "shapes.pebble.kind is '/etc/passwd.X'; it must be 'clump'",
    "os.system": "shapes.pebble.kind is 'os.system'; there is no file",
    "dem.shapes.disc.Disc": "it must be 'clump'",
}
RESTING = """
SECTIONS = {'cylinder': False, 'record': False}
VALUES = {'margin': (0.0, 'm', 'width', {'ge': 0}), 'layers': (4, '1', 'layers')}
VARIABLES = {'count': (('layer',), '1', 'granules')}
SIZES = {'layer': 'rest.layers'}
def run(replicate):
    pass
"""
OBSERVED = "def look(it):\n    pass\nVARIABLES = "
RUN = "def run(it):\n    pass\nVARIABLES = "
SWEPT = "experiment: rest.py\nsweep: {shape: c1, density: 3900, seed: 1, "
FILES_OF_EXPERIMENTS = {  # what a sweep says: which file is there, and what is told
    "experiment: rests.py": ("", "experiment is 'rests.py'; there is no file"),
    "experiment: mine.rest": ("", "experiment is 'mine.rest'; it must be one of drag"),
    "experiment: rest.py": ("VARIABLES = {}\n", "rest.py has no function run."),
    "experiment: drag.py": ("", "drag is a name of this package"),
    "record: {observables: [drag, rest.py]}": (
        f"{OBSERVED}{{'drag': ((), 'N', 'force')}}",
        "drag has two meanings in files of its runs; rename yours.",
    ),
    "experiment: rest.py  # labels": (
        f"{RUN}{{'density': ((), '1', 'words')}}",
        "density has two meanings in files of its runs; rename yours.",
    ),
    "experiment: rest.py  # axis": (
        f"{RUN}{{'at': ((), '1', 'words')}}\nSIZES = {{'at': 2}}\nAXIS = {{'at': (('at',), '1', 'at')}}",
        "at has two meanings in files of its runs; rename yours.",
    ),
    "experiment: rest.py\nrest: {margn: 0}": (
        RESTING,
        "rest.margn is not a known key; the nearest is margin",
    ),
    "experiment: rest.py\nrest: {margin: -1}": (
        RESTING,
        "rest.margin is -1; it must be at least 0, in m.",
    ),
    "experiment: drag\nrest: {margin: 0}": (RESTING, "rest is not a known key"),
    "experiment: title.py": (RESTING, "its VALUES need a section title, which is another key"),
    "experiment: rest.py  # limit": (
        RESTING.replace("'ge'", "'least'"),
        "its VALUES must be plain values, name: (default",
    ),
    "experiment: rest.py  # no path": (
        RESTING.replace("rest.layers", "rest.layer"),
        "the dimension layer of SIZES has the length None",
    ),
    f"{SWEPT}rest.layers: [2, 3]}}": (
        RESTING,
        "sweep varies rest.layers, which runs of one block share; use blocks.",
    ),
    f"{SWEPT}rest.margin: [0, 1]}}": (
        RESTING.replace("'count'", "'rest_margin'"),
        "sweep gives files of results two things named rest_margin; rename one.",
    ),
    f"{SWEPT}count: {{a: {{}}, b: {{gravity: 1}}}}}}": (
        RESTING,
        "two things named count; rename one",
    ),
    "record: {observables: [rest.py, drag]}": (
        f"{OBSERVED}{{'turn': (('snap',), 'N', 'force')}}",
        "the variable turn is over snap; its dimensions may be bound, displacement",
    ),
}
CALLS = {
    words: (refused(words, text), sentence)
    for words, (text, sentence) in FILES_OF_EXPERIMENTS.items()
}
SHAPES = """
shapes: {pebble: {kind: '%s', diameter: 1e-3, granules: 60, aspect_ratio: 1}}
sweep: {shape: pebble, density: 3900, seed: 1}
"""
CALLS |= {kind: (refused(SHAPES % kind, ""), sentence) for kind, sentence in KINDS.items()}
