"""The paper, or any sweep, from one configuration file: kernels, chunks of runs, drag.nc, figures.

    snakemake -j2                                         config/paper.yaml into results/
    snakemake -j2 --configfile config/smoke.yaml          another sweep into its own folder
    snakemake -j2 figures                                 draw what the results give, simulate nothing
    snakemake -j1 benchmark                               time the kernels, beside other codes
    snakemake -j2 accuracy                                error against run time
    snakemake -j2 stability                               stiff and extreme cases
    snakemake -j2 claims                                  which of the paper's claims hold
    snakemake -j2 report                                  one page of everything
"""

import json
import logging
import os
import re
import shlex
import sys
from base64 import urlsafe_b64encode
from functools import cache
from itertools import chain

from snakemake.cli import get_argument_parser
from snakemake.common.configfile import load_configfile

import dem
from dem.base.errors import InputError, RunError
from dem.base.say import say
from dem.base.sources import code_hash
from dem.base.yaml_file import read
from dem.experiment.config import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.figures.catalogue import FIGURES as OWN_FIGURES, possible, wanted
from dem.io.progress import WorkflowProgress
from dem.io.results_folder import on_failure, prepare
from dem.sweep import config as schema
from dem.sweep.estimate import kept, outcome
from dem.sweep.units import unusual
from dem.sweep.work import Work


def refuse(sentence):
    say(sentence)
    sys.exit(2)


# Snakemake reads the files of --configfile before this file. What Snakemake refuses (no such file, no
# UTF-8, values nested too deep) keeps its words and its status 1. Snakemake also waits for a pipe and
# expands aliases without end. What it takes but should not, such as equal keys, is refused here, with
# status 2.
CONFIG_FILES = list(map(str, workflow.overwrite_configfiles)) or ["config/paper.yaml"]
try:
    for each in CONFIG_FILES:
        read(each)
except InputError as error:
    refuse(error)

if not workflow.overwrite_configfiles:

    configfile: "config/paper.yaml"


# The folder of studies may be absent, and each study.
STUDIES = Path(workflow.basedir) / "studies"
if STUDIES.is_dir():
    sys.path.insert(0, workflow.basedir)
    import studies
    from studies.catalogue import figures as figures_of_all, reported

    KNOWN_FIGURES, STUDY_NAMES, REPORTED = figures_of_all(), studies.NAMES, reported()
else:
    KNOWN_FIGURES, STUDY_NAMES, REPORTED = OWN_FIGURES, (), ()


def written(work):
    """Places, beside the combined files, at which a job would write through a link or replace it."""
    found = []
    for folder in map(Path, {work.sweep.results, *work.folders}):
        named = [f"{name}.{kind}" for name in REPORTED for kind in ("nc", "txt")]
        named += [f"figures/{name}.{kind}" for name in KNOWN_FIGURES for kind in ("svg", "png")]
        found += [folder / name for name in (*named, "report.html", "provenance.html")]
        for name in ("logs", "benchmarks", "flow", *STUDY_NAMES):
            found += (folder / name).rglob("*")
    # chunks are links of our own
    return [path for path in found if path.is_symlink() and not path.is_dir() and "chunks" not in path.parts]


# What other values than those of one file go into (--config, a module) has no file.
try:
    found = schema.parse(config, ", ".join(CONFIG_FILES))
    OF_FILE = len(CONFIG_FILES) == 1 and load_configfile(CONFIG_FILES[0]) == config
    MAIN = Work(found, file=schema.file_of(found, CONFIG_FILES[0]) if OF_FILE else "")
    MAIN.check(written(MAIN))
except InputError as error:
    refuse(error)
SWEEP, STORE = MAIN.sweep, MAIN.store
WITH_SWEEPS = [name for name in STUDY_NAMES if (STUDIES / name / "rules.smk").is_file() and (STUDIES / name / SWEEP.studies).is_file()]

# Snakemake puts the file of `update` back when a job fails, but notes the job as finished, and would do nothing
# the next time. A job therefore leaves a mark where it began and did not end, also where it was killed with all
# else. It becomes Snakemake's own mark of what is incomplete.
UNFINISHED = ".snakemake/unfinished"
for mark in Path(UNFINISHED).rglob("*") if "--target-jobs" not in sys.argv else ():
    if mark.is_file():
        name = urlsafe_b64encode(str(mark.relative_to(UNFINISHED)).encode()).decode()
        *folders, name = re.findall(".{1,254}", name)
        noted = Path(".snakemake/incomplete", *(f"@{each}" for each in folders), name)
        noted.parent.mkdir(parents=True, exist_ok=True)
        noted.write_text('{"external_jobid": null}')

# The command line, because Snakemake gives its targets only after reading this file. It is not read
# if another program, or a job that Snakemake sent, runs this file.
OWN = "snakemake" in Path(sys.argv[0]).parts[-2:] and "--target-jobs" not in sys.argv
ARGUMENTS = get_argument_parser().parse_known_args(sys.argv[1:] if OWN else [])[0]
TARGETS = set(ARGUMENTS.targets)

# `figures` draws the results that exist. Without the rules that make results, drag.nc is a file like
# any other, and nothing is simulated, even if it is older than the code.
ONLY_FIGURES = "figures" in TARGETS
if ONLY_FIGURES and len(TARGETS) > 1:
    others = ", ".join(sorted(TARGETS - {"figures"}))
    refuse(f"the target figures comes with {others}; ask for it alone, because it makes no results.")

RESULTS = SWEEP.results
CONFIG = f"{RESULTS}/config.yaml"  # the configuration as resolved, written when the run starts
WORKS = {RESULTS: MAIN}  # sweeps by their folder of results; those of studies when they are asked for


@cache
def study(name):
    """The sweep of a study."""
    try:
        found = Work.of(STUDIES / name / SWEEP.studies, STORE)
        found.check(written(found))
    except InputError as error:
        refuse(error)
    return WORKS.setdefault(found.sweep.results, found)


def study_needed(name):
    """Combined files of blocks that values of others are derived from."""
    work = study(name)
    return sorted({str(path) for block in work.sweep.blocks for path in work.needed(block)})


def study_chunks(name, derived=False):
    """The chunks of those blocks of a study whose values are derived from other blocks, or of the others."""
    work = study(name)
    folders = [work.folder_of(each) for each in work.sweep.blocks if bool(work.needed(each)) == derived]
    return list(dict.fromkeys(link for folder in folders for link in chunks_in(folder)))


def study_config(name):
    """The configuration of a study as resolved."""
    return f"{study(name).sweep.results}/config.yaml"


def place_of(folder):
    """The sweep of a folder, and the block whose combined files are in it."""
    for work in chain(list(WORKS.values()), map(study, WITH_SWEEPS)):  # each study when it is looked at
        if folder in work.folders:
            return work, work.folders[folder]
    raise ValueError(f"{folder} is no folder of this sweep")


def values_of_block(folder):
    """What is made of the runs of a block depends on in a configuration, as text."""
    work, block = place_of(folder)
    return values_of(work.sweep, "sweep", *UNREAD) + json.dumps(work.sweep.blocks[block])


# Code is a parameter of a rule, and not an input: the hash of what its module and the shapes depend on,
# without comments, docstrings and sentences of errors. Other edits rerun no job. Runs need no such
# parameter, because the code is part of their identity.
def code_of(*modules, shapes=()):
    """Hash of the code that modules and shapes of the sweep depend on."""
    return SWEEP.code_of(*modules, shapes=shapes)


def values_of(sweep, *without):
    """What a job depends on in a configuration, as text."""
    return json.dumps({key: new for key, new in sweep.dump().items() if key not in without})


SHOWN = "title", "results", "chunk", "failures", "figures", "studies", "beside"  # no run reads them
UNREAD = "chunk", "figures", "results", "studies", "beside"  # nor does what is made of runs

# The results of each block of the sweep: its combined files, and the figures that these suffice for.
COMBINED, FIGURES = [], []
for folder, name in MAIN.folders.items():
    try:
        drawn = wanted(MAIN.block(name), SWEEP.figures, KNOWN_FIGURES)
    except InputError as error:
        refuse(error)
    found = [*MAIN.observables(name), *(KNOWN_FIGURES[figure].file for figure in drawn)]
    COMBINED += [f"{folder}/{observable}.nc" for observable in dict.fromkeys(found)]
    FIGURES += [(folder, figure) for figure in drawn]
PICTURES = [f"{folder}/figures/{figure}.{kind}" for folder, figure in FIGURES for kind in ("svg", "png")]


def quoted(text):
    """A word of the shell; Snakemake fills in what is in braces."""
    return shlex.quote(str(text)).replace("{", "{{").replace("}", "}}")


# Jobs run the Python that runs Snakemake, for any PATH, and the `dem` that it found: -P ignores a
# folder `dem` in the working folder. Ctrl-C reaches a job only when it can answer (dem.cli.terminal),
# because Python would show a traceback while it starts.
shell.prefix(
    "set -euo pipefail; trap '' INT; "
    f"export PYTHONPATH={quoted(Path(dem.__file__).parent.parent)}:{quoted(workflow.basedir)}${{{{PYTHONPATH:+:$PYTHONPATH}}}}; "
    # begin and end mark what a job is to make, where it is there
    + f'begin() {{{{ for each; do if [ -e "$each" ]; then mkdir -p "{UNFINISHED}/${{{{each%/*}}}}"; '
    f'touch "{UNFINISHED}/$each"; fi; done; }}}}; '
    f'end() {{{{ for each; do rm -f "{UNFINISHED}/$each"; done; }}}}; '
    + f'dem() {{{{ {quoted(sys.executable)} -P -m dem "$@"; }}}}; '
    + f'study() {{{{ {quoted(sys.executable)} -P -m studies "$@"; }}}}; '
    # --forceall and -R chunk make runs again that are there
    + ("export DEM_AGAIN=1; " if ARGUMENTS.forceall or "chunk" in (ARGUMENTS.forcerun or ()) else "")
)


wildcard_constraints:
    folder="results(/[A-Za-z0-9][A-Za-z0-9._ -]*)*",
    chunk="[0-9a-f]{16}",
    kernels="[0-9a-f]{16}",
    shape="[A-Za-z][A-Za-z0-9_-]*",


localrules:
    all,
    figures,


rule all:
    input:
        COMBINED,
        PICTURES,
    default_target: True


include: "rules/figures.smk"


if not ONLY_FIGURES:

    include: "rules/kernels.smk"
    include: "rules/chunk.smk"
    include: "rules/combine.smk"
    include: "rules/flow.smk"
    include: "rules/report.smk"

    for name in STUDY_NAMES:
        if (STUDIES / name / "rules.smk").is_file():
            include: f"studies/{name}/rules.smk"


STARTED = False


onstart:
    global HELD, STARTED  # the folder, until the process ends
    try:
        HELD, said = prepare(RESULTS)
        for work in WORKS.values():
            said += work.check()
            schema.save(work.sweep, f"{work.sweep.results}/config.yaml", work.file)
            work.settle()
        STARTED = True
        said += unusual(MAIN)
    except (InputError, RunError, OSError) as error:
        say(error)
        sys.exit(1)
    for sentence in said:
        say(sentence)
    logging.raiseExceptions = False  # that Snakemake's log cannot grow on a full disk is said once
    logging.getLogger("snakemake.logging").addHandler(WorkflowProgress())


# Only of the sweep itself: of what else is made, such as studies, Snakemake names the files.
WHOLE = OWN and TARGETS <= {"all"}


onsuccess:
    if WHOLE:
        given = ["--configfile", *map(os.path.relpath, CONFIG_FILES)] if workflow.overwrite_configfiles else []
        say(outcome(MAIN, draws=shlex.join(["snakemake", "-j2", "report", *given])))


onerror:
    said = "Finished files are kept; run the same command to continue."
    if WHOLE:
        said = kept(MAIN, shlex.join(["snakemake", *sys.argv[1:]]))
    say(on_failure(RESULTS, said))
