"""One page of everything, that opens without a network.

    snakemake -j2 report

Studies are shown if their results exist: a report does not run them. So is Snakemake's own
report, provenance.html:

    snakemake -j1 --report {RESULTS}/provenance.html

REQUIRED INPUTS
    {RESULTS}/drag.nc, and what else the sweep gives; all figures
OUTPUTS
    {RESULTS}/report.html
"""


rule report:
    message:
        "Write {output}"
    input:
        combined=COMBINED,
        figures=PICTURES,
    output:
        f"{RESULTS}/report.html",
    params:
        code=code_of("dem/report", "dem/figures/catalogue.py", *NUMBERS),
        studies=lambda w: {
            path.name: path.stat().st_mtime for name in ("*.txt", "provenance.html") for path in sorted(SWEEP.results.glob(name))
        },
    log:
        f"{RESULTS}/logs/report.log",
    shell:
        "dem report {input.combined[0]:q} -o {output} 2> {log}"
