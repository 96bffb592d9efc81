"""Run the replicates: shape x density x seed, one small file each.

REQUIRED INPUTS
    {RESULTS}/packings/{shape}/seed{seed}.nc
OUTPUTS
    {RESULTS}/replicates/{shape}/density{density}/seed{seed}.nc
"""


rule simulate:
    message:
        "Simulate {wildcards.shape} at {wildcards.density} kg/m3, seed {wildcards.seed}"
    input:
        bed=RESULTS + "/packings/{shape}/seed{seed}.nc",
    output:
        RESULTS + "/replicates/{shape}/density{density}/seed{seed}.nc",
    params:
        sources=SOURCES,
        run=lambda w: SWEEP.replicate(w.shape, float(w.density), int(w.seed)).run_key(),
    log:
        RESULTS + "/logs/simulate/{shape}/density{density}/seed{seed}.log",
    benchmark:
        RESULTS + "/benchmarks/simulate/{shape}/density{density}/seed{seed}.tsv"
    shell:
        "dem simulate --config {CONFIG} --shape {wildcards.shape} --density {wildcards.density}"
        " --seed {wildcards.seed} --bed {input.bed} -o {output} 2> {log}"
