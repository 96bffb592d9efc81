"""One page of everything, that opens without a network.

    snakemake -j2 report

REQUIRED INPUTS
    {RESULTS}/drag.nc, {RESULTS}/flow.nc, all figures; the studies that lie there, if any
OUTPUTS
    {RESULTS}/report.html
"""

PRESENT = [
    name for name in ("accuracy", "stability", "benchmark") if Path(f"{RESULTS}/{name}.txt").is_file()
]


localrules:
    report,


rule report:
    input:
        RESULTS + "/report.html",


rule report_page:
    message:
        "Write {output}"
    input:
        drag=RESULTS + "/drag.nc",
        flow=RESULTS + "/flow.nc",
        figures=expand(RESULTS + "/figures/{figure}.png", figure=FIGURES),
        studies=expand(RESULTS + "/{study}.txt", study=PRESENT),
        readme="README.md",
        code=[*sorted(map(str, Path("dem/report").glob("*.py"))), *sorted(map(str, Path("dem/report/page").iterdir()))],
    output:
        RESULTS + "/report.html",
    log:
        RESULTS + "/logs/report.log",
    shell:
        "dem report {input.drag} --flow {input.flow} --readme {input.readme} -o {output} 2> {log}"
