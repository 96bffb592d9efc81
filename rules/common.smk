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

from dem.base.messages import say
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
KNOWN_FIGURES, REPORTED = FIGURES, ()
if STUDIES.is_dir():
    sys.path.insert(0, str(HERE))
    from studies.catalogue import figures, reported

    KNOWN_FIGURES, REPORTED = figures(), reported()
STUDY_NAMES = sorted(path.parent.name for path in STUDIES.glob("*/rules.smk"))

ROOT = workflow.modifier.path_modifier.prefix or ""  # of a module
SWEEP = Campaign.of_values(config, workflow.configfiles, ROOT)
RESULTS = SWEEP.sweep.results
SMOKE = "--smoke" if SWEEP.sweep.studies == "smoke.yaml" else ""  # of verbs that measure
SWEEP.check()

# Jobs run the Python that runs Snakemake, for any PATH, and this package, for any working folder.
shell.prefix(
    "set -euo pipefail; export PATH={}:$PATH PYTHONPATH={}:${{{{PYTHONPATH:-}}}}; ".format(
        *(shlex.quote(str(path)).replace("{", "{{").replace("}", "}}") for path in (Path(sys.executable).parent, HERE))
    )
)


@cache
def study(name):
    """The sweep of a study."""
    found = Campaign.of(STUDIES / name / SWEEP.sweep.studies, ROOT)
    found.check()
    return found


def place_of(folder):
    """The sweep of a folder, and the block whose combined files are in it."""
    with_sweeps = (name for name in STUDY_NAMES if (STUDIES / name / SWEEP.sweep.studies).is_file())
    for sweep in chain([SWEEP], map(study, with_sweeps)):
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


def study_batches(name, derived=False):
    """The batches of those blocks of a study whose values are derived from other blocks, or of the others."""
    sweep = study(name)
    folders = [folder for folder, block in sweep.folders.items() if bool(sweep.needed(block)) == derived]
    return list(dict.fromkeys(batch for folder in folders for batch in batches_in(folder)))


# Code is a parameter of a rule, and not an input: the hash of what its module and the shapes depend on,
# without comments, docstrings and sentences of errors. Other edits rerun no job. Batches need no such
# parameter, because the code is part of the identity of their runs.
def code_of(*modules, shapes=()):
    """Hash of the code that modules and shapes of the sweep depend on."""
    return SWEEP.sweep.code_of(*modules, shapes=shapes)


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
    logging.raiseExceptions = False  # that Snakemake's log cannot grow on a full disk is said once
    logging.getLogger("snakemake.logging").addHandler(WorkflowProgress(SWEEP.counts, SWEEP.failed))
