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
        code=lambda w: code_of(f"{KNOWN_FIGURES[w.figure].module.replace('.', '/')}.py") + code_of(*SHARED, *NUMBERS),
        caption=lambda w: KNOWN_FIGURES[w.figure].caption,
    log:
        "{folder}/logs/figures/{figure}.log",
    # by profiles/default in the process of Snakemake, which imports Matplotlib once for all figures
    run:
        draw_one(wildcards.figure, input.data, output.svg, log[0])
