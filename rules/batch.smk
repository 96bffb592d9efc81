"""Make the runs of a sweep, many in one process and one file.

A batch is in the store, which all sweeps share, under a name that says what it holds: the values of its
runs and the code that made them.

REQUIRED INPUTS
    none; results/store/batches/{batch}.json, which is written before, says what the runs are
OUTPUTS
    results/store/batches/{batch}.nc; {folder}/rounds/{number}, an empty file, after each round of replicates
"""


rule batch:
    message:
        "Simulate batch {wildcards.batch}"
    output:
        "results/store/batches/{batch}.nc",
    # in the order of the plan, so that each kind of kernel is compiled first; all of them before measures, so
    # that these fill the processors that the last batches leave idle
    priority:
        lambda w: 2 + 1 / (1 + POSITION.get(w.batch, 0))
    threads: SWEEP.sweep.threads
    log:
        f"{RESULTS}/logs/batches/{{batch}}.log",
    shell:
        "python -P -m dem.cli.batch {output} 2> {log}"


localrules:
    round,


# of a block that grows until a precision: what a round gave decides whether another follows
checkpoint round:
    message:
        "Round {wildcards.number} of {wildcards.folder} is made"
    input:
        lambda w: batches_in(w.folder, int(w.number)),
    output:
        touch("{folder}/rounds/{number}"),
    params:
        sweep=values_of,
