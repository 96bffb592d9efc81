"""Known cases of the field, each against a closed form or a published value.

    snakemake -j2 verification

REQUIRED INPUTS
    none; some cases read files that other studies released
OUTPUTS
    {RESULTS}/verification.nc, {RESULTS}/verification.txt
    {RESULTS}/figures/verification.svg, {RESULTS}/figures/verification.png
"""


localrules:
    verification,


rule verification:
    input:
        f"{RESULTS}/verification.txt",
        pictures_of("verification"),


rule verification_cases:
    message:
        "Run the cases of the verification"
    output:
        f"{RESULTS}/verification.nc",
    params:
        code=code_of("studies/verification/measure.py", "studies/verification/cases", runs=True),
    threads: lambda w: workflow.cores
    log:
        f"{RESULTS}/logs/verification.log",
    shell:
        "python -P -m studies verification measure --jobs {threads} -o {output} 2> {log}"
