"""How the beds move: measures of all runs, Figures 9 to 12.

REQUIRED INPUTS
    {RESULTS}/replicates/{shape}/density{density}/seed{seed}.nc, for all cases and seeds
OUTPUTS
    {RESULTS}/flow.nc
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png
"""

rule flow:
    message:
        "Measure how the beds move into {output}"
    input:
        replicates=REPLICATES,
        code=[f"dem/flow/{name}.py" for name in ("collect", "layout", "measures", "motion")],
    output:
        RESULTS + "/flow.nc",
    params:
        sweep=SWEEP.model_dump_json(include={"title", "seeds", "failures", "shapes", "cases", "record"}),
    log:
        RESULTS + "/logs/flow.log",
    benchmark:
        RESULTS + "/benchmarks/flow.tsv"
    shell:
        "dem flow --config {CONFIG} -o {output} 2> {log}"

rule flow_figure:
    message:
        "Draw {wildcards.moving}"
    input:
        data=RESULTS + "/flow.nc",
        code="dem/figures/{moving}.py",
        common=["dem/figures/style.py", "dem/figures/bed.py", "dem/figures/snapshots.py", "dem/flow/verdict.py"],
    output:
        RESULTS + "/figures/{moving}.svg",
        RESULTS + "/figures/{moving}.png",
    wildcard_constraints:
        moving="|".join(FLOW),
    log:
        RESULTS + "/logs/figures/{moving}.log",
    shell:
        "dem figure {wildcards.moving} {input.data} 2> {log}"

ruleorder: flow_figure > figure
