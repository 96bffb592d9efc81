"""How often a mean is as near as a sweep asks for: snakemake -j2 precision
REQUIRED INPUTS studies/claims/claims.nc, whose runs are drawn again
OUTPUTS {RESULTS}/precision.nc, {RESULTS}/precision.txt, {RESULTS}/figures/precision.svg and .png
"""


localrules:
    precision,


rule precision:
    input:
        f"{RESULTS}/precision.txt",
        pictures_of("precision"),


rule precision_rows:
    message:
        "Try the rule that adds replicates"
    input:
        os.path.relpath(STUDIES / "claims/claims.nc"),
    output:
        f"{RESULTS}/precision.nc",
    params:
        code=code_of("studies.precision.calibrate"),
    log:
        f"{RESULTS}/logs/precision.log",
    shell:
        "python -P -m studies precision calibrate --runs {input} -o {output} 2> {log}"
