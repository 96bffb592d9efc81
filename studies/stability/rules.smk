"""Stiff and extreme cases, the map of the time step, the paper's cases with an energy ledger.

    snakemake -j2 stability

REQUIRED INPUTS
    the batches of the sweep that the configuration names as studies.stability; studies/stability/catalogue.yaml
OUTPUTS
    {RESULTS}/stability/{part}/{shape}.nc, {RESULTS}/stability.nc, {RESULTS}/stability.txt
    {RESULTS}/figures/stability_{figure}.svg, {RESULTS}/figures/stability_{figure}.png
"""

from studies.stability.catalogue import parts as stability_parts

CATALOGUE = os.path.relpath(STUDIES / "stability/catalogue.yaml")


localrules:
    stability,


rule stability:
    input:
        f"{RESULTS}/stability.txt",
        pictures_of("stability"),


rule stability_part:
    message:
        "Stability of {wildcards.shape}: {wildcards.part}"
    input:
        catalogue=CATALOGUE,
    output:
        f"{RESULTS}/stability/{{part}}/{{shape}}.nc",
    wildcard_constraints:
        part="catalogue|limits",
    params:
        code=code_of("studies/stability/study.py", runs=True),
        sweep=lambda w: study("stability").text(None, "record", "sweep", "title", "failures"),
        seed=lambda w: study("stability").sweep.first_seed,
        config=lambda w: config_of(study("stability")),
    log:
        f"{RESULTS}/logs/stability/{{part}}/{{shape}}.log",
    shell:
        "python -P -m studies stability {wildcards.part} --config {params.config} --catalogue {input.catalogue}"
        " --shape {wildcards.shape} -o {output} 2> {log}"


rule stability_table:
    message:
        "Gather the study into {output}"
    input:
        parts=lambda w: [
            f"{RESULTS}/stability/{part}/{shape}.nc" for part, shape in stability_parts(CATALOGUE)
        ],
        batches=lambda w: study_batches("stability"),
    output:
        f"{RESULTS}/stability.nc",
    params:
        code=code_of("studies/stability/table.py"),
        sweep=lambda w: study("stability").text(),
        config=lambda w: config_of(study("stability")),
    log:
        f"{RESULTS}/logs/stability/table.log",
    shell:
        "python -P -m studies stability table --config {params.config} -o {output} {input.parts} 2> {log}"
