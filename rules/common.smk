"""What rules ask of sweeps, which dem.sweep.state computes.

SWEEP is that of the configuration. Each study has one of its own, which is read where a rule asks for it.
"""

import logging
import os
import sys
from functools import cache
from itertools import chain
from pathlib import Path
from threading import Lock

from dem.base.messages import say
from dem.base.source_hash import code_hash, codes, files_of, run_codes, with_imports
from dem.experiment.config import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.figures.catalogue import FIGURES, draw, wanted
from dem.sweep.restart import prepare
from dem.sweep.estimate import interrupted, outcome
from dem.sweep.state import SweepState

HERE = Path(str(workflow.current_basedir)).parent
KNOWN_FIGURES, REPORTED = FIGURES, {}
if (HERE / "studies").is_dir():  # it may be absent, and each study
    sys.path.insert(0, str(HERE))
    from studies import FOLDERS, has_sweep
    from studies.catalogue import figures, reported

    KNOWN_FIGURES, REPORTED = figures(), reported()

ROOT = workflow.modifier.path_modifier.prefix or ""  # of a module
SWEEP = SweepState.of_values(config, workflow.configfiles, ROOT)
RESULTS = SWEEP.sweep.results
WARNINGS = SWEEP.check()

# Jobs run the Python that runs Snakemake, for any PATH, and this package, for any working folder.
os.environ.update(
    PATH=f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}",
    PYTHONPATH=f"{HERE}:{os.environ.get('PYTHONPATH', '')}",
)


@cache
def study(name):
    """The sweep that a study reads: its own, or else that of the configuration."""
    if not has_sweep(name):
        return SWEEP
    state = SweepState.of(FOLDERS[name] / SWEEP.sweep.studies, ROOT)
    state.check()
    return state


def block_of(folder):
    """The sweep of a folder, and the block whose combined files are in it."""
    for sweep in chain([SWEEP], map(study, REPORTED)):  # of studies only until one has it
        if folder in sweep.folders:
            return sweep, sweep.folders[folder]
    raise ValueError(f"{folder} is no folder of this sweep")


def values_of(w):
    """What combining the runs of a folder reads in its configuration."""
    return SweepState.text(*block_of(w.folder))


def config_of(sweep):
    """The resolved configuration of a sweep, which jobs read beside the plans of batches."""
    return f"{ROOT}{sweep.sweep.results}/config.yaml" if workflow.dryrun else sweep.begin()


def batches_in(folder, rounds=None):
    """The batches of a block; those of a derived one are known once the blocks that it needs are combined,
    and those of a round of replicates once the rounds before it are made."""
    sweep, block = block_of(folder)
    for other in sweep.sweep.needed(block):
        for name in sweep.observables(other):
            checkpoints.combine.get(folder=sweep.folder_of(other), observable=name)
    for number in sweep.rounds(block):
        if number == rounds:
            break
        if missing(sweep, block, number):
            checkpoints.round.get(folder=folder, number=number)
    batches = names_of(sweep, block, rounds)
    config_of(sweep)
    return batches


POSITION = {}  # of a batch in the plan of its block, where the first of each kind of kernel are in front


def names_of(sweep, block, rounds=None):
    """The files of the batches of a block, below the root; rounds: after a number of these, or all that are known."""
    batches = [batch.id for batch in sweep.batches(block, rounds)]
    POSITION.update(map(reversed, enumerate(batches)))
    return [f"results/store/batches/{batch}.nc" for batch in batches]


def missing(sweep, block, rounds=None):
    """Those that do not exist."""
    return [name for name in names_of(sweep, block, rounds) if not os.path.exists(ROOT + name)]


def to_make(wildcards):
    """What the sweep must make. Snakemake does not reopen an existing drag.nc, nor one by `dem
    sweep`, so missing batches are targets themselves."""
    targets = []
    for block in filter(SWEEP.is_known, SWEEP.sweep.blocks):
        if batches := missing(SWEEP, block):
            rounds = list(SWEEP.rounds(block))
            targets += [f"{SWEEP.folder_of(block)}/rounds/{rounds[-1]}"] if rounds else batches
    config_of(SWEEP)
    return targets


# Code is a parameter of a rule, and not an input, so that an edit of a comment or a docstring reruns no job. Batches
# need none: the code is part of the identity of their runs.
@cache
def code_of(*names, runs=False):
    """Hash of the code of files and folders, and of what they import of studies; runs: also of what makes runs."""
    files = [path for file in files_of(names, HERE) for path in with_imports(file, HERE)]
    return code_hash(codes(files, HERE) | (run_codes() if runs else {}))


NUMBERS = "dem/analysis", "dem/base/statistics.py"  # what makes the numbers of figures, tables and reports of runs

# Files that all figures share, and sweep.py, whose headings some have.
SHARED = {*files_of(["dem/figures"], HERE)} - {HERE / f"dem/figures/{name}.py" for name in FIGURES if name != "sweep"}

DRAWING = Lock()  # neither Matplotlib nor HDF5 may be used by two threads


def draw_one(figure, data, picture, log):
    """Draw a figure into the folder of a picture, after those before it; the log says why it failed, if it did."""
    with DRAWING, open(log, "w") as text:
        try:
            draw(figure, Path(data), Path(picture).parent, KNOWN_FIGURES)
        except Exception as error:
            print(error, file=text)
            raise


NOT_READ = "record", "sweep", "title", "failures"  # by a study without runs


def read_by(name):
    """The files that a study reads: those that it names, and the batches of its runs."""
    batches = [path for folder in study(name).folders for path in batches_in(folder)] if has_sweep(name) else []
    return [*map(os.path.relpath, map(HERE.joinpath, REPORTED[name].get("READS", ()))), *dict.fromkeys(batches)]


def pictures(names, folder=RESULTS):
    """Both files of each of some figures."""
    return expand("{folder}/figures/{figure}.{kind}", folder=folder, figure=names, kind=["svg", "png"])


def pictures_of(study):
    """Both files of each figure of a study."""
    return pictures([name for name, figure in KNOWN_FIGURES.items() if figure.file == study])


# The results of each block of the sweep: its combined files, and the figures that these suffice for.
COMBINED, PICTURES = [], []
for folder, block in SWEEP.folders.items():
    COMBINED += [f"{folder}/{name}.nc" for name in SWEEP.observables(block)]
    PICTURES += pictures(wanted(SWEEP.block(block), SWEEP.sweep.figures, KNOWN_FIGURES), folder)
