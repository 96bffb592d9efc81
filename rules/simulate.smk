"""Run the replicates: shape x density x seed, one small file each.

REQUIRED INPUTS
    {RESULTS}/packings/{shape}/seed{seed}.nc
OUTPUTS
    {RESULTS}/replicates/{shape}/density{density}/seed{seed}.nc

With `batch` above 1 in the configuration a job makes the replicates of so many seeds, and their
beds, in one process; it leaves those alone that are up to date.
"""


rule simulate:
    message:
        "Simulate {wildcards.shape} at {wildcards.density} kg/m3, seed {wildcards.seed}"
    input:
        bed=RESULTS + "/packings/{shape}/seed{seed}.nc",
    output:
        RESULTS + "/replicates/{shape}/density{density}/seed{seed}.nc",
    params:
        code=run_code,
        run=lambda w: SWEEP.replicate(w.shape, float(w.density), int(w.seed)).run_key(),
    log:
        RESULTS + "/logs/simulate/{shape}/density{density}/seed{seed}.log",
    benchmark:
        RESULTS + "/benchmarks/simulate/{shape}/density{density}/seed{seed}.tsv"
    shell:
        "dem simulate --config {CONFIG} --shape {wildcards.shape} --density {wildcards.density}"
        " --seed {wildcards.seed} --bed {input.bed} -o {output}"
        " --checkpoint {RESULTS}/checkpoints/{wildcards.shape}_{wildcards.density}_{wildcards.seed}.npz 2> {log}"


def batch_of(wildcards):
    """What the replicates of a batch depend on, as text."""
    seeds = SWEEP.seeds_of_batch(int(wildcards.number))
    densities = SWEEP.densities(wildcards.shape)
    first = SWEEP.replicate(wildcards.shape, densities[0], seeds[0])
    return f"{first.run_key()} {densities} {seeds} {SWEEP.failures}"


rule batch:
    message:
        "Simulate {wildcards.shape}, batch {wildcards.number}"
    input:
        kernels=kernels_of,
    output:
        touch(RESULTS + "/batches/{shape}/{number}.done"),
    params:
        code=run_code,
        run=batch_of,
    log:
        RESULTS + "/logs/batches/{shape}/{number}.log",
    benchmark:
        RESULTS + "/benchmarks/batches/{shape}/{number}.tsv"
    shell:
        "dem batch --config {CONFIG} --shape {wildcards.shape} --number {wildcards.number}"
        " -o {RESULTS} 2> {log}"
