"""Draw the figures, each from drag.nc alone.

REQUIRED INPUTS
    {RESULTS}/drag.nc
OUTPUTS
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png
"""


rule figure:
    message:
        "Draw {wildcards.figure}"
    input:
        data=RESULTS + "/drag.nc",
        code="dem/figures/{figure}.py",
        common=["dem/figures/style.py", "dem/statistics.py"],
    output:
        RESULTS + "/figures/{figure}.svg",
        RESULTS + "/figures/{figure}.png",
    log:
        RESULTS + "/logs/figures/{figure}.log",
    benchmark:
        RESULTS + "/benchmarks/figures/{figure}.tsv"
    shell:
        "dem figure {wildcards.figure} {input.data} 2> {log}"


# Has drag.nc as a parameter and not as an input: nothing is simulated, whatever has changed.
rule figures:
    message:
        "Draw all figures again from {params.data}"
    params:
        data=RESULTS + "/drag.nc",
    log:
        RESULTS + "/logs/figures/all.log",
    benchmark:
        RESULTS + "/benchmarks/figures/all.tsv"
    shell:
        "dem figure all {params.data} 2> {log}"
