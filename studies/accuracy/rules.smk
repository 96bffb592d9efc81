"""Error against run time: contacts, integrators, the mean drag; not part of the default.

    snakemake -j2 accuracy

What is timed runs alone on the computer, the rest side by side.

REQUIRED INPUTS
    the batches of the sweep that the configuration names as studies.accuracy
OUTPUTS
    {RESULTS}/accuracy/contacts.nc, {RESULTS}/accuracy/steps.nc
    {RESULTS}/accuracy.nc, {RESULTS}/accuracy.txt
    {RESULTS}/figures/accuracy_{figure}.svg, {RESULTS}/figures/accuracy_{figure}.png
"""

localrules:
    accuracy,


rule accuracy:
    input:
        f"{RESULTS}/accuracy.txt",
        pictures_of("accuracy"),


rule accuracy_contacts:
    message:
        "Contacts of ellipses: error against time, alone on the computer"
    output:
        f"{RESULTS}/accuracy/contacts.nc",
    params:
        code=code_of("studies.accuracy.contacts", "studies.accuracy.bounces"),
        smoke=SMOKE,
        config=lambda w: config_of(study("accuracy")),
    threads: lambda w: workflow.cores
    log:
        f"{RESULTS}/logs/accuracy/contacts.log",
    shell:
        "python -P -m studies accuracy contacts --config {params.config} {params.smoke} -o {output} 2> {log}"


rule accuracy_steps:
    message:
        "Time steps and integrators: error against time, alone on the computer"
    output:
        f"{RESULTS}/accuracy/steps.nc",
    params:
        code=code_of("studies.accuracy.steps"),
        sweep=lambda w: study("accuracy").text(None, "record", "sweep", "title", "failures"),
        smoke=SMOKE,
        config=lambda w: config_of(study("accuracy")),
    threads: lambda w: workflow.cores
    log:
        f"{RESULTS}/logs/accuracy/steps.log",
    shell:
        "python -P -m studies accuracy steps --config {params.config} {params.smoke} -o {output} 2> {log}"


rule accuracy_table:
    message:
        "Gather the study into {output}"
    input:
        contacts=f"{RESULTS}/accuracy/contacts.nc",
        steps=f"{RESULTS}/accuracy/steps.nc",
        batches=lambda w: study_batches("accuracy"),
    output:
        f"{RESULTS}/accuracy.nc",
    params:
        code=code_of("studies.accuracy.table"),
        sweep=lambda w: study("accuracy").text(),
        config=lambda w: config_of(study("accuracy")),
    log:
        f"{RESULTS}/logs/accuracy/table.log",
    shell:
        "python -P -m studies accuracy table --config {params.config} --contacts {input.contacts} --steps {input.steps}"
        " -o {output} 2> {log}"
