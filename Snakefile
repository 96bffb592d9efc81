"""The paper from one configuration file: kernels, beds, replicates, drag.nc, figures.

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
import shlex
import sys

from snakemake.cli import get_argument_parser

import dem
from dem.studies import config as schema
from dem.base.errors import InputError, RunError
from dem.figures import FLOW, possible
from dem.io.progress import WorkflowProgress
from dem.experiment.config import save
from dem.io.results_folder import on_failure, prepare
from dem.base.yaml_file import read


def refuse(sentence):
    print(sentence, file=sys.stderr)
    sys.exit(2)


# What --configfile names, Snakemake reads before this file. What it refuses then (no such file, no UTF-8, values
# nested too deep) keeps its words and its status 1, and it waits for a pipe and expands aliases of groups of
# aliases without end. What it takes but should not, such as equal keys, is refused here, with status 2.
CONFIG_FILES = list(map(str, workflow.overwrite_configfiles)) or ["config/paper.yaml"]
try:
    for each in CONFIG_FILES:
        read(each)
except InputError as error:
    refuse(error)

if not workflow.overwrite_configfiles:

    configfile: "config/paper.yaml"


try:
    SWEEP = schema.parse(config, ", ".join(CONFIG_FILES))
except InputError as error:
    refuse(error)


def targets():
    """Targets of the command line: Snakemake itself tells them only once it has read this file."""
    if "snakemake" not in Path(sys.argv[0]).parts[-2:] or "--target-jobs" in sys.argv:
        return set()  # another program's, or a job that Snakemake sent
    return set(get_argument_parser().parse_known_args(sys.argv[1:])[0].targets)


# `figures` draws what lies there: without the rules that make results, drag.nc and the like are files like any
# other, and nothing is simulated, however much older than the code they are
ONLY_FIGURES = "figures" in targets()
if ONLY_FIGURES and len(targets()) > 1:
    others = ", ".join(sorted(targets() - {"figures"}))
    refuse(f"figures is asked for with {others}; ask for it alone, because it makes no results.")

RESULTS = SWEEP.results
CONFIG = f"{RESULTS}/config.yaml"  # the configuration as resolved, written when the run starts


# Code is a parameter of a rule, and not an input: what its module and the shapes depend on, without comments,
# docstrings and sentences of errors. An edit of anything else makes no job again.
def code_of(*modules, shapes=()):
    """Hash of the code that modules below dem/ and shapes of the sweep depend on."""
    return SWEEP.code_of(*(f"dem.{name}" for name in modules), shapes=shapes)


def physics(*without):
    """What runs of a study depend on in the configuration, as text: not how many there are, nor what they are called."""
    return json.dumps(SWEEP.own_dump({"title", "results", "seeds", "batch", "failures", *without}))


def run_code(wildcards):
    """What a bed and a run of a shape depend on."""
    return code_of("experiment.drag", shapes=[wildcards.shape])


# what says that all replicates are there: with one seed a job their files, else a mark a job
if SWEEP.batch == 1:
    REPLICATES = [f"{RESULTS}/{replicate.path}" for replicate in SWEEP.replicates()]
else:
    REPLICATES = [
        f"{RESULTS}/batches/{shape}/{number}.done"
        for shape in dict.fromkeys(case.shape for case in SWEEP.cases.values())
        for number in range(SWEEP.batches())
    ]
FIGURES = possible(SWEEP) + possible(SWEEP, FLOW)


def quoted(text):
    """A word of the shell; Snakemake fills in what is in braces."""
    return shlex.quote(str(text)).replace("{", "{{").replace("}", "}}")


# Jobs run the Python that runs Snakemake, whatever PATH says, and the `dem` that it found: -P keeps a folder of
# that name where Snakemake was started from being taken. Ctrl-C reaches a job only once it can answer it
# (dem.cli.terminal): Python's start would show a traceback.
shell.prefix(
    "set -euo pipefail; trap '' INT; "
    f"export PYTHONPATH={quoted(Path(dem.__file__).parent.parent)}${{{{PYTHONPATH:+:$PYTHONPATH}}}}; "
    f'dem() {{{{ {quoted(sys.executable)} -P -m dem "$@"; }}}}; '
)


wildcard_constraints:
    shape="[A-Za-z][A-Za-z0-9_-]*",
    density="[0-9.e+-]+",
    seed="[0-9]+",
    group="[0-9]+",
    number="[0-9]+",
    part="[a-z]+",


localrules:
    all,
    figures,


rule all:
    input:
        f"{RESULTS}/drag.nc",
        expand(f"{RESULTS}/figures/{{figure}}.{{kind}}", figure=FIGURES, kind=["svg", "png"]),
    default_target: True


include: "rules/figures.smk"


if not ONLY_FIGURES:

    include: "rules/kernels.smk"
    include: "rules/pack.smk"
    include: "rules/simulate.smk"
    include: "rules/combine.smk"
    include: "rules/flow.smk"
    include: "rules/benchmark.smk"
    include: "rules/accuracy.smk"
    include: "rules/stability.smk"
    include: "rules/claims.smk"
    include: "rules/report.smk"


onstart:
    global HELD  # the folder, until the process ends
    try:
        HELD, said = prepare(RESULTS)
        save(SWEEP, CONFIG)
    except (RunError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(1)
    print(*said, sep="\n", end="\n" if said else "", file=sys.stderr)
    logging.raiseExceptions = False  # that Snakemake's log cannot grow on a full disk is said once
    logging.getLogger("snakemake.logging").addHandler(WorkflowProgress())


onerror:
    print(on_failure(RESULTS), file=sys.stderr)
