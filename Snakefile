"""The paper from one configuration file: kernels, beds, replicates, drag.nc, figures.

    snakemake -j2                                         config/paper.yaml into results/
    snakemake -j2 --configfile config/smoke.yaml          another sweep into its own folder
    snakemake -j2 figures                                 draw again, simulate nothing
    snakemake -j1 benchmark                               time the kernels, beside other codes
    snakemake -j2 accuracy                                error against run time
    snakemake -j2 stability                               stiff and extreme cases
    snakemake -j2 claims                                  which of the paper's claims hold
    snakemake -j2 report                                  one page of everything
"""

import logging
import sys

from dem import config as schema
from dem.errors import InputError, RunError
from dem.figures import FLOW, possible
from dem.progress import WorkflowProgress
from dem.provenance import source_hash
from dem.workplace import on_failure, prepare

if not workflow.overwrite_configfiles:

    configfile: "config/paper.yaml"


try:
    SWEEP = schema.parse(config, ", ".join(map(str, workflow.overwrite_configfiles)) or "config/paper.yaml")
except InputError as error:
    print(error, file=sys.stderr)
    sys.exit(2)

RESULTS = SWEEP.results
CONFIG = f"{RESULTS}/config.yaml"  # the configuration as resolved, written when the run starts
SOURCES = source_hash()
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


# Ctrl-C reaches a job only once it can answer it (dem.terminal): Python's start would show a traceback
shell.prefix("set -euo pipefail; trap '' INT; ")


wildcard_constraints:
    shape="[A-Za-z][A-Za-z0-9_-]*",
    density="[0-9.e+-]+",
    seed="[0-9]+",
    figure="figure[0-9]+",
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


include: "rules/kernels.smk"
include: "rules/pack.smk"
include: "rules/simulate.smk"
include: "rules/combine.smk"
include: "rules/figures.smk"
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
        schema.save(SWEEP, CONFIG)
    except (RunError, OSError) as error:
        print(error, file=sys.stderr)
        sys.exit(1)
    print(*said, sep="\n", end="\n" if said else "", file=sys.stderr)
    logging.raiseExceptions = False  # that Snakemake's log can not grow on a full disk is said once
    logging.getLogger("snakemake.logging").addHandler(WorkflowProgress())


onerror:
    print(on_failure(RESULTS), file=sys.stderr)
