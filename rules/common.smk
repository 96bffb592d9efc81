"""What rules ask of sweeps, which dem.sweep.state computes.

SWEEP is that of the configuration. Each study has one of its own, which is read where a rule asks for it.
"""

import logging
import os
import shlex
import sys
from functools import cache
from pathlib import Path

from dem.base.messages import say
from dem.base.sources import code_hash, codes, files_of, run_codes, with_imports
from dem.experiment.config import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.figures.catalogue import FIGURES, wanted
from dem.io.progress import WorkflowProgress
from dem.io.results_folder import on_failure, prepare
from dem.sweep.estimate import interrupted, outcome
from dem.sweep.state import SweepState
from snakemake.io import IOFile

HERE = Path(str(workflow.current_basedir)).parent
STUDIES = HERE / "studies"  # may be absent, and each study
KNOWN_FIGURES, REPORTED = FIGURES, {}
if STUDIES.is_dir():
    sys.path.insert(0, str(HERE))
    from studies import FOLDERS, has_sweep, package_of
    from studies.catalogue import figures, reported

    KNOWN_FIGURES, REPORTED = figures(), reported()

ROOT = workflow.modifier.path_modifier.prefix or ""  # of a module
SWEEP = SweepState.of_values(config, workflow.configfiles, ROOT)
RESULTS = SWEEP.sweep.results
WARNINGS = SWEEP.check()

# Jobs run the Python that runs Snakemake, for any PATH, and this package, for any working folder.
shell.prefix(
    "set -euo pipefail; export PATH={}:$PATH PYTHONPATH={}:${{{{PYTHONPATH:-}}}}; ".format(
        *(shlex.quote(str(path)).replace("{", "{{").replace("}", "}}") for path in (Path(sys.executable).parent, HERE))
    )
)


@cache
def study(name):
    """The sweep that a study reads: its own, or else that of the configuration."""
    if not has_sweep(name):
        return SWEEP
    sweep = SweepState.of(FOLDERS[name] / SWEEP.sweep.studies, ROOT)
    sweep.check()
    return sweep


def block_of(folder):
    """The sweep of a folder, and the block whose combined files are in it."""
    for sweep in (SWEEP, *map(study, REPORTED)):
        if folder in sweep.folders:
            return sweep, sweep.folders[folder]
    raise ValueError(f"{folder} is no folder of this sweep")


def values_of(w):
    """What combining the runs of a folder reads in its configuration."""
    sweep, block = block_of(w.folder)
    return sweep.text(block)


def config_of(sweep):
    """The resolved configuration of a sweep, which jobs read."""
    return f"{ROOT}{sweep.sweep.results}/config.yaml" if workflow.dryrun else sweep.begin()


def combined(sweep, block):
    """The combined files of a block."""
    return [f"{sweep.folder_of(block)}/{name}.nc" for name in sweep.observables(block)]


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
    if not workflow.dryrun:
        sweep.begin(block)
        keep_whole(sweep.files(block))
    return names_of(sweep.batches(block, rounds))


def names_of(batches):
    """Their files, below the root."""
    return [f"results/store/batches/{batch.id}.nc" for batch in batches]


def missing(sweep, block, rounds=None):
    """The batches of a block that do not exist, after a number of rounds or all that are known."""
    return [batch for batch in sweep.batches(block, rounds) if not sweep.store.file_of(batch.id).is_file()]


def to_make(wildcards):
    """What the sweep must make. Of a drag.nc that exists Snakemake does not ask what it waits for, or what it was
    made of if `dem sweep` made it, so that more runs are targets themselves."""
    targets, known = [], [block for block in SWEEP.sweep.blocks if SWEEP.is_known(block)]
    for block in known:
        if batches := missing(SWEEP, block):
            rounds = list(SWEEP.rounds(block))
            targets += [f"{SWEEP.folder_of(block)}/rounds/{rounds[-1]}"] if rounds else names_of(batches)
    if targets and not workflow.dryrun:
        SWEEP.begin(*known)
    return targets


def keep_whole(files):
    """Let batches be kept whose jobs ended when Snakemake did not live any more: it would take them for
    half-written, delete them and make their runs again."""
    for path in filter(Path.exists, files):
        noted = workflow.persistence.metadata(file := IOFile(str(path)))
        if noted is None or noted.endtime < path.stat().st_mtime:
            workflow.persistence.cleanup_metadata(file)


# Code is a parameter of a rule, and not an input, so that an edit of a comment or a docstring reruns no job. Batches
# need none: the code is part of the identity of their runs.
def code_of(*names, runs=False):
    """Hash of the code of files and folders, and of what they import of studies; runs: also of what makes runs."""
    files = [each for file in files_of(names, HERE) for each in with_imports(file)]
    return code_hash(codes(files, HERE) | (run_codes() if runs else {}))


def code_of_figure(figure):
    """The same of a figure, and of what all figures share; no other figure but that whose headings some have."""
    figures = {f"dem/figures/{name}.py" for name in FIGURES} - {"dem/figures/sweep.py"}
    shared = {file.relative_to(HERE).as_posix() for file in files_of(["dem/figures"], HERE)} - figures
    return code_of(f"{figure.module.replace('.', '/')}.py", *sorted(shared), "dem/analysis")


NOT_READ = "record", "sweep", "title", "failures"  # by a study without runs


def read_by(name):
    """The files that a study reads beside the batches of its runs: those that it names, and the
    combined files that some of its runs are derived from."""
    found = [os.path.relpath(HERE / path) for path in REPORTED[name].get("READS", ())]
    if has_sweep(name):
        own = study(name)
        needed = [each for block in own.sweep.blocks for each in own.sweep.needed(block)]
        for block in dict.fromkeys(needed):
            found += combined(own, block)
    return found


def folder_of(name):
    """The folder of a study, below the checkout."""
    return package_of(name).replace(".", "/")


def measures(name):
    """Whether a study measures by itself."""
    return REPORTED[name].get("MEASURES", False)


def batches_of(name, derived=False):
    """The batches of those blocks of a study whose values are derived from others, or of the others."""
    own = study(name)
    blocks = own.folders.items()
    folders = [folder for folder, block in blocks if bool(own.needed(block)) == derived]
    return list(dict.fromkeys(batch for folder in folders for batch in batches_in(folder)))


def pictures(names, folder=RESULTS):
    """Both files of each of some figures."""
    return expand("{folder}/figures/{figure}.{kind}", folder=folder, figure=names, kind=["svg", "png"])


def pictures_of(study):
    """Both files of each figure of a study."""
    return pictures([name for name, figure in KNOWN_FIGURES.items() if figure.file == study])


# The results of each block of the sweep: its combined files, and the figures that these suffice for.
COMBINED, PICTURES = [], []
for folder, block in SWEEP.folders.items():
    COMBINED += combined(SWEEP, block)
    PICTURES += pictures(wanted(SWEEP.block(block), SWEEP.sweep.figures, KNOWN_FIGURES), folder)


def begin():
    """Hold the folder of results until the process ends, and say what is unusual."""
    global LOCK
    LOCK, sentences = prepare(SWEEP.results, SWEEP.store.folder)
    for sentence in (*sentences, *WARNINGS):
        say(sentence)
    SWEEP.failed()  # counts what fails from now on
    logging.raiseExceptions = False  # that Snakemake's log cannot grow on a full disk is said once
    logging.getLogger("snakemake.logging").addHandler(WorkflowProgress(SWEEP.counts))
