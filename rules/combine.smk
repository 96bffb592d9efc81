"""Combine the runs of a block into one file an observable, over its axes.

REQUIRED INPUTS
    {folder}/chunks/{chunk}.nc, for all runs
OUTPUTS
    {folder}/{observable}.nc, such as {RESULTS}/drag.nc
"""


def chunks_in(folder):
    """The chunks of a block; those of a derived one are known once the blocks that it needs are combined."""
    work, block = place_of(folder)
    for path in work.needed(block):
        checkpoints.combine.get(folder=path.parent, observable=path.stem)
    try:
        found = work.links(block)
        if STARTED:  # before that nothing is written
            work.settle()
    except (InputError, RunError) as error:
        refuse(error)
    return found


def chunks_of(wildcards):
    return chunks_in(wildcards.folder)


# of a whole checkpoint Snakemake asks again, once it is made, what the rest needs
checkpoint combine:
    message:
        "Combine the runs into {output}"
    input:
        chunks=chunks_of,
    output:
        update("{folder}/{observable}.nc"),
    params:
        code=code_of("dem.sweep.combine"),
        sweep=lambda w: values_of_block(w.folder),
        block=lambda w: place_of(w.folder)[1],
        config=lambda w: f"{place_of(w.folder)[0].sweep.results}/config.yaml",
    wildcard_constraints:
        observable="|".join(sorted({*OBSERVABLES, *EXPERIMENTS, *RECORDED} - {"snapshots", "flow"})),
    log:
        "{folder}/logs/combine/{observable}.log",
    benchmark:
        "{folder}/benchmarks/combine/{observable}.tsv"
    shell:
        "begin {output:q}; dem combine --config {params.config} --block {params.block:q}"
        " --observable {wildcards.observable} -o {output:q} 2> {log:q}; end {output:q}"
