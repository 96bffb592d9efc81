"""Stiff and extreme cases, the map of the time step, the paper's cases with an energy ledger.

    snakemake -j2 stability

REQUIRED INPUTS
    the chunks of the sweep that the configuration names as studies.stability; studies/stability/catalogue.yaml
OUTPUTS
    {RESULTS}/stability/{part}/{shape}.nc, {RESULTS}/stability.nc, {RESULTS}/stability.txt
    {RESULTS}/figures/stability_{figure}.svg, {RESULTS}/figures/stability_{figure}.png
"""

CATALOGUE = str(STUDIES / "stability/catalogue.yaml")


def stability_parts(wildcards):
    """The files of the parts that are scripts."""
    from studies.stability import catalogue, study as cases_of
    from studies.stability.table import blocks_of

    try:
        blocks_of(study("stability").sweep)
        cases = catalogue.load(CATALOGUE)
        cases_of.check(study("stability").sweep, cases)
    except InputError as error:
        refuse(error)
    jobs = [("catalogue", shape) for shape in cases.shapes]
    jobs += [("limits", shape) for shape in cases.limits.shapes]
    return [f"{RESULTS}/stability/{part}/{shape}.nc" for part, shape in jobs]


localrules:
    stability,


rule stability:
    input:
        RESULTS + "/stability.txt",
        pictures_of("stability"),


rule stability_part:
    message:
        "Stability of {wildcards.shape}: {wildcards.part}"
    input:
        catalogue=CATALOGUE,
    output:
        update(RESULTS + "/stability/{part}/{shape}.nc"),
    wildcard_constraints:
        part="catalogue|limits",
    params:
        code=lambda w: SWEEP.code_of("studies.stability.study", shapes=[w.shape]),
        sweep=lambda w: values_of(study("stability").sweep, "record", "sweep", *SHOWN),
        seed=lambda w: study("stability").sweep.first_seed,
        config=lambda w: study_config("stability"),
    log:
        RESULTS + "/logs/stability/{part}/{shape}.log",
    benchmark:
        RESULTS + "/benchmarks/stability/{part}/{shape}.tsv"
    shell:
        "begin {output:q}; study stability {wildcards.part} --config {params.config} --catalogue {input.catalogue}"
        " --shape {wildcards.shape} -o {output} 2> {log}; end {output:q}"


rule stability_table:
    message:
        "Gather the study into {output}"
    input:
        parts=stability_parts,
        chunks=lambda w: study_chunks("stability"),
    output:
        update(RESULTS + "/stability.nc"),
    params:
        code=code_of("studies.stability.table"),
        sweep=lambda w: values_of(study("stability").sweep, *UNREAD),
        config=lambda w: study_config("stability"),
    log:
        RESULTS + "/logs/stability/table.log",
    shell:
        "begin {output:q}; study stability table --config {params.config} -o {output} {input.parts} 2> {log}; end {output:q}"
