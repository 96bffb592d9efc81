"""Which of the paper's claims hold, and why: many runs, other assumptions, jamming, scaling.

    snakemake -j2 claims

REQUIRED INPUTS
    the batches of the sweep that the configuration names as studies.claims
OUTPUTS
    {RESULTS}/claims.nc, {RESULTS}/claims.txt
    {RESULTS}/figures/claims_{figure}.svg, {RESULTS}/figures/claims_{figure}.png
"""


localrules:
    claims,


rule claims:
    input:
        f"{RESULTS}/claims.txt",
        pictures_of("claims"),


rule claims_table:
    message:
        "Gather what claims are about into {output}"
    input:
        needed=lambda w: [
            f"{study('claims').folder_of(name)}/{observable}.nc"
            for block in study("claims").sweep.blocks
            for name in study("claims").sweep.needed(block)
            for observable in study("claims").observables(name)
        ],
        batches=lambda w: study_batches("claims"),
        derived=lambda w: study_batches("claims", derived=True),
    output:
        f"{RESULTS}/claims.nc",
    params:
        code=code_of("studies/claims/table.py", "dem/analysis"),
        sweep=lambda w: study("claims").text(),
        config=lambda w: config_of(study("claims")),
    log:
        f"{RESULTS}/logs/claims/table.log",
    shell:
        "python -P -m studies claims table --config {params.config} -o {output} 2> {log}"
