"""Make the beds: random, at the packing fraction, at rest around the cylinder.

REQUIRED INPUTS
    {RESULTS}/kernels/{kind}.done
OUTPUTS
    {RESULTS}/packings/{shape}/seed{seed}.nc
"""


rule pack:
    message:
        "Pack {wildcards.shape}, seed {wildcards.seed}"
    input:
        kernels=kernels_of,
    output:
        RESULTS + "/packings/{shape}/seed{seed}.nc",
    params:
        code=run_code,
        bed=lambda w: SWEEP.replicate(w.shape, 1.0, int(w.seed)).bed_key(),
    log:
        RESULTS + "/logs/pack/{shape}/seed{seed}.log",
    benchmark:
        RESULTS + "/benchmarks/pack/{shape}/seed{seed}.tsv"
    shell:
        "dem pack --config {CONFIG} --shape {wildcards.shape} --seed {wildcards.seed}"
        " -o {output} 2> {log}"
