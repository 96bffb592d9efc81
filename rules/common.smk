"""What rules ask of sweeps, which dem.sweep.campaign computes.

SWEEP is that of the configuration. Each study has one of its own, looked at where it is asked for.
"""

import logging
import os
import shlex
import sys
from functools import cache
from itertools import chain
from pathlib import Path

from dem.base.say import say
from dem.base.sources import code_hash, codes, files_of, run_codes, with_imports
from dem.experiment.config import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.figures.catalogue import FIGURES, wanted
from dem.io.progress import WorkflowProgress
from dem.io.results_folder import on_failure, prepare
from dem.sweep.campaign import Campaign
from dem.sweep.estimate import kept, outcome
from dem.sweep.units import unusual
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
SWEEP = Campaign.of_values(config, workflow.configfiles, ROOT)
RESULTS = SWEEP.sweep.results
SWEEP.check()

# Jobs run the Python that runs Snakemake, for any PATH, and this package, for any working folder. Ctrl-C
# reaches a job only when it can answer (dem.cli.stopping), because Python would show a traceback while
# it starts.
shell.prefix(
    "set -euo pipefail; trap '' INT; export PATH={}:$PATH PYTHONPATH={}:${{{{PYTHONPATH:-}}}}; ".format(
        *(shlex.quote(str(path)).replace("{", "{{").replace("}", "}}") for path in (Path(sys.executable).parent, HERE))
    )
)


@cache
def study(name):
    """The sweep that a study reads: its own, or else that of the configuration."""
    if not has_sweep(name):
        return SWEEP
    found = Campaign.of(FOLDERS[name] / SWEEP.sweep.studies, ROOT)
    found.check()
    return found


def place_of(folder):
    """The sweep of a folder, and the block whose combined files are in it."""
    for sweep in chain([SWEEP], map(study, REPORTED)):
        if folder in sweep.folders:
            return sweep, sweep.folders[folder]
    raise ValueError(f"{folder} is no folder of this sweep")


def config_of(sweep):
    """The resolved configuration of a sweep, which jobs read."""
    return f"{ROOT}{sweep.sweep.results}/config.yaml" if workflow.dryrun else sweep.begin()


def batches_in(folder, rounds=None):
    """The batches of a block; those of a derived one are known once the blocks that it needs are combined,
    and those of a round once the rounds before it are made."""
    sweep, block = place_of(folder)
    for name in sweep.sweep.needed(block):
        for observable in sweep.observables(name):
            checkpoints.combine.get(folder=sweep.folder_of(name), observable=observable)
    for number in sweep.rounds(block):
        if number == rounds:
            break
        if missing(sweep, block, number):
            checkpoints.round.get(folder=folder, number=number)
    if not workflow.dryrun:
        sweep.begin(block)
        keep_whole(sweep.files(block))
    return [f"results/store/batches/{batch.id}.nc" for batch in sweep.batches(block, rounds)]


def missing(sweep, block, rounds=None):
    """The batches of a block that are not there, after a number of rounds or all that are known."""
    return [batch for batch in sweep.batches(block, rounds) if not sweep.store.file_of(batch.id).is_file()]


def to_make(wildcards):
    """What the sweep must make. Of a drag.nc that is there Snakemake does not ask what it waits for, or what it was
    made of if `dem sweep` made it, so that more runs are targets themselves."""
    found = []
    for folder, block in SWEEP.folders.items():
        if SWEEP.is_known(block) and (left := missing(SWEEP, block)):
            rounds = list(SWEEP.rounds(block))
            batches = [f"results/store/batches/{batch.id}.nc" for batch in left]
            found += [f"{folder}/rounds/{rounds[-1]}"] if rounds else batches
    if found and not workflow.dryrun:
        SWEEP.begin(*(block for block in SWEEP.sweep.blocks if SWEEP.is_known(block)))
    return found


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


def pictures(names, folder=RESULTS):
    """Both files of each of some figures."""
    return expand("{folder}/figures/{figure}.{kind}", folder=folder, figure=names, kind=["svg", "png"])


def pictures_of(study):
    """Both files of each figure of a study."""
    return pictures([name for name, each in KNOWN_FIGURES.items() if each.file == study])


RECORDED = {each for block in SWEEP.sweep.blocks for each in SWEEP.observables(block)}  # also by files of a user's own

# The results of each block of the sweep: its combined files, and the figures that these suffice for.
COMBINED, PICTURES = [], []
for folder, block in SWEEP.folders.items():
    names = wanted(SWEEP.block(block), SWEEP.sweep.figures, KNOWN_FIGURES)
    found = [*SWEEP.observables(block), *(KNOWN_FIGURES[name].file for name in names)]
    COMBINED += [f"{folder}/{observable}.nc" for observable in dict.fromkeys(found)]
    PICTURES += pictures(names, folder)

HELD = []


def begin():
    """Hold the folder of results until the process ends, and say what is unusual."""
    held, said = prepare(SWEEP.results, SWEEP.store.folder)
    HELD.append(held)
    for sentence in (*said, *unusual(SWEEP)):
        say(sentence)
    SWEEP.failed()  # counts what fails from now on
    logging.raiseExceptions = False  # that Snakemake's log cannot grow on a full disk is said once
    logging.getLogger("snakemake.logging").addHandler(WorkflowProgress(SWEEP.counts))
