"""Combine all replicates into one file over case, seed and displacement.

REQUIRED INPUTS
    {RESULTS}/replicates/{shape}/density{density}/seed{seed}.nc, for all cases and seeds
OUTPUTS
    {RESULTS}/drag.nc
"""


rule combine:
    message:
        "Combine the replicates into {output}"
    input:
        replicates=REPLICATES,
    output:
        RESULTS + "/drag.nc",
    params:
        code=code_of("sweep.combine"),
        sweep=SWEEP.model_dump_json(include={"title", "seeds", "failures", "shapes", "cases", "record"}),
    log:
        RESULTS + "/logs/combine.log",
    benchmark:
        RESULTS + "/benchmarks/combine.tsv"
    shell:
        "dem combine --config {CONFIG} -o {output} 2> {log}"
