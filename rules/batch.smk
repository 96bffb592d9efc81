"""Make the runs of a sweep, many in one process and one file.

A batch is in the store, which all sweeps share, under a name that says what it holds: the values of its
runs and the code that made them.

REQUIRED INPUTS
    none; results/store/batches/{batch}.json, which is written before, says what the runs are
OUTPUTS
    results/store/batches/{batch}.nc
"""


rule batch:
    message:
        "Simulate batch {wildcards.batch}"
    output:
        "results/store/batches/{batch}.nc",
    # before measures, so that these fill the processors that the last batches leave idle
    priority: 2
    log:
        f"{RESULTS}/logs/batches/{{batch}}.log",
    shell:
        "dem batch {output} 2> {log}"
