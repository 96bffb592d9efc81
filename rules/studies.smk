"""The files of results of the studies, and a target by the name of each, beside the default.

    snakemake -j2 budget            what a budget of processor time buys
    snakemake -j1 benchmark         time the kernels, beside other codes where they are installed

A study with a sweep of its own waits for its runs; what measures by itself runs alone.

REQUIRED INPUTS
    the batches of the sweep of a study, and what else its results.py reads
OUTPUTS
    {RESULTS}/{study}.nc, {RESULTS}/{study}.txt, the figures that are drawn from it
"""


NOT_READ = "record", "sweep", "title", "failures"  # by a study without runs


def read_by(name):
    """The files that a study reads beside the batches of its runs: those that it names, and the
    combined files that some of its runs are derived from."""
    found = [os.path.relpath(HERE / path) for path in REPORTED[name].get("READS", ())]
    if has_sweep(name):
        own = study(name)
        needed = [each for block in own.sweep.blocks for each in own.sweep.needed(block)]
        for block in dict.fromkeys(needed):
            found += [f"{own.folder_of(block)}/{each}.nc" for each in own.observables(block)]
    return found


def folder_of(name):
    """The folder of a study, below the checkout."""
    return package_of(name).replace(".", "/")


def measures(name):
    """Whether a study measures by itself."""
    return REPORTED[name].get("MEASURES", False)


def batches_of(name, derived=False):
    """The batches of those blocks of a study whose values are derived from others, or of the others."""
    own = study(name)
    blocks = own.folders.items()
    folders = [folder for folder, block in blocks if bool(own.needed(block)) == derived]
    return list(dict.fromkeys(batch for folder in folders for batch in batches_in(folder)))


rule results:
    message:
        "Write {output}"
    input:
        read=lambda w: read_by(w.study),
        batches=lambda w: batches_of(w.study) if has_sweep(w.study) else [],
        derived=lambda w: batches_of(w.study, derived=True) if has_sweep(w.study) else [],
    output:
        f"{RESULTS}/{{study}}.nc",
    params:
        code=lambda w: code_of(f"{folder_of(w.study)}/results.py", "dem/analysis", runs=measures(w.study)),
        sweep=lambda w: study(w.study).text() if has_sweep(w.study) else SWEEP.text(None, *NOT_READ),
        config=lambda w: config_of(study(w.study)),
    threads: lambda w: workflow.cores if measures(w.study) else 1
    wildcard_constraints:
        study="|".join(REPORTED),
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
        code=lambda w: code_of(f"{folder_of(w.study)}/findings.py", "dem/analysis", "dem/report"),
    wildcard_constraints:
        study="|".join(REPORTED),
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
