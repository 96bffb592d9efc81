"""How the beds move: measures of all runs, chunk by chunk, for Figures 9 to 12.

REQUIRED INPUTS
    {folder}/chunks/{chunk}.nc, for all runs
OUTPUTS
    {folder}/flow/{chunk}.nc, measures of the runs of a chunk from their snapshots; {folder}/flow.nc;
    {folder}/flow/{beds}.nc, the same for the shapes of a figure alone, which need not wait for others
"""

BEDS = parts_of(KNOWN_FIGURES)


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


def chunks_of_beds(wildcards):
    """The chunks of all runs of a block, or of those that show some beds."""
    links = chunks_of(wildcards)
    if not hasattr(wildcards, "beds"):
        return links
    from dem.analysis.flow.collect import chunks_with

    work, block = place_of(wildcards.folder)
    runs = work.block(block).part(BEDS[wildcards.beds]).places
    wanted = {chunk.id for chunk in chunks_with(work, block, runs)}
    return [link for link in links if Path(link).stem in wanted]


def measured(wildcards):
    """What holds the measures of these runs."""
    work, block = place_of(wildcards.folder)
    links, folder = chunks_of_beds(wildcards), work.sweep.results
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


rule beds:
    message:
        "Combine how the beds of some shapes move into {output}"
    input:
        measured=measured,
        chunks=chunks_of_beds,
    output:
        update("{folder}/flow/{beds}.nc"),
    params:
        code=code_of("dem.analysis.flow.collect"),
        sweep=lambda w: values_of_block(w.folder),
        block=lambda w: place_of(w.folder)[1],
        shapes=lambda w: [word for shape in BEDS[w.beds] for word in ("--shape", shape)],
        config=lambda w: f"{place_of(w.folder)[0].sweep.results}/config.yaml",
    wildcard_constraints:
        beds="|".join(BEDS),
    log:
        "{folder}/logs/flow/{beds}.log",
    shell:
        "begin {output:q}; dem flow --config {params.config} --block {params.block:q} {params.shapes} -o {output} 2> {log}; end {output:q}"
