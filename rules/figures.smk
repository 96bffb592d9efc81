"""Draw the figures, each from one file of results.

    snakemake -j2 figures          those that the files in {RESULTS} suffice for; makes no file of results

REQUIRED INPUTS
    {RESULTS}/drag.nc, flow.nc, accuracy.nc, stability.nc, claims.nc, benchmark.nc: see dem/figures/__init__.py
OUTPUTS
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png
"""

from dem.figures import FILE_OF, drawable
from dem.base.sources import closure


def pictures(names):
    """Both files of each of some figures."""
    return expand(RESULTS + "/figures/{figure}.{kind}", figure=names, kind=["svg", "png"])


def pictures_of_results(wildcards):
    if not ONLY_FIGURES:  # the rules that make results are there, and would run
        refuse("figures must be a target on the command line: snakemake -j2 figures.")
    try:
        return pictures(drawable(RESULTS))
    except InputError as error:
        refuse(error)


rule figure:
    message:
        "Draw {wildcards.figure}"
    input:
        data=lambda w: f"{RESULTS}/{FILE_OF[w.figure]}.nc",
        code=lambda w: closure(f"dem.figures.{w.figure}"),
    output:
        RESULTS + "/figures/{figure}.svg",
        RESULTS + "/figures/{figure}.png",
    wildcard_constraints:
        figure="|".join(FILE_OF),
    log:
        RESULTS + "/logs/figures/{figure}.log",
    shell:
        "dem figure {wildcards.figure} {input.data} 2> {log}"


rule figures:
    input:
        pictures_of_results,
