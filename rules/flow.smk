"""How the beds move: measures of all runs, chunk by chunk, for Figures 9 to 12.

REQUIRED INPUTS
    {folder}/chunks/{chunk}.nc, for all runs
OUTPUTS
    {folder}/flow/{chunk}.nc, measures of the runs of a chunk from their snapshots; {folder}/flow.nc
"""


rule measure_flow:
    message:
        "Measure how the beds of chunk {wildcards.chunk} move"
    input:
        "{folder}/chunks/{chunk}.nc",
    output:
        "{folder}/flow/{chunk}.nc",
    params:
        code=code_of("analysis.flow.collect", shapes=SWEEP.shapes),
    # before drag.nc is combined and drawn, because more is made of it
    priority: 1
    log:
        "{folder}/logs/flow/{chunk}.log",
    shell:
        "dem flow {input} -o {output} 2> {log}"


def measured(wildcards):
    """What holds the measures of all runs of a block."""
    work, block = place_of(wildcards.folder)
    if "flow" in work.observables(block):
        return chunks_of(wildcards)
    folder = work.sweep.results
    return [link.replace(f"{folder}/chunks/", f"{folder}/flow/") for link in chunks_of(wildcards)]


rule flow:
    message:
        "Combine how the beds move into {output}"
    input:
        measured=measured,
        chunks=chunks_of,  # the beds that are drawn
    output:
        "{folder}/flow.nc",
    params:
        code=code_of("analysis.flow.collect"),
        sweep=lambda w: values_of_block(w.folder),
        block=lambda w: place_of(w.folder)[1],
        config=lambda w: f"{place_of(w.folder)[0].sweep.results}/config.yaml",
    log:
        "{folder}/logs/flow.log",
    benchmark:
        "{folder}/benchmarks/flow.tsv"
    shell:
        "dem flow --config {params.config} --block {params.block:q} -o {output} 2> {log}"
