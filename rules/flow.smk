"""How the beds move: measures of all runs, batch by batch, for Figures 9 to 12.

REQUIRED INPUTS
    results/store/batches/{batch}.nc, for all runs
OUTPUTS
    {folder}/flow/{batch}.nc, measures of the runs of a batch from their snapshots; {folder}/flow.nc
"""


rule measure_flow:
    message:
        "Measure how the beds of batch {wildcards.batch} move"
    input:
        "results/store/batches/{batch}.nc",
    output:
        "{folder}/flow/{batch}.nc",
    params:
        code=code_of("dem/analysis/flow", "dem/experiment/flow_measures.py"),
        # where the files of shapes of a user's own are, and not the folder itself: it may be moved
        shapes=lambda w: f"--config {config_of(SWEEP)}" if SWEEP.sweep.beside else "",
    # before drag.nc is combined and drawn, because more is made of it
    priority: 1
    log:
        "{folder}/logs/flow/{batch}.log",
    shell:
        "dem flow {input} -o {output:q} {params.shapes} 2> {log:q}"


rule flow:
    message:
        "Combine how the beds move into {output}"
    input:
        measured=lambda w: [
            batch if "flow" in place_of(w.folder)[0].observables(place_of(w.folder)[1])
            else f"{place_of(w.folder)[0].sweep.results}/flow/{Path(batch).name}"
            for batch in batches_in(w.folder)
        ],
        batches=lambda w: batches_in(w.folder),  # the beds that are drawn
    output:
        "{folder}/flow.nc",
    params:
        code=code_of("dem/analysis/flow", "dem/sweep/combine.py"),
        sweep=lambda w: place_of(w.folder)[0].text(place_of(w.folder)[1]),
        block=lambda w: place_of(w.folder)[1],
        config=lambda w: config_of(place_of(w.folder)[0]),
    log:
        "{folder}/logs/flow.log",
    shell:
        "dem flow --config {params.config} --block {params.block:q} -o {output:q} 2> {log:q}"
