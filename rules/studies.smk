"""The files of results of the studies, and a target by the name of each, beside the default.

    snakemake -j2 budget            what a budget of processor time buys
    snakemake -j1 benchmark         time the kernels, beside other codes where they are installed

A study with a sweep of its own waits for its runs; what measures by itself runs alone.

REQUIRED INPUTS
    the batches of the sweep of a study, and what else its results.py reads
OUTPUTS
    {RESULTS}/{study}.nc, {RESULTS}/{study}.txt, the figures that are drawn from it
"""


rule results:
    message:
        "Write {output}"
    input:
        lambda w: read_by(w.study),
    output:
        f"{RESULTS}/{{study}}.nc",
    params:
        code=lambda w: code_of(FOLDERS[w.study] / "results.py", *NUMBERS, runs="MEASURES" in REPORTED[w.study]),
        sweep=lambda w: study(w.study).text(None, *(() if has_sweep(w.study) else NOT_READ)),
        config=lambda w: config_of(study(w.study)),
    threads: lambda w: workflow.cores if "MEASURES" in REPORTED[w.study] else 1
    log:
        f"{RESULTS}/logs/{{study}}.log",
    shell:
        "python -P -m studies {wildcards.study} make --config {params.config} --jobs {threads}"
        " -o {output} 2> {log}"


rule table:
    message:
        "Write {output}"
    input:
        f"{RESULTS}/{{study}}.nc",
    output:
        report(f"{RESULTS}/{{study}}.txt", category="Tables", labels={"table": "{study}"}),
    params:
        code=lambda w: code_of(FOLDERS[w.study] / "findings.py", *NUMBERS, "dem/report"),
    log:
        f"{RESULTS}/logs/{{study}}/table.log",
    shell:
        "python -P -m studies {wildcards.study} info {input} -o {output} 2> {log}"


for name in REPORTED:

    rule:
        name:
            name
        input:
            f"{RESULTS}/{name}.txt",
            pictures_of(name),
        localrule: True
