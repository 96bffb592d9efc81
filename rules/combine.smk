"""Combine the runs of a block into one file an observable, over its axes.

REQUIRED INPUTS
    results/store/batches/{batch}.nc, for all runs
OUTPUTS
    {folder}/{observable}.nc, such as {RESULTS}/drag.nc
"""


# after a checkpoint Snakemake evaluates again what the other rules need
checkpoint combine:
    message:
        "Combine the runs into {output}"
    input:
        batches=lambda w: batches_in(w.folder),
    output:
        "{folder}/{observable}.nc",
    params:
        code=code_of("dem/sweep/combine.py", "dem/io/dataset.py"),
        sweep=values_of,
        block=lambda w: block_of(w.folder)[1],
        config=lambda w: config_of(block_of(w.folder)[0]),
    log:
        "{folder}/logs/combine/{observable}.log",
    shell:
        "dem combine --config {params.config} --block {params.block:q}"
        " --observable {wildcards.observable} -o {output:q} 2> {log:q}"
