"""Stiff and extreme cases, the map of the time step, the paper's cases with an energy ledger.

    snakemake -j2 stability

REQUIRED INPUTS
    config/stability.yaml
OUTPUTS
    {RESULTS}/stability/{part}/{shape}.nc, {RESULTS}/stability.nc, {RESULTS}/stability.txt
    {RESULTS}/figures/stability_{figure}.svg, {RESULTS}/figures/stability_{figure}.png
"""

from dem.figures import STABILITY

CATALOGUE = "config/stability.yaml"


def stability_parts(wildcards):
    """The files of all jobs."""
    from dem.studies.stability import catalogue, study

    try:
        cases = catalogue.load(CATALOGUE)
        study.check(SWEEP, cases)
    except InputError as error:
        refuse(error)
    jobs = [("catalogue", shape) for shape in cases.shapes]
    jobs += [("map", shape) for shape in cases.map.shapes]
    jobs += [("paper", shape) for shape in dict.fromkeys(c.shape for c in SWEEP.cases.values())]
    return [f"{RESULTS}/stability/{part}/{shape}.nc" for part, shape in jobs]


localrules:
    stability,


rule stability:
    input:
        RESULTS + "/stability.txt",
        pictures(STABILITY),


rule stability_part:
    message:
        "Stability of {wildcards.shape}: {wildcards.part}"
    input:
        catalogue=CATALOGUE,
    output:
        RESULTS + "/stability/{part}/{shape}.nc",
    params:
        code=lambda w: code_of("studies.stability.study", shapes=[w.shape]),
        sweep=physics("record"),
        seed=SWEEP.seeds[0],
    log:
        RESULTS + "/logs/stability/{part}/{shape}.log",
    benchmark:
        RESULTS + "/benchmarks/stability/{part}/{shape}.tsv"
    shell:
        "dem stability {wildcards.part} --config {CONFIG} --catalogue {input.catalogue}"
        " --shape {wildcards.shape} -o {output} 2> {log}"


rule stability_join:
    message:
        "Combine the study into {output}"
    input:
        parts=stability_parts,
    output:
        RESULTS + "/stability.nc",
    params:
        code=code_of("studies.stability.layout"),
    log:
        RESULTS + "/logs/stability/join.log",
    shell:
        "dem stability combine -o {output} {input.parts} 2> {log}"
