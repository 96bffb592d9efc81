"""The paper, or any sweep, from one configuration file: batches of runs, drag.nc, figures.

    snakemake -j2                                         config/paper.yaml into results/
    snakemake -j2 --configfile config/smoke.yaml          another sweep into its own folder
    snakemake -j2 --profile profiles/figures figures      draw what the results give, simulate nothing
    snakemake -j1 benchmark                               time the kernels, beside other codes
    snakemake -j2 accuracy                                error against run time, of the step and of few beds
    snakemake -j2 stability                               stiff and extreme cases
    snakemake -j2 verification                            known cases against what is expected
    snakemake -j2 precision                               how often a mean is as near as a sweep asks for: part of accuracy
    snakemake -j2 budget                                  what a budget of processor time buys: part of accuracy
    snakemake -j2 claims                                  which of the paper's claims hold
    snakemake -j2 report                                  one page of everything

profiles/default names config/paper.yaml. As a module, this takes the values of a sweep as config.
"""


include: "rules/common.smk"  # SWEEP, its RESULTS, and what rules ask of it


wildcard_constraints:
    folder="results(/[A-Za-z0-9][A-Za-z0-9._ -]*)*",
    batch="[0-9a-f]{16}",
    number="[0-9]+",
    observable="|".join({*OBSERVABLES, *EXPERIMENTS, *(Path(file).stem for file in COMBINED)}),  # also of a user's own
    figure="|".join(KNOWN_FIGURES),
    study="|".join(REPORTED) or "-",


localrules:
    all,
    figures,


rule all:
    input:
        COMBINED,
        PICTURES,
        to_make,


rule figures:
    input:
        PICTURES,
        [pictures_of(name) for name in REPORTED if os.path.exists(f"{RESULTS}/{name}.nc")],


include: "rules/batch.smk"
include: "rules/combine.smk"
include: "rules/figures.smk"
include: "rules/report.smk"


include: "rules/studies.smk"


onstart:
    workflow.results_lock = prepare(SWEEP.results, SWEEP.store.folder)  # until the process ends
    for sentence in WARNINGS:
        say(sentence)
    logging.raiseExceptions = False  # that Snakemake's log cannot grow on a full disk is said once


onsuccess:
    if all(map(os.path.exists, COMBINED)):
        files = " ".join(map(os.path.relpath, workflow.configfiles))
        say(outcome(SWEEP, draws=f"snakemake -j2 report --configfile {files}"))
        if words := SWEEP.near_zero(*SWEEP.sweep.blocks):
            say(words)
            sys.exit(1)


onerror:
    say(f"{SWEEP.results}: {interrupted(SWEEP)}")
