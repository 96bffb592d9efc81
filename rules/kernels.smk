"""Compile the kernels of each kind of run once, before many processes need them.

REQUIRED INPUTS
    none; the machine code itself is kept in the cache folder of dem.base.sources
OUTPUTS
    {STORE}/kernels/{kernels}.done
"""


rule kernels:
    message:
        "Compile kernels"
    output:
        touch(f"{STORE.folder}/kernels/{{kernels}}.done"),
    # chunks wait for it
    priority: 3
    log:
        RESULTS + "/logs/kernels/{kernels}.log",
    benchmark:
        RESULTS + "/benchmarks/kernels/{kernels}.tsv"
    shell:
        "dem compile --kernels {wildcards.kernels} 2> {log}"
