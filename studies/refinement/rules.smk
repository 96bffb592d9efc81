"""How many runs a curve takes by several designs: snakemake -j2 refinement
REQUIRED INPUTS the batches of the sweep that the configuration names as studies.refinement
OUTPUTS {RESULTS}/refinement.nc, {RESULTS}/refinement.txt, {RESULTS}/figures/refinement.svg and .png
"""


localrules:
    refinement,


rule refinement:
    input:
        f"{RESULTS}/refinement.txt",
        pictures_of("refinement"),


rule refinement_table:
    message:
        "Gather the study into {output}"
    input:
        batches=lambda w: study_batches("refinement"),
    output:
        f"{RESULTS}/refinement.nc",
    params:
        code=code_of("studies.refinement.table"),
        sweep=lambda w: study("refinement").text(),
        config=lambda w: config_of(study("refinement")),
    log:
        f"{RESULTS}/logs/refinement/table.log",
    shell:
        "python -P -m studies refinement table --config {params.config} -o {output} 2> {log}"
