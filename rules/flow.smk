"""How the beds move: measures of all runs, chunk by chunk, for Figures 9 to 12.

REQUIRED INPUTS
    {folder}/chunks/{chunk}.nc, for all runs
OUTPUTS
    {folder}/flow/{chunk}.nc, measures of the runs of a chunk from their snapshots; {folder}/flow.nc
"""


def shapes_of(folder):
    """What says where the files of shapes of a user's own are, as words of a command. Not the folder
    itself: nothing is made again when it is moved."""
    sweep = place_of(folder)[0].sweep
    return f"--config {sweep.results}/config.yaml" if sweep.beside else ""


rule measure_flow:
    message:
        "Measure how the beds of chunk {wildcards.chunk} move"
    input:
        "{folder}/chunks/{chunk}.nc",
    output:
        update("{folder}/flow/{chunk}.nc"),
    params:
        code=code_of("dem.analysis.flow.collect", shapes=SWEEP.shapes),
        shapes=lambda w: shapes_of(w.folder),
    # before drag.nc is combined and drawn, because more is made of it
    priority: 1
    log:
        "{folder}/logs/flow/{chunk}.log",
    shell:
        "begin {output:q}; dem flow {input} -o {output} {params.shapes} 2> {log}; end {output:q}"


def measured(wildcards):
    """What holds the measures of the runs of a block."""
    work, block = place_of(wildcards.folder)
    links, folder = chunks_of(wildcards), work.sweep.results
    if "flow" in work.observables(block):
        return links
    return [link.replace(f"{folder}/chunks/", f"{folder}/flow/") for link in links]


rule flow:
    message:
        "Combine how the beds move into {output}"
    input:
        measured=measured,
        chunks=chunks_of,  # the beds that are drawn
    output:
        update("{folder}/flow.nc"),
    params:
        code=code_of("dem.analysis.flow.collect"),
        sweep=lambda w: values_of_block(w.folder),
        block=lambda w: place_of(w.folder)[1],
        config=lambda w: f"{place_of(w.folder)[0].sweep.results}/config.yaml",
    log:
        "{folder}/logs/flow.log",
    benchmark:
        "{folder}/benchmarks/flow.tsv"
    shell:
        "begin {output:q}; dem flow --config {params.config} --block {params.block:q} -o {output} 2> {log}; end {output:q}"
