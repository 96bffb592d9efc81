"""Draw the figures, each from one file of results.

    snakemake -j2 --profile profiles/figures figures      simulates nothing, and makes no file of results

REQUIRED INPUTS
    {RESULTS}/drag.nc, snapshots.nc, onset.nc, shear.nc or the file of a study: as each figure says
OUTPUTS
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png
"""


rule figure:
    message:
        "Draw {wildcards.figure}"
    input:
        data=lambda w: f"{w.folder}/{KNOWN_FIGURES[w.figure].file}.nc",
    output:
        svg=report(
            "{folder}/figures/{figure}.svg",
            caption="caption.rst",
            category="Figures",
            subcategory="{folder}",
            labels=lambda w, params: {"figure": w.figure, "shows": params.caption},
        ),
        png="{folder}/figures/{figure}.png",
    params:
        code=lambda w: code_of(f"{KNOWN_FIGURES[w.figure].module.replace('.', '/')}.py") + code_of(*SHARED, "dem/analysis"),
        caption=lambda w: KNOWN_FIGURES[w.figure].caption,
        by=lambda w: "dem" if w.figure in FIGURES else "python -P -m studies",
    log:
        "{folder}/logs/figures/{figure}.log",
    shell:
        "{params.by} figure {wildcards.figure} {input.data:q} -o $(dirname {output.svg:q}) 2> {log:q}"
