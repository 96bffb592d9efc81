"""How the beds move: measures of all runs, for Figures 9 to 12.

REQUIRED INPUTS
    {RESULTS}/replicates/{shape}/density{density}/seed{seed}.nc, for all cases and seeds
OUTPUTS
    {RESULTS}/flow.nc
"""

rule flow:
    message:
        "Measure how the beds move into {output}"
    input:
        replicates=REPLICATES,
    output:
        RESULTS + "/flow.nc",
    params:
        code=code_of("analysis.flow.collect", shapes=SWEEP.shapes),
        sweep=SWEEP.model_dump_json(include={"title", "seeds", "failures", "shapes", "cases", "record"}),
    log:
        RESULTS + "/logs/flow.log",
    benchmark:
        RESULTS + "/benchmarks/flow.tsv"
    shell:
        "dem flow --config {CONFIG} -o {output} 2> {log}"
