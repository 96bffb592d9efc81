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

def studies_there():
    """Digest of the results of studies next to those of the sweep."""
    from hashlib import sha256

    digest = sha256()
    for text in sorted(Path(RESULTS).glob("*.txt")):
        for file in (text, *sorted(Path(RESULTS).glob(f"figures/{text.stem}*.png"))):
            digest.update(file.read_bytes())
    digest.update(bytes([Path(f"{RESULTS}/provenance.html").is_file()]))
    return digest.hexdigest()


# of the paper the page tells what it leaves open
NOTES = ["docs/explanation/open.md"] if CONFIG_FILES == ["config/paper.yaml"] else []


localrules:
    report,


rule report:
    input:
        RESULTS + "/report.html",


rule report_page:
    message:
        "Write {output}"
    input:
        combined=COMBINED,
        figures=PICTURES,
        notes=NOTES,
        page=sorted(map(str, Path("dem/report/page").iterdir())),
    output:
        update(RESULTS + "/report.html"),
    params:
        code=code_of("dem.report.build"),
        studies=lambda w: studies_there(),
        notes=[f"--notes {file}" for file in NOTES],
    log:
        RESULTS + "/logs/report.log",
    shell:
        "begin {output:q}; dem report {RESULTS}/drag.nc {params.notes} -o {output} 2> {log}; end {output:q}"
