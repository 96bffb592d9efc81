"""Make the runs of a sweep, many in one process and one file.

A chunk is in the store, which all sweeps share, under a name that says what it holds: the values of its
runs and the code that made them. What Snakemake makes, dates and removes is a link to it.

REQUIRED INPUTS
    {STORE}/kernels/{kernels}.done
OUTPUTS
    {folder}/chunks/{chunk}.nc, a link to {STORE}/chunks/{chunk}.nc
"""


def kernels_of(wildcards):
    """The mark that the kernels of the runs of a chunk are compiled."""
    for work in WORKS.values():
        if kernels := work.kernels(wildcards.chunk):
            break
    else:  # a job that Snakemake sent: the plan is written
        kernels = STORE.read_plan(wildcards.chunk).kernels
    return ancient(f"{STORE.folder}/kernels/{kernels}.done")


rule chunk:
    message:
        "Simulate chunk {wildcards.chunk}"
    input:
        kernels=kernels_of,
    output:
        "{folder}/chunks/{chunk}.nc",
    # before measures, so that these fill the processors that the last chunks leave idle
    priority: 2
    log:
        "{folder}/logs/chunks/{chunk}.log",
    benchmark:
        "{folder}/benchmarks/chunks/{chunk}.tsv"
    shell:
        "dem chunk {wildcards.chunk} -o {output} 2> {log}"
