"""Error against run time: contacts, integrators, the mean drag; not part of the default.

    snakemake -j2 accuracy

What is timed runs alone on the computer, the rest side by side.

REQUIRED INPUTS
    the chunks of the sweep that the configuration names as studies.accuracy
OUTPUTS
    {RESULTS}/accuracy/contacts.nc, {RESULTS}/accuracy/steps.nc
    {RESULTS}/accuracy.nc, {RESULTS}/accuracy.txt
    {RESULTS}/figures/accuracy_{figure}.svg, {RESULTS}/figures/accuracy_{figure}.png
"""


def accuracy_chunks(wildcards):
    """The chunks of all runs."""
    from studies.accuracy.table import runs_of

    try:
        runs_of(study("accuracy").sweep)
    except InputError as error:
        refuse(error)
    return study_chunks("accuracy")


SMOKE = "--smoke" if SWEEP.studies == "smoke.yaml" else ""


localrules:
    accuracy,


rule accuracy:
    input:
        RESULTS + "/accuracy.txt",
        pictures_of("accuracy"),


rule accuracy_contacts:
    message:
        "Contacts of ellipses: error against time, alone on the computer"
    output:
        update(RESULTS + "/accuracy/contacts.nc"),
    params:
        code=code_of("studies.accuracy.contacts", "studies.accuracy.bounces"),
        smoke=SMOKE,
        config=lambda w: study_config("accuracy"),
    threads: workflow.cores
    log:
        RESULTS + "/logs/accuracy/contacts.log",
    shell:
        "begin {output:q}; study accuracy contacts --config {params.config} {params.smoke} -o {output} 2> {log}; end {output:q}"


rule accuracy_steps:
    message:
        "Time steps and integrators: error against time, alone on the computer"
    output:
        update(RESULTS + "/accuracy/steps.nc"),
    params:
        code=code_of("studies.accuracy.steps"),
        sweep=lambda w: values_of(study("accuracy").sweep, "record", "sweep", *SHOWN),
        smoke=SMOKE,
        config=lambda w: study_config("accuracy"),
    threads: workflow.cores
    log:
        RESULTS + "/logs/accuracy/steps.log",
    shell:
        "begin {output:q}; study accuracy steps --config {params.config} {params.smoke} -o {output} 2> {log}; end {output:q}"


rule accuracy_table:
    message:
        "Gather the study into {output}"
    input:
        contacts=RESULTS + "/accuracy/contacts.nc",
        steps=RESULTS + "/accuracy/steps.nc",
        chunks=accuracy_chunks,
    output:
        update(RESULTS + "/accuracy.nc"),
    params:
        code=code_of("studies.accuracy.table"),
        sweep=lambda w: values_of(study("accuracy").sweep, *UNREAD),
        config=lambda w: study_config("accuracy"),
    log:
        RESULTS + "/logs/accuracy/table.log",
    shell:
        "begin {output:q}; study accuracy table --config {params.config} --contacts {input.contacts} --steps {input.steps}"
        " -o {output} 2> {log}; end {output:q}"
