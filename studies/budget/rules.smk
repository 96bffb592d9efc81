"""What a budget of processor time buys: snakemake -j2 budget
REQUIRED INPUTS the batches of the sweep that the configuration names as studies.budget
OUTPUTS {RESULTS}/budget.nc, {RESULTS}/budget.txt, {RESULTS}/figures/budget.svg and .png
"""


localrules:
    budget,


rule budget:
    input:
        f"{RESULTS}/budget.txt",
        pictures_of("budget"),


rule budget_table:
    message:
        "Gather the study into {output}"
    input:
        batches=lambda w: study_batches("budget"),
    output:
        f"{RESULTS}/budget.nc",
    params:
        code=code_of("studies.budget.table"),
        sweep=lambda w: study("budget").text(),
        config=lambda w: config_of(study("budget")),
    log:
        f"{RESULTS}/logs/budget/table.log",
    shell:
        "python -P -m studies budget table --config {params.config} -o {output} 2> {log}"
