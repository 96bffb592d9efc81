"""Which of the paper's claims hold, and why: many runs, other assumptions, jamming, scaling.

    snakemake -j2 claims

REQUIRED INPUTS
    the chunks of the sweep that the configuration names as studies.claims
OUTPUTS
    {RESULTS}/claims.nc, {RESULTS}/claims.txt
    {RESULTS}/figures/claims_{figure}.svg, {RESULTS}/figures/claims_{figure}.png
"""


localrules:
    claims,


rule claims:
    input:
        RESULTS + "/claims.txt",
        pictures_of("claims"),


rule claims_table:
    message:
        "Gather what claims are about into {output}"
    input:
        needed=lambda w: study_needed("claims"),
        chunks=lambda w: study_chunks("claims"),
        derived=lambda w: study_chunks("claims", derived=True),
    output:
        update(RESULTS + "/claims.nc"),
    params:
        code=code_of("studies.claims.table"),
        sweep=lambda w: values_of(study("claims").sweep, *UNREAD),
        config=lambda w: study_config("claims"),
    log:
        RESULTS + "/logs/claims/table.log",
    shell:
        "begin {output:q}; study claims table --config {params.config} -o {output} 2> {log}; end {output:q}"
